//! What a material is put on: a unit sphere, a torus, a square, a mesh; and where rays meet it.
//!
//! Twin: `wgsl/shape.wgsl`. Parametrisations: u runs around the z axis from +x towards +y, v from the bottom to the top of a sphere and around the
//! tube of a torus from its outer equator upwards; on a square u is along x and v along y. Images stand upright on all of them
//! ([`super::texture`]).

use super::Number;
use super::mesh::Mesh;
use super::torus::Torus;
use crate::frame::{Frame, Vector};
use crate::material::Point;
use crate::real::Real;

/// How far from a surface the rays that leave it start. A thousandth of a pixel at usual sizes; in f32 positions are good to 1e-6.
pub const CLEARANCE: f64 = 1e-4;

/// A half line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray<R> {
    /// Where it starts.
    pub origin: Vector<R>,
    /// Its unit direction.
    pub direction: Vector<R>,
}

impl<R: Real> Ray<R> {
    /// The point at a distance.
    #[inline(always)]
    pub fn at(&self, distance: R) -> Vector<R> {
        self.origin + self.direction * distance
    }

    /// The ray that leaves a point of a surface: it starts [`CLEARANCE`] above.
    #[inline(always)]
    pub fn leaving(hit: &Hit<R>, direction: Vector<R>) -> Self {
        Ray { origin: hit.position + hit.geometric * R::from_f64(CLEARANCE), direction }
    }
}

/// A point of a shape that a ray met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit<R> {
    /// How far along the ray.
    pub distance: R,
    /// Where.
    pub position: Vector<R>,
    /// The unit normal of the surface itself, on the ray's side.
    pub geometric: Vector<R>,
    /// The shading frame: its normal interpolated on a mesh, its tangent along increasing u.
    pub frame: Frame<R>,
    /// The parameters, in [0, 1), of a square and a mesh; those of a sphere and a torus are found when a material asks ([`Shape::point`]).
    pub uv: [R; 2],
    /// How much they grow for a unit of length along the frame's tangent and bitangent.
    pub uv_per_length: [R; 2],
    /// How much of the hemisphere above the shape itself hides, in [0, 1].
    pub occlusion: R,
}

impl<R: Number> Hit<R> {
    /// Turns both normals to the side that the ray came from, and the shading normal so far towards it that it is seen.
    fn facing(mut self, ray: &Ray<R>) -> Self {
        if R::ZERO.lt(self.geometric.dot(ray.direction)) {
            self.geometric = -self.geometric;
        }
        let mut normal = self.frame.normal;
        if normal.dot(self.geometric).lt(R::ZERO) {
            normal = -normal;
        }
        // An interpolated normal may be turned away from the viewer where the surface itself is not.
        if !normal.dot(ray.direction).lt(R::ZERO) {
            normal = self.geometric;
        }
        if normal != self.frame.normal {
            let before = self.frame.bitangent;
            self.frame = Frame::from_normal_and_tangent(normal, self.frame.tangent);
            if self.frame.bitangent.dot(before).lt(R::ZERO) {
                self.uv_per_length[1] = -self.uv_per_length[1];
            }
        }
        self
    }
}

/// A shape.
#[derive(Clone, Debug)]
pub enum Shape {
    /// The unit sphere.
    Sphere,
    /// A torus around the z axis whose tube's centre is at distance 1.
    Torus(Torus),
    /// The square [−1, 1]² at z = 0.
    Plane,
    /// Triangles.
    Mesh(Mesh),
}

impl Shape {
    /// The nearest point of the shape on a ray, within a distance.
    #[inline]
    pub fn hit<R: Number>(&self, ray: &Ray<R>, within: R) -> Option<Hit<R>> {
        match self {
            Shape::Sphere => sphere(ray, within),
            Shape::Torus(torus) => torus.hit(ray, within).map(|hit| hit.facing(ray)),
            Shape::Plane => plane(ray, within),
            Shape::Mesh(mesh) => mesh.hit(ray, within).map(|hit| hit.facing(ray)),
        }
    }

    /// What the material is told: `travelled` is the way from the viewer, `spread` the width of a pixel at distance 1.
    pub fn point<R: Number>(&self, hit: &Hit<R>, travelled: R, spread: R) -> Point<R> {
        let at = hit.position;
        let uv = match self {
            Shape::Sphere => {
                let height = at.sin_squared().sqrt().angle(at.z.abs()) * R::FRAC_1_PI;
                let v = if at.z.lt(R::ZERO) { height } else { R::ONE - height };
                [turn(at.x, at.y), v.min(R::ONE - R::HALF * R::EPSILON)]
            }
            Shape::Torus(_) => [turn(at.x, at.y), turn(at.sin_squared().sqrt() - R::ONE, at.z)],
            Shape::Plane | Shape::Mesh(_) => hit.uv,
        };
        Point {
            position: at,
            tangent: hit.frame.tangent,
            bitangent: hit.frame.bitangent,
            uv,
            uv_per_length: hit.uv_per_length,
            occlusion: hit.occlusion,
            distance: travelled,
            footprint: travelled * spread,
        }
    }

