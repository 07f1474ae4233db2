//! Our side of `benches/peers/run`: evaluates and times on request, line by line over stdin and stdout.
//!
//! `cargo run --release --example peers -- DIRECTIONS`, where the file holds six arrays of f32 (little-endian): wi.x, wi.y,
//! wi.z, wo.x, wo.y, wo.z. Each request is answered by one line of JSON:
//!
//! * `names`: the subjects.
//! * `eval NAME THREADS`: seconds of one evaluation of all pairs into memory.
//! * `error NAME STEP FLOOR`: the relative errors of the last `eval NAME` against f64 at every STEP-th pair where f > FLOOR.
//! * `write NAME PATH`: the last result as three arrays of f32.

use brdf::fresnel::Fit;
use brdf::layered::{Interface, Layer, Model, Stack};
use brdf::material::metal;
use brdf::microfacet::{cos_half, facets, torrance_sparrow};
use brdf::refraction::refract;
use brdf::single::Single;
use brdf::{Real, Vector, absorption, distribution, fresnel, half_vector, masking};
use std::error::Error;
use std::io::{BufRead, Write};
use std::sync::LazyLock;
use std::time::Instant;

/// Pairs of directions, an array for each component.
struct Directions {
    wi: [Vec<f32>; 3],
    wo: [Vec<f32>; 3],
}

impl Directions {
    fn read(path: &str) -> Result<Self, Box<dyn Error>> {
        let bytes = std::fs::read(path)?;
        let (floats, rest) = bytes.as_chunks::<4>();
        let count = floats.len() / 6;
        if count == 0 || !rest.is_empty() || floats.len() != 6 * count {
            return Err(format!("{path} does not hold six arrays of f32").into());
        }
        let array = |i: usize| floats[i * count..(i + 1) * count].iter().map(|b| f32::from_le_bytes(*b)).collect();
        Ok(Directions { wi: [array(0), array(1), array(2)], wo: [array(3), array(4), array(5)] })
    }

    fn count(&self) -> usize {
        self.wi[0].len()
    }

    fn pair<R: Real>(&self, i: usize) -> [Vector<R>; 2] {
        [&self.wi, &self.wo].map(|w| Vector::new(w[0][i], w[1][i], w[2][i]).cast())
    }
}

type Output = [Vec<f32>; 3];

/// Calls `part(wi, wo, out)` with a contiguous part of all arrays on each thread: the shape of a batch call.
fn split(
    directions: &Directions,
    threads: usize,
    out: &mut Output,
    part: impl Fn([&[f32]; 3], [&[f32]; 3], [&mut [f32]; 3]) + Sync,
) {
    let count = directions.count();
    let mut rest = out.each_mut().map(Vec::as_mut_slice);
    let mut start = 0;
    std::thread::scope(|scope| {
        for thread in 0..threads {
            let end = count * (thread + 1) / threads;
            let [wi, wo] = [&directions.wi, &directions.wo].map(|w| w.each_ref().map(|array| &array[start..end]));
            let (mine, others) = rest.map(|array| array.split_at_mut(end - start)).into_halves();
            (rest, start) = (others, end);
            let part = &part;
            if thread + 1 == threads {
                part(wi, wo, mine);
            } else {
                scope.spawn(move || part(wi, wo, mine));
            }
        }
    });
}

/// Three pairs as a pair of threes.
trait Halves<T> {
    fn into_halves(self) -> ([T; 3], [T; 3]);
}
impl<T> Halves<T> for [(T, T); 3] {
    fn into_halves(self) -> ([T; 3], [T; 3]) {
        let [a, b, c] = self;
        ([a.0, b.0, c.0], [a.1, b.1, c.1])
    }
}

