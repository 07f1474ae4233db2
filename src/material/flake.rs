//! The documents' metal flakes: normals of a map that is not filtered, flattened with distance (Elek 2010, §4.1).
//!
//! Twin: `wgsl/flake.wgsl`. What the map and the distance leave of the lobe is no distribution: its energy changes with
//! the distance. [`glint`](super::glint) is one that conserves.

use crate::frame::Vector;
use crate::real::Real;

/// The normal of a lower layer with flakes.
///
/// $$\mathrm{normalize}\left(N + \max(d, 1)\,\hat z + (2t - 1)\right)$$
///
/// In plain text: the direction of N + max(distance, 1)·(0, 0, 1) + (2·texel − 1).
///
/// * `normal`: the normal of the surface's own map, in the tangent frame. `distance` from the viewer, in units of the
///   artist's choosing: below 1 nothing is flattened. `texel`: of the map of flakes, in [0, 1].
///
/// Far away it is +z. The zero vector, of N = −z below distance 1 and the grey texel, stays zero. It is applied between lines
/// 13 and 14 of Algorithm 1, to the lower layer only.
///
/// Error in f32: ≤ 1 ULP of the largest component. Source: Elek 2010, §4.1, listing 1.
#[inline]
pub fn flake_normal<R: Real>(normal: Vector<R>, distance: R, texel: Vector<R>) -> Vector<R> {
    let wide = flake_normal_wide(normal.widen(), distance.widen(), texel.widen());
    Vector::new(R::narrow(wide.x), R::narrow(wide.y), R::narrow(wide.z))
}

#[inline(always)]
fn flake_normal_wide<W: Real>(normal: Vector<W>, distance: W, texel: Vector<W>) -> Vector<W> {
    let x = normal.x + (W::TWO * texel.x - W::ONE);
    let y = normal.y + (W::TWO * texel.y - W::ONE);
    let z = normal.z + distance.max(W::ONE) + (W::TWO * texel.z - W::ONE);
    // By the largest component first: the square of a large distance does not overflow.
    let largest = x.abs().max(y.abs()).max(z.abs());
    let some = largest.gt(W::ZERO);
    let divisor = W::select(some, largest, W::ONE);
    let scaled = Vector::new(x / divisor, y / divisor, z / divisor);
    let length = W::select(some, scaled.length_squared(), W::ONE).sqrt();
    Vector::new(scaled.x / length, scaled.y / length, scaled.z / length)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// N, the distance, the texel and the result.
    type Row = ([f64; 3], f64, [f64; 3], [f64; 3]);

    /// `flake_normal` of the project's reference values (terms.json): N, distance, texel and result.
    #[test]
    fn it_has_its_published_values() {
        let rows: [Row; 7] = [
            ([0.0, 0.0, 1.0], 0.0, [0.1, 0.9, 0.6], [-0.3233808333817773, 0.3233808333817773, 0.8892972917998876]),
            ([0.0, 0.0, 1.0], 0.5, [0.7, 0.4, 0.9], [0.14106912317171963, -0.07053456158585981, 0.9874838622020375]),
            ([0.0, 0.0, 1.0], 1.0, [0.5, 0.5, 1.0], [0.0, 0.0, 1.0]),
            ([0.0, 0.0, 1.0], 1.0, [0.7, 0.4, 0.9], [0.14106912317171963, -0.07053456158585981, 0.9874838622020375]),
            ([0.0, 0.0, 1.0], 1.0, [0.1, 0.9, 0.6], [-0.3233808333817773, 0.3233808333817773, 0.8892972917998876]),
            ([0.0, 0.0, 1.0], 2.0, [0.7, 0.4, 0.9], [0.10454167469786331, -0.052270837348931655, 0.9931459096297017]),
            ([0.0, 0.0, 1.0], 10.0, [0.1, 0.9, 0.6], [-0.07106690545187014, 0.07106690545187015, 0.994936676326182]),
        ];
        for (normal, distance, texel, want) in rows {
            let got: [f64; 3] = flake_normal(normal.into(), distance, texel.into()).into();
            let single: [f32; 3] =
                flake_normal(normal.map(|x| x as f32).into(), distance as f32, texel.map(|x| x as f32).into()).into();
            for i in 0..3 {
                assert!((got[i] - want[i]).abs() <= 4e-16, "{got:?} {want:?}");
                // Seven roundings of inputs, of at most half an ULP of 1 and twice that of a texel; and the result's own.
                assert!((f64::from(single[i]) - want[i]).abs() <= 5.0 * f64::from(f32::EPSILON), "{single:?} {want:?}");
            }
        }
    }

    #[test]
    fn it_is_a_direction_whatever_comes() {
        let numbers = [0.0f32, 0.5, 1.0, -1.0, 1e-30, 1e20, -1e20, f32::MAX];
        for a in numbers {
            for b in numbers {
                for c in numbers {
                    let got = flake_normal(Vector::new(a, b, c), b, Vector::new(c, a, 0.5));
                    let length = got.length_squared();
                    assert!((length - 1.0).abs() < 1e-6 || length == 0.0, "{a} {b} {c}: {got:?}");
                }
            }
        }
        assert_eq!(flake_normal(Vector::new(0.0, 0.0, -1.0), 0.5, Vector::new(0.5, 0.5, 0.5)), Vector::default());
        let near = flake_normal(Vector::new(0.0, 0.0, 1.0), f64::NAN, Vector::new(1.0, 0.5, 0.5));
        assert_eq!(near, flake_normal(Vector::new(0.0, 0.0, 1.0), 0.0, Vector::new(1.0, 0.5, 0.5)));
        let _ = flake_normal(Vector::new(f64::NAN, f64::INFINITY, 0.0), f64::INFINITY, Vector::new(0.0, f64::NAN, 1.0));
    }
}
