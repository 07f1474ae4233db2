//! Maps of the sphere of directions on a square: the octahedral parametrisation, without trigonometry.
//!
//! A direction is scaled to |x|+|y|+|z| = 1; the lower half of that octahedron is folded out over the corners of the square.
//! Twin: `wgsl/octahedral.wgsl`.
//!
//! Source: Cigolle et al. 2014, "Survey of Efficient Representations for Independent Unit Vectors", listing 2.

use crate::frame::Vector;
use crate::real::Real;
use rayon::prelude::*;

/// The point of [−1, 1]² that a direction of any length > 0 falls on, and 1/(|x|+|y|+|z|): a unit direction's distance on the octahedron.
#[inline(always)]
pub fn square<R: Real>(w: Vector<R>) -> ([R; 2], R) {
    let scale = R::ONE / (w.x.abs() + w.y.abs() + w.z.abs());
    let (x, y) = (w.x * scale, w.y * scale);
    let below = w.z.lt(R::ZERO);
    let sign = |v: R| R::select(v.lt(R::ZERO), -R::ONE, R::ONE);
    let fold = |v: R, other: R| R::select(below, (R::ONE - other.abs()) * sign(v), v);
    ([fold(x, y), fold(y, x)], scale)
}

/// The direction of a point of [−1, 1]², and the cube of its distance on the octahedron: dω = dx dy / that.
#[inline(always)]
pub fn direction<R: Real>([x, y]: [R; 2]) -> (Vector<R>, R) {
    let z = R::ONE - x.abs() - y.abs();
    let over = (-z).max(R::ZERO);
    let pull = |v: R| v - R::select(v.lt(R::ZERO), -over, over);
    let point = Vector::new(pull(x), pull(y), z);
    let squared = point.length_squared();
    let distance = squared.sqrt();
    (point * (R::ONE / distance), squared * distance)
}

/// Texels of three channels over the square, with a border that makes lookups across its edges continuous, and one more number each.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    side: usize,
    /// `side + 2` rows of as many texels.
    texels: Vec<[f32; 4]>,
}

impl Map {
    /// A map of `side`² texels, each from the direction of its centre; one at least.
    pub fn new(side: usize, texel: impl Fn(usize, usize) -> [f32; 3]) -> Self {
        let side = side.max(1);
        let stride = side + 2;
        let mut map = Map { side, texels: vec![[0.0; 4]; stride * stride] };
        for row in 0..side {
            for column in 0..side {
                let [r, g, b] = texel(column, row);
                map.set(column, row, [r, g, b, 0.0]);
            }
        }
        map.wrap();
        map
    }

    /// [`Map::new`] on the threads of the current pool, for texels that take a while.
    pub fn in_parallel(side: usize, texel: impl Fn(usize, usize) -> [f32; 3] + Sync) -> Self {
        let side = side.max(1);
        let texels: Vec<[f32; 3]> = (0..side * side).into_par_iter().map(|i| texel(i % side, i / side)).collect();
        Map::new(side, |column, row| texels.get(row * side + column).copied().unwrap_or_default())
    }

    /// The texels to a side, without the border.
    pub fn side(&self) -> usize {
        self.side
    }

    /// All texels, border included, row by row.
    pub fn texels(&self) -> &[[f32; 4]] {
        &self.texels
    }

    /// The texel at a column and a row of the square.
    pub fn texel(&self, column: usize, row: usize) -> [f32; 4] {
        self.texels.get((row + 1) * (self.side + 2) + column + 1).copied().unwrap_or_default()
    }

    fn set(&mut self, column: usize, row: usize, value: [f32; 4]) {
        let place = (row + 1) * (self.side + 2) + column + 1;
        if let Some(texel) = self.texels.get_mut(place) {
            *texel = value;
        }
    }

    /// Replaces the fourth number of each texel.
    pub fn with_fourth(mut self, fourth: impl Fn(usize, usize) -> f32) -> Self {
        for row in 0..self.side {
            for column in 0..self.side {
                let [r, g, b, _] = self.texel(column, row);
                self.set(column, row, [r, g, b, fourth(column, row)]);
            }
        }
        self.wrap();
        self
    }

