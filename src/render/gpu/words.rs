//! The scene as the words that `wgsl/scene.wgsl` reads.
//!
//! | words | |
//! |---|---|
//! | 0 | the shape: 0 sphere, 1 torus, 2 plane, 3 mesh |
//! | 1, 2 | pixels to a row, rows |
//! | 3 | 1: the environment is seen behind the shape; 2: it shines |
//! | 4–15 | the camera: its eye, the way to the picture's centre, from there to the right and the upper edge |
//! | 16 | the width of a pixel at distance 1 |
//! | 17, 18 | the most points of a path, the strategy |
//! | 19, 20 | a torus: its minor radius, where its 33 occlusions start |
//! | 21, 22 | how many lights there are, where they start: kind (0 directional, 1 point, 2 point with 1/d), three of place, three of power each |
//! | 23, 24 | where the environment's map starts, its side |
//! | 25 | where its alias table starts: a share and an index each |
//! | 26, 27 | where a mesh's nodes start (low, first, high, count), and its triangles (three times position, normal, uv, occlusion) |
//! | 28, 29 | where the list of blurred levels starts (width, start, side each), how many there are |

use crate::render::light::{Falloff, Light};
use crate::render::octahedral::Map;
use crate::render::offline::{Options, Strategy};
use crate::render::prefilter::{ALPHAS, Prefiltered};
use crate::render::scene::Scene;
use crate::render::shape::Shape;

/// The words before what has no fixed length.
const HEADER: usize = 30;

/// The words of a scene; with the levels of its environment for the local model, without for paths.
pub(super) fn words(scene: &Scene, options: &Options, levels: Option<&Prefiltered>) -> Vec<u32> {
    let mut words = Words(vec![0; HEADER]);
    let (kind, camera) = (kind(&scene.shape), &scene.camera);
    words.set(0, kind);
    words.set(1, camera.width());
    words.set(2, camera.height());
    words.set(3, u32::from(scene.backdrop) + 2 * u32::from(scene.environment.shines()));
    let vectors = camera.vectors().map(|v| [v.x, v.y, v.z]);
    for (i, x) in vectors.as_flattened().iter().enumerate() {
        words.set(4 + i, (*x as f32).to_bits());
    }
    words.set(16, (camera.spread() as f32).to_bits());
    words.set(17, options.depth);
    words.set(
        18,
        match options.strategy {
            Strategy::Both => 0,
            Strategy::Environment => 1,
            Strategy::Material => 2,
        },
    );
    words.set(21, scene.lights.len() as u32);
    words.here(22);
    for light in &scene.lights {
        let (kind, place, power) = match light {
            Light::Directional { towards, irradiance } => (0, towards, irradiance),
            Light::Point { position, intensity, falloff: Falloff::InverseSquare } => (1, position, intensity),
            Light::Point { position, intensity, falloff: Falloff::Inverse } => (2, position, intensity),
        };
        words.0.push(kind);
        words.reals([place.x, place.y, place.z].iter().chain(power).map(|x| *x as f32));
    }
    match &scene.shape {
        Shape::Sphere | Shape::Plane => {}
        Shape::Torus(torus) => {
            words.set(19, (torus.minor() as f32).to_bits());
            words.here(20);
            words.reals(torus.occlusion().iter().copied());
        }
        Shape::Mesh(mesh) => {
            words.here(26);
            for node in mesh.bvh().nodes() {
                words.reals(node.low);
                words.0.push(node.first);
                words.reals(node.high);
                words.0.push(node.count);
            }
            words.here(27);
            for (i, triangle) in mesh.triangles().iter().enumerate() {
                let occlusion = mesh.occlusion().and_then(|all| all.get(i)).copied().unwrap_or_default();
                for (vertex, occlusion) in triangle.iter().zip(occlusion) {
                    words.reals(vertex.position.into_iter().chain(vertex.normal).chain(vertex.uv).chain([occlusion]));
                }
            }
        }
    }
    match levels {
        None => {
            words.set(24, scene.environment.map().side() as u32);
            let start = words.map(scene.environment.map());
            words.set(23, start);
            words.here(25);
            for alias in scene.environment.alias() {
                words.0.extend([alias.keep.to_bits(), alias.other]);
            }
        }
        Some(levels) => {
            let list: Vec<[u32; 3]> = levels
                .levels()
                .iter()
                .zip(ALPHAS)
                .map(|(map, alpha)| [(alpha as f32).to_bits(), words.map(map), map.side() as u32])
                .collect();
            words.here(28);
            words.set(29, list.len() as u32);
            words.0.extend(list.as_flattened());
        }
    }
    words.0
}

fn kind(shape: &Shape) -> u32 {
    match shape {
        Shape::Sphere => 0,
        Shape::Torus(_) => 1,
        Shape::Plane => 2,
        Shape::Mesh(_) => 3,
    }
}

struct Words(Vec<u32>);

impl Words {
    fn set(&mut self, place: usize, word: u32) {
        if let Some(slot) = self.0.get_mut(place) {
            *slot = word;
        }
    }

    /// Notes where the next word will lie.
    fn here(&mut self, place: usize) {
        self.set(place, self.0.len() as u32);
    }

    fn reals(&mut self, values: impl IntoIterator<Item = f32>) {
        self.0.extend(values.into_iter().map(f32::to_bits));
    }

    /// Appends a map with its border, and returns where it starts.
    fn map(&mut self, map: &Map) -> u32 {
        let start = self.0.len() as u32;
        self.reals(map.texels().as_flattened().iter().copied());
        start
    }
}
