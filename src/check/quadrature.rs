//! Adaptive cubature over a rectangle, of several channels at once.
//!
//! Genz & Malik 1980, "An adaptive algorithm for numerical integration over an n-dimensional rectangular region": a rule
//! of degree 7 on 17 points whose points also carry one of degree 5. The difference is the error estimate; the panel with
//! the largest one is halved along the axis with the larger fourth difference until the sum meets the target. The panels
//! are kept as a binary tree, which the cross-check then draws samples from.

use core::cmp::Ordering;
use std::collections::BinaryHeap;

/// √(9/70), √(9/10), √(9/19).
const NEAR: f64 = 0.358_568_582_800_318_1;
const FAR: f64 = 0.948_683_298_050_513_8;
const CORNER: f64 = 0.688_247_201_611_685_3;

/// Offsets of the 17 points in half-widths, with the weights of degree 7 and of degree 5.
const RULE: [([f64; 2], f64, f64); 17] = {
    const CENTRE: (f64, f64) = (-3816.0 / 19683.0, -971.0 / 729.0);
    const A: (f64, f64) = (980.0 / 6561.0, 245.0 / 486.0);
    const B: (f64, f64) = (1020.0 / 19683.0, 65.0 / 1458.0);
    const C: (f64, f64) = (200.0 / 19683.0, 25.0 / 729.0);
    const D: f64 = 6859.0 / 78732.0;
    [
        ([0.0, 0.0], CENTRE.0, CENTRE.1),
        ([-NEAR, 0.0], A.0, A.1),
        ([NEAR, 0.0], A.0, A.1),
        ([0.0, -NEAR], A.0, A.1),
        ([0.0, NEAR], A.0, A.1),
        ([-FAR, 0.0], B.0, B.1),
        ([FAR, 0.0], B.0, B.1),
        ([0.0, -FAR], B.0, B.1),
        ([0.0, FAR], B.0, B.1),
        ([-FAR, -FAR], C.0, C.1),
        ([FAR, -FAR], C.0, C.1),
        ([-FAR, FAR], C.0, C.1),
        ([FAR, FAR], C.0, C.1),
        ([-CORNER, -CORNER], D, 0.0),
        ([CORNER, -CORNER], D, 0.0),
        ([-CORNER, CORNER], D, 0.0),
        ([CORNER, CORNER], D, 0.0),
    ]
};

/// Evaluations that one panel costs.
pub(super) const POINTS: usize = RULE.len();

/// Panels that are halved at once: their 14 halves have 238 points, a block of an interpreter.
const HALVED: usize = 7;

/// The share of the worst panel's error that another must have to be halved with it.
const ALIKE: f64 = 0.1;

/// The integral so far, and the panels that it was taken over.
pub(super) struct Cubature {
    channels: usize,
    nodes: Vec<Node>,
    estimates: Vec<f64>,
    errors: Vec<f64>,
    /// Slopes, curvatures and twist of the integrand over each panel, for the control variate.
    shapes: Vec<[f64; 5]>,
    pub(super) evaluations: usize,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    low: [f64; 2],
    high: [f64; 2],
    /// Axis and position of the cut and the first of the two children.
    cut: Option<(usize, f64, usize)>,
    /// The axis along which the integrand is rougher.
    axis: usize,
    /// The largest error of a channel.
    error: f64,
    /// Share of the samples that the cross-check draws here.
    mass: f64,
}

struct Ranked(f64, usize);

impl PartialEq for Ranked {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}
impl Eq for Ranked {}
impl PartialOrd for Ranked {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl Ord for Ranked {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0).then(other.1.cmp(&self.1))
    }
}

impl Cubature {
    /// A rectangle that starts with cuts at the given edges along either axis (ascending, ends included).
    pub(super) fn new(channels: usize, edges: [&[f64]; 2]) -> Self {
        let end = |e: &[f64], last: bool| (if last { e.last() } else { e.first() }).copied().unwrap_or(0.0);
        let mut cubature = Cubature {
            channels,
            nodes: Vec::new(),
            estimates: Vec::new(),
            errors: Vec::new(),
            shapes: Vec::new(),
            evaluations: 0,
        };
        cubature.push([end(edges[0], false), end(edges[1], false)], [end(edges[0], true), end(edges[1], true)]);
        cubature.cut_at(0, edges);
        cubature
    }

    fn push(&mut self, low: [f64; 2], high: [f64; 2]) -> usize {
        self.nodes.push(Node { low, high, cut: None, axis: 0, error: 0.0, mass: 0.0 });
        self.estimates.resize(self.nodes.len() * self.channels, 0.0);
        self.errors.resize(self.nodes.len() * self.channels, 0.0);
        self.shapes.resize(self.nodes.len() * self.channels, [0.0; 5]);
        self.nodes.len() - 1
    }

