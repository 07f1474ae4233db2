//! Finding the lobes of a BRDF: maxima of f·cosθ and their widths.
//!
//! The chart makes lobes at the mirror direction visible whatever their width. Elsewhere (retro-reflection, tilted
//! flakes, peaks off the mirror direction) a narrow lobe is met only if it is looked for: from rings of every radius around
//! the mirror, the retro direction and the normal, and from the whole hemisphere, uphill.

use super::subject::Section;
use crate::frame::{Frame, Vector};
use core::f64::consts::TAU;

/// A maximum of f·cosθ.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lobe {
    pub(super) direction: Vector<f64>,
    /// Chord from the maximum to half of it, in the direction where that is nearest.
    pub(super) width: f64,
}

/// Radii of the probes around an anchor, from the width of α = 1e-4 up.
const RADII: [f64; 9] = [1e-4, 3e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1, 0.25, 0.6];
const SPOKES: usize = 6;
/// Starts that cover the hemisphere evenly in projected solid angle.
const SPREAD: usize = 48;
/// How many of those are climbed from.
const CLIMBED: usize = 3;
const FINEST: f64 = 2e-5;

struct Search<'a> {
    section: Section<'a>,
    f: Vec<f64>,
    evaluations: usize,
}

impl Search<'_> {
    fn height(&mut self, v: Vector<f64>) -> f64 {
        if v.z <= 0.0 {
            return 0.0;
        }
        self.evaluations += 1;
        self.section.evaluate(v, &mut self.f);
        self.f.iter().map(|x| x.abs()).sum::<f64>() * v.z
    }

    /// Compass search with a step that halves when no neighbour is higher.
    fn climb(&mut self, mut v: Vector<f64>, mut step: f64) -> (Vector<f64>, f64) {
        let mut top = self.height(v);
        let limit = self.evaluations + 160;
        while step > FINEST && self.evaluations < limit {
            let frame = Frame::from_normal(v);
            let best = [(step, 0.0), (-step, 0.0), (0.0, step), (0.0, -step)]
                .map(|(a, b)| step_from(v, &frame, a, b))
                .map(|u| (u, self.height(u)))
                .into_iter()
                .fold((v, top), |best, next| if next.1 > best.1 { next } else { best });
            if best.1 > top {
                (v, top) = best;
            } else {
                step *= 0.5;
            }
        }
        (v, top)
    }

    fn width(&mut self, v: Vector<f64>, top: f64) -> f64 {
        let frame = Frame::from_normal(v);
        let mut radius = FINEST;
        while radius < 1.0 {
            let fallen = [(radius, 0.0), (-radius, 0.0), (0.0, radius), (0.0, -radius)].into_iter().any(|(a, b)| {
                let u = step_from(v, &frame, a, b);
                u.z > 0.0 && self.height(u) < 0.5 * top
            });
            if fallen {
                break;
            }
            radius *= 2.0;
        }
        radius
    }
}

fn step_from(v: Vector<f64>, frame: &Frame<f64>, a: f64, b: f64) -> Vector<f64> {
    (v + frame.tangent * a + frame.bitangent * b).normalized()
}

/// The lobe that is uphill from a direction, if f is not 0 there, and what finding it cost.
pub(super) fn uphill(section: Section<'_>, from: Vector<f64>) -> (Option<Lobe>, usize) {
    let mut search = Search { section, f: vec![0.0; section.subject.channels()], evaluations: 0 };
    let (direction, top) = search.climb(from, 1e-3);
    let lobe = (top > 0.0).then(|| Lobe { direction, width: search.width(direction, top) });
    (lobe, search.evaluations)
}

/// The lobes of a section, and what finding them cost in evaluations.
pub(super) fn find(section: Section<'_>) -> (Vec<Lobe>, usize) {
    let w = section.direction;
    let mut search = Search { section, f: vec![0.0; section.subject.channels()], evaluations: 0 };
    let mut starts = Vec::new();
    for anchor in [Vector::new(-w.x, -w.y, w.z), w, Vector::new(0.0, 0.0, 1.0)] {
        let frame = Frame::from_normal(anchor);
        let mut best = (anchor, search.height(anchor), 1e-4);
        for (i, radius) in RADII.into_iter().enumerate() {
            for spoke in 0..SPOKES {
                let angle = TAU * (spoke as f64 + 0.5 * (i % 2) as f64) / SPOKES as f64;
                let v = step_from(anchor, &frame, radius * angle.cos(), radius * angle.sin());
                let height = search.height(v);
                if height > best.1 {
                    best = (v, height, 0.5 * radius);
                }
            }
        }
        starts.push(best);
    }
    let mut spread: Vec<_> = (0..SPREAD)
        .map(|i| {
            // A sunflower spiral in the projected disk.
            let square = (i as f64 + 0.5) / SPREAD as f64;
            let angle = 2.399_963_229_728_653 * i as f64;
            let v = Vector::new(square.sqrt() * angle.cos(), square.sqrt() * angle.sin(), (1.0 - square).sqrt());
            (v, search.height(v), 0.1)
        })
        .collect();
    spread.sort_by(|a, b| b.1.total_cmp(&a.1));
    starts.extend(spread.into_iter().take(CLIMBED));
    let mut lobes: Vec<Lobe> = Vec::new();
    for (start, _, step) in starts {
        let (direction, top) = search.climb(start, step);
        if top > 0.0 && direction.z > 0.0 {
            let width = search.width(direction, top);
            let new = |lobe: &Lobe| (lobe.direction - direction).length_squared().sqrt() > 0.5 * lobe.width.min(width);
            if lobes.iter().all(new) {
                lobes.push(Lobe { direction, width });
            }
        }
    }
    (lobes, search.evaluations)
}

#[cfg(test)]
mod tests {
    use super::super::subject::{Fixed, from_fn};
    use super::*;

    #[test]
    fn narrow_retro_and_wide_tilted_lobes_are_found() {
        let tilted = Vector::from_angles(0.9, 2.0);
        let subject = from_fn("two lobes", 1, move |wi: Vector<f64>, wo: Vector<f64>, f: &mut [f64]| {
            let retro = (wi - wo).length_squared() / 4e-6;
            f[0] = (-retro).exp() * 1e5 + (-(wi - tilted).length_squared() / 0.02).exp();
        });
        let direction = Vector::from_angles(0.6, 0.3);
        let (lobes, cost) = find(Section { subject: &subject, direction, fixed: Fixed::View });
        assert!(cost < 1500, "{cost}");
        let near =
            |v: Vector<f64>, d: f64| lobes.iter().find(|l| (l.direction - v).length_squared().sqrt() < d).copied();
        let retro = near(direction, 1e-4).map(|l| l.width);
        assert!(retro.is_some_and(|w| w > 5e-4 && w < 5e-3), "{lobes:?}");
        assert!(near(tilted, 0.05).is_some_and(|l| l.width > 0.05 && l.width < 0.4), "{lobes:?}");
    }
}
