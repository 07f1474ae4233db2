//! Triangles, from Wavefront OBJ files.
//!
//! A mesh is moved and scaled so that the smallest sphere around its bounding box's centre that holds it is the unit sphere. Normals of the file are
//! interpolated; without them a triangle is flat. A triangle without texture coordinates has those of a sphere around that centre.
//!
//! How much of its surroundings each corner is hidden from by the mesh itself is measured when a picture's material asks for it, and not before:
//! [`Mesh::measure_occlusion`].

use super::bvh::Bvh;
use super::shape::{Hit, Ray, turn};
use super::{Number, Progress, obj};
use crate::frame::{Frame, Vector};
use crate::walk::random::random;
use rayon::prelude::*;
use std::collections::HashMap;
use std::path::Path;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Rays that measure the occlusion of a corner.
const OCCLUSION_RAYS: u32 = 128;

/// A corner of a triangle as it is given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Corner {
    /// Where it is, in any unit.
    pub position: [f64; 3],
    /// The direction of the shading normal, of any length > 0; without one that of the triangle.
    pub normal: Option<[f64; 3]>,
    /// The parameters; they may exceed [0, 1), where a texture repeats. Without them at any corner the triangle has those of a sphere.
    pub uv: Option<[f64; 2]>,
}

/// A corner of a triangle of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Where it is, within the unit sphere.
    pub position: [f32; 3],
    /// The unit shading normal.
    pub normal: [f32; 3],
    /// The parameters; they may exceed [0, 1), where a texture repeats.
    pub uv: [f32; 2],
}

/// Triangles with a hierarchy of boxes around them.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Three vertices a triangle, in the order of the hierarchy's leaves.
    triangles: Vec<[Vertex; 3]>,
    bvh: Bvh,
    /// How much of the hemisphere over each corner's normal the mesh itself hides, once it is measured.
    occlusion: OnceLock<Vec<[f32; 3]>>,
}

impl Mesh {
    /// Reads an OBJ file; its materials are left alone.
    ///
    /// # Errors
    /// One line: the file, what is wrong, and where. Lines that do not parse, an index of a vertex that is not there, a coordinate that is
    /// infinite or not a number, no triangle that has an area.
    pub fn read(path: &Path) -> Result<Self, String> {
        let place = path.display();
        let bytes = std::fs::read(path).map_err(|error| format!("{place}: {error}"))?;
        // Names may be in any encoding.
        let text = String::from_utf8_lossy(&bytes);
        let triangles = obj::triangles(&text).map_err(|error| format!("{place}: {error}"))?;
        Self::new(&triangles).map_err(|error| format!("{place}: {error}"))
    }

    /// A mesh of triangles, moved and scaled to the unit sphere. Triangles without an area, which no ray meets, are left out.
    ///
    /// # Errors
    /// Without triangles, with a position that is infinite or not a number (which is named by its triangle, counted from 1), or beyond 1e100, with
    /// texture coordinates beyond 1e9, and where no triangle has an area.
    pub fn new(triangles: &[[Corner; 3]]) -> Result<Self, String> {
        if triangles.is_empty() {
            return Err("no triangles; a face has three corners at least (lines `f`)".to_owned());
        }
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for (i, corner) in triangles.iter().enumerate().flat_map(|(i, t)| t.iter().map(move |corner| (i, corner))) {
            for axis in 0..3 {
                let x = corner.position[axis];
                // Squares of larger ones would overflow.
                if !x.is_finite() || x.abs() > 1e100 {
                    let at = corner.position;
                    return Err(format!(
                        "triangle {}: a vertex at {at:?}; coordinates are finite and within 1e100",
                        i + 1
                    ));
                }
                low[axis] = low[axis].min(x);
                high[axis] = high[axis].max(x);
            }
            if let Some(uv) = corner.uv.filter(|uv| uv.iter().any(|x| !x.is_finite() || x.abs() > 1e9)) {
                return Err(format!("triangle {}: texture coordinates {uv:?}; they are within 1e9", i + 1));
            }
        }
        let centre = Vector::from([0, 1, 2].map(|axis: usize| 0.5 * low[axis] + 0.5 * high[axis]));
        let radius = triangles.iter().flatten().map(|corner| (Vector::from(corner.position) - centre).length_squared());
        let radius = radius.fold(0.0, f64::max).sqrt();
        if radius <= 0.0 {
            return Err("no triangles with an area: all vertices are one point".to_owned());
        }
        let count = triangles.len();
        let triangles: Vec<[Vertex; 3]> = triangles.iter().filter_map(|t| prepared(t, centre, 1.0 / radius)).collect();
        if triangles.is_empty() {
            return Err(format!("no triangles with an area: the corners of all {count} lie on lines or in points"));
        }
        let corners: Vec<_> = triangles.iter().map(|triangle| triangle.map(|vertex| vertex.position)).collect();
        let (bvh, order) = Bvh::new(&corners);
        let triangles = order.into_iter().filter_map(|i| triangles.get(i).copied()).collect();
        Ok(Mesh { triangles, bvh, occlusion: OnceLock::new() })
    }

