//! Bumps: a normal that is not the surface's, from a height or from a texel, and the frame about it.
//!
//! Normals here are local to the shading frame of the surface: +z is the surface's own normal, +x its tangent along growing u, so
//! that a height h(u, v) over it has the normal (−∂h/∂x, −∂h/∂y, 1), made unit. [`frame_about`] is where a BRDF is evaluated then;
//! [`perturbed`] the same frame in the world's space (Mihaylov 2013, eq. 4.14). A material's own frame
//! ([`Spot`](crate::material::Spot)) is [`Frame::from_normal_and_tangent`] of the same normal and +x: the same but for a normal within 1e-7 of
//! the tangent.
//!
//! A bump changes the normal, not the surface: what it hides, it does not shadow.

use crate::frame::{Frame, Vector};
use crate::real::Real;

/// The normal of a height by its slopes along the tangent and the bitangent: (−dx, −dy, 1), made unit.
///
/// Slopes of any finite size up to 1e19; 0 gives +z. Blinn 1978, eq. 7, for a parametrisation of unit speed.
#[inline]
pub fn normal_from_slopes<R: Real>(dx: R, dy: R) -> Vector<R> {
    Vector::new(-dx, -dy, R::ONE).normalized()
}

/// The slopes of a height by differences: from here, a step along the tangent and the same step along the bitangent.
///
/// In plain text: ((along − here)/step, (across − here)/step).
///
/// Error: half the step times the curvature, and 2⁻²³·|height|/step of rounding in f32; so a step near the square root of it, in the
/// height's own length, is best. A step of 0 gives 0.
#[inline]
pub fn slopes<R: Real>(here: R, along: R, across: R, step: R) -> [R; 2] {
    let none = !(step.lt(R::ZERO) | step.gt(R::ZERO));
    let step = R::select(none, R::ONE, step);
    [along, across].map(|there| R::select(none, R::ZERO, (there - here) / step))
}

/// A unit normal tilted by the slope of a height in space, both in one space: normal − (slope − normal·(slope·normal)), made unit.
///
/// The part of the slope along the normal does nothing. For solid noise
/// ([`gradient_slope`](crate::texture::noise::gradient_slope)) on a surface, without a parametrisation. Source: Mikkelsen 2010, eq. 2.
#[inline]
pub fn tilted<R: Real>(normal: Vector<R>, slope: Vector<R>) -> Vector<R> {
    let along = slope - normal * slope.dot(normal);
    (normal - along).normalized()
}

/// The normal of a texel of an RGB normal map, components in [0, 1]: 2c − 1, made unit.
///
/// Normals of such maps point out of the surface: a negative z counts as 0. The texel (½, ½, ½), which has no direction, and
/// (½, ½, z < ½) give +z.
#[inline]
pub fn decode_rgb<R: Real>(texel: [R; 3]) -> Vector<R> {
    let [x, y, z] = texel.map(centred);
    let n = Vector::new(x, y, z.max(R::ZERO));
    let is_flat = n.length_squared().le(R::ZERO);
    Vector::new(n.x, n.y, R::select(is_flat, R::ONE, n.z)).normalized()
}

/// The normal of a texel of a two-channel normal map: x in alpha, y in green, z from the unit length.
///
/// $$x = 2a - 1,\qquad y = 2g - 1,\qquad z = \sqrt{1 - x^2 - y^2}$$
///
/// In plain text: (2a − 1, 2g − 1, √(1 − x² − y²)). Where x² + y² > 1, as filtering and compression leave it and the printed root
/// is NaN, the normal is on the horizon in the texel's direction. Source: Mihaylov 2013, eq. 4.13.
#[inline]
pub fn decode_two_channel<R: Real>(a: R, g: R) -> Vector<R> {
    let (x, y) = (centred(a), centred(g));
    let squared = x * x + y * y;
    let scale = R::ONE / squared.max(R::ONE).sqrt();
    Vector::new(x * scale, y * scale, (R::ONE - squared).max(R::ZERO).sqrt())
}

/// 2c − 1, exactly.
#[inline(always)]
fn centred<R: Real>(c: R) -> R {
    R::TWO * (c - R::HALF)
}

/// The texel of an RGB normal map that holds a unit normal: (n + 1)/2.
#[inline]
pub fn encode<R: Real>(normal: Vector<R>) -> [R; 3] {
    [normal.x, normal.y, normal.z].map(|c| (c + R::ONE) * R::HALF)
}

/// A unit normal with its slopes scaled: (strength·x, strength·y, z), made unit. 0 flattens, 1 changes nothing.
///
/// A normal on the horizon has no slope to scale: it stays where strength > 0. Flattened it is +z.
#[inline]
pub fn scaled<R: Real>(normal: Vector<R>, strength: R) -> Vector<R> {
    let n = Vector::new(normal.x * strength, normal.y * strength, normal.z);
    let is_flat = n.length_squared().le(R::ZERO);
    Vector::new(n.x, n.y, R::select(is_flat, R::ONE, n.z)).normalized()
}