    fn cut(&mut self, node: usize, axis: usize, at: f64) -> usize {
        let Node { low, high, .. } = self.nodes[node];
        let (mut middle_high, mut middle_low) = (high, low);
        middle_high[axis] = at;
        middle_low[axis] = at;
        let first = self.push(low, middle_high);
        self.push(middle_low, high);
        self.nodes[node].cut = Some((axis, at, first));
        first
    }

    fn cut_at(&mut self, node: usize, edges: [&[f64]; 2]) {
        let axis = usize::from(edges[0].len() <= 2);
        let cuts = edges[axis];
        if cuts.len() <= 2 {
            return;
        }
        let middle = cuts.len() / 2;
        let first = self.cut(node, axis, cuts[middle]);
        let (mut below, mut above) = (edges, edges);
        below[axis] = &cuts[..=middle];
        above[axis] = &cuts[middle..];
        self.cut_at(first, below);
        self.cut_at(first + 1, above);
    }

    /// Cuts the panel around a point until `small` says that it is (given its corners).
    pub(super) fn focus(&mut self, point: [f64; 2], small: impl Fn([f64; 2], [f64; 2]) -> [bool; 2]) {
        for _ in 0..48 {
            let leaf = self.leaf(point);
            let Node { low, high, .. } = self.nodes[leaf];
            let Some(axis) = small(low, high).iter().position(|small| !small) else { return };
            self.cut(leaf, axis, 0.5 * (low[axis] + high[axis]));
        }
    }

    /// Halves panels, along either axis in turn, until none holds more than `most` of the points.
    pub(super) fn divide(&mut self, points: &[[f64; 2]], most: usize) {
        let mut counts = std::collections::HashMap::<usize, Vec<[f64; 2]>>::new();
        for &point in points {
            counts.entry(self.leaf(point)).or_default().push(point);
        }
        let mut crowded: Vec<(usize, Vec<[f64; 2]>, u32)> =
            counts.into_iter().map(|(leaf, held)| (leaf, held, 0)).collect();
        crowded.sort_by_key(|(leaf, ..)| *leaf);
        while let Some((leaf, held, depth)) = crowded.pop() {
            if held.len() <= most || depth > 40 {
                continue;
            }
            let axis = (depth % 2) as usize;
            let Node { low, high, .. } = self.nodes[leaf];
            let at = 0.5 * (low[axis] + high[axis]);
            let first = self.cut(leaf, axis, at);
            let (below, above) = held.into_iter().partition(|point: &[f64; 2]| point[axis] < at);
            crowded.extend([(first, below, depth + 1), (first + 1, above, depth + 1)]);
        }
    }

    /// The panels with their integrals and errors, of the first channel, neighbours mostly one after the other.
    pub(super) fn leaves(&self) -> Vec<(usize, f64, f64)> {
        let mut leaves = Vec::new();
        let mut open = vec![0];
        while let Some(node) = open.pop() {
            match self.nodes[node].cut {
                Some((_, _, first)) => open.extend([first + 1, first]),
                None => leaves.push((node, self.estimates[node * self.channels], self.errors[node * self.channels])),
            }
        }
        leaves
    }

    pub(super) fn leaf(&self, point: [f64; 2]) -> usize {
        let mut node = 0;
        while let Some((axis, at, first)) = self.nodes[node].cut {
            node = first + usize::from(point[axis] >= at);
        }
        node
    }

    /// Evaluates the panels of `nodes` at once.
    fn measure(&mut self, nodes: &[usize], f: &mut impl FnMut(&[[f64; 2]], &mut [f64])) {
        let mut points = Vec::with_capacity(POINTS * nodes.len());
        for &node in nodes {
            let Node { low, high, .. } = self.nodes[node];
            let half = [0.5 * (high[0] - low[0]), 0.5 * (high[1] - low[1])];
            points.extend(RULE.iter().map(|(o, ..)| [0, 1].map(|axis| low[axis] + half[axis] * (1.0 + o[axis]))));
        }
        let mut values = vec![0.0; points.len() * self.channels];
        f(&points, &mut values);
        self.evaluations += points.len();
        for (&node, values) in nodes.iter().zip(values.chunks_exact(POINTS * self.channels)) {
            self.digest(node, values);
        }
    }

