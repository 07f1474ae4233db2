//! Triangles, from Wavefront OBJ files.
//!
//! A mesh is moved and scaled so that the smallest sphere around its bounding box's centre that holds it is the unit sphere. OBJ files have +y up;
//! it becomes +z. Faces of more than three corners are fans. Normals of the file are interpolated; without them a triangle is flat. Without
//! texture coordinates a vertex has those of a sphere.

use super::Number;
use super::bvh::Bvh;
use super::shape::{Hit, Ray, turn};
use crate::frame::{Frame, Vector};
use crate::walk::random::random;
use rayon::prelude::*;
use std::path::Path;

/// Rays that measure the occlusion of a vertex.
const OCCLUSION_RAYS: u32 = 128;

/// A corner of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vertex {
    /// Where it is.
    pub position: [f32; 3],
    /// The unit shading normal.
    pub normal: [f32; 3],
    /// The parameters; they may exceed [0, 1), where a texture repeats.
    pub uv: [f32; 2],
    /// How much of the hemisphere over the normal the mesh itself hides.
    pub occlusion: f32,
}

/// Triangles with a hierarchy of boxes around them.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Three vertices a triangle, in the order of the hierarchy's leaves.
    triangles: Vec<[Vertex; 3]>,
    bvh: Bvh,
}

impl Mesh {
    /// Reads an OBJ file; its materials are left alone.
    ///
    /// # Errors
    /// One line: the file, what is wrong, and where. Files that do not parse, no triangle, an index of a vertex that is not there, a
    /// coordinate that is infinite or not a number, all vertices in one point.
    pub fn read(path: &Path) -> Result<Self, String> {
        let place = path.display();
        let file = std::fs::File::open(path).map_err(|error| format!("{place}: {error}"))?;
        let mut reader = std::io::BufReader::new(file);
        let options = tobj::LoadOptions { triangulate: true, ..Default::default() };
        let (models, _) = tobj::load_obj_buf(&mut reader, &options, |_| Ok(Default::default()))
            .map_err(|error| format!("{place}: {error}"))?;
        let meshes: Vec<_> = models.into_iter().map(|model| (model.name, model.mesh)).collect();
        let mut triangles = Vec::new();
        for (name, mesh) in &meshes {
            triangles_of(mesh, &mut triangles).map_err(|error| format!("{place}: object `{name}`: {error}"))?;
        }
        Self::new(triangles).map_err(|error| format!("{place}: {error}"))
    }

    /// A mesh of triangles, moved and scaled to the unit sphere; occlusion is measured, what is given of it does not matter.
    ///
    /// # Errors
    /// Without triangles, with a position that is infinite or not a number (which is named by its triangle), or with all vertices in one point.
    pub fn new(mut triangles: Vec<[Vertex; 3]>) -> Result<Self, String> {
        if triangles.is_empty() {
            return Err("no triangles; a face has three corners at least (lines `f`)".to_owned());
        }
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for (i, triangle) in triangles.iter().enumerate() {
            for vertex in triangle {
                for axis in 0..3 {
                    let x = vertex.position[axis];
                    if !x.is_finite() {
                        return Err(format!(
                            "triangle {}: a vertex at {:?}; coordinates are finite",
                            i + 1,
                            vertex.position
                        ));
                    }
                    low[axis] = low[axis].min(x);
                    high[axis] = high[axis].max(x);
                }
            }
        }
        let centre: [f64; 3] = core::array::from_fn(|axis| 0.5 * (f64::from(low[axis]) + f64::from(high[axis])));
        let from_centre = |p: [f32; 3]| -> [f64; 3] { core::array::from_fn(|axis| f64::from(p[axis]) - centre[axis]) };
        let radius = triangles.iter().flatten().map(|v| from_centre(v.position).iter().map(|x| x * x).sum::<f64>());
        let radius = radius.fold(0.0, f64::max).sqrt();
        if radius <= 0.0 {
            return Err("all vertices are one point; a mesh has an extent".to_owned());
        }
        for vertex in triangles.iter_mut().flatten() {
            vertex.position = from_centre(vertex.position).map(|x| (x / radius) as f32);
        }
        let corners: Vec<_> = triangles.iter().map(|triangle| triangle.map(|vertex| vertex.position)).collect();
        let (bvh, order) = Bvh::new(&corners);
        let triangles = order.into_iter().filter_map(|i| triangles.get(i).copied()).collect();
        let mut mesh = Mesh { triangles, bvh };
        mesh.bake();
        Ok(mesh)
    }

