//! What evaluations cost: measured, and the unit costs that predictions are made of.

use brdf::batch::{self, Kernel, Level};
use brdf::layered::Stack;
use brdf::plan::{Operations, Path, Plan};
use brdf::{Real, Vector};
use serde_json::{Map, Value, json};
use std::hint::black_box;
use std::time::Instant;

/// Evaluations that are measured together; with their results they stay in the second-level cache.
const COUNT: usize = 2048;
/// Rounds, of which each does everything that is compared once; the median counts.
const ROUNDS: usize = 15;

/// ns an evaluation, medians.
pub(crate) struct Costs {
    /// By [`Stack::evaluate`] in f32.
    pub(crate) general: f64,
    /// By [`Plan::evaluate`] in f32.
    pub(crate) plan: f64,
    /// By [`Plan::evaluate_batch`], on one thread.
    pub(crate) batch: f64,
    /// The level of the batch.
    pub(crate) level: Level,
}

impl Costs {
    pub(crate) fn json(&self) -> Value {
        json!({"general": self.general, "plan": self.plan, "batch": self.batch, "level": self.level.name()})
    }
}

/// Pairs of directions over the hemisphere, uniform in the cosine above .02 and in the azimuth.
fn directions() -> [Vec<f32>; 6] {
    // Roberts 2018: the root of x⁵ = x + 1 gives the steps of a sequence in four dimensions.
    const G: f64 = 1.167_303_978_261_418_7;
    let mut columns: [Vec<f32>; 6] = Default::default();
    for i in 0..COUNT as i32 {
        let point = [1, 2, 3, 4].map(|axis| (0.5 + f64::from(i) * G.powi(-axis)).fract());
        for (direction, [u, v]) in [[point[0], point[1]], [point[2], point[3]]].into_iter().enumerate() {
            let w = Vector::<f64>::from_angles((0.02 + 0.98 * u).acos(), std::f64::consts::TAU * v);
            for (axis, component) in [w.x, w.y, w.z].into_iter().enumerate() {
                columns[3 * direction + axis].push(component as f32);
            }
        }
    }
    columns
}

/// ns an evaluation of each run, in interleaved rounds.
fn interleaved<const N: usize>(mut runs: [&mut dyn FnMut(); N]) -> [f64; N] {
    let mut times = [(); N].map(|()| Vec::with_capacity(ROUNDS));
    for round in 0..=ROUNDS {
        for (run, times) in runs.iter_mut().zip(&mut times) {
            let start = Instant::now();
            run();
            let ns = start.elapsed().as_secs_f64() * 1e9 / COUNT as f64;
            // The first warms up.
            if round > 0 {
                times.push(ns);
            }
        }
    }
    times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    })
}

/// What a stack and its plan cost.
pub(crate) fn measure<const C: usize>(stack: &Stack<f32, C>, plan: &Plan<C>) -> Costs {
    let [costs, _] = measure_both(stack, [plan, plan]);
    costs
}

/// What a stack costs by two plans of it.
pub(crate) fn measure_both<const C: usize>(stack: &Stack<f32, C>, plans: [&Plan<C>; 2]) -> [Costs; 2] {
    let columns = directions();
    let pair = |i: usize| {
        let [a, b, c, d, e, f] = columns.each_ref().map(|column| column[i]);
        (Vector::new(a, b, c), Vector::new(d, e, f))
    };
    let pairs: Vec<_> = (0..COUNT).map(pair).collect();
    let [a, b, c, d, e, f] = columns.each_ref().map(Vec::as_slice);
    let mut first = [(); C].map(|()| vec![0.0f32; COUNT]);
    let mut second = first.clone();
    let mut general = || {
        for (wi, wo) in black_box(&pairs) {
            black_box(stack.evaluate(*wi, *wo));
        }
    };
    let scalar = |plan: &Plan<C>| {
        for (wi, wo) in black_box(&pairs) {
            black_box(plan.evaluate(*wi, *wo));
        }
    };
    let batch = |plan: &Plan<C>, results: &mut [Vec<f32>; C]| {
        let outputs = results.each_mut().map(Vec::as_mut_slice);
        // The slices are of one length.
        let _ = black_box(plan.evaluate_batch(black_box([a, b, c]), [d, e, f], outputs));
    };
    let times = interleaved([
        &mut general,
        &mut || scalar(plans[0]),
        &mut || scalar(plans[1]),
        &mut || batch(plans[0], &mut first),
        &mut || batch(plans[1], &mut second),
    ]);
    let [general, a, b, c, d] = times;
    let level = Level::detect();
    [Costs { general, plan: a, batch: c, level }, Costs { general, plan: b, batch: d, level }]
}