    /// The triangles, in the order of the hierarchy's leaves.
    pub fn triangles(&self) -> &[[Vertex; 3]] {
        &self.triangles
    }

    /// The hierarchy.
    pub fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// How much of the hemisphere over each corner's normal the mesh itself hides, in [0, 1]; none before it is measured.
    pub fn occlusion(&self) -> Option<&[[f32; 3]]> {
        self.occlusion.get().map(Vec::as_slice)
    }

    /// Measures the occlusion of every corner by 128 rays, unless that is done: the same whatever the number of threads.
    ///
    /// Corners that share position and normal are measured once, in about 0.1 ms of one core each.
    pub fn measure_occlusion(&self, progress: &Progress<'_>) {
        self.occlusion.get_or_init(|| self.measured(progress));
    }

    fn measured(&self, progress: &Progress<'_>) -> Vec<[f32; 3]> {
        let mut places: HashMap<[u32; 6], usize> = HashMap::new();
        let mut distinct = Vec::new();
        let mut place = |vertex: &Vertex| {
            let ([x, y, z], [nx, ny, nz]) = (vertex.position.map(f32::to_bits), vertex.normal.map(f32::to_bits));
            *places.entry([x, y, z, nx, ny, nz]).or_insert_with(|| {
                distinct.push(*vertex);
                distinct.len() - 1
            })
        };
        let all: Vec<[usize; 3]> = self.triangles.iter().map(|triangle| triangle.each_ref().map(&mut place)).collect();
        let done = AtomicUsize::new(0);
        let measured = |vertices: &[Vertex]| -> Vec<f32> {
            let measured = vertices.iter().map(|vertex| self.hidden(vertex)).collect();
            let count = done.fetch_add(vertices.len(), Ordering::Relaxed) + vertices.len();
            progress(count as f64 / distinct.len().max(1) as f64);
            measured
        };
        let hidden: Vec<f32> = distinct.par_chunks(256).map(measured).flatten_iter().collect();
        all.into_iter().map(|corners| corners.map(|i| hidden.get(i).copied().unwrap_or(0.0))).collect()
    }

    /// The part of the hemisphere over a corner's normal that the mesh hides.
    fn hidden(&self, vertex: &Vertex) -> f32 {
        let normal = Vector::from(vertex.normal.map(f64::from));
        let frame = Frame::from_normal(normal);
        let origin = Vector::from(vertex.position.map(f64::from)) + normal * 1e-3;
        let hidden = |i: &u32| {
            // Seeded by the position, so that equal vertices of neighbouring triangles agree.
            let [x, y, z] = vertex.position.map(f32::to_bits);
            let [a, b, ..]: [f64; 4] = random(x ^ y.rotate_left(11) ^ z.rotate_left(22), *i, 0);
            let local = crate::sampling::cosine_hemisphere([a, b]);
            self.blocks(&Ray { origin, direction: frame.to_world(local) }, f64::MAX)
        };
        (0..OCCLUSION_RAYS).filter(hidden).count() as f32 / OCCLUSION_RAYS as f32
    }

