//! Finding the lobes of a BRDF: maxima of f·cosθ and their widths.
//!
//! The chart makes lobes at the mirror direction visible whatever their width. Elsewhere (retro-reflection, tilted
//! flakes, peaks off the mirror direction) a narrow lobe is met only if it is looked for: from rings of every radius around
//! the mirror, the retro direction and the normal, and from the whole hemisphere, uphill.

use super::subject::Probe;
use crate::frame::{Frame, Vector};
use core::f64::consts::TAU;

/// A maximum of f·cosθ.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lobe {
    pub(super) direction: Vector<f64>,
    /// Chord from the maximum to half of it, in the direction where that is nearest.
    pub(super) width: f64,
    /// f·cosθ at the maximum, summed over the channels.
    pub(super) height: f64,
}

/// Radii of the probes around an anchor, from the width of α = 1e-4 up.
const RADII: [f64; 9] = [1e-4, 3e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1, 0.25, 0.6];
const SPOKES: usize = 6;
/// Starts that cover the hemisphere evenly in projected solid angle.
const SPREAD: usize = 48;
/// How many of those are climbed from.
const CLIMBED: usize = 3;
/// Steps of a climb.
const STEPS: usize = 40;
const FINEST: f64 = 2e-5;

/// f·cosθ of each direction, summed over the channels; 0 at and below the horizon.
fn heights(probe: &mut Probe<'_>, directions: &[Vector<f64>]) -> Vec<f64> {
    let channels = probe.section.subject.channels().max(1);
    let above: Vec<Vector<f64>> = directions.iter().copied().filter(|v| v.z > 0.0).collect();
    let mut f = vec![0.0; above.len() * channels];
    probe.evaluate(&above, &mut f);
    let mut found = f.chunks_exact(channels).map(|f| f.iter().map(|x| x.abs()).sum::<f64>());
    directions.iter().map(|v| if v.z > 0.0 { found.next().unwrap_or(0.0) * v.z } else { 0.0 }).collect()
}

/// The four neighbours at a distance.
fn around(v: Vector<f64>, step: f64) -> [Vector<f64>; 4] {
    let frame = Frame::from_normal(v);
    [(step, 0.0), (-step, 0.0), (0.0, step), (0.0, -step)].map(|(a, b)| step_from(v, &frame, a, b))
}

/// One compass search: a step that halves when no neighbour is higher.
#[derive(Clone, Copy)]
struct Climber {
    at: Vector<f64>,
    top: f64,
    step: f64,
}

/// Takes every climber to its top, all of them a step at a time, in `steps` steps at most.
fn climb(probe: &mut Probe<'_>, climbers: &mut [Climber], steps: usize) {
    for _ in 0..steps {
        let active: Vec<usize> = (0..climbers.len()).filter(|&i| climbers[i].step > FINEST).collect();
        if active.is_empty() {
            return;
        }
        let next: Vec<Vector<f64>> = active.iter().flat_map(|&i| around(climbers[i].at, climbers[i].step)).collect();
        let found = heights(probe, &next);
        for ((&i, next), found) in active.iter().zip(next.chunks_exact(4)).zip(found.chunks_exact(4)) {
            let climber = &mut climbers[i];
            let best = next
                .iter()
                .zip(found)
                .fold((climber.at, climber.top), |best, (&at, &top)| if top > best.1 { (at, top) } else { best });
            if best.1 > climber.top {
                (climber.at, climber.top) = best;
            } else {
                climber.step *= 0.5;
            }
        }
    }
}

/// The lobes at the tops, with their widths.
fn measured(probe: &mut Probe<'_>, tops: &[Climber]) -> Vec<Lobe> {
    let mut radii = vec![FINEST; tops.len()];
    let mut open: Vec<usize> = (0..tops.len()).collect();
    while !open.is_empty() {
        let points: Vec<Vector<f64>> = open.iter().flat_map(|&i| around(tops[i].at, radii[i])).collect();
        let found = heights(probe, &points);
        let each: Vec<(usize, bool)> = open
            .iter()
            .zip(points.chunks_exact(4).zip(found.chunks_exact(4)))
            .map(|(&i, (points, found))| {
                (i, points.iter().zip(found).any(|(v, &height)| v.z > 0.0 && height < 0.5 * tops[i].top))
            })
            .collect();
        open.clear();
        for (i, fallen) in each {
            if !fallen {
                radii[i] *= 2.0;
                if radii[i] < 1.0 {
                    open.push(i);
                }
            }
        }
    }
    tops.iter().zip(radii).map(|(top, width)| Lobe { direction: top.at, width, height: top.top }).collect()
}

fn step_from(v: Vector<f64>, frame: &Frame<f64>, a: f64, b: f64) -> Vector<f64> {
    (v + frame.tangent * a + frame.bitangent * b).normalized()
}