    /// The triangles, in the order of the hierarchy's leaves.
    pub fn triangles(&self) -> &[[Vertex; 3]] {
        &self.triangles
    }

    /// The hierarchy.
    pub fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// Measures the occlusion of every vertex: the same whatever the number of threads.
    fn bake(&mut self) {
        let occlusion = |vertex: &Vertex| {
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
        };
        let baked: Vec<[f32; 3]> = self.triangles.par_iter().map(|t| t.each_ref().map(occlusion)).collect();
        for (triangle, baked) in self.triangles.iter_mut().zip(baked) {
            for (vertex, occlusion) in triangle.iter_mut().zip(baked) {
                vertex.occlusion = occlusion;
            }
        }
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
                    found = Some((triangle, met));
                    met.0
                }
                None => within,
            }
        });
        let (triangle, (distance, b, c)) = found?;
        Some(interpolated(triangle, ray, distance, b, c))
    }
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
    let [oa, ob, oc] = triangle.each_ref().map(|vertex| R::from_f64(f64::from(vertex.occlusion)));
    Hit {
        distance,
        position: pa * a + pb * b + pc * c,
        geometric,
        frame,
        uv: [wrap(0), wrap(1)],
        uv_per_length,
        occlusion: oa * a + ob * b + oc * c,
    }
}

/// The triangles of an object of a file, with +z up.
fn triangles_of(mesh: &tobj::Mesh, triangles: &mut Vec<[Vertex; 3]>) -> Result<(), String> {
    let triple = |values: &[f32], index: u32, what: &str| {
        let at = index as usize * 3;
        match values.get(at..at + 3) {
            Some([x, y, z]) => Ok([*x, -*z, *y]),
            _ => Err(format!("{what} {} is not there; the file has {}", index + 1, values.len() / 3)),
        }
    };
    let indices = |own: &[u32], place: usize| own.get(place).or(mesh.indices.get(place)).copied().unwrap_or(0);
    for (face, corners) in mesh.indices.chunks_exact(3).enumerate() {
        let at = |error: String| format!("face {}: {error}", face + 1);
        let mut positions = [[0.0f32; 3]; 3];
        for (position, index) in positions.iter_mut().zip(corners) {
            *position = triple(&mesh.positions, *index, "vertex").map_err(at)?;
            if !position.iter().all(|x| x.is_finite()) {
                return Err(at(format!("vertex {} is not finite", index + 1)));
            }
        }
        let [a, b, c] = positions.map(|p| Vector::from(p.map(f64::from)));
        let flat = (b - a).cross(c - a);
        if flat.length_squared() <= 0.0 {
            // A triangle without an area cannot be met.
            continue;
        }
        let mut triangle = positions.map(|position| Vertex {
            position,
            normal: <[f64; 3]>::from(flat.normalized()).map(|x| x as f32),
            uv: [0.0; 2],
            occlusion: 0.0,
        });
        for (corner, vertex) in triangle.iter_mut().enumerate() {
            let place = 3 * face + corner;
            if !mesh.normals.is_empty() {
                let normal = triple(&mesh.normals, indices(&mesh.normal_indices, place), "normal").map_err(at)?;
                let unit = Vector::from(normal.map(f64::from)).normalized();
                if unit.length_squared() > 0.5 {
                    vertex.normal = <[f64; 3]>::from(unit).map(|x| x as f32);
                }
            }
            if mesh.texcoords.is_empty() {
                let at = Vector::from(vertex.position.map(f64::from));
                let height = at.z.atan2(at.sin_squared().sqrt()) * core::f64::consts::FRAC_1_PI;
                vertex.uv = [turn(at.x, at.y) as f32, (height + 0.5) as f32];
            } else {
                let index = indices(&mesh.texcoord_indices, place) as usize;
                let uv = mesh.texcoords.get(2 * index..2 * index + 2);
                let Some([u, v]) = uv else {
                    let all = mesh.texcoords.len() / 2;
                    return Err(at(format!("texture coordinate {} is not there; the file has {all}", index + 1)));
                };
                if !(u.is_finite() && v.is_finite()) {
                    return Err(at(format!("texture coordinate {} is not finite", index + 1)));
                }
                vertex.uv = [*u, *v];
            }
        }
        triangles.push(triangle);
    }
    Ok(())
}
