//! Our side of `benches/peers/run`: evaluates and times on request, line by line over stdin and stdout.
//!
//! `cargo run --release --features rayon --example peers -- DIRECTIONS [LEVEL]`, where the file holds six arrays of f32 (little-endian): wi.x, wi.y,
//! wi.z, wo.x, wo.y, wo.z. Each request is answered by one line of JSON:
//!
//! * `names`: the subjects.
//! * `eval NAME THREADS`: seconds of one evaluation of all pairs into memory.
//! * `error NAME STEP FLOOR`: the relative errors of the last `eval NAME` against f64 at every STEP-th pair where f > FLOOR.
//! * `write NAME PATH`: the last result as three arrays of f32.

use brdf::batch::{self, Kernel, Level};
use brdf::layered::{Interface, Layer, Medium, Model, Stack};
use brdf::material::metal;
use brdf::microfacet::cos_half;
use brdf::plan::{Plan, Reflectance};
use brdf::{Real, Vector, distribution, fresnel, half_vector, masking};
use std::error::Error;
use std::io::{BufRead, Write};
use std::sync::LazyLock;
use std::time::Instant;

/// Pairs of directions, an array for each component.
struct Directions {
    wi: [Column; 3],
    wo: [Column; 3],
}

impl Directions {
    fn read(path: &str) -> Result<Self, Box<dyn Error>> {
        let bytes = std::fs::read(path)?;
        let (floats, rest) = bytes.as_chunks::<4>();
        let count = floats.len() / 6;
        if count == 0 || !rest.is_empty() || floats.len() != 6 * count {
            return Err(format!("{path} does not hold six arrays of f32").into());
        }
        let array =
            |i: usize| Column::new(i, floats[i * count..(i + 1) * count].iter().map(|b| f32::from_le_bytes(*b)));
        Ok(Directions { wi: [array(0), array(1), array(2)], wo: [array(3), array(4), array(5)] })
    }

    fn count(&self) -> usize {
        self.wi[0].numbers().len()
    }

    fn pair<R: Real>(&self, i: usize) -> [Vector<R>; 2] {
        [&self.wi, &self.wo].map(|w| Vector::new(w[0].numbers()[i], w[1].numbers()[i], w[2].numbers()[i]).cast())
    }
}

/// f of each channel.
type Output = [Column; 3];

/// An array that starts some cache lines into its pages. Arrays that all start at the same place of a page cost 10 to 20 % from
/// memory: their lines share the ways of the first cache (`brdf::batch`).
#[derive(Default)]
struct Column {
    numbers: Vec<f32>,
    start: usize,
}

impl Column {
    fn new(index: usize, numbers: impl ExactSizeIterator<Item = f32>) -> Self {
        const LINE: usize = 16;
        let start = index * LINE;
        Column { numbers: std::iter::repeat_n(0.0, start).chain(numbers).collect(), start }
    }
    fn numbers(&self) -> &[f32] {
        &self.numbers[self.start..]
    }
    fn numbers_mut(&mut self) -> &mut [f32] {
        &mut self.numbers[self.start..]
    }
}

/// What a subject reads, six slices of one length.
fn slices(directions: &Directions) -> [&[f32]; 6] {
    let [[a, b, c], [d, e, g]] = [&directions.wi, &directions.wo].map(|w| w.each_ref().map(Column::numbers));
    [a, b, c, d, e, g]
}

// The materials. `peer.py` has the same numbers.

const METAL_ALPHA: f64 = 0.3;
const COAT_ALPHA: f64 = 0.1;
const COAT_INDEX: f64 = 1.5;
const SIGMA: [f64; 3] = [0.1, 0.2, 0.3];
const THICKNESS: f64 = 0.5;

static COPPER: LazyLock<([f64; 3], [f64; 3])> =
    LazyLock::new(|| metal::by_name("copper").map_or(([0.0; 3], [0.0; 3]), |metal| (metal.n, metal.k)));

static STACK: LazyLock<Stack<f64, 3>> = LazyLock::new(|| {
    let (n, k) = *COPPER;
    let coat = Layer::new(Interface::dielectric(COAT_INDEX, COAT_ALPHA)).over(SIGMA, THICKNESS);
    Stack::new(Model::Conserving, vec![coat, Layer::new(Interface::conductor(n, k, METAL_ALPHA))])
        .expect("every number is in its range")
});

/// The largest error of F that the fitted subjects allow.
const FITTED: f64 = 1e-6;

static METAL: LazyLock<Stack<f64, 3>> = LazyLock::new(|| {
    let (n, k) = *COPPER;
    let metal = Layer::new(Interface::conductor(n, k, METAL_ALPHA));
    Stack::new(Model::Conserving, vec![metal]).expect("every number is in its range")
});

