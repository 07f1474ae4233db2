//! Branch and bound: a box on which bounds say nothing is cut, until they do or the budget is spent.

use super::domain::{Domain, Edge, Region};
use super::enclosure::Enclosure;
use super::{Answer, Options, Proof, Provable, Rest, Witness};
use rayon::prelude::*;
use std::cmp::Ordering;
use std::collections::BinaryHeap;

/// The boxes that are cut together.
const GENERATION: usize = 256;
/// The rows that one task evaluates.
const TASK: usize = 128;
/// The boxes that [`Rest`] lists.
const LISTED: usize = 8;

/// A box that is open.
struct Item {
    region: Region,
    /// Of the whole domain.
    share: f64,
    /// That it is not negative, and that it is finite, is open.
    open: [bool; 2],
    bounds: Enclosure,
    order: usize,
}

impl PartialEq for Item {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}
impl Eq for Item {}
impl PartialOrd for Item {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Item {
    /// The largest first, and the oldest of those alike.
    fn cmp(&self, other: &Self) -> Ordering {
        self.share.total_cmp(&other.share).then(other.order.cmp(&self.order))
    }
}

struct Search<'a> {
    subject: &'a dyn Provable,
    domain: &'a Domain,
    witnesses: [Option<Witness>; 2],
    boxes: usize,
}

pub(super) fn prove(subject: &dyn Provable, domain: Domain, options: &Options) -> Proof {
    let mut search = Search { subject, domain: &domain, witnesses: [None, None], boxes: 0 };
    let mut heap = BinaryHeap::new();
    // What is too narrow to be cut.
    let mut stuck: Vec<Item> = Vec::new();
    search.admit(vec![(domain.whole(), 1.0, [true; 2])], &mut heap);
    while search.boxes < options.boxes && !heap.is_empty() {
        let room = (options.boxes - search.boxes).div_ceil(2).min(GENERATION);
        let mut items: Vec<Item> = Vec::with_capacity(room);
        while items.len() < room
            && let Some(item) = heap.pop()
        {
            if search.is_open(item.open) {
                items.push(item);
            }
        }
        let mut children = Vec::with_capacity(2 * items.len());
        for (item, axis) in search.axes(&items).into_iter().zip(items).map(|(axis, item)| (item, axis)) {
            let cut = axis.and_then(|axis| domain.halves(axis, *item.region.get(axis)?).map(|halves| (axis, halves)));
            let Some((axis, halves)) = cut else {
                stuck.push(item);
                continue;
            };
            let whole = item.region.get(axis).map_or(1.0, |edge| domain.share(axis, *edge));
            for half in halves {
                let mut region = item.region.clone();
                if let Some(edge) = region.get_mut(axis) {
                    *edge = half;
                }
                let part = if half.low == half.high { 0.5 } else { domain.share(axis, half) / whole };
                children.push((region, item.share * part, item.open));
            }
        }
        search.admit(children, &mut heap);
    }
    stuck.extend(heap.into_sorted_vec().into_iter().rev());
    let [sign, finite] = [0, 1].map(|property| answer(&mut search.witnesses[property], &stuck, property));
    let boxes = search.boxes;
    Proof { subject: subject.name(), domain, sign, finite, boxes }
}

/// What is known of a property in the end.
fn answer(witness: &mut Option<Witness>, rest: &[Item], property: usize) -> Answer {
    if let Some(witness) = witness.take() {
        return Answer::Disproved(witness);
    }
    let mut open: Vec<&Item> = rest.iter().filter(|item| item.open[property]).collect();
    if open.is_empty() {
        return Answer::Proved;
    }
    open.sort_by(|a, b| b.cmp(a));
    let worst = open.iter().take(LISTED).map(|item| (item.region.clone(), item.bounds)).collect();
    Answer::Undecided(Rest { share: open.iter().map(|item| item.share).sum(), count: open.len(), worst })
}

