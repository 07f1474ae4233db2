//! Every term and stack at random inputs and corners of its domain: no NaN, no infinity, no negative value, no panic.
//!
//! `ENDURANCE=1e9 cargo test --release --test accuracy endurance -- --nocapture` is the full run; with `BRDF_BLESS=1` it is
//! recorded. Arguments of drawn rows
//! are recombined, an eighth of them replaced by corners: the ends of each argument's range, cosines of 0 and next to it,
//! directions at, below and a hair above the horizon. Half of the evaluations are in f32, half in f64.

use crate::inputs::point;
use crate::terms::{Term, terms};
use brdf::Vector;
use brdf::layered::{Interface, Layer, Model, Stack};
use brdf::material::stack::built_in;

/// Evaluations of an ordinary run.
const COUNT: u64 = 4_000_000;
/// Drawn rows per term.
const POOL: usize = 1 << 13;

/// Marsaglia 2003, the 64-bit xorshift.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }
    fn below(&mut self, n: usize) -> usize {
        (((self.next() >> 32) * n as u64) >> 32) as usize
    }
}

/// Directions at the edges of the hemisphere and beyond them.
const DIRECTIONS: [[f32; 3]; 14] = [
    [0.0, 0.0, 1.0],
    [-0.0, -0.0, 1.0],
    [0.0, 0.0, -1.0],
    [1.0, 0.0, 0.0],
    [-1.0, 0.0, 0.0],
    [0.0, -1.0, -0.0],
    [1.0, 0.0, 1e-45],
    [-1.0, 0.0, 1e-45],
    [0.0, 1.0, 1.2e-38],
    [0.0, -1.0, 1e-20],
    [-1.0, 0.0, 1e-7],
    [0.8, 0.6, -1e-7],
    [0.6, -0.8, 6e-8],
    [3e-4, 0.0, 0.999_999_94],
];

/// Cosines and shares at the edges of [0, 1].
const UNIT: [f32; 9] = [0.0, -0.0, 1e-45, 1.2e-38, 1e-20, 1e-7, 0.5, 0.999_999_94, 1.0];

/// How many leading arguments of a term are vectors.
fn vectors(term: &Term) -> usize {
    match (term.module, term.function) {
        ("distribution", _)
        | ("refraction", "refract")
        | ("masking", "projected_area_ggx" | "projected_area_beckmann") => 1,
        ("masking" | "phong" | "microfacet", _) | ("layered", "elek" | "conserving" | "weidlich_wilkie") => 2,
        ("diffuse", "oren_nayar" | "oren_nayar_qualitative") | ("refraction", "refract_about") => 2,
        _ => 0,
    }
}

/// Whether an argument is a cosine or a share of 1, whose range is closed at 0.
fn is_unit(term: &Term, argument: usize) -> bool {
    match (term.module, term.function) {
        ("fresnel", "schlick" | "f82_tint") | ("layered", "internal_reflection") | ("diffuse", "lambert") => true,
        ("fresnel", "normal_incidence") => false,
        ("fresnel", _) | ("refraction", "cos_t") => argument == 0,
        ("absorption", _) => argument >= 2,
        ("diffuse", "oren_nayar_qualitative") => argument == 7,
        _ => false,
    }
}

/// Where a term gave what it must not.
#[derive(Default)]
struct Faults {
    count: u64,
    first: Vec<String>,
}

impl Faults {
    fn check(&mut self, value: f64, signed: bool, place: impl FnOnce() -> String) {
        if !value.is_finite() || value < 0.0 && !signed {
            self.count += 1;
            if self.first.len() < 40 {
                let place = place();
                if !self.first.iter().any(|other| other.split(" = ").next() == place.split(" = ").next()) {
                    self.first.push(place);
                }
            }
        }
    }
}

/// Evaluates a term at `count` recombined rows.
fn term_holds(term: &Term, count: u64, random: &mut Random, faults: &mut Faults) {
    let pool: Vec<Vec<f32>> = (0..POOL as u64).map(|i| (term.draw)(&point(i))).collect();
    let vectors = vectors(term);
    let width = pool[0].len();
    let end = |argument: usize, f: fn(f32, f32) -> f32| pool.iter().map(|row| row[argument]).fold(pool[0][argument], f);
    let ends: Vec<[f32; 2]> = (0..width).map(|i| [end(i, f32::min), end(i, f32::max)]).collect();
    let (mut row, mut wide) = (vec![0.0; width], vec![0.0; width]);
    for i in 0..count {
        // Whole rows keep what ties their arguments: a half vector close to the mirror's.
        let base = random.below(POOL);
        let mix = i % 4 != 0;
        for vector in 0..vectors {
            let dice = random.next();
            let from = if mix && dice & 1 == 1 { random.below(POOL) } else { base };
            let range = 3 * vector..3 * vector + 3;
            if mix && dice >> 1 & 7 == 0 {
                row[range].copy_from_slice(&DIRECTIONS[random.below(DIRECTIONS.len())]);
            } else {
                row[range.clone()].copy_from_slice(&pool[from][range]);
            }
        }
        for argument in 3 * vectors..width {
            let dice = random.next();
            let from = if mix && dice & 1 == 1 { random.below(POOL) } else { base };
            row[argument] = if mix && dice >> 1 & 7 == 0 {
                if is_unit(term, argument) { UNIT[random.below(UNIT.len())] } else { ends[argument][random.below(2)] }
            } else {
                pool[from][argument]
            };
        }
        let (values, number) = if i % 2 == 0 {
            ((term.single)(&row).map(f64::from), "f32")
        } else {
            for (wide, narrow) in wide.iter_mut().zip(&row) {
                *wide = f64::from(*narrow);
            }
            ((term.double)(&wide), "f64")
        };
        for value in &values[..term.results.len()] {
            faults.check(*value, term.signed, || format!("{} {number} = {value:e} at {row:?}", term.name()));
        }
    }
}

