//! Coordinates of the hemisphere that a narrow lobe cannot hide in.
//!
//! With one direction w fixed, every free direction v has a half vector and so a slope s = (hx, hy)/hz. In the plane of
//! slopes the hemisphere v.z > 0 is exactly a disk: centre w_t/w.z, radius 1/w.z. It contains the mirror direction, s = 0,
//! where microfacet lobes sit whatever their width, refracted ones included (v_t + w_t = 0 does not change by Snell's
//! law). Polar coordinates about that point with a logarithmic radius give every scale of width the same room:
//!
//! * `x`: |s| = r₀ sinh x, linear below r₀ and logarithmic above;
//! * `t` in [−1, 1]: the azimuth of s from w_t is ψ(|s|)·sin(πt/2), ψ the half arc of that circle inside the disk. The sine
//!   crowds points at the horizon, where masking terms have a layer as thin as w.z.
//!
//! So the horizon is an edge of the rectangle, not a jump inside it. The half arc is π up to |s| = cosθ/(1+sinθ), and
//! from there to (1+sinθ)/cosθ falls to 0 with a square root at either end, which a cubic in x removes.

use crate::frame::Vector;
use core::f64::consts::{FRAC_PI_2, PI};

/// Where the radius turns from linear to logarithmic: a hundredth of the narrowest α (1e-4) that the crate accepts.
const R0: f64 = 1e-6;

/// The widest panel in x that a lobe is sampled with at first: a factor of 2 in slope.
const RING: f64 = 0.7;

/// The chart about the mirror image of one fixed direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chart {
    w: Vector<f64>,
    sin: f64,
    azimuth: (f64, f64),
    /// End of the full circles, and end of the chart, in x.
    inner: f64,
    outer: f64,
}

/// A point of the chart: the free direction and how much of ∫ · cosθ dω one unit of (x, t) is worth there.
#[derive(Clone, Copy, Debug)]
pub(super) struct Point {
    pub(super) v: Vector<f64>,
    pub(super) weight: f64,
}

impl Chart {
    pub(super) fn new(w: Vector<f64>) -> Self {
        let sin = w.sin_squared().sqrt();
        let azimuth = if sin > 0.0 { (w.x / sin, w.y / sin) } else { (1.0, 0.0) };
        let radius = w.z / (1.0 + sin);
        Chart { w, sin, azimuth, inner: (radius / R0).asinh(), outer: (1.0 / (radius * R0)).asinh() }
    }

    /// The extent of the first coordinate, from 0; the second runs over [−1, 1].
    pub(super) fn extent(&self) -> f64 {
        self.outer
    }

    /// The edges in t that an adaptive rule starts from.
    pub(super) const SECTORS: [f64; 9] = [-1.0, -0.75, -0.5, -0.25, 0.0, 0.25, 0.5, 0.75, 1.0];

    /// Half as many, for a glance.
    pub(super) const HALVES: [f64; 5] = [-1.0, -0.5, 0.0, 0.5, 1.0];

    /// The edges of the rings that an adaptive rule starts from, `wide` times the usual width.
    pub(super) fn rings(&self, wide: f64) -> Vec<f64> {
        let mut edges = vec![0.0];
        // The cubic's derivative is at most 3/2.
        for (from, to, ring) in [(0.0, self.inner, RING * wide), (self.inner, self.outer, RING * wide / 1.5)] {
            let count = ((to - from) / ring).ceil();
            if to - from > 1e-9 {
                edges.extend((1..=count as usize).map(|i| from + (to - from) * i as f64 / count));
            }
        }
        edges
    }

    /// x and dx/dc of the coordinate c.
    fn stretch(&self, c: f64) -> (f64, f64) {
        let length = self.outer - self.inner;
        if c <= self.inner || length <= 1e-9 {
            return (c, 1.0);
        }
        let y = ((c - self.inner) / length).min(1.0);
        (self.inner + length * y * y * (3.0 - 2.0 * y), 6.0 * y * (1.0 - y))
    }

    fn half_arc(&self, r: f64, x: f64) -> f64 {
        if x <= self.inner || self.sin == 0.0 {
            return PI;
        }
        ((r - 1.0) * (r + 1.0) * self.w.z / (2.0 * r * self.sin)).clamp(-1.0, 1.0).acos()
    }