    /// Fills the border: beyond an edge of the square lies the same edge, turned round.
    fn wrap(&mut self) {
        let (stride, last) = (self.side + 2, self.side - 1);
        let copy = |texels: &mut Vec<[f32; 4]>, to: (usize, usize), from: (usize, usize)| {
            let value = texels.get((from.1 + 1) * stride + from.0 + 1).copied().unwrap_or_default();
            if let Some(texel) = texels.get_mut(to.1 * stride + to.0) {
                *texel = value;
            }
        };
        for i in 0..self.side {
            let turned = last - i;
            copy(&mut self.texels, (i + 1, 0), (turned, 0));
            copy(&mut self.texels, (i + 1, stride - 1), (turned, last));
            copy(&mut self.texels, (0, i + 1), (0, turned));
            copy(&mut self.texels, (stride - 1, i + 1), (last, turned));
        }
        // The four corners of the square are one direction: −z.
        copy(&mut self.texels, (0, 0), (last, last));
        copy(&mut self.texels, (stride - 1, 0), (0, last));
        copy(&mut self.texels, (0, stride - 1), (last, 0));
        copy(&mut self.texels, (stride - 1, stride - 1), (0, 0));
    }

    /// The three channels at a direction, bilinear, and the fourth number of the texel that it falls into.
    #[inline(always)]
    pub fn look<R: Real>(&self, w: Vector<R>) -> ([R; 3], R) {
        self.at(square(w).0)
    }

    /// [`Map::look`] at the point of [−1, 1]² that the direction falls on.
    #[inline(always)]
    pub fn at<R: Real>(&self, [x, y]: [R; 2]) -> ([R; 3], R) {
        let size = R::from_f64(self.side as f64);
        // A direction that is not a number falls into the first texel.
        let place = |v: R| ((v + R::ONE) * (R::HALF * size)).max(R::ZERO).min(size) + R::HALF;
        let (x, y) = (place(x), place(y));
        let (column, row) = (x.floor(), y.floor());
        let (u, v) = (x - column, y - row);
        let stride = self.side + 2;
        let corners: [R; 16] = R::at_cell([column, row], |[column, row]| {
            let start = row as usize * stride + column as usize;
            let pair = |start: usize| self.texels.get(start..start + 2).unwrap_or(&[[0.0; 4]; 2]);
            let (upper, lower) = (pair(start), pair(start + stride));
            let mut corners = [0.0; 16];
            for i in 0..4 {
                for (corner, texel) in [upper[0], upper[1], lower[0], lower[1]].iter().enumerate() {
                    corners[4 * corner + i] = f64::from(texel[i]);
                }
            }
            corners
        });
        let mut channels = [R::ZERO; 3];
        for i in 0..3 {
            let [a, b, c, d] = [corners[i], corners[4 + i], corners[8 + i], corners[12 + i]];
            let (top, bottom) = (a + (b - a) * u, c + (d - c) * u);
            channels[i] = top + (bottom - top) * v;
        }
        // The centres of the four are half a texel away: beyond the middle it is the next one's.
        let (left, above) = (u.lt(R::HALF), v.lt(R::HALF));
        let upper = R::select(left, corners[3], corners[7]);
        let inside = R::select(above, upper, R::select(left, corners[11], corners[15]));
        (channels, inside)
    }

    /// The direction of the centre of a texel, and its solid angle but for second order.
    pub fn centre(side: usize, column: usize, row: usize) -> (Vector<f64>, f64) {
        let place = |i: usize| (2 * i + 1) as f64 / side as f64 - 1.0;
        let (w, cube) = direction([place(column), place(row)]);
        (w, 4.0 / ((side * side) as f64 * cube))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn directions() -> impl Iterator<Item = Vector<f64>> {
        (0..=32).flat_map(|i| {
            (0..64).map(move |j| {
                Vector::from_angles(
                    f64::from(i) / 32.0 * core::f64::consts::PI,
                    f64::from(j) / 64.0 * core::f64::consts::TAU,
                )
            })
        })
    }

    #[test]
    fn the_square_and_back_is_the_direction() {
        for w in directions() {
            let (back, _) = direction(square(w).0);
            assert!((back - w).length_squared() < 1e-28, "{w:?} {back:?}");
        }
    }

    #[test]
    fn solid_angles_sum_to_the_sphere() {
        let side = 64;
        let sum: f64 = (0..side * side).map(|i| Map::centre(side, i % side, i / side).1).sum();
        // The midpoint rule's error falls as 1/side².
        assert!((sum / (4.0 * core::f64::consts::PI) - 1.0).abs() < 1e-3, "{sum}");
    }

    #[test]
    fn lookups_are_continuous_across_the_edges() {
        // A linear function of the direction, which a bilinear lookup gives back up to the curvature of the parametrisation.
        let side = 256;
        let map = Map::new(side, |column, row| {
            let (w, _) = Map::centre(side, column, row);
            [w.x as f32, w.y as f32, w.z as f32]
        });
        for w in directions() {
            let ([x, y, z], _) = map.look(w);
            let off = (Vector::new(x, y, z) - w).length_squared().sqrt();
            // Half a texel's second difference, and at the creases of the fold a first one: 2/side at most.
            assert!(off < 2.0 / side as f64, "{w:?}: {off}");
        }
    }
}