/// The lobes that are uphill from some directions, where f is not 0; one for each, though several may be the same.
pub(super) fn uphill(probe: &mut Probe<'_>, from: &[Vector<f64>]) -> Vec<Lobe> {
    let tops = heights(probe, from);
    let mut climbers: Vec<Climber> = from.iter().zip(tops).map(|(&at, top)| Climber { at, top, step: 1e-3 }).collect();
    climb(probe, &mut climbers, STEPS);
    climbers.retain(|climber| climber.top > 0.0 && climber.at.z > 0.0);
    distinct(measured(probe, &climbers))
}

/// Those that are apart by their widths.
fn distinct(found: Vec<Lobe>) -> Vec<Lobe> {
    let mut lobes: Vec<Lobe> = Vec::new();
    for lobe in found {
        let apart = |other: &Lobe| {
            (other.direction - lobe.direction).length_squared().sqrt() > 0.5 * other.width.min(lobe.width)
        };
        if lobes.iter().all(apart) {
            lobes.push(lobe);
        }
    }
    lobes
}

/// The lobes of a section. A search that is not thorough climbs less.
pub(super) fn find(probe: &mut Probe<'_>, thorough: bool) -> Vec<Lobe> {
    let w = probe.section.direction;
    let anchors = [Vector::new(-w.x, -w.y, w.z), w, Vector::new(0.0, 0.0, 1.0)];
    // Each anchor, what surrounds it, and the step to climb with from there.
    let mut rings: Vec<(Vector<f64>, f64)> = Vec::new();
    for anchor in anchors {
        let frame = Frame::from_normal(anchor);
        rings.push((anchor, 1e-4));
        for (i, radius) in RADII.into_iter().enumerate() {
            rings.extend((0..SPOKES).map(|spoke| {
                let angle = TAU * (spoke as f64 + 0.5 * (i % 2) as f64) / SPOKES as f64;
                (step_from(anchor, &frame, radius * angle.cos(), radius * angle.sin()), 0.5 * radius)
            }));
        }
    }
    let each = rings.len() / anchors.len();
    // A sunflower spiral in the projected disk.
    rings.extend((0..SPREAD).map(|i| {
        let square = (i as f64 + 0.5) / SPREAD as f64;
        let angle = 2.399_963_229_728_653 * i as f64;
        (Vector::new(square.sqrt() * angle.cos(), square.sqrt() * angle.sin(), (1.0 - square).sqrt()), 0.1)
    }));
    let directions: Vec<Vector<f64>> = rings.iter().map(|&(v, _)| v).collect();
    let tops = heights(probe, &directions);
    let mut starts: Vec<Climber> = rings.iter().zip(tops).map(|(&(at, step), top)| Climber { at, top, step }).collect();
    let mut spread = starts.split_off(each * anchors.len());
    spread.sort_by(|a, b| b.top.total_cmp(&a.top));
    let highest = |a: &Climber, b: &Climber| a.top >= b.top;
    let mut climbers: Vec<Climber> = starts
        .chunks_exact(each)
        .filter_map(|ring| ring.iter().copied().reduce(|a, b| if highest(&a, &b) { a } else { b }))
        .collect();
    climbers.extend(spread.into_iter().take(if thorough { CLIMBED } else { 1 }));
    climb(probe, &mut climbers, if thorough { STEPS } else { STEPS / 2 });
    climbers.retain(|climber| climber.top > 0.0 && climber.at.z > 0.0);
    distinct(measured(probe, &climbers))
}

#[cfg(test)]
mod tests {
    use super::super::subject::{Fixed, Section, from_fn};
    use super::*;

    #[test]
    fn narrow_retro_and_wide_tilted_lobes_are_found() {
        let tilted = Vector::from_angles(0.9, 2.0);
        let subject = from_fn("two lobes", 1, move |wi: Vector<f64>, wo: Vector<f64>, f: &mut [f64]| {
            let retro = (wi - wo).length_squared() / 4e-6;
            f[0] = (-retro).exp() * 1e5 + (-(wi - tilted).length_squared() / 0.02).exp();
        });
        let direction = Vector::from_angles(0.6, 0.3);
        let mut probe = Probe::new(Section { subject: &subject, direction, fixed: Fixed::View });
        let lobes = find(&mut probe, true);
        assert!(probe.evaluations < 2000, "{}", probe.evaluations);
        let near =
            |v: Vector<f64>, d: f64| lobes.iter().find(|l| (l.direction - v).length_squared().sqrt() < d).copied();
        let retro = near(direction, 1e-4).map(|l| l.width);
        assert!(retro.is_some_and(|w| w > 5e-4 && w < 5e-3), "{lobes:?}");
        assert!(near(tilted, 0.05).is_some_and(|l| l.width > 0.05 && l.width < 0.4), "{lobes:?}");
    }
}
