//! A torus around the z axis, met by rays at its exact distance.
//!
//! The distance of a point from a torus is known: √((ρ−1)² + z²) − r with ρ² = x² + y². A ray advances by it until it is closer than
//! the tolerance, which never steps over the surface and has none of the quartic's cancellation in f32; the point is then moved
//! onto the surface along the normal, which is exact. Twin: `wgsl/shape.wgsl`.
//!
//! Source: Hart 1996, "Sphere Tracing", §2 and App. A.

use super::Number;
use super::shape::{Hit, Ray, around_per_length, turn};
use crate::frame::{Frame, Vector};

/// How close counts as met: under a twentieth of [`CLEARANCE`](super::shape::CLEARANCE), above f32's rounding of positions.
const TOLERANCE: f64 = 4e-6;

/// Steps before a ray that only grazes the surface is given up.
const STEPS: usize = 256;

/// Nodes of the occlusion, over the angle around the tube from the outer to the inner equator.
pub const OCCLUSION_NODES: usize = 33;

/// A torus of major radius 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Torus {
    minor: f64,
    occlusion: [f32; OCCLUSION_NODES],
}

impl Torus {
    /// A torus with a tube of this radius.
    ///
    /// Its occlusion is measured once: the cosine-weighted part of the hemisphere that the torus hides, by 48×96 rays at each of 33
    /// angles around the tube. It is 0 on the outer half, which no other part of a torus rises above.
    ///
    /// # Errors
    /// Where `minor` is not in [0.01, 0.99].
    pub fn new(minor: f64) -> Result<Self, String> {
        if !(0.01..=0.99).contains(&minor) {
            return Err(format!("a torus of major radius 1 has a minor radius in [0.01, 0.99], not {minor}"));
        }
        let mut torus = Torus { minor, occlusion: [0.0; OCCLUSION_NODES] };
        for node in OCCLUSION_NODES / 2 + 1..OCCLUSION_NODES {
            torus.occlusion[node] = torus.hidden(node as f64 / (OCCLUSION_NODES - 1) as f64) as f32;
        }
        Ok(torus)
    }

    /// The radius of the tube.
    pub fn minor(&self) -> f64 {
        self.minor
    }

    /// The occlusion at angles around the tube, from the outer to the inner equator.
    pub fn occlusion(&self) -> &[f32; OCCLUSION_NODES] {
        &self.occlusion
    }

    /// The part of the cosine that is hidden at a half turn's part around the tube.
    fn hidden(&self, part: f64) -> f64 {
        let (sine, cosine) = (core::f64::consts::PI * part).sin_cos();
        let normal = Vector::new(cosine, 0.0, sine);
        let frame = Frame::from_normal(normal);
        let origin = Vector::new(1.0, 0.0, 0.0) + normal * (self.minor + 1e-3);
        let (rings, turns) = (48, 96);
        let mut hidden = 0u32;
        for i in 0..rings * turns {
            let square = (f64::from(i / turns) + 0.5) / f64::from(rings);
            let (y, x) = (core::f64::consts::TAU * (f64::from(i % turns) + 0.5) / f64::from(turns)).sin_cos();
            let radius = square.sqrt();
            let direction = frame.to_world(Vector::new(radius * x, radius * y, (1.0 - square).sqrt()));
            hidden += u32::from(self.meets(&Ray { origin, direction }, f64::MAX).is_some());
        }
        f64::from(hidden) / f64::from(rings * turns)
    }

    /// How far along a ray that starts outside the torus begins, within a distance.
    #[inline]
    pub fn meets<R: Number>(&self, ray: &Ray<R>, within: R) -> Option<R> {
        let (minor, tolerance) = (R::from_f64(self.minor), R::from_f64(TOLERANCE));
        // Between the planes that it touches, and inside the sphere around it.
        let outer = R::ONE + minor;
        let middle = -ray.origin.dot(ray.direction);
        let nearest = ray.at(middle);
        let square = outer * outer - nearest.length_squared();
        if square.lt(R::ZERO) {
            return None;
        }
        let half = square.sqrt();
        let (mut start, mut end) = ((middle - half).max(R::ZERO), (middle + half).min(within));
        let steep = R::EPSILON.lt(ray.direction.z.abs());
        if steep {
            let inverse = R::ONE / ray.direction.z;
            let (a, b) = ((-minor - ray.origin.z) * inverse, (minor - ray.origin.z) * inverse);
            start = start.max(a.min(b));
            end = end.min(a.max(b));
        } else if minor.lt(ray.origin.z.abs()) {
            return None;
        }
        let mut distance = start;
        for _ in 0..STEPS {
            if !distance.lt(end + tolerance) {
                return None;
            }
            let at = ray.at(distance);
            let step = self.distance(at);
            if step.lt(tolerance) {
                return Some(distance);
            }
            distance = distance + step;
        }
        None
    }