/// Two unit normals of one surface as one: their slopes added, as if their heights were.
///
/// In plain text: (x₁z₂ + x₂z₁, y₁z₂ + y₂z₁, z₁z₂), made unit. z > 0 for both; +z where neither leaves a direction. For scratches over the grain of
/// a surface: exact for heights, unlike the sum of the normals.
#[inline]
pub fn combined<R: Real>(a: Vector<R>, b: Vector<R>) -> Vector<R> {
    let n = Vector::new(a.x * b.z + b.x * a.z, a.y * b.z + b.y * a.z, a.z * b.z);
    let is_flat = n.length_squared().le(R::ZERO);
    Vector::new(n.x, n.y, R::select(is_flat, R::ONE, n.z)).normalized()
}

/// The frame about a unit normal whose tangent stays the surface's, +x, made perpendicular to it.
///
/// In plain text: r = √(y² + z²); tangent (r, −xy/r, −xz/r), bitangent (0, z/r, −y/r).
///
/// [`Frame::to_local`] takes a direction of the surface's frame to where a BRDF about this normal is evaluated. About a normal along
/// the tangent itself it is the limit from +z: tangent (0, 0, −x), bitangent +y.
#[inline]
pub fn frame_about<R: Real>(normal: Vector<R>) -> Frame<R> {
    let Vector { x, y, z } = normal;
    let squared = y * y + z * z;
    let across = squared.gt(R::ZERO);
    let r = R::select(across, squared, R::ONE).sqrt();
    let (s, c) = (R::select(across, y / r, R::ZERO), R::select(across, z / r, R::ONE));
    let along = R::select(across, r, R::ZERO);
    Frame { tangent: Vector::new(along, -x * s, -x * c), bitangent: Vector::new(R::ZERO, c, -s), normal }
}

