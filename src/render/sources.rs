//! The built-in environments: a clear sky with its sun, and a photographer's studio.
//!
//! Both are functions of the direction, sampled on a map when they are made. +z is up.

use super::environment::Environment;
use crate::frame::Vector;

/// The texels to a side: 0.8° each, half the sun's edge; 1 MiB, which a processor's cache holds.
const SIDE: usize = 256;

/// The built-in environment of this name: `sky`, `studio` or `furnace`.
pub fn by_name(name: &str) -> Option<Environment> {
    match name {
        "sky" => Some(Environment::from_radiance(SIDE, sky)),
        "studio" => Some(Environment::from_radiance(SIDE, studio)),
        "furnace" => Some(Environment::furnace()),
        _ => None,
    }
}

/// The names that [`by_name`] knows.
pub const NAMES: [&str; 3] = ["sky", "studio", "furnace"];

/// The angular radius of the sun in radians: eight times the real one, so that the map resolves it, with 1/64 of its radiance.
const SUN_RADIUS: f64 = 8.0 * 0.004_65;

/// Where the sun stands.
const SUN: Vector<f64> = Vector::new(-0.5, -0.6, 0.624_499_8);

/// Radiance relative to the zenith's blue channel.
///
/// The gradation and indicatrix of the CIE's standard clear sky (type 12: a = −1, b = −.32, c = 10, d = −3, e = .45), a tint
/// from blue at the zenith to white at the horizon, a sun whose irradiance is five times the sky's, and grey ground.
///
/// Source: Darula & Kittler 2002, "CIE General Sky Standard Defining Luminance Distributions", eq. 1–4 and table 1.
fn sky(w: Vector<f64>) -> [f64; 3] {
    if w.z < 0.0 {
        return [0.16, 0.14, 0.12];
    }
    let apart = w.dot(SUN).clamp(-1.0, 1.0).acos();
    let gradation = |cos: f64| 1.0 - (-0.32 / cos.max(0.01)).exp();
    let indicatrix =
        |x: f64| 1.0 + 10.0 * ((-3.0 * x).exp() - (-3.0 * core::f64::consts::FRAC_PI_2).exp()) + 0.45 * x.cos().powi(2);
    let zenith = gradation(1.0) * indicatrix(SUN.z.acos());
    let relative = gradation(w.z) * indicatrix(apart) / zenith;
    let low = (1.0 - w.z).powi(3);
    let tint = [0.28 + 0.52 * low, 0.48 + 0.40 * low, 1.0 - 0.05 * low];
    // A smooth edge of a tenth of the radius.
    let edge = ((SUN_RADIUS - apart) / (0.1 * SUN_RADIUS) + 0.5).clamp(0.0, 1.0);
    let disc = 5.0 * 2.5 / (core::f64::consts::PI * SUN_RADIUS * SUN_RADIUS);
    let sun = [disc, 0.92 * disc, 0.80 * disc];
    core::array::from_fn(|c| 0.8 * tint[c] * relative + edge * sun[c])
}

/// A soft box: a rectangle on a plane at distance 1 from the object.
struct SoftBox {
    towards: Vector<f64>,
    /// Half the width and half the height at distance 1.
    half: [f64; 2],
    radiance: [f64; 3],
}

/// A key light on the left, a fill on the right, a strip from behind, a large ceiling; dim walls and a darker floor. A white diffuse sphere in it
/// is about 1 where it is brightest.
fn studio(w: Vector<f64>) -> [f64; 3] {
    const BOXES: [SoftBox; 4] = [
        SoftBox { towards: Vector::new(-0.64, -0.48, 0.6), half: [0.35, 0.5], radiance: [4.2, 4.06, 3.85] },
        SoftBox { towards: Vector::new(0.8, -0.36, 0.48), half: [0.3, 0.45], radiance: [1.4, 1.5, 1.68] },
        SoftBox { towards: Vector::new(0.0, 0.96, 0.28), half: [0.9, 0.12], radiance: [3.1, 3.1, 3.1] },
        SoftBox { towards: Vector::new(0.0, 0.0, 1.0), half: [0.6, 0.6], radiance: [1.0, 1.0, 1.0] },
    ];
    for SoftBox { towards, half, radiance } in BOXES {
        let along = w.dot(towards);
        let up = if towards.z > 0.9 { Vector::new(0.0, 1.0, 0.0) } else { Vector::new(0.0, 0.0, 1.0) };
        let right = up.cross(towards).normalized();
        let (x, y) = (w.dot(right) / along, w.dot(towards.cross(right)) / along);
        if along > 0.0 && x.abs() < half[0] && y.abs() < half[1] {
            return radiance;
        }
    }
    let wall = 0.09 + 0.06 * w.z;
    [wall, wall, wall]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_shines() {
        for name in NAMES {
            assert!(by_name(name).is_some_and(|environment| environment.shines()), "{name}");
        }
        assert!(by_name("dungeon").is_none());
        assert!((SUN.length_squared() - 1.0).abs() < 1e-6);
    }
}
