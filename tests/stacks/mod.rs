//! Stacks at which every rule of a plan applies, directions, and how far f of a plan may be off.
#![allow(dead_code)] // each test takes what it needs

use brdf::Vector;
use brdf::layered::{Interface, Layer, Medium, Model, Stack};

/// Numbers in [0, 1): Steele, Lea & Flood 2014, SplitMix64.
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
    pub(crate) fn log(&mut self, from: f64, to: f64) -> f64 {
        (from.ln() + (to / from).ln() * self.unit()).exp()
    }
    pub(crate) fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// Three numbers, or one number three times.
    pub(crate) fn channels(&mut self, same: bool, mut one: impl FnMut(&mut Self) -> f64) -> [f64; 3] {
        let first = one(self);
        if same { [first; 3] } else { [first, one(self), one(self)] }
    }

    /// Up to four layers of any kind, with everything that a rule looks for about every third time.
    pub(crate) fn stack(&mut self, model: Model) -> Stack<f64, 3> {
        let covers = (4.0 * self.unit()) as usize;
        let disperses = self.chance(0.15);
        let mut layers: Vec<Layer<f64, 3>> = Vec::new();
        for _ in 0..covers {
            let n = match layers.last() {
                Some(Layer { interface: Interface::Microfacet { n, .. }, .. }) if self.chance(0.3) => *n,
                _ if self.chance(0.1) => [1.0; 3],
                _ => self.channels(!disperses, |random| random.log(0.4, 4.0)),
            };
            let k = match self.unit() {
                x if x < 0.75 => [0.0; 3],
                x => self.channels(x < 0.9, |random| random.log(1e-6, 1.0)),
            };
            let interface = Interface::Microfacet { n, k, alpha: self.log(1e-3, 1.0) };
            let medium = if self.chance(0.4) {
                Medium::CLEAR
            } else {
                let sigma = self.channels(self.0 & 1 == 0, |random| random.log(1e-3, 100.0));
                Medium { sigma, thickness: self.unit() }
            };
            layers.push(Layer { interface, medium });
        }
        let base = match self.unit() {
            x if x < 0.4 => {
                let grey = self.chance(0.3);
                let n = self.channels(grey, |random| random.log(0.02, 8.0));
                let k = self.channels(grey, |random| random.log(0.01, 12.0));
                Interface::conductor(n, k, self.log(1e-3, 1.0))
            }
            x if x < 0.6 => Interface::dielectric(self.log(0.5, 3.0), self.log(1e-3, 1.0)),
            x => {
                let albedo = if self.chance(0.1) { [0.0; 3] } else { self.channels(false, Self::unit) };
                Interface::diffuse(albedo, if x < 0.8 { 0.0 } else { 1.5 * self.unit() })
            }
        };
        layers.push(Layer::new(base).over([1.0; 3], self.unit()));
        Stack::new(model, layers).expect("within the ranges")
    }

    /// A direction whose cosine is at least 1e-6, spaced in the logarithm towards grazing.
    pub(crate) fn direction(&mut self) -> Vector<f64> {
        let cos = if self.chance(0.3) { self.log(1e-6, 1.0) } else { self.unit().max(1e-6) };
        Vector::from_angles(cos.acos(), std::f64::consts::TAU * self.unit())
    }

    /// Half of the pairs mirror about a facet close to the normal.
    pub(crate) fn pair(&mut self) -> [Vector<f64>; 2] {
        let wi = self.direction();
        if self.chance(0.5) {
            return [wi, self.direction()];
        }
        let (slope, phi) = (self.log(1e-5, 1.0), std::f64::consts::TAU * self.unit());
        let m = Vector::new(slope * phi.cos(), slope * phi.sin(), 1.0).normalized();
        let wo = (m * (2.0 * wi.dot(m)) - wi).normalized();
        if wo.z > 1e-6 { [wi, wo] } else { [wi, self.direction()] }
    }
}

/// The most that f of each channel changes by where a component of a direction or a number of a layer changes by this share of it.
/// By a critical angle, behind a thinner medium at grazing, and where an exponent is large, that is what any way of computing f loses.
pub(crate) fn moved(stack: &Stack<f64, 3>, [wi, wo]: [Vector<f64>; 2], share: f64) -> [f64; 3] {
    let f: [f64; 3] = stack.evaluate(wi, wo);
    let mut moved = [0.0f64; 3];
    let mut compare = |near: [f64; 3]| {
        for channel in 0..3 {
            moved[channel] = moved[channel].max((near[channel] - f[channel]).abs());
        }
    };
    for factor in [1.0 - share, 1.0 + share] {
        for component in 0..6 {
            let mut numbers: [f64; 6] = [wi.x, wi.y, wi.z, wo.x, wo.y, wo.z];
            numbers[component] *= factor;
            let [a, b, c, d, e, g] = numbers;
            compare(stack.evaluate(Vector::new(a, b, c), Vector::new(d, e, g)));
        }
        for position in 0..stack.layers().len() {
            for number in 0..4 {
                let mut layers = stack.layers().to_vec();
                match (&mut layers[position], number) {
                    (Layer { interface: Interface::Microfacet { n, .. }, .. }, 0) => *n = n.map(|n| n * factor),
                    (Layer { interface: Interface::Microfacet { k, .. }, .. }, 1) => *k = k.map(|k| k * factor),
                    (Layer { interface: Interface::Microfacet { alpha, .. }, .. }, 2) => {
                        *alpha = (*alpha * factor).min(1.0)
                    }
                    (Layer { medium, .. }, 3) => medium.thickness *= factor,
                    _ => continue,
                }
                compare(Stack::new(stack.model(), layers).expect("within the ranges").evaluate(wi, wo));
            }
        }
    }
    moved
}

/// How far f of a plan may be off in f64, channel by channel: 1e-12 of it, and 8 times what 4 ε of a number do to it.
pub(crate) fn allowed(stack: &Stack<f64, 3>, pair: [Vector<f64>; 2]) -> [f64; 3] {
    let f: [f64; 3] = stack.evaluate(pair[0], pair[1]);
    let moved = moved(stack, pair, 4.0 * f64::EPSILON);
    [0, 1, 2].map(|c| 1e-12 * f[c] + 8.0 * moved[c] + 1e-30)
}