    /// The direction at (c, t). Its cosine may be ≤ 0 by rounding at the rim; the weight is 0 there.
    pub(super) fn point(&self, c: f64, t: f64) -> Point {
        let (x, dx) = self.stretch(c);
        let r = R0 * x.sinh();
        let arc = self.half_arc(r, x);
        let (bend, slant) = (FRAC_PI_2 * t).sin_cos();
        let (sin, cos) = (arc * bend).sin_cos();
        let squared = 1.0 + r * r;
        // (w·h)/hz and then v_t + w_t = 2 (w·h) hz s.
        let q = self.w.z + self.sin * r * cos;
        let scale = 2.0 * q / squared * r;
        let (along, across) = (scale * cos, scale * sin);
        let (a, b) = self.azimuth;
        let v = Vector::new(
            along * a - across * b - self.w.x,
            along * b + across * a - self.w.y,
            (2.0 * self.sin * r * cos + self.w.z * (1.0 - r) * (1.0 + r)) / squared,
        );
        // dω = 4 (w·h) dω_h and dω_h = cos³θ_h ds.
        let measure = 4.0 * q / (squared * squared) * arc * FRAC_PI_2 * slant * r * (R0 * x.cosh()) * dx;
        Point { v, weight: if v.z > 0.0 { (measure * v.z).max(0.0) } else { 0.0 } }
    }

    /// The coordinates of a direction above the horizon.
    pub(super) fn coordinates(&self, v: Vector<f64>) -> (f64, f64) {
        let h = v + self.w;
        let (a, b) = self.azimuth;
        let (along, across) = (h.x * a + h.y * b, h.y * a - h.x * b);
        let r = along.hypot(across) / h.z;
        let x = (r / R0).asinh().min(self.outer);
        let length = self.outer - self.inner;
        let c = if x <= self.inner || length <= 1e-9 {
            x
        } else {
            let s = ((x - self.inner) / length).clamp(0.0, 1.0);
            self.inner + length * (0.5 - ((1.0 - 2.0 * s).asin() / 3.0).sin())
        };
        let arc = self.half_arc(r, x);
        let bend = if arc > 0.0 { across.atan2(along) / arc } else { 0.0 };
        (c, bend.clamp(-1.0, 1.0).asin() / FRAC_PI_2)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_invert_points() {
        for theta in [0.0f64, 1.0, 45.0, 80.0, 89.9] {
            let w = Vector::from_angles(theta.to_radians(), 0.7);
            let chart = Chart::new(w);
            for i in 1..40 {
                for j in 0..16 {
                    let (c, t) = (chart.extent() * f64::from(i) / 40.0, (f64::from(j) - 7.5) / 8.0);
                    let p = chart.point(c, t);
                    assert!((p.v.length_squared() - 1.0).abs() < 1e-12, "{theta} {c} {t} {p:?}");
                    if p.v.z > 1e-6 {
                        let (c2, t2) = chart.coordinates(p.v);
                        // Near the mirror direction v + w has lost digits: 1e-16 of 1e-6·cosθ.
                        assert!((c - c2).abs() < 1e-5 && (t - t2).abs() < 1e-5, "{theta}: {c} {t} → {c2} {t2}");
                    }
                }
            }
        }
    }

    #[test]
    fn weights_are_the_jacobian() {
        // dω by finite differences of the point.
        for theta in [0.0f64, 30.0, 75.0, 89.0] {
            let chart = Chart::new(Vector::from_angles(theta.to_radians(), -2.0));
            for (c, t) in [(9.0, 0.1), (12.0, -0.8), (13.5, 0.4), (13.9, -0.3), (15.0, 0.9), (17.0, 0.5)] {
                if c >= chart.extent() {
                    continue;
                }
                let p = chart.point(c, t);
                let e = 1e-5;
                let dc = (chart.point(c + e, t).v - chart.point(c - e, t).v) * (0.5 / e);
                let dt = (chart.point(c, t + e).v - chart.point(c, t - e).v) * (0.5 / e);
                let want = dc.cross(dt).length_squared().sqrt() * p.v.z;
                assert!((p.weight / want - 1.0).abs() < 1e-5, "{theta} {c} {t}: {} {want}", p.weight);
            }
        }
    }
}
