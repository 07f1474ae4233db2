//! Charts of one hemisphere together: one about the mirror direction, one about each narrow lobe elsewhere.
//!
//! A lobe whose width is a thousandth and whose tails reach everywhere (GGX about the retro direction) is as hard for a chart
//! that is centred elsewhere as it is easy for its own. So f is divided among the charts by a partition of unity: with the
//! distances dᵢ to the centres, the share of a chart is dᵢ⁻⁴/Σ dⱼ⁻⁴ (Becke 1988 divides molecules among their atoms so). It is 1 at
//! the chart's own centre, falls to 0 at the others faster than tails rise there, and is smooth. The shares sum to 1 exactly,
//! so where the centres are does not change the integral.

use super::chart::Chart;
use super::lobes::Lobe;
use super::pairs::mirror;
use crate::frame::Vector;
use core::f64::consts::PI;

/// Charts, at most.
const MOST: usize = 3;

/// Wider lobes do not need a chart.
const NARROW: f64 = 0.05;

/// Widths off a centre from which a lobe is another.
const APART: f64 = 8.0;

/// An albedo that is worth a chart: a tenth of the tolerance.
pub(super) const WORTHY: f64 = 1e-4;

/// Directions that charts are centred on; the mirror direction is the first.
pub(super) struct Atlas {
    centres: Vec<Vector<f64>>,
}

/// What of f one chart of an atlas integrates.
#[derive(Clone, Copy)]
pub(super) struct Share<'a> {
    atlas: &'a Atlas,
    index: usize,
}

impl Atlas {
    pub(super) fn new(direction: Vector<f64>, lobes: &[Lobe]) -> Self {
        let mut centres = vec![mirror(direction)];
        let mass = |lobe: &Lobe| lobe.height * PI * lobe.width * lobe.width;
        let mut worthy: Vec<&Lobe> = lobes
            .iter()
            .filter(|lobe| lobe.width < NARROW && mass(lobe) > WORTHY && lobe.direction.z > APART * lobe.width)
            .collect();
        worthy.sort_by(|a, b| mass(b).total_cmp(&mass(a)));
        for lobe in worthy {
            let apart = |centre: &Vector<f64>| (lobe.direction - *centre).length_squared().sqrt() > APART * lobe.width;
            if centres.len() < MOST && centres.iter().all(apart) {
                centres.push(lobe.direction);
            }
        }
        Atlas { centres }
    }

    pub(super) fn shares(&self) -> impl Iterator<Item = Share<'_>> {
        (0..self.centres.len()).map(|index| Share { atlas: self, index })
    }
}

impl Share<'_> {
    /// Whether there is no other chart.
    pub(super) fn is_alone(&self) -> bool {
        self.atlas.centres.len() == 1
    }

    pub(super) fn chart(&self) -> Chart {
        Chart::new(mirror(self.atlas.centres[self.index]))
    }

    /// Whether a lobe lies at another chart's centre, where this one has no share.
    pub(super) fn is_of_another(&self, lobe: &Lobe) -> bool {
        let near = |centre: &Vector<f64>| (lobe.direction - *centre).length_squared().sqrt() <= APART * lobe.width;
        self.atlas.centres.iter().enumerate().any(|(index, centre)| index != self.index && near(centre))
            && !near(&self.atlas.centres[self.index])
    }

    /// The share of f in a direction, from 0 to 1.
    pub(super) fn of(&self, v: Vector<f64>) -> f64 {
        let centres = &self.atlas.centres;
        if centres.len() == 1 {
            return 1.0;
        }
        // Multiplied out: no centre is a division by 0.
        let others = |index: usize| {
            let each = centres.iter().enumerate().filter(|(other, _)| *other != index);
            each.map(|(_, centre)| (v - *centre).length_squared().powi(2)).product::<f64>()
        };
        others(self.index) / (0..centres.len()).map(others).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_sum_to_one() {
        let direction = Vector::from_angles(0.8, 0.0);
        let lobe = |theta: f64, phi: f64, width: f64| Lobe {
            direction: Vector::from_angles(theta, phi),
            width,
            height: 1.0 / (width * width),
        };
        assert_eq!(Atlas::new(direction, &[lobe(0.8, PI, 1e-3), lobe(0.4, 1.0, 0.2)]).centres.len(), 1);
        let atlas = Atlas::new(direction, &[lobe(0.8, 0.0, 1e-3), lobe(0.81, 0.0, 0.01), lobe(0.2, 1.0, 1e-2)]);
        assert_eq!(atlas.centres.len(), 3);
        for v in [Vector::from_angles(0.3, 2.0), direction, mirror(direction), Vector::from_angles(1.5, 1.0)] {
            let each: Vec<f64> = atlas.shares().map(|share| share.of(v)).collect();
            assert!((each.iter().sum::<f64>() - 1.0).abs() < 1e-15 && each.iter().all(|s| *s >= 0.0), "{each:?}");
        }
        assert!(atlas.shares().nth(1).is_some_and(|share| share.of(mirror(direction)) == 0.0));
    }
}
