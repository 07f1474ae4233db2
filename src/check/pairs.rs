//! Pairs of directions to put to a subject: the classes in which shaders go wrong, each sampled evenly on its own.

use super::chart::Chart;
use super::subject::Pair;
use crate::frame::{Frame, Vector};
use core::f64::consts::TAU;
use sobol_burley::sample_4d;

/// A class of pairs of directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Class {
    /// Both directions anywhere, even in projected solid angle.
    Hemisphere,
    /// wi close to the mirror image of wo, all slopes of the half vector from 1e-6 up alike.
    Mirror,
    /// wi the mirror image of wo, up to rounding: wi = −wo projected on the surface.
    MirrorExactly,
    /// wi close to wo, every distance from 1e-6 up alike.
    Retro,
    /// wi = wo.
    RetroExactly,
    /// One direction along the normal.
    Normal,
    /// One direction grazing: cosines from 1e-7 up, every magnitude alike.
    Grazing,
    /// Both directions grazing.
    GrazingBoth,
    /// Cosines and azimuths from a list of corners.
    Corners,
}

impl Class {
    /// Every class.
    pub const ALL: [Class; 9] = [
        Class::Hemisphere,
        Class::Mirror,
        Class::MirrorExactly,
        Class::Retro,
        Class::RetroExactly,
        Class::Normal,
        Class::Grazing,
        Class::GrazingBoth,
        Class::Corners,
    ];

    /// What reports call the class.
    pub const fn name(self) -> &'static str {
        match self {
            Class::Hemisphere => "anywhere",
            Class::Mirror => "near mirror",
            Class::MirrorExactly => "mirror",
            Class::Retro => "near wi = wo",
            Class::RetroExactly => "wi = wo",
            Class::Normal => "normal incidence",
            Class::Grazing => "one grazing",
            Class::GrazingBoth => "both grazing",
            Class::Corners => "corners",
        }
    }

    /// The `index`-th pair (wi, wo) of the class under a seed. Unit up to rounding, both above the horizon.
    pub fn pair(self, index: usize, seed: u32) -> (Vector<f64>, Vector<f64>) {
        let scramble = seed.wrapping_mul(0x85eb_ca6b) ^ ((index >> 16) as u32) ^ ((self as u32) << 20);
        let u = sample_4d((index & 0xffff) as u32, 0, scramble).map(|u| f64::from(u) + 2.98e-8);
        let anywhere = |a: f64, b: f64| with_cosine((1.0 - a).sqrt(), TAU * b);
        let grazing = |a: f64, b: f64| with_cosine(1e-7f64.powf(a), TAU * b);
        // Every other pair has wo near grazing, where most models fail.
        let either = if index.is_multiple_of(2) { anywhere(u[0], u[1]) } else { grazing(0.5 * u[0], u[1]) };
        match self {
            Class::Hemisphere => (anywhere(u[2], u[3]), anywhere(u[0], u[1])),
            Class::Mirror => {
                let chart = Chart::new(either);
                let v = chart.point(u[2] * chart.extent(), 2.0 * u[3] - 1.0).v;
                (if v.z > 0.0 { v } else { mirror(either) }, either)
            }
            Class::MirrorExactly => (mirror(either), either),
            Class::Retro => {
                let frame = Frame::from_normal(either);
                let (distance, angle) = (1e-6f64.powf(u[2]), TAU * u[3]);
                let step = frame.tangent * (distance * angle.cos()) + frame.bitangent * (distance * angle.sin());
                let v = (either + step).normalized();
                (if v.z > 0.0 { v } else { either }, either)
            }
            Class::RetroExactly => (either, either),
            Class::Normal => {
                let normal = Vector::new(0.0, 0.0, 1.0);
                if index % 4 < 2 { (normal, either) } else { (either, normal) }
            }
            Class::Grazing if index % 4 < 2 => (grazing(u[2], u[3]), anywhere(u[0], u[1])),
            Class::Grazing => (anywhere(u[0], u[1]), grazing(u[2], u[3])),
            Class::GrazingBoth => (grazing(u[2], u[3]), grazing(u[0], u[1])),
            Class::Corners => corner(index),
        }
    }
}

/// Cosines at which terms meet their limits.
const COSINES: [f64; 11] = [
    1.0,
    1.0 - f64::EPSILON,
    core::f64::consts::FRAC_1_SQRT_2,
    0.5,
    0.258_819_045_102_520_74,    // 75°
    0.087_155_742_747_658_18,    // 85°
    0.017_452_406_437_283_52,    // 89°
    0.001_745_328_365_898_308_9, // 89.9°
    1e-4,
    1e-6,
    1e-7,
];
/// Fractions of a turn between the azimuths.
const TURNS: [f64; 8] = [0.0, 0.5, 0.25, 1e-8, 0.5 - 1e-8, 1e-3, 0.499, 0.125];