    /// Whether a ray meets any triangle within a distance.
    #[inline]
    pub fn blocks<R: Number>(&self, ray: &Ray<R>, within: R) -> bool {
        let mut blocked = false;
        self.bvh.walk(ray, within, |i, within| {
            blocked = blocked || self.triangles.get(i).is_some_and(|t| meets(t, ray, within).is_some());
            if blocked { R::ZERO } else { within }
        });
        blocked
    }

    /// The nearest point on a ray, within a distance.
    #[inline]
    pub fn hit<R: Number>(&self, ray: &Ray<R>, within: R) -> Option<Hit<R>> {
        let mut found = None;
        self.bvh.walk(ray, within, |i, within| {
            match self.triangles.get(i).and_then(|triangle| Some((triangle, meets(triangle, ray, within)?))) {
                Some((triangle, met)) => {
                    found = Some((i, triangle, met));
                    met.0
                }
                None => within,
            }
        });
        let (i, triangle, (distance, b, c)) = found?;
        let occlusion = self.occlusion().and_then(|all| all.get(i)).copied().unwrap_or_default();
        let [oa, ob, oc] = occlusion.map(|x| R::from_f64(f64::from(x)));
        let hit = interpolated(triangle, ray, distance, b, c);
        Some(Hit { occlusion: oa * (R::ONE - b - c) + ob * b + oc * c, ..hit })
    }
}

/// A triangle of the unit sphere; none where its corners lie on a line.
fn prepared(corners: &[Corner; 3], centre: Vector<f64>, scale: f64) -> Option<[Vertex; 3]> {
    let single = |v: Vector<f64>| <[f64; 3]>::from(v).map(|x| x as f32);
    let positions = corners.each_ref().map(|corner| single((Vector::from(corner.position) - centre) * scale));
    let [a, b, c] = positions.map(|p| Vector::from(p.map(f64::from)));
    let flat = (b - a).cross(c - a);
    if flat.length_squared() <= 0.0 {
        return None;
    }
    let own = corners.each_ref().map(|corner| corner.uv);
    let uvs = match own {
        [Some(a), Some(b), Some(c)] => [a, b, c],
        _ => of_a_sphere([a, b, c]),
    };
    let vertex = |i: usize| {
        // A length of 0, or one that is no number, is no normal.
        let unit = corners[i].normal.map(|normal| Vector::from(normal).normalized());
        let normal = unit.filter(|unit| unit.length_squared() > 0.5).unwrap_or(flat.normalized());
        Vertex { position: positions[i], normal: single(normal), uv: uvs[i].map(|x| x as f32) }
    };
    Some([vertex(0), vertex(1), vertex(2)])
}

/// The parameters of a sphere around the origin at three points, as [`Shape::Sphere`](super::shape::Shape) has them, without a jump between them: where
/// u passes from 1 to 0 it goes on beyond 1, and at a pole, which has no u, it is between the other two.
fn of_a_sphere(points: [Vector<f64>; 3]) -> [[f64; 2]; 3] {
    let mut uvs = points.map(|at| {
        let height = at.z.atan2(at.sin_squared().sqrt()) * core::f64::consts::FRAC_1_PI;
        [turn(at.x, at.y), height + 0.5]
    });
    let polar = points.map(|at| at.sin_squared() <= 1e-12 * at.length_squared());
    let us = || (0..3).filter(|i| !polar[*i]);
    let largest = us().map(|i| uvs[i][0]).fold(0.0, f64::max);
    for i in us() {
        if largest - uvs[i][0] > 0.5 {
            uvs[i][0] += 1.0;
        }
    }
    let mean = us().map(|i| uvs[i][0]).sum::<f64>() / us().count().max(1) as f64;
    for i in 0..3 {
        if polar[i] {
            uvs[i][0] = mean;
        }
    }
    uvs
}