/// Evaluates stacks at `count` pairs of directions: the built-in ones, and deep ones under every closed-form model.
fn stacks_hold(count: u64, random: &mut Random, faults: &mut Faults) {
    let mut stacks: Vec<(String, Stack<f32, 3>)> = Vec::new();
    for material in built_in() {
        for model in Model::CLOSED_FORM {
            stacks
                .push((format!("{} {}", material.name, model.name()), material.stack.cast::<f32>().with_model(model)));
        }
    }
    let number = |random: &mut Random, low: f64, high: f64| {
        let u = random.next() as f64 / u64::MAX as f64;
        let corner = random.below(8);
        (if corner == 0 {
            low
        } else if corner == 1 {
            high
        } else {
            low + (high - low) * u
        }) as f32
    };
    for index in 0..600 {
        let mut layers = Vec::new();
        for _ in 0..random.below(4) {
            let n = number(random, 0.3, 3.0);
            let spread = if random.below(2) == 0 { 0.0 } else { 0.2 };
            let k = if random.below(2) == 0 { 0.0 } else { number(random, 0.0, 4.0) };
            let alpha = 10f64.powf(f64::from(number(random, -4.0, 0.0))).clamp(1.01e-4, 1.0) as f32;
            let sigma = [number(random, 0.0, 20.0), number(random, 0.0, 1.0), 0.0];
            layers.push(
                Layer::new(Interface::conductor([n, n + spread, n], [k; 3], alpha))
                    .over(sigma, number(random, 0.0, 5.0)),
            );
        }
        layers.push(if random.below(2) == 0 {
            Layer::new(Interface::diffuse([0.0, 1.0, number(random, 0.0, 1.0)], number(random, 0.0, 1.57)))
        } else {
            let (n, k) = (number(random, 0.02, 8.0), number(random, 0.0, 12.0));
            Layer::new(Interface::conductor([n; 3], [k, 0.0, k], number(random, 1.01e-4, 1.0)))
        });
        for model in Model::CLOSED_FORM {
            let stack = Stack::new(model, layers.clone()).unwrap_or_else(|error| panic!("{error}: {layers:?}"));
            stacks.push((format!("stack {index} {}", model.name()), stack));
        }
    }
    let doubles: Vec<Stack<f64, 3>> = stacks.iter().map(|(_, stack)| stack.cast()).collect();
    let drawn: Vec<[f32; 3]> = (0..POOL as u64)
        .map(|i| {
            let p = point(i);
            crate::inputs::upper(p[0], p[1]).into()
        })
        .collect();
    let direction = |random: &mut Random| -> Vector<f32> {
        let corner = random.below(8) == 0;
        Vector::from(if corner { DIRECTIONS[random.below(DIRECTIONS.len())] } else { drawn[random.below(POOL)] })
    };
    for i in 0..count {
        let (wi, mut wo) = (direction(random), direction(random));
        if i % 3 == 0 {
            wo = Vector::new(-wi.x, -wi.y, wi.z);
        }
        let at = random.below(stacks.len());
        let (name, single) = &stacks[at];
        let values = if i % 2 == 0 {
            single.evaluate(wi, wo).map(f64::from)
        } else {
            doubles[at].evaluate(wi.cast::<f64>(), wo.cast::<f64>())
        };
        for value in values {
            faults.check(value, false, || format!("{name} = {value:e} at {wi:?} {wo:?} {:?}", single.layers()));
        }
    }
}

/// Spreads `count` evaluations over all terms and, as one more share of five, the stacks.
fn run(count: u64) -> (u64, u64, Vec<String>) {
    let terms = terms();
    let share = count.div_ceil(terms.len() as u64 + 5);
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    let mut faults = Faults::default();
    for term in &terms {
        term_holds(term, share, &mut random, &mut faults);
    }
    stacks_hold(5 * share, &mut random, &mut faults);
    (share * (terms.len() as u64 + 5), faults.count, faults.first)
}

#[test]
fn endurance() {
    let count = std::env::var("ENDURANCE").map_or(COUNT, |text| text.parse::<f64>().expect("a number") as u64);
    let start = std::time::Instant::now();
    let (done, faults, first) = run(count);
    let seconds = start.elapsed().as_secs_f64();
    println!("{done} evaluations, {faults} faults, {seconds:.0} s");
    assert!(faults == 0, "{faults} of {done} evaluations:\n{}", first.join("\n"));
    if count > COUNT && std::env::var_os("BRDF_BLESS").is_some_and(|value| value == "1") {
        let record = format!("`ENDURANCE={count}` last ran {done} evaluations on one thread: {faults} faults.\n");
        std::fs::write(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/accuracy/endurance.txt"), record)
            .expect("the record can be written");
    }
}