fn corner(index: usize) -> (Vector<f64>, Vector<f64>) {
    let [i, j] = [index, index / COSINES.len()].map(|i| COSINES[i % COSINES.len()]);
    let rest = index / (COSINES.len() * COSINES.len());
    let base = TAU * 0.5 * (rest / TURNS.len()) as f64 / TURNS.len() as f64;
    (with_cosine(i, base + TAU * TURNS[rest % TURNS.len()]), with_cosine(j, base))
}

fn with_cosine(cos: f64, phi: f64) -> Vector<f64> {
    let (sin_phi, cos_phi) = phi.sin_cos();
    let sin = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
    Vector::new(sin * cos_phi, sin * sin_phi, cos)
}

/// The pair with its angles at whole multiples of 5°, 1°, 0.1° and 0.01°: what a person would rather read. Those that leave the
/// hemisphere are left out.
pub(super) fn rounder(pair: Pair) -> impl Iterator<Item = Pair> {
    [5.0, 1.0, 0.1, 0.01].into_iter().filter_map(move |step| {
        let [wi, wo] = [pair.0, pair.1].map(|v| {
            let round = |degrees: f64| ((degrees / step).round() * step).to_radians();
            let theta = round(v.sin_squared().sqrt().atan2(v.z).to_degrees());
            Vector::from_angles(theta, round(v.y.atan2(v.x).to_degrees()))
        });
        (wi.z > 1e-6 && wo.z > 1e-6).then_some((wi, wo))
    })
}

/// The mirror image about the normal.
pub(super) fn mirror(v: Vector<f64>) -> Vector<f64> {
    Vector::new(-v.x, -v.y, v.z)
}

/// A rotation about the normal.
pub(super) fn turned(v: Vector<f64>, angle: f64) -> Vector<f64> {
    let (sin, cos) = angle.sin_cos();
    Vector::new(v.x * cos - v.y * sin, v.x * sin + v.y * cos, v.z)
}

/// Offspring of a generation: enough that a block of an interpreter is not wasted on one pair.
const OFFSPRING: usize = 16;

/// Climbs an objective from a pair by a (1+λ) evolution strategy with a success rule, λ = 16; returns the best pair and its
/// value.
///
/// `objective` writes the value of each pair. NaN is never better than a number.
pub(super) fn climb(
    start: Pair,
    seed: u32,
    generations: u32,
    mut objective: impl FnMut(&[Pair], &mut [f64]),
) -> (Pair, f64) {
    let mut value = [0.0];
    objective(&[start], &mut value);
    let (mut best, mut value, mut sigma) = (start, value[0], 0.1);
    for generation in 0..generations {
        let next: Vec<Pair> = (0..OFFSPRING)
            .map(|child| {
                let index = (generation as usize * OFFSPRING + child) as u32;
                let u = sample_4d(index & 0xffff, 1, seed).map(|u| 2.0 * f64::from(u) - 1.0);
                // Offspring of several sizes: the right one is not known.
                let sigma = sigma * [1.0, 0.3, 0.1, 3.0][child % 4];
                (moved(best.0, sigma, u[0], u[1]), moved(best.1, sigma, u[2], u[3]))
            })
            .collect();
        let mut values = vec![f64::NEG_INFINITY; next.len()];
        objective(&next, &mut values);
        let top = (0..next.len()).reduce(|a, b| if values[b] > values[a] { b } else { a });
        match top {
            Some(top) if values[top] > value => {
                (best, value) = (next[top], values[top]);
                sigma = (sigma * 1.5).min(1.0);
            }
            _ => sigma *= 0.6,
        }
    }
    (best, value)
}

/// A direction moved by up to `sigma`, still above the horizon.
pub(super) fn moved(v: Vector<f64>, sigma: f64, a: f64, b: f64) -> Vector<f64> {
    let frame = Frame::from_normal(v);
    // Steps shrink with the cosine, so that grazing directions stay above the horizon.
    let v = (v + (frame.tangent * a + frame.bitangent * b) * (sigma * v.z.clamp(1e-6, 1.0).sqrt())).normalized();
    if v.z > 1e-7 { v } else { Vector::new(v.x, v.y, 1e-7).normalized() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_are_unit_and_above_the_horizon() {
        for class in Class::ALL {
            for i in 0..2000 {
                let (wi, wo) = class.pair(i, 7);
                for v in [wi, wo] {
                    assert!((v.length_squared() - 1.0).abs() < 1e-12 && v.z > 0.0, "{class:?} {i} {v:?}");
                }
            }
        }
    }

    #[test]
    fn climbing_finds_a_maximum() {
        let target = Vector::from_angles(0.7, 1.0);
        let start = Class::Hemisphere.pair(3, 1);
        let (_, value) = climb(start, 5, 60, |pairs, values| {
            for ((wi, wo), value) in pairs.iter().zip(values) {
                *value = -((*wi - target).length_squared() + (*wo - target).length_squared());
            }
        });
        assert!(value > -1e-4, "{value}");
    }
}