    fn digest(&mut self, node: usize, values: &[f64]) {
        let (n, Node { low, high, .. }) = (self.channels, self.nodes[node]);
        let half = [0.5 * (high[0] - low[0]), 0.5 * (high[1] - low[1])];
        let area = 4.0 * half[0] * half[1];
        let mut rough = [0.0; 2];
        let mut worst = 0.0f64;
        for channel in 0..n {
            let at = |i: usize| values[i * n + channel];
            let (mut seven, mut five) = (0.0, 0.0);
            for (i, (_, w7, w5)) in RULE.iter().enumerate() {
                seven += w7 * at(i);
                five += w5 * at(i);
            }
            let error = area * (seven - five).abs();
            self.estimates[node * n + channel] = area * seven;
            self.errors[node * n + channel] = error;
            worst = worst.max(error);
            let slope = |plus: f64, minus: f64| (plus - minus) / (2.0 * FAR);
            let bend = |plus: f64, minus: f64| (plus + minus - 2.0 * at(0)) / (2.0 * FAR * FAR);
            self.shapes[node * n + channel] = [
                slope(at(6), at(5)),
                slope(at(8), at(7)),
                bend(at(6), at(5)),
                bend(at(8), at(7)),
                (at(9) - at(10) - at(11) + at(12)) / (4.0 * FAR * FAR),
            ];
            for (axis, rough) in rough.iter_mut().enumerate() {
                // λ₂²/λ₃² = 1/7.
                let near = at(1 + 2 * axis) + at(2 + 2 * axis) - 2.0 * at(0);
                let far = at(5 + 2 * axis) + at(6 + 2 * axis) - 2.0 * at(0);
                *rough += (near - far / 7.0).abs();
            }
        }
        self.nodes[node].error = worst;
        self.nodes[node].axis = usize::from(rough[1] > rough[0]);
    }

    /// Integrates `f` until the error estimates sum to `target` (relative to integrals above 1) or the budget is spent.
    ///
    /// `f` is given points in blocks, and writes the channels of one after the other. Several of the worst panels are halved
    /// at a time, those whose errors are of one magnitude.
    pub(super) fn run(&mut self, target: f64, evaluations: usize, mut f: impl FnMut(&[[f64; 2]], &mut [f64])) {
        if self.channels == 0 {
            return;
        }
        let leaves: Vec<usize> = (0..self.nodes.len()).filter(|&node| self.nodes[node].cut.is_none()).collect();
        for block in leaves.chunks(2 * HALVED) {
            self.measure(block, &mut f);
        }
        let mut heap: BinaryHeap<Ranked> = leaves.iter().map(|&node| Ranked(self.nodes[node].error, node)).collect();
        let mut error: f64 = leaves.iter().map(|&node| self.nodes[node].error).sum();
        let mut size: f64 = leaves.iter().map(|&node| self.size(node)).sum();
        let (mut parents, mut children) = (Vec::new(), Vec::new());
        let mut divisible = true;
        while divisible && error > target * size.max(1.0) {
            parents.clear();
            children.clear();
            let (mut most, mut rest) = (0.0, error);
            while parents.len() < HALVED
                && self.evaluations + 2 * POINTS * (parents.len() + 1) <= evaluations
                && rest > target * size.max(1.0)
            {
                let Some(Ranked(worst, node)) = heap.pop() else { break };
                let Node { low, high, axis, .. } = self.nodes[node];
                let middle = 0.5 * (low[axis] + high[axis]);
                divisible = low[axis] < middle && middle < high[axis];
                most = f64::max(most, worst);
                if !divisible || worst < ALIKE * most {
                    heap.push(Ranked(worst, node));
                    break;
                }
                let first = self.cut(node, axis, middle);
                parents.push((node, first));
                children.extend([first, first + 1]);
                rest -= worst;
                size -= self.size(node);
            }
            if parents.is_empty() {
                break;
            }
            error = rest;
            self.measure(&children, &mut f);
            for &(node, first) in &parents {
                self.doubt(node, first);
                for child in [first, first + 1] {
                    heap.push(Ranked(self.nodes[child].error, child));
                    error += self.nodes[child].error;
                    size += self.size(child);
                }
            }
        }
    }

    /// Two rules can agree by luck. What the halves together differ from the whole by is a second, independent estimate.
    fn doubt(&mut self, parent: usize, first: usize) {
        let n = self.channels;
        for c in 0..n {
            let [whole, a, b] = [parent, first, first + 1].map(|node| self.estimates[node * n + c]);
            let doubt = 0.5 * (whole - a - b).abs();
            for child in [first, first + 1] {
                let error = &mut self.errors[child * n + c];
                *error = error.max(doubt);
                self.nodes[child].error = self.nodes[child].error.max(*error);
            }
        }
    }

    fn size(&self, node: usize) -> f64 {
        self.estimates[node * self.channels..][..self.channels].iter().fold(0.0, |a, x| x.abs().max(a))
    }

    /// The integral of each channel and its error estimate, summed afresh over the panels.
    pub(super) fn result(&self) -> (Vec<f64>, Vec<f64>) {
        let (mut value, mut error) = (vec![0.0; self.channels], vec![0.0; self.channels]);
        for (i, _) in self.nodes.iter().enumerate().filter(|(_, node)| node.cut.is_none()) {
            for c in 0..self.channels {
                value[c] += self.estimates[i * self.channels + c];
                error[c] += self.errors[i * self.channels + c];
            }
        }
        (value, error)
    }