    /// Whether anything of the shape is on a ray that leaves it, within a distance.
    #[inline]
    pub fn blocks<R: Number>(&self, ray: &Ray<R>, within: R) -> bool {
        match self {
            Shape::Sphere | Shape::Plane => false,
            Shape::Torus(torus) => torus.meets(ray, within).is_some(),
            Shape::Mesh(mesh) => mesh.blocks(ray, within),
        }
    }

    /// The radius of the smallest sphere around the origin that holds it.
    pub fn radius(&self) -> f64 {
        match self {
            Shape::Sphere | Shape::Mesh(_) => 1.0,
            Shape::Torus(torus) => 1.0 + torus.minor(),
            Shape::Plane => core::f64::consts::SQRT_2,
        }
    }

    /// Whether a point lies within the shape, from where it is not seen. A square has no inside, and a mesh may be open: it is seen from both sides.
    pub fn encloses(&self, at: Vector<f64>) -> bool {
        match self {
            Shape::Sphere => at.length_squared() <= 1.0,
            Shape::Torus(torus) => torus.encloses(at),
            Shape::Plane | Shape::Mesh(_) => false,
        }
    }

    /// Whether rays that leave the shape never meet it again.
    pub fn is_convex(&self) -> bool {
        self.convex().is_some()
    }

    pub(crate) fn convex(&self) -> Option<Convex> {
        match self {
            Shape::Sphere => Some(Convex::Sphere),
            Shape::Plane => Some(Convex::Plane),
            Shape::Torus(_) | Shape::Mesh(_) => None,
        }
    }
}

/// The shapes that rays leave for good.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Convex {
    Sphere,
    Plane,
}

impl Convex {
    /// In every lane whether a ray from outside meets the shape; where, and the shading frame there.
    #[inline(always)]
    pub(crate) fn meet<R: Real>(self, ray: &Ray<R>) -> (R::Mask, Vector<R>, Frame<R>) {
        match self {
            Convex::Sphere => {
                let Met { found, position, .. } = sphere_met(ray);
                (found, position, sphere_frame(position).0)
            }
            Convex::Plane => {
                let Met { found, position, .. } = plane_met(ray);
                (found, position, plane_frame(ray))
            }
        }
    }
}

/// The angle of the point (x, y) in turns, in [0, 1).
#[inline]
pub fn turn<R: Number>(x: R, y: R) -> R {
    let quarter = R::HALF * R::HALF;
    let first = y.abs().angle(x.abs()) * R::FRAC_1_PI * R::HALF;
    let half = if x.lt(R::ZERO) { R::HALF - first } else { first };
    let whole = if y.lt(R::ZERO) { R::ONE - half } else { half };
    if whole.lt(R::ONE) && R::ZERO.le(whole) { whole } else { R::ZERO * quarter }
}

/// Turns around the z axis for a unit of length at this distance from it; 0 on it, where there is no direction around.
#[inline]
pub(crate) fn around_per_length<R: Number>(radius: R) -> R {
    if R::ZERO.lt(radius) { R::HALF * R::FRAC_1_PI / radius } else { R::ZERO }
}

fn sphere<R: Number>(ray: &Ray<R>, within: R) -> Option<Hit<R>> {
    let Met { found, distance, position: normal } = sphere_met(ray);
    if !found || !distance.lt(within) {
        return None;
    }
    let (frame, around) = sphere_frame(normal);
    Some(Hit {
        distance,
        position: normal,
        geometric: normal,
        frame,
        uv: [R::ZERO; 2],
        uv_per_length: [R::HALF * R::FRAC_1_PI * around, R::FRAC_1_PI],
        occlusion: R::ZERO,
    })
}

fn plane<R: Number>(ray: &Ray<R>, within: R) -> Option<Hit<R>> {
    let Met { found, distance, position } = plane_met(ray);
    if !found || !distance.lt(within) {
        return None;
    }
    let frame = plane_frame(ray);
    let parameter = |x: R| ((x + R::ONE) * R::HALF).max(R::ZERO).min(R::ONE - R::HALF * R::EPSILON);
    Some(Hit {
        distance,
        position,
        geometric: frame.normal,
        frame,
        uv: [parameter(position.x), parameter(position.y)],
        uv_per_length: [R::HALF, R::HALF * frame.normal.z],
        occlusion: R::ZERO,
    })
}

/// Where rays meet a shape, in every lane.
struct Met<R: Real> {
    found: R::Mask,
    distance: R,
    position: Vector<R>,
}

