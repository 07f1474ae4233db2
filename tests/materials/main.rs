//! The documents' materials: their WGSL means what the Rust says and runs everywhere, they keep energy, and what is drawn for them has the
//! density that is stated.
#![cfg(feature = "gpu")]

#[path = "../adapters/mod.rs"]
mod adapters;
mod energy;
mod fields;
mod grooves;
#[cfg(feature = "check")]
mod plausible;
mod twins;
#[cfg(feature = "toml")]
mod variants;

use brdf::Vector;
use brdf::material::{Material, Point, built_in};
use brdf::random::random;

/// Every built-in material that has a twin: all of them.
fn materials() -> Vec<(&'static str, Material)> {
    built_in::all().iter().map(|named| (named.name, named.material().expect(named.name))).collect()
}

/// What no built-in material is made of: other fields, maps of normals, images, stacks; and fields that leave their range.
fn variants() -> Vec<(&'static str, Material)> {
    #[cfg(feature = "toml")]
    return variants::variants();
    #[cfg(not(feature = "toml"))]
    Vec::new()
}

/// A point of the unit sphere, and what else a material may ask.
fn point(index: u32) -> Point<f32> {
    let [a, b, c, d] = random::<f64>(41, index, 0);
    let [e, ..] = random::<f64>(41, index, 1);
    let (theta, phi) = ((1.0 - 2.0 * a).acos().clamp(0.05, 3.09), std::f64::consts::TAU * b);
    let position = Vector::<f64>::from_angles(theta, phi);
    let tangent = Vector::new(-phi.sin(), phi.cos(), 0.0);
    Point {
        position,
        tangent,
        bitangent: position.cross(tangent),
        uv: [b, 1.0 - theta / std::f64::consts::PI],
        // Coordinates of every other point are mirrored.
        uv_per_length: [
            1.0 / (std::f64::consts::TAU * theta.sin()),
            if index.is_multiple_of(2) { 1.0 } else { -1.0 } / std::f64::consts::PI,
        ],
        occlusion: c,
        distance: 0.5 + 9.5 * d,
        footprint: 10f64.powf(-4.0 + 3.0 * e),
    }
    .cast()
}

/// A direction of the upper hemisphere.
fn direction(index: u32, dimension: u32) -> Vector<f32> {
    let [u, v, ..] = random::<f64>(43, index, dimension);
    brdf::sampling::uniform_hemisphere([0.02 + 0.98 * u, v]).cast()
}