/// The coat without its absorption.
static CLEAR: LazyLock<Stack<f64, 3>> = LazyLock::new(|| {
    let mut layers = STACK.layers().to_vec();
    layers[0].medium = Medium::CLEAR;
    Stack::new(Model::Conserving, layers).expect("every number is in its range")
});

fn plan(stack: &Stack<f64, 3>, max_error: f64) -> Plan<3> {
    Plan::with_error(stack, max_error).expect("the model has a closed form")
}

static METAL_PLAN: LazyLock<Plan<3>> = LazyLock::new(|| plan(&METAL, 0.0));
static METAL_FITTED: LazyLock<Plan<3>> = LazyLock::new(|| plan(&METAL, FITTED));
static CLEAR_PLAN: LazyLock<Plan<3>> = LazyLock::new(|| plan(&CLEAR, 0.0));
static TINTED_PLAN: LazyLock<Plan<3>> = LazyLock::new(|| plan(&STACK, 0.0));
static TINTED_FITTED: LazyLock<Plan<3>> = LazyLock::new(|| plan(&STACK, FITTED));

static COPPER_F: LazyLock<Reflectance<3>> = LazyLock::new(|| Reflectance::new(COPPER.0, COPPER.1));

/// GGX under Smith's correlated masking.
struct Ggx(Reflectance<3>);

impl Kernel<6, 3> for Ggx {
    #[inline(always)]
    fn evaluate<R: Real<Wide = R>>(&self, [ix, iy, iz, ox, oy, oz]: [R; 6]) -> [R; 3] {
        let (wi, wo) = (Vector::new(ix, iy, iz), Vector::new(ox, oy, oz));
        let lobe = ggx_lobe(wi, wo);
        let [r, g, b] = Kernel::evaluate(&self.0, [cos_half(wi, wo)]);
        [r * lobe, g * lobe, b * lobe]
    }
}

#[inline(always)]
fn ggx_lobe<R: Real>(wi: Vector<R>, wo: Vector<R>) -> R {
    let alpha = R::from_f64(METAL_ALPHA);
    distribution::ggx(half_vector(wi, wo), alpha) * masking::smith_ggx(wi, wo, alpha, alpha).visibility
}

/// The same by the terms' own formulas, as the truth.
fn ggx(wi: Vector<f64>, wo: Vector<f64>) -> [f64; 3] {
    let (lobe, cos) = (ggx_lobe(wi, wo), cos_half(wi, wo));
    [0, 1, 2].map(|i| fresnel::conductor(cos, COPPER.0[i], COPPER.1[i]).reflectance * lobe)
}

// What is timed: a function for each subject.

/// On the calling thread, or on those of the current pool, which take the fastest level.
#[derive(Clone, Copy)]
enum Way {
    Alone(Level),
    Parallel,
}

fn planned(plan: &Plan<3>, directions: &Directions, way: Way, out: &mut Output) {
    let [a, b, c, d, e, g] = slices(directions);
    let out = out.each_mut().map(Column::numbers_mut);
    match way {
        Way::Alone(level) => plan.evaluate_batch_at(level, [a, b, c], [d, e, g], out),
        Way::Parallel => plan.par_evaluate_batch([a, b, c], [d, e, g], out),
    }
    .expect("arrays of one length");
}

fn conductor_ggx(directions: &Directions, way: Way, out: &mut Output) {
    let (kernel, out) = (Ggx(*COPPER_F), out.each_mut().map(Column::numbers_mut));
    let inputs = slices(directions);
    match way {
        Way::Alone(level) => batch::map_at(level, &kernel, inputs, out),
        Way::Parallel => batch::par_map(&kernel, inputs, out),
    }
    .expect("arrays of one length");
}

struct Subject {
    name: &'static str,
    run: fn(&Directions, Way, &mut Output),
    /// The exact model in f64: of a fitted subject the one that it was fitted to.
    exact: fn(Vector<f64>, Vector<f64>) -> [f64; 3],
}

const SUBJECTS: [Subject; 6] = [
    Subject {
        name: "conductor_beckmann",
        run: |directions, way, out| planned(&METAL_PLAN, directions, way, out),
        exact: |wi, wo| METAL.evaluate(wi, wo),
    },
    Subject {
        name: "conductor_beckmann_fitted",
        run: |directions, way, out| planned(&METAL_FITTED, directions, way, out),
        exact: |wi, wo| METAL.evaluate(wi, wo),
    },
    Subject { name: "conductor_ggx", run: conductor_ggx, exact: ggx },
    Subject {
        name: "layered",
        run: |directions, way, out| planned(&CLEAR_PLAN, directions, way, out),
        exact: |wi, wo| CLEAR.evaluate(wi, wo),
    },
    Subject {
        name: "layered_tinted",
        run: |directions, way, out| planned(&TINTED_PLAN, directions, way, out),
        exact: |wi, wo| STACK.evaluate(wi, wo),
    },
    Subject {
        name: "layered_tinted_fitted",
        run: |directions, way, out| planned(&TINTED_FITTED, directions, way, out),
        exact: |wi, wo| STACK.evaluate(wi, wo),
    },
];

