//! Plans against the general evaluation of the same stack, and each rule at work.

use brdf::Vector;
use brdf::batch::{LengthError, Level};
use brdf::layered::{Interface, Layer, Medium, Model, Stack};
use brdf::material::stack;
use brdf::plan::{Options, Plan, Rule};

/// Numbers in [0, 1): Steele, Lea & Flood 2014, SplitMix64.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
    fn log(&mut self, from: f64, to: f64) -> f64 {
        (from.ln() + (to / from).ln() * self.unit()).exp()
    }
    fn chance(&mut self, probability: f64) -> bool {
        self.unit() < probability
    }

    /// Three numbers, or one number three times.
    fn channels(&mut self, same: bool, mut one: impl FnMut(&mut Self) -> f64) -> [f64; 3] {
        let first = one(self);
        if same { [first; 3] } else { [first, one(self), one(self)] }
    }

    /// Up to four layers of any kind, with everything that a rule looks for about every third time.
    fn stack(&mut self, model: Model) -> Stack<f64, 3> {
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
    fn direction(&mut self) -> Vector<f64> {
        let cos = if self.chance(0.3) { self.log(1e-6, 1.0) } else { self.unit().max(1e-6) };
        Vector::from_angles(cos.acos(), std::f64::consts::TAU * self.unit())
    }

    /// Half of the pairs mirror about a facet close to the normal.
    fn pair(&mut self) -> [Vector<f64>; 2] {
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
fn moved(stack: &Stack<f64, 3>, [wi, wo]: [Vector<f64>; 2], share: f64) -> [f64; 3] {
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
                    (Layer { interface: Interface::Microfacet { alpha, .. }, .. }, 2) => *alpha = (*alpha * factor).min(1.0),
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
fn allowed(stack: &Stack<f64, 3>, pair: [Vector<f64>; 2]) -> [f64; 3] {
    let f: [f64; 3] = stack.evaluate(pair[0], pair[1]);
    let moved = moved(stack, pair, 4.0 * f64::EPSILON);
    [0, 1, 2].map(|c| 1e-12 * f[c] + 8.0 * moved[c] + 1e-30)
}

#[test]
fn plans_mean_what_their_stacks_mean() {
    let mut random = Random(1);
    let mut seen = std::collections::HashMap::<Rule, usize>::new();
    let mut worst = 0.0f64;
    for round in 0..3 * 4_000 {
        let model = Model::CLOSED_FORM[round % 3];
        let stack = random.stack(model);
        let plan = Plan::new(&stack).expect("a closed form");
        for applied in plan.applied() {
            *seen.entry(applied.rule).or_default() += 1;
            assert!(applied.layer < stack.layers().len());
        }
        for _ in 0..12 {
            let [wi, wo] = random.pair();
            let (want, got): ([f64; 3], [f64; 3]) = (stack.evaluate(wi, wo), plan.evaluate(wi, wo));
            for ((want, got), bound) in want.into_iter().zip(got).zip(allowed(&stack, [wi, wo])) {
                let error = (got - want).abs();
                worst = worst.max(error / (want + 1e-18));
                assert!(
                    error <= bound,
                    "{wi:?} {wo:?}: {got:e}, but the stack's f is {want:e}, {bound:e} allowed\n{stack:?}\n{plan:?}"
                );
            }
        }
    }
    println!("largest relative difference {worst:e}");
    for rule in Rule::ALL {
        assert!(seen.get(&rule).is_some_and(|times| *times > 20), "{rule} was hardly ever applied: {seen:?}");
    }
}

/// Structure of arrays, as a batch takes them.
fn columns(pairs: &[[Vector<f32>; 2]]) -> [Vec<f32>; 6] {
    let one = |c: usize| {
        let number = |[wi, wo]: &[Vector<f32>; 2]| [wi.x, wi.y, wi.z, wo.x, wo.y, wo.z][c];
        pairs.iter().map(number).collect()
    };
    [0, 1, 2, 3, 4, 5].map(one)
}

/// f of a plan for pairs of directions, by a batch at a level.
fn batch(plan: &Plan<3>, level: Level, pairs: &[[Vector<f32>; 2]]) -> Vec<[f32; 3]> {
    let columns = columns(pairs);
    let [a, b, c, d, e, g] = columns.each_ref().map(Vec::as_slice);
    // What is not written shows.
    let mut f = [(); 3].map(|()| vec![f32::NAN; pairs.len()]);
    plan.evaluate_batch_at(level, [a, b, c], [d, e, g], f.each_mut().map(Vec::as_mut_slice)).expect("of one length");
    (0..pairs.len()).map(|i| [f[0][i], f[1][i], f[2][i]]).collect()
}

/// The bits of every number.
fn bits(f: &[[f32; 3]]) -> Vec<[u32; 3]> {
    f.iter().map(|f| f.map(f32::to_bits)).collect()
}

/// A plan of each of the built-in materials, under each closed-form model.
fn built_in_plans() -> impl Iterator<Item = Plan<3>> {
    let of = |model| stack::built_in().into_iter().map(move |one| one.stack.with_model(model));
    Model::CLOSED_FORM.into_iter().flat_map(of).map(|stack| Plan::new(&stack).expect("a closed form"))
}

/// The spacing of f32 at a positive number.
fn ulp(x: f64) -> f64 {
    f64::from((x as f32).next_up() - x as f32)
}

/// What an Oren–Nayar base may reflect: its parts of that size cancel.
fn cancels(stack: &Stack<f64, 3>) -> [f64; 3] {
    match stack.layers().last().map(|layer| layer.interface) {
        Some(Interface::Diffuse { albedo, sigma }) if sigma > 0.0 => albedo.map(|albedo| albedo / std::f64::consts::PI),
        _ => [0.0; 3],
    }
}

#[test]
fn explore_batch() {
    let mut random = Random(7);
    let mut worst = std::collections::BTreeMap::<(usize, String), (f64, String)>::new();
    let rounds: usize = std::env::var("ROUNDS").map_or(4000, |text| text.parse().expect("a number"));
    for round in 0..rounds {
        let model = Model::CLOSED_FORM[round % 3];
        let stack = random.stack(model);
        let plan = Plan::new(&stack).expect("a closed form");
        let base = cancels(&stack);
        let pairs: Vec<[Vector<f32>; 2]> = (0..32).map(|_| random.pair().map(|w| w.cast())).collect();
        for level in Level::available() {
            for (got, pair) in batch(&plan, level, &pairs).into_iter().zip(&pairs) {
                let pair = pair.map(|w| w.cast::<f64>());
                let want: [f64; 3] = stack.evaluate(pair[0], pair[1]);
                let mut sensitive = None;
                for c in 0..3 {
                    if want[c] < 1e-8 { continue; }
                    let error = (f64::from(got[c]) - want[c]).abs();
                    let ulps = error / ulp(want[c]);
                    let mut note = |key: &str, value: f64| {
                        let entry = worst.entry((stack.layers().len(), key.to_owned())).or_default();
                        if !(value <= entry.0) {
                            *entry = (value, format!("{} {pair:?} {:e} {stack:?}", level.name(), want[c]));
                        }
                    };
                    if ulps > 6.0 {
                        let m = sensitive.get_or_insert_with(|| moved(&stack, pair, 0.5 * f64::from(f32::EPSILON)))[c];
                        let scale = ulp(base[c].max(1e-30));
                        let c = m / ulp(want[c]);
                        if c < 1.0 && base[0] == 0.0 { note("c<1", ulps); }
                        else if c < 2.0 && base[0] == 0.0 { note("c<2", ulps); }
                        else if c < 4.0 && base[0] == 0.0 { note("c<4", ulps); }
                        else if base[0] == 0.0 { note("c>4, ratio", ulps / c); }
                        else { note("oren", (error - 4.0 * m - 12.0 * ulp(want[0])) / scale); }
                    } else { note("small", ulps); }
                }
            }
        }
    }
    for (key, (error, at)) in worst {
        println!("{key:?} {error:.2}");
        if error > 12.0 { println!("    {at}"); }
    }
}