/// The frame of a surface in the world about a local perturbed normal: its tangent stays the surface's, made perpendicular.
///
/// The normal is N′ₓT + N′ᵧB + N′_z N, Mihaylov 2013, eq. 4.14, with a right-handed orthonormal (T, B, N).
#[inline]
pub fn perturbed<R: Real>(surface: &Frame<R>, normal: Vector<R>) -> Frame<R> {
    let Frame { tangent, bitangent, normal } = frame_about(normal);
    Frame {
        tangent: surface.to_world(tangent),
        bitangent: surface.to_world(bitangent),
        normal: surface.to_world(normal),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Unit normals with z ≥ 0: the pole, the horizon and between.
    fn normals() -> impl Iterator<Item = Vector<f64>> {
        (0..=16).flat_map(|i| {
            (0..24).map(move |j| {
                let (z, azimuth) = (f64::from(i) / 16.0, f64::from(j) * core::f64::consts::TAU / 24.0);
                let r = ((1.0 - z) * (1.0 + z)).sqrt();
                Vector::new(r * azimuth.cos(), r * azimuth.sin(), z)
            })
        })
    }

    fn near(a: Vector<f64>, b: Vector<f64>, room: f64) -> bool {
        (a - b).length_squared().sqrt() <= room
    }

    #[test]
    fn slopes_are_those_of_the_tangent_plane() {
        for (dx, dy) in [(0.0, 0.0), (0.75, 0.0), (-2.0, 1.0), (1e8, -3e7)] {
            let n = normal_from_slopes(dx, dy);
            // Perpendicular to both tangents, (1, 0, dx) and (0, 1, dy); their lengths scale what rounding leaves.
            assert!((n.x + n.z * dx).abs() <= 4.0 * f64::EPSILON * n.x.abs(), "{n:?}");
            assert!((n.y + n.z * dy).abs() <= 4.0 * f64::EPSILON * n.y.abs(), "{n:?}");
            assert!((n.length_squared() - 1.0).abs() <= 6.0 * f64::EPSILON && n.z > 0.0);
        }
        assert!(near(normal_from_slopes(0.75, 0.0), Vector::new(-0.6, 0.0, 0.8), 2.0 * f64::EPSILON));
        assert_eq!(slopes(1.0, 1.5, 0.75, 0.25), [2.0, -1.0]);
        assert_eq!(slopes(1.0, 1.5, 0.75, 0.0), [0.0, 0.0]);
    }

    #[test]
    fn a_tilt_by_a_slope_in_space_is_the_bump_of_the_plane() {
        let up = Vector::new(0.0, 0.0, 1.0);
        for (dx, dy, dz) in [(0.3, -0.2, 0.0), (0.3, -0.2, 9.0)] {
            assert!(near(tilted(up, Vector::new(dx, dy, dz)), normal_from_slopes(dx, dy), 4.0 * f64::EPSILON));
        }
        // Any rotation of both rotates the result.
        let frame = Frame::from_normal([0.48, 0.64, 0.6]);
        let (n, slope) = (Vector::new(0.6, 0.0, 0.8), Vector::new(0.1, 0.7, -0.4));
        let turned = tilted(frame.to_world(n), frame.to_world(slope));
        assert!(near(turned, frame.to_world(tilted(n, slope)), 16.0 * f64::EPSILON));
    }

    #[test]
    fn decoding_undoes_encoding() {
        for n in normals() {
            let texel = encode(n);
            assert!(texel.iter().all(|c| (0.0..=1.0).contains(c)));
            // (n + 1)/2 and 2c − 1 round to ε/2 of numbers up to 2 each, and the norm adds as much.
            assert!(near(decode_rgb(texel), n, 6.0 * f64::EPSILON), "{n:?}");
            let [x, y, _] = texel;
            let two = decode_two_channel(x, y);
            // z² carries the error of x² + y², 4ε; near the horizon its root carries the root of that.
            assert!((two.z * two.z - n.z * n.z).abs() <= 8.0 * f64::EPSILON, "{n:?} {two:?}");
            assert!((two.x - n.x).abs().max((two.y - n.y).abs()) <= 4.0 * f64::EPSILON, "{n:?} {two:?}");
        }
    }

    #[test]
    fn texels_without_a_normal_have_one() {
        let up = Vector::new(0.0, 0.0, 1.0);
        assert_eq!(decode_rgb([0.5f32, 0.5, 0.5]), up.cast());
        assert_eq!(decode_rgb([0.5f32, 0.5, 0.0]), up.cast());
        assert_eq!(decode_rgb([1.0f32, 0.5, 0.0]), Vector::new(1.0, 0.0, 0.0));
        // Out of the disc: (1, 1) has length √2.
        let n = decode_two_channel(1.0f64, 1.0);
        let half = core::f64::consts::FRAC_1_SQRT_2;
        assert!(near(n, Vector::new(half, half, 0.0), 2.0 * f64::EPSILON), "{n:?}");
        assert_eq!(decode_two_channel(0.5f32, 0.5), up.cast());
        assert_eq!(scaled(Vector::new(1.0f32, 0.0, 0.0), 0.0), up.cast());
        assert_eq!(combined(Vector::new(1.0f32, 0.0, 0.0), Vector::new(0.0, 1.0, 0.0)), up.cast());
    }

    #[test]
    fn strength_and_combination_work_on_slopes() {
        for (a, b) in [((0.3, -0.2), (0.5, 1.5)), ((2.0, 0.0), (-2.0, 0.1))] {
            let [na, nb] = [a, b].map(|(dx, dy)| normal_from_slopes(dx, dy));
            assert!(near(scaled(na, 3.0), normal_from_slopes(3.0 * a.0, 3.0 * a.1), 8.0 * f64::EPSILON));
            assert!(near(combined(na, nb), normal_from_slopes(a.0 + b.0, a.1 + b.1), 16.0 * f64::EPSILON));
        }
    }

    #[test]
    fn frames_keep_the_tangent() {
        let surface = Frame::from_normal_and_tangent([0.48, 0.64, 0.6], [1.0, 0.2, -0.3]);
        for n in normals() {
            let frame = frame_about(n);
            let (t, b, n) = (frame.tangent, frame.bitangent, frame.normal);
            for (product, want) in [(t.dot(t), 1.0), (b.dot(b), 1.0), (t.dot(b), 0.0), (t.dot(n), 0.0), (b.dot(n), 0.0)]
            {
                assert!((product - want).abs() <= 8.0 * f64::EPSILON, "{frame:?}");
            }
            assert!(near(t.cross(b), n, 8.0 * f64::EPSILON), "right-handed: {frame:?}");
            // In the plane of the surface's tangent and the normal, on the tangent's side.
            assert!(t.x >= 0.0 && b.x == 0.0, "{frame:?}");
            let world = perturbed(&surface, n);
            let want = Frame::from_normal_and_tangent(surface.to_world(n), surface.tangent);
            // Where the tangent is nearly along the normal, from_normal_and_tangent cancels.
            if n.x.abs() < 0.9 {
                assert!(near(world.tangent, want.tangent, 32.0 * f64::EPSILON), "{n:?}");
                assert!(near(world.bitangent, want.bitangent, 32.0 * f64::EPSILON), "{n:?}");
            }
        }
        assert_eq!(frame_about(Vector::new(0.0f32, 0.0, 1.0)).tangent, Vector::new(1.0, 0.0, 0.0));
        assert_eq!(frame_about(Vector::new(1.0f32, 0.0, 0.0)).tangent, Vector::new(0.0, 0.0, -1.0));
    }
}