/// A scalar function over a part, pair by pair.
fn each(
    [ix, iy, iz]: [&[f32]; 3],
    [ox, oy, oz]: [&[f32]; 3],
    [r, g, b]: [&mut [f32]; 3],
    evaluate: impl Fn(Vector<Single>, Vector<Single>) -> [Single; 3],
) {
    for i in 0..r.len() {
        let vector = |x: &[f32], y: &[f32], z: &[f32]| Vector::new(Single(x[i]), Single(y[i]), Single(z[i]));
        [r[i], g[i], b[i]] = evaluate(vector(ix, iy, iz), vector(ox, oy, oz)).map(f32::from);
    }
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

static COPPER_FIT: LazyLock<Fit<3, 8>> = LazyLock::new(|| Fit::new(COPPER.0, COPPER.1).expect("copper's F is smooth"));
static COAT_FIT: LazyLock<Fit<1, 8>> = LazyLock::new(|| Fit::new([COAT_INDEX], [0.0]).expect("F at 1.5 is smooth"));
static COATED_COPPER_FIT: LazyLock<Fit<3, 8>> = LazyLock::new(|| {
    let relative = |index: [f64; 3]| index.map(|x| x / COAT_INDEX);
    Fit::new(relative(COPPER.0), relative(COPPER.1)).expect("copper's F is smooth under a coat, too")
});

// The scalar formulas, over Single where they are timed and over f64 as the truth.

fn beckmann<R: Real>(wi: Vector<R>, wo: Vector<R>) -> [R; 3] {
    let (n, k) = &*COPPER;
    let one = |i: usize| torrance_sparrow(wi, wo, R::from_f64(n[i]), R::from_f64(k[i]), R::from_f64(METAL_ALPHA)).f;
    [one(0), one(1), one(2)]
}

fn beckmann_fitted<R: Real>(wi: Vector<R>, wo: Vector<R>) -> [R; 3] {
    let lobe = facets(wi, wo, R::from_f64(METAL_ALPHA)).lobe;
    COPPER_FIT.reflectance(cos_half(wi, wo)).map(|f| f * lobe)
}

fn ggx_lobe<R: Real>(wi: Vector<R>, wo: Vector<R>) -> R {
    let alpha = R::from_f64(METAL_ALPHA);
    distribution::ggx(half_vector(wi, wo), alpha) * masking::smith_ggx(wi, wo, alpha, alpha).visibility
}

fn ggx<R: Real>(wi: Vector<R>, wo: Vector<R>) -> [R; 3] {
    let (n, k) = &*COPPER;
    let (cos, lobe) = (cos_half(wi, wo), ggx_lobe(wi, wo));
    let one = |i: usize| fresnel::conductor(cos, R::from_f64(n[i]), R::from_f64(k[i])).reflectance * lobe;
    [one(0), one(1), one(2)]
}

fn ggx_fitted<R: Real>(wi: Vector<R>, wo: Vector<R>) -> [R; 3] {
    let lobe = ggx_lobe(wi, wo);
    COPPER_FIT.reflectance(cos_half(wi, wo)).map(|f| f * lobe)
}

/// [`STACK`] with fitted Fresnel terms, from the terms that `layered::conserving` is made of.
fn coated_fitted<R: Real>(wi: Vector<R>, wo: Vector<R>) -> [R; 3] {
    let eta = R::from_f64(COAT_INDEX);
    let [coat] = COAT_FIT.reflectance(cos_half(wi, wo));
    let coat = coat * facets(wi, wo, R::from_f64(COAT_ALPHA)).lobe;
    let ([ti], [to]) = (COAT_FIT.transmittance(wi.z), COAT_FIT.transmittance(wo.z));
    let (below_i, below_o) = (refract(wi, eta), refract(wo, eta));
    let base = facets(below_i, below_o, R::from_f64(METAL_ALPHA)).lobe * ti * to / (eta * eta);
    let reflectance = COATED_COPPER_FIT.reflectance(cos_half(below_i, below_o));
    let one = |i: usize| {
        let absorbed = absorption::transmittance(R::from_f64(SIGMA[i]), R::from_f64(THICKNESS), below_i.z, below_o.z);
        coat + base * reflectance[i] * absorbed
    };
    [one(0), one(1), one(2)]
}

// What is timed: a function for each subject. TODO(batch): put the call of brdf::batch in place of `each`.

fn conductor_beckmann(directions: &Directions, threads: usize, out: &mut Output) {
    split(directions, threads, out, |wi, wo, out| each(wi, wo, out, beckmann));
}

fn conductor_beckmann_fitted(directions: &Directions, threads: usize, out: &mut Output) {
    split(directions, threads, out, |wi, wo, out| each(wi, wo, out, beckmann_fitted));
}

fn conductor_ggx(directions: &Directions, threads: usize, out: &mut Output) {
    split(directions, threads, out, |wi, wo, out| each(wi, wo, out, ggx));
}

fn conductor_ggx_fitted(directions: &Directions, threads: usize, out: &mut Output) {
    split(directions, threads, out, |wi, wo, out| each(wi, wo, out, ggx_fitted));
}

fn layered(directions: &Directions, threads: usize, out: &mut Output) {
    let stack = STACK.cast::<Single>();
    split(directions, threads, out, |wi, wo, out| each(wi, wo, out, |wi, wo| stack.evaluate(wi, wo)));
}

fn layered_fitted(directions: &Directions, threads: usize, out: &mut Output) {
    split(directions, threads, out, |wi, wo, out| each(wi, wo, out, coated_fitted));
}

struct Subject {
    name: &'static str,
    run: fn(&Directions, usize, &mut Output),
    /// The exact model in f64: of a fitted subject the one that it was fitted to.
    exact: fn(Vector<f64>, Vector<f64>) -> [f64; 3],
}

const SUBJECTS: [Subject; 6] = [
    Subject { name: "conductor_beckmann", run: conductor_beckmann, exact: beckmann },
    Subject { name: "conductor_beckmann_fitted", run: conductor_beckmann_fitted, exact: beckmann },
    Subject { name: "conductor_ggx", run: conductor_ggx, exact: ggx },
    Subject { name: "conductor_ggx_fitted", run: conductor_ggx_fitted, exact: ggx },
    Subject { name: "layered", run: layered, exact: |wi, wo| STACK.evaluate(wi, wo) },
    Subject { name: "layered_fitted", run: layered_fitted, exact: |wi, wo| STACK.evaluate(wi, wo) },
];

/// The largest and the 99.9th percentile of |f − exact|/exact over every `step`-th pair and all channels.
fn error(subject: &Subject, directions: &Directions, out: &Output, step: usize, floor: f64) -> String {
    let mut errors = Vec::new();
    for i in (0..directions.count()).step_by(step.max(1)) {
        let [wi, wo] = directions.pair::<f64>(i);
        for (exact, out) in (subject.exact)(wi, wo).into_iter().zip(out) {
            if exact > floor {
                errors.push((f64::from(out[i]) - exact).abs() / exact);
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
            if out[0].is_empty() {
                *out = [(); 3].map(|()| vec![0.0; directions.count()]);
            }
            let start = Instant::now();
            (subject.run)(directions, threads, out);
            let seconds = start.elapsed().as_secs_f64();
            std::hint::black_box(out);
            Ok(format!(r#"{{"seconds":{seconds:e}}}"#))
        }
        ("error" | "write", _) if out[0].is_empty() => Err("nothing was evaluated yet".into()),
        ("error", [step, floor]) => Ok(error(subject, directions, out, step.parse()?, floor.parse()?)),
        ("write", [path]) => {
            let bytes: Vec<u8> = out.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
            std::fs::write(path, bytes)?;
            Ok(format!(r#"{{"written":{}}}"#, 3 * directions.count()))
        }
        _ => Err("an unknown request, or a wrong number of words".into()),
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("usage: peers DIRECTIONS")?;
    let directions = Directions::read(&path)?;
    let mut outputs = SUBJECTS.map(|subject| (subject.name, Output::default()));
    let mut stdout = std::io::stdout().lock();
    for line in std::io::stdin().lock().lines() {
        let reply = match answer(&line?, &directions, &mut outputs) {
            Ok(reply) => reply,
            Err(problem) => format!(r#"{{"error":{:?}}}"#, problem.to_string()),
        };
        writeln!(stdout, "{reply}")?;
        stdout.flush()?;
    }
    Ok(())
}