/// The largest and the 99.9th percentile of |f − exact|/exact over every `step`-th pair and all channels.
fn error(subject: &Subject, directions: &Directions, out: &Output, step: usize, floor: f64) -> String {
    let mut errors = Vec::new();
    for i in (0..directions.count()).step_by(step.max(1)) {
        let [wi, wo] = directions.pair::<f64>(i);
        for (exact, out) in (subject.exact)(wi, wo).into_iter().zip(out) {
            if exact > floor {
                errors.push((f64::from(out.numbers()[i]) - exact).abs() / exact);
            }
        }
    }
    errors.sort_by(f64::total_cmp);
    // The percentile as numpy's method "lower" takes it.
    let at = |share: f64| errors.get((errors.len().saturating_sub(1) as f64 * share) as usize).copied().unwrap_or(0.0);
    format!(r#"{{"max":{:e},"p999":{:e},"count":{}}}"#, at(1.0), at(0.999), errors.len())
}

fn answer(
    line: &str,
    directions: &Directions,
    outputs: &mut [(&'static str, Output)],
    pools: &mut Vec<rayon::ThreadPool>,
    level: Level,
) -> Result<String, Box<dyn Error>> {
    let words: Vec<&str> = line.split_whitespace().collect();
    let [request, rest @ ..] = &words[..] else { return Err("an empty request".into()) };
    if *request == "names" {
        let names: Vec<String> = SUBJECTS.iter().map(|subject| format!("{:?}", subject.name)).collect();
        return Ok(format!("[{}]", names.join(",")));
    }
    let name = rest.first().ok_or("a request needs a name")?;
    let subject = SUBJECTS.iter().find(|subject| subject.name == *name).ok_or("unknown name")?;
    let (_, out) = outputs.iter_mut().find(|(other, _)| other == name).ok_or("unknown name")?;
    match (*request, &rest[1..]) {
        ("eval", [threads]) => {
            let threads = threads.parse::<usize>()?.max(1);
            if threads > 1 && pools.iter().all(|pool| pool.current_num_threads() != threads) {
                pools.push(rayon::ThreadPoolBuilder::new().num_threads(threads).build()?);
            }
            if out[0].numbers.is_empty() {
                *out = [6, 7, 8].map(|index| Column::new(index, vec![0.0; directions.count()].into_iter()));
            }
            let start = Instant::now();
            match pools.iter().find(|pool| threads > 1 && pool.current_num_threads() == threads) {
                Some(pool) => pool.install(|| (subject.run)(directions, Way::Parallel, out)),
                None => (subject.run)(directions, Way::Alone(level), out),
            }
            let seconds = start.elapsed().as_secs_f64();
            std::hint::black_box(out);
            Ok(format!(r#"{{"seconds":{seconds:e}}}"#))
        }
        ("error" | "write", _) if out[0].numbers.is_empty() => Err("nothing was evaluated yet".into()),
        ("error", [step, floor]) => Ok(error(subject, directions, out, step.parse()?, floor.parse()?)),
        ("write", [path]) => {
            let bytes: Vec<u8> = out.iter().flat_map(Column::numbers).flat_map(|x| x.to_le_bytes()).collect();
            std::fs::write(path, bytes)?;
            Ok(format!(r#"{{"written":{}}}"#, 3 * directions.count()))
        }
        _ => Err("an unknown request, or a wrong number of words".into()),
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let path = arguments.next().ok_or("usage: peers DIRECTIONS [LEVEL]")?;
    let level = match arguments.next() {
        Some(name) => {
            Level::available().find(|level| level.name() == name).ok_or("this processor has no such level")?
        }
        None => Level::detect(),
    };
    let directions = Directions::read(&path)?;
    let mut outputs = SUBJECTS.map(|subject| (subject.name, Output::default()));
    let mut pools = Vec::new();
    let mut stdout = std::io::stdout().lock();
    for line in std::io::stdin().lock().lines() {
        let reply = match answer(&line?, &directions, &mut outputs, &mut pools, level) {
            Ok(reply) => reply,
            Err(problem) => format!(r#"{{"error":{:?}}}"#, problem.to_string()),
        };
        writeln!(stdout, "{reply}")?;
        stdout.flush()?;
    }
    Ok(())
}