    /// Prepares [`Cubature::sample`]: panels are drawn in proportion to what they hold, none never.
    pub(super) fn weigh(&mut self) {
        let leaves = self.nodes.iter().filter(|node| node.cut.is_none()).count();
        let total: f64 = (0..self.nodes.len()).filter(|&i| self.nodes[i].cut.is_none()).map(|i| self.size(i)).sum();
        let least = (0.02 * total / leaves as f64).max(f64::MIN_POSITIVE);
        for node in (0..self.nodes.len()).rev() {
            self.nodes[node].mass = match self.nodes[node].cut {
                Some((_, _, first)) => self.nodes[first].mass + self.nodes[first + 1].mass,
                None => self.size(node) + self.nodes[node].error + least,
            };
        }
    }

    /// A point drawn in proportion to the panels, by warping a uniform one down the tree.
    pub(super) fn sample(&self, mut u: [f64; 2]) -> [f64; 2] {
        let mut node = 0;
        while let Some((axis, _, first)) = self.nodes[node].cut {
            let share = self.nodes[first].mass / self.nodes[node].mass;
            if u[axis] < share {
                u[axis] /= share;
                node = first;
            } else {
                u[axis] = (u[axis] - share) / (1.0 - share);
                node = first + 1;
            }
        }
        let Node { low, high, .. } = self.nodes[node];
        [0, 1].map(|axis| low[axis] + u[axis].clamp(0.0, 1.0) * (high[axis] - low[axis]))
    }

    /// The quadratic through each panel whose integral is exactly [`Cubature::result`], in every channel: the control
    /// variate of the cross-check.
    pub(super) fn model(&self, point: [f64; 2], model: &mut [f64]) {
        let leaf = self.leaf(point);
        let Node { low, high, .. } = self.nodes[leaf];
        let inverse = 1.0 / ((high[0] - low[0]) * (high[1] - low[1]));
        let [x, y] = [0, 1].map(|i| (2.0 * point[i] - low[i] - high[i]) / (high[i] - low[i]));
        for (channel, model) in model.iter_mut().enumerate() {
            let [a, b, aa, bb, ab] = self.shapes[leaf * self.channels + channel];
            let mean = self.estimates[leaf * self.channels + channel] * inverse;
            *model = mean + a * x + b * y + aa * (x * x - 1.0 / 3.0) + bb * (y * y - 1.0 / 3.0) + ab * x * y;
        }
    }

    /// The density of [`Cubature::sample`] at a point.
    pub(super) fn density(&self, point: [f64; 2]) -> f64 {
        let Node { low, high, mass, .. } = self.nodes[self.leaf(point)];
        mass / (self.nodes[0].mass * (high[0] - low[0]) * (high[1] - low[1]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degree_seven_is_exact() {
        let edges = [-1.0, 0.5, 2.0];
        let mut c = Cubature::new(2, [&edges, &[0.0, 1.0]]);
        c.run(1e-12, 17 * 2, |points, f| {
            for ([x, y], f) in points.iter().zip(f.chunks_exact_mut(2)) {
                f[0] = x.powi(4) * y.powi(3);
                f[1] = 1.0;
            }
        });
        let (value, error) = c.result();
        assert!((value[0] - 33.0 / 5.0 / 4.0).abs() < 1e-13 && (value[1] - 3.0).abs() < 1e-13, "{value:?} {error:?}");
    }

    #[test]
    fn samples_follow_the_panels() {
        let mut c = Cubature::new(1, [&[0.0, 1.0], &[0.0, 1.0]]);
        c.run(1e-5, 10_000, |points, f| {
            for ([x, y], f) in points.iter().zip(f) {
                *f = (-((x - 0.3) / 0.05).powi(2) - ((y - 0.6) / 0.1).powi(2)).exp();
            }
        });
        let (value, error) = c.result();
        let exact = core::f64::consts::PI * 0.005;
        assert!((value[0] - exact).abs() <= error[0] && error[0] < 1e-4, "{value:?} {error:?}");
        c.weigh();
        let n = 64;
        let (mut mean, mut model) = (0.0, 0.0);
        for i in 0..n * n {
            let u = [(f64::from(i % n) + 0.5) / f64::from(n), (f64::from(i / n) + 0.5) / f64::from(n)];
            let mut value = [0.0];
            c.model(u, &mut value);
            model += value[0] / f64::from(n * n);
            let [x, y] = c.sample(u);
            mean += (x + y) / f64::from(n * n);
        }
        // The Gaussian's centre, but for the panels' width and the floor.
        assert!((mean - 0.9).abs() < 0.05, "{mean}");
        assert!((model / value[0] - 1.0).abs() < 0.02, "{model}");
    }
}