    /// The signed distance of a point.
    #[inline]
    fn distance<R: Number>(&self, at: Vector<R>) -> R {
        let across = at.sin_squared().sqrt() - R::ONE;
        (across * across + at.z * at.z).sqrt() - R::from_f64(self.minor)
    }

    /// Whether a point lies within the tube.
    pub(super) fn encloses(&self, at: Vector<f64>) -> bool {
        self.distance(at) <= 0.0
    }

    /// The nearest point of the torus on a ray, within a distance.
    #[inline]
    pub fn hit<R: Number>(&self, ray: &Ray<R>, within: R) -> Option<Hit<R>> {
        let distance = self.meets(ray, within)?;
        let at = ray.at(distance);
        let radius = at.sin_squared().sqrt();
        let outwards = Vector::new(at.x / radius, at.y / radius, R::ZERO);
        let across = radius - R::ONE;
        let normal = (outwards * across + Vector::new(R::ZERO, R::ZERO, at.z)).normalized();
        let position = outwards + normal * R::from_f64(self.minor);
        // Around the tube: 0 at the outer equator, half a turn at the inner one.
        let v = turn(across, at.z);
        let half = R::TWO * if R::HALF.lt(v) { R::ONE - v } else { v };
        let place = half * R::from_f64((OCCLUSION_NODES - 1) as f64);
        let node = (place.to_f64() as usize).min(OCCLUSION_NODES - 2);
        let share = place - R::from_f64(node as f64);
        let [low, high] = [self.occlusion[node], self.occlusion[node + 1]].map(|x| R::from_f64(f64::from(x)));
        Some(Hit {
            distance,
            position,
            geometric: normal,
            frame: Frame::from_normal_and_tangent(normal, Vector::new(-outwards.y, outwards.x, R::ZERO)),
            uv: [R::ZERO; 2],
            uv_per_length: [
                around_per_length(position.sin_squared().sqrt()),
                R::from_f64(0.5 * core::f64::consts::FRAC_1_PI / self.minor),
            ],
            occlusion: low + (high - low) * share,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::walk::random::random;

    #[test]
    fn points_lie_on_the_torus_and_nothing_is_before_them() {
        let torus = Torus::new(0.4).expect("valid");
        let mut met = 0;
        for i in 0..4000 {
            let [a, b, c, d]: [f64; 4] = random(9, i, 0);
            let origin = Vector::from_angles(3.1 * a, 6.2 * b) * 4.0;
            let target = Vector::new(1.4 * (2.0 * c - 1.0), 1.4 * (2.0 * d - 1.0), 0.3 * (a - b));
            let direction = (target - origin).normalized();
            let ray = Ray { origin, direction };
            // The quartic's first root by its sign: 20000 steps along the ray.
            let inside =
                (0..20000).map(|i| 2.0 + 4.0 * f64::from(i) / 20000.0).find(|t| torus.distance(ray.at(*t)) < 0.0);
            let Some(hit) = torus.hit(&ray, f64::MAX) else {
                // A ray that stays within a step of the surface may be missed by the march, never the other way round.
                assert!(inside.is_none(), "{ray:?}");
                continue;
            };
            met += 1;
            assert!(torus.distance(hit.position).abs() < 1e-14);
            if let Some(inside) = inside {
                // The tolerance over the sine of the angle of incidence, at most √(2·tolerance·1) at grazing, and the march's step.
                assert!(hit.distance <= inside && inside - hit.distance < 6e-3, "{} {inside}", hit.distance);
            }
            let single = Ray { origin: origin.cast::<f32>(), direction: direction.cast::<f32>() };
            if let Some(single) = torus.hit(&single, f32::MAX) {
                assert!((single.position.cast::<f64>() - hit.position).length_squared().sqrt() < 6e-3);
            }
        }
        assert!(met > 1000, "{met}");
    }

    #[test]
    fn occlusion_grows_inwards() {
        let torus = Torus::new(0.4).expect("valid");
        let nodes = torus.occlusion();
        assert!(nodes[..=OCCLUSION_NODES / 2].iter().all(|x| *x == 0.0));
        // The edge of what is hidden passes through rings of 1/48, and half of that is lost or won.
        assert!(nodes.windows(2).all(|pair| pair[0] <= pair[1] + 1.0 / 96.0), "{nodes:?}");
        assert!(nodes[OCCLUSION_NODES - 1] > 0.2 && nodes[OCCLUSION_NODES - 1] < 0.9);
        assert!(Torus::new(1.0).is_err() && Torus::new(f64::NAN).is_err());
    }
}