#[inline(always)]
fn sphere_met<R: Real>(ray: &Ray<R>) -> Met<R> {
    // From the point of the ray that is nearest to the centre, whose distance is had without cancellation.
    let along = -ray.origin.dot(ray.direction);
    let nearest = ray.at(along);
    let square = R::ONE - nearest.length_squared();
    // A ray that leaves the sphere starts outside and does not come back.
    let distance = along - square.max(R::ZERO).sqrt();
    Met { found: square.ge(R::ZERO) & distance.gt(R::ZERO), distance, position: ray.at(distance).normalized() }
}

/// The frame at a point of the sphere, and the inverse of the point's distance from the axis: 0 at the poles, where there is no
/// direction around.
#[inline(always)]
fn sphere_frame<R: Real>(normal: Vector<R>) -> (Frame<R>, R) {
    let squared = normal.sin_squared();
    let off_axis = squared.gt(R::EPSILON * R::EPSILON);
    let inverse = R::ONE / R::select(off_axis, squared, R::ONE).sqrt();
    let along_x = Vector::new(R::ONE, R::ZERO, R::ZERO);
    let tangent = Vector::select(off_axis, Vector::new(-normal.y * inverse, normal.x * inverse, R::ZERO), along_x);
    (Frame { tangent, bitangent: normal.cross(tangent), normal }, R::select(off_axis, inverse, R::ZERO))
}

#[inline(always)]
fn plane_met<R: Real>(ray: &Ray<R>) -> Met<R> {
    let distance = -ray.origin.z / ray.direction.z;
    let at = ray.at(distance);
    let found = distance.gt(R::ZERO) & at.x.abs().le(R::ONE) & at.y.abs().le(R::ONE);
    Met { found, distance, position: Vector::new(at.x, at.y, R::ZERO) }
}

/// The square's frame on the side that a ray comes from.
#[inline(always)]
fn plane_frame<R: Real>(ray: &Ray<R>) -> Frame<R> {
    let up = R::select(ray.direction.z.lt(R::ZERO), R::ONE, -R::ONE);
    let (tangent, normal) = (Vector::new(R::ONE, R::ZERO, R::ZERO), Vector::new(R::ZERO, R::ZERO, up));
    Frame { tangent, bitangent: normal.cross(tangent), normal }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_go_around() {
        for i in 0..64 {
            let phi = core::f64::consts::TAU * f64::from(i) / 64.0;
            assert!((turn(phi.cos(), phi.sin()) - f64::from(i) / 64.0).abs() < 1e-15, "{i}");
        }
        assert_eq!(turn(0.0, 0.0), 0.0);
        assert_eq!(turn(1.0f32, -1e-12), 0.0);
        assert_eq!(turn(f64::NAN, 1.0), 0.0);
    }

    #[test]
    fn a_sphere_is_met_where_it_is() {
        let ray = Ray { origin: Vector::new(3.0, 0.6, 0.0), direction: Vector::new(-1.0, 0.0, 0.0) };
        let hit = Shape::Sphere.hit(&ray, f64::MAX).expect("met");
        assert!((hit.distance - 2.2).abs() < 1e-15);
        assert!((hit.frame.normal - Vector::new(0.8, 0.6, 0.0)).length_squared() < 1e-30);
        let point = Shape::Sphere.point(&hit, 2.2, 0.0);
        assert!(
            (point.uv[1] - 0.5).abs() < 1e-15
                && point.uv_per_length[0] < 0.16
                && hit.frame.tangent.dot(Vector::new(-0.6, 0.8, 0.0)) > 0.999
        );
        let away = Ray { direction: Vector::new(1.0, 0.0, 0.0), ..ray };
        assert!(Shape::Sphere.hit(&away, f64::MAX).is_none());
        assert!(Shape::Sphere.hit(&ray, 2.0).is_none());
    }

    #[test]
    fn points_within_are_known() {
        let torus = Shape::Torus(Torus::new(0.4).expect("valid"));
        let at = |x, z| Vector::new(x, 0.0, z);
        assert!(Shape::Sphere.encloses(at(0.9, 0.1)) && !Shape::Sphere.encloses(at(0.9, 0.9)));
        assert!(torus.encloses(at(1.2, 0.2)) && !torus.encloses(at(0.1, 0.0)) && !torus.encloses(at(1.2, 0.4)));
        assert!(!Shape::Plane.encloses(at(0.0, 0.0)));
    }

    #[test]
    fn a_square_ends() {
        let down = |x, y| Ray { origin: Vector::new(x, y, 2.0f32), direction: Vector::new(0.0, 0.0, -1.0) };
        let hit = Shape::Plane.hit(&down(0.5, -0.5), f32::MAX).expect("met");
        assert_eq!((hit.distance, hit.uv), (2.0, [0.75, 0.25]));
        assert!(Shape::Plane.hit(&down(1.1, 0.0), f32::MAX).is_none());
    }
}