/// ns an operation takes in an evaluation, for each of [`Operations::KINDS`].
pub(crate) struct Unit {
    /// `scalar`, or the name of a level.
    pub(crate) name: &'static str,
    /// Whose operations they are.
    pub(crate) path: Path,
    pub(crate) ns: [f64; 6],
}

impl Unit {
    pub(crate) fn json(&self) -> Value {
        let kinds = Operations::KINDS.iter().zip(self.ns);
        Value::Object(kinds.map(|(kind, ns)| ((*kind).to_owned(), ns.into())).collect::<Map<_, _>>())
    }
}

/// The one table of unit costs.
pub(crate) type Units = Vec<Unit>;

/// `N` operations of a kind in each of two rows, each of what the one before left.
struct Rows<const KIND: usize, const N: usize>;

impl<const KIND: usize, const N: usize> Kernel<2, 1> for Rows<KIND, N> {
    #[inline(always)]
    fn evaluate<R: Real<Wide = R>>(&self, [first, second]: [R; 2]) -> [R; 1] {
        let mut row = [first, second];
        for i in 0..N {
            for (x, other) in [(0, second), (1, first)] {
                let last = row[x];
                row[x] = match KIND {
                    0 if i % 2 == 0 => last * other,
                    0 => last + other,
                    1 if i % 2 == 0 => last.min(row[1 - x]),
                    1 => last.max(other),
                    2 => other / last,
                    3 => last.sqrt(),
                    4 => (-last).exp_within(),
                    _ => last.angle(other),
                };
            }
        }
        [row[0] + row[1]]
    }
}

/// The unit costs of this machine, measured now: a twelfth of what two rows of 8 operations take longer than two of 2. Many evaluations
/// are under way at once, as in a batch: it is throughput that counts, not latency.
pub(crate) fn units() -> Units {
    let scalar = Unit { name: "scalar", path: Path::Scalar, ns: kinds(None) };
    let of = |level: Level| {
        let path =
            if level == Level::BASELINE && cfg!(target_arch = "x86_64") { Path::Batch } else { Path::FusedBatch };
        Unit { name: level.name(), path, ns: kinds(Some(level)) }
    };
    std::iter::once(scalar).chain(Level::available().map(of)).collect()
}

fn kinds(level: Option<Level>) -> [f64; 6] {
    [
        slope(&Rows::<0, 2>, &Rows::<0, 8>, level),
        slope(&Rows::<1, 2>, &Rows::<1, 8>, level),
        slope(&Rows::<2, 2>, &Rows::<2, 8>, level),
        slope(&Rows::<3, 2>, &Rows::<3, 8>, level),
        slope(&Rows::<4, 2>, &Rows::<4, 8>, level),
        slope(&Rows::<5, 2>, &Rows::<5, 8>, level),
    ]
}

/// ns that each of the 12 operations by which two rows differ takes: in a batch at a level, else one by one in f64.
fn slope<A: Kernel<2, 1>, B: Kernel<2, 1>>(short: &A, long: &B, level: Option<Level>) -> f64 {
    let start: Vec<f32> = (0..COUNT).map(|i| 0.5 + i as f32 / COUNT as f32).collect();
    let other: Vec<f32> = start.iter().rev().copied().collect();
    let (mut a, mut b) = (vec![0.0; COUNT], vec![0.0; COUNT]);
    fn run(kernel: &impl Kernel<2, 1>, level: Option<Level>, inputs: [&[f32]; 2], output: &mut [f32]) {
        match level {
            // The slices are of one length.
            Some(level) => drop(batch::map_at(level, kernel, black_box(inputs), [output])),
            None => {
                for (x, y) in inputs[0].iter().zip(inputs[1]) {
                    black_box(kernel.evaluate(black_box([f64::from(*x), f64::from(*y)])));
                }
            }
        }
    }
    let [short, long] = interleaved([&mut || run(short, level, [&start, &other], &mut a), &mut || {
        run(long, level, [&start, &other], &mut b)
    }]);
    ((long - short) / 12.0).max(0.0)
}