impl Search<'_> {
    fn is_open(&self, open: [bool; 2]) -> bool {
        open.iter().zip(&self.witnesses).any(|(open, witness)| *open && witness.is_none())
    }

    /// The bounds over regions.
    fn enclose(&self, regions: &[Region]) -> Vec<Enclosure> {
        let each = regions.par_chunks(TASK).map(|regions| {
            let rows: Vec<Enclosure> = regions.iter().flat_map(|region| self.domain.row(region)).collect();
            let mut bounds = self.subject.enclose(&rows, regions.len());
            // What is missing is not known.
            bounds.resize(regions.len(), Enclosure::ANYTHING);
            bounds
        });
        each.flatten().collect()
    }

    /// Bounds boxes, looks for witnesses in those that stay open, and keeps them.
    fn admit(&mut self, boxes: Vec<(Region, f64, [bool; 2])>, heap: &mut BinaryHeap<Item>) {
        let regions: Vec<Region> = boxes.iter().map(|(region, ..)| region.clone()).collect();
        let bounds = self.enclose(&regions);
        let mut open = Vec::new();
        for ((region, share, before), bounds) in boxes.into_iter().zip(bounds) {
            self.boxes += 1;
            let now = [before[0] && bounds.low() < 0.0, before[1] && !bounds.is_total()];
            if self.is_open(now) {
                open.push(Item { region, share, open: now, bounds, order: self.boxes });
            }
        }
        let points: Vec<Vec<f64>> =
            open.iter().flat_map(|item| [self.middle(&item.region), self.roundest(&item.region)]).collect();
        let values: Vec<f64> = points.par_chunks(TASK).map(|points| self.values(points)).flatten().collect();
        for (point, value) in points.iter().zip(values) {
            for property in [0, 1] {
                if self.witnesses[property].is_none() && violates(property, value) && self.confirms(property, point) {
                    self.witnesses[property] = Some(self.shrunk(property, point.clone(), value));
                }
            }
        }
        heap.extend(open);
    }

    fn values(&self, points: &[Vec<f64>]) -> Vec<f64> {
        let value = |point: &Vec<f64>| {
            let [wi, wo] = self.domain.pair(point);
            self.subject.value(wi, wo, self.domain.parameters_at(point))
        };
        points.iter().map(value).collect()
    }

    /// That a violation is no rounding of f64: a negative value must be so in exact arithmetic.
    fn confirms(&self, property: usize, point: &[f64]) -> bool {
        let region: Region = point.iter().map(|x| Edge { low: *x, high: *x }).collect();
        let bounds = self.enclose(&[region]);
        bounds.first().is_some_and(|bounds| property == 1 && !bounds.is_total() || bounds.high() < 0.0)
    }

    fn middle(&self, region: &[Edge]) -> Vec<f64> {
        region.iter().enumerate().map(|(axis, edge)| self.domain.middle(axis, *edge)).collect()
    }

    /// The point of the fewest digits, where poles like to be.
    fn roundest(&self, region: &[Edge]) -> Vec<f64> {
        let round = |(axis, edge): (usize, &Edge)| {
            let middle = self.domain.middle(axis, *edge);
            (0..=12)
                .map(|digits| rounded(middle, digits))
                .find(|x| (edge.low..=edge.high).contains(x) && self.domain.holds(axis, *x))
                .unwrap_or(middle)
        };
        region.iter().enumerate().map(round).collect()
    }

    /// The violation with as few digits as it bears.
    fn shrunk(&self, property: usize, mut point: Vec<f64>, mut value: f64) -> Witness {
        for axis in 0..point.len() {
            for digits in 0..=6 {
                let mut candidate = point.clone();
                let Some(x) = candidate.get_mut(axis) else { continue };
                *x = rounded(*x, digits);
                if !self.domain.holds(axis, *x) {
                    continue;
                }
                let new = self.values(std::slice::from_ref(&candidate)).first().copied().unwrap_or(0.0);
                if violates(property, new) && self.confirms(property, &candidate) {
                    (point, value) = (candidate, new);
                    break;
                }
            }
        }
        let [wi, wo] = self.domain.pair(&point);
        Witness { point, wi, wo, value }
    }

    /// The axis to cut each box along: that which, were it known exactly, would bring the bounds nearest to an answer.
    fn axes(&self, items: &[Item]) -> Vec<Option<usize>> {
        let mut trials = Vec::new();
        let mut regions = Vec::new();
        for (index, item) in items.iter().enumerate() {
            for (axis, edge) in item.region.iter().enumerate() {
                if self.domain.halves(axis, *edge).is_some() {
                    let middle = self.domain.middle(axis, *edge);
                    let mut region = item.region.clone();
                    if let Some(edge) = region.get_mut(axis) {
                        *edge = Edge { low: middle, high: middle };
                    }
                    trials.push((index, axis, self.domain.share(axis, *edge)));
                    regions.push(region);
                }
            }
        }
        let mut best: Vec<Option<(f64, f64, usize)>> = vec![None; items.len()];
        for ((index, axis, share), bounds) in trials.into_iter().zip(self.enclose(&regions)) {
            let Some(item) = items.get(index) else { continue };
            // A thousandth is noise: the widest of what helps alike.
            let gain = if !bounds.is_total() || !item.bounds.is_total() && item.open[0] && bounds.low() < -1e30 {
                0.0
            } else if !item.bounds.is_total() {
                1.0
            } else {
                ((bounds.low().min(0.0) - item.bounds.low()) / -item.bounds.low()).max(0.0)
            };
            let gain = (gain * 64.0).round();
            if let Some(best) = best.get_mut(index)
                && best.is_none_or(|(most, widest, _)| (gain, share) > (most, widest))
            {
                *best = Some((gain, share, axis));
            }
        }
        best.into_iter().map(|best| best.map(|(.., axis)| axis)).collect()
    }
}

fn violates(property: usize, value: f64) -> bool {
    if property == 0 { value < 0.0 } else { !value.is_finite() }
}

fn rounded(x: f64, digits: i32) -> f64 {
    // By way of its digits: 0.3, and not 3·0.1.
    format!("{x:.*}", digits.max(0) as usize).parse().unwrap_or(x)
}