fn vector<R: Number>(v: [f32; 3]) -> Vector<R> {
    Vector::from(v.map(|x| R::from_f64(f64::from(x))))
}

/// The distance to a triangle and the barycentric coordinates of the point there.
///
/// Source: Möller & Trumbore 1997, "Fast, Minimum Storage Ray/Triangle Intersection".
#[inline]
fn meets<R: Number>(triangle: &[Vertex; 3], ray: &Ray<R>, within: R) -> Option<(R, R, R)> {
    let [a, b, c] = triangle.each_ref().map(|vertex| vector::<R>(vertex.position));
    let (edge_b, edge_c) = (b - a, c - a);
    let p = ray.direction.cross(edge_c);
    let determinant = edge_b.dot(p);
    if determinant == R::ZERO {
        return None;
    }
    let inverse = R::ONE / determinant;
    let from = ray.origin - a;
    let u = from.dot(p) * inverse;
    let q = from.cross(edge_b);
    let v = ray.direction.dot(q) * inverse;
    let distance = edge_c.dot(q) * inverse;
    let inside = R::ZERO.le(u) && R::ZERO.le(v) && (u + v).le(R::ONE) && R::ZERO.lt(distance) && distance.lt(within);
    inside.then_some((distance, u, v))
}

fn interpolated<R: Number>(triangle: &[Vertex; 3], ray: &Ray<R>, distance: R, b: R, c: R) -> Hit<R> {
    let a = R::ONE - b - c;
    let [pa, pb, pc] = triangle.each_ref().map(|vertex| vector::<R>(vertex.position));
    let [na, nb, nc] = triangle.each_ref().map(|vertex| vector::<R>(vertex.normal));
    let (edge_b, edge_c) = (pb - pa, pc - pa);
    let across = edge_b.cross(edge_c);
    let mut geometric = across.normalized();
    if R::ZERO.lt(geometric.dot(ray.direction)) {
        geometric = -geometric;
    }
    let mixed = na * a + nb * b + nc * c;
    let normal = if R::ZERO.lt(mixed.length_squared()) { mixed.normalized() } else { geometric };
    let [ta, tb, tc] = triangle.each_ref().map(|vertex| vertex.uv.map(|x| R::from_f64(f64::from(x))));
    // ∂p/∂u, from the two edges and what u and v change along them.
    let (du_b, dv_b, du_c, dv_c) = (tb[0] - ta[0], tb[1] - ta[1], tc[0] - ta[0], tc[1] - ta[1]);
    let determinant = du_b * dv_c - du_c * dv_b;
    let sign = if determinant.lt(R::ZERO) { -R::ONE } else { R::ONE };
    let tangent = (edge_b * dv_c - edge_c * dv_b) * sign;
    let wrap = |i: usize| {
        let x = ta[i] * a + tb[i] * b + tc[i] * c;
        let whole = R::from_f64(x.to_f64().floor());
        (x - whole).max(R::ZERO).min(R::ONE - R::HALF * R::EPSILON)
    };
    let frame = Frame::from_normal_and_tangent(normal, tangent);
    // The gradients of the barycentric coordinates b and c.
    let inverse = R::ONE / across.length_squared();
    let (slope_b, slope_c) = (edge_c.cross(across) * inverse, across.cross(edge_b) * inverse);
    let gradient = |b: R, c: R| slope_b * b + slope_c * c;
    let uv_per_length = [gradient(du_b, du_c).dot(frame.tangent), gradient(dv_b, dv_c).dot(frame.bitangent)];
    Hit {
        distance,
        position: pa * a + pb * b + pc * c,
        geometric,
        frame,
        uv: [wrap(0), wrap(1)],
        uv_per_length,
        occlusion: R::ZERO,
    }
}
