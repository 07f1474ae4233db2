//! Samples of stacks against their density: χ² tests, normalisation, albedo, bounded weights.

use brdf::layered::{Interface, Layer, Model, Stack};
use brdf::material::stack::built_in;
use brdf::sampling::{Sample, WEIGHT_BOUND, ceiling};
use brdf::{Real, Vector, half_vector};
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::atomic::{AtomicUsize, Ordering};

const THETAS: [f64; 4] = [0.0, 30.0, 60.0, 85.0];

/// A stack under a model, and its name.
struct Subject {
    name: String,
    stack: Stack<f64, 3>,
}

/// The built-in stacks and corners that they leave out, under every one of the models that makes a difference.
fn subjects(models: &[Model]) -> Vec<Subject> {
    let facets = |n, alpha| Layer::new(Interface::dielectric(n, alpha));
    let metal = |alpha| Layer::new(Interface::conductor([0.213, 1.04, 1.17], [4.05, 2.59, 2.36], alpha));
    let base = |sigma| Layer::new(Interface::diffuse([0.9, 0.5, 0.1], sigma));
    let corners = [
        ("metal .002", vec![metal(0.002)]),
        ("metal 1", vec![metal(1.0)]),
        ("coat .002 over metal .3", vec![facets(1.5, 0.002), metal(0.3)]),
        ("coat .3 over metal .002", vec![facets(1.5, 0.3), metal(0.002)]),
        ("coat 1 over metal 1", vec![facets(1.8, 1.0), metal(1.0)]),
        ("lambert", vec![base(0.0)]),
        ("oren_nayar .5", vec![base(0.5)]),
        ("oren_nayar π/2", vec![base(FRAC_PI_2)]),
        ("matched coat over oren_nayar", vec![facets(1.0, 0.1), base(1.0)]),
        ("coat, air, metal", vec![facets(1.5, 0.1), facets(1.0, 0.2), metal(0.3)]),
        ("index below 1 over a base", vec![facets(0.7, 0.2), base(0.3)]),
        (
            "gold film over a base",
            vec![
                Layer::new(Interface::conductor([0.7, 0.9, 1.383], [0.1, 0.3, 1.9], 0.1)).over([1.0, 0.5, 0.2], 0.1),
                base(0.2),
            ],
        ),
    ];
    let corners = corners.map(|(name, layers)| (name.to_owned(), Stack::new(Model::Conserving, layers).unwrap()));
    let built_in = built_in().into_iter().map(|material| (material.name.to_owned(), material.stack));
    let mut all = Vec::new();
    for (name, stack) in built_in.chain(corners) {
        if stack.layers().len() > 1 {
            for model in models.iter().copied().filter(|model| *model != Model::Conserving) {
                let name = format!("{name} [{}]", model.name());
                all.push(Subject { name, stack: stack.clone().with_model(model) });
            }
        }
        all.push(Subject { name, stack });
    }
    all
}

/// PCG's 64-bit generator of 32 bits (O'Neill 2014).
struct Random(u64);

impl Random {
    fn new(seed: u64) -> Self {
        let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x853c_49e6_748f_ea9b);
        random.bits();
        random
    }
    fn bits(&mut self) -> u32 {
        let state = self.0;
        self.0 = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let shifted = (((state >> 18) ^ state) >> 27) as u32;
        shifted.rotate_right((state >> 59) as u32)
    }
    fn unit(&mut self) -> f64 {
        (f64::from(self.bits()) + f64::from(self.bits()) * 2f64.powi(-32)) * 2f64.powi(-32)
    }
    fn triple(&mut self) -> [f64; 3] {
        [self.unit(), self.unit(), self.unit()]
    }
}

/// Runs `work` for every subject and angle on all processors; the results keep their order.
fn for_all<T: Send>(thetas: &[f64], work: impl Fn(&Subject, f64, u64) -> T + Sync) -> Vec<T> {
    for_all_under(&Model::CLOSED_FORM, thetas, work)
}

/// [`for_all`] with `coupled` as well, for what draws without evaluating: no tables are built.
fn for_every_model<T: Send>(thetas: &[f64], work: impl Fn(&Subject, f64, u64) -> T + Sync) -> Vec<T> {
    for_all_under(&Model::ALL, thetas, work)
}

fn for_all_under<T: Send>(models: &[Model], thetas: &[f64], work: impl Fn(&Subject, f64, u64) -> T + Sync) -> Vec<T> {
    let subjects = subjects(models);
    let jobs: Vec<(&Subject, f64)> =
        subjects.iter().flat_map(|subject| thetas.iter().map(move |theta| (subject, *theta))).collect();
    let next = AtomicUsize::new(0);
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get());
    let mut results: Vec<(usize, T)> = std::thread::scope(|scope| {
        let worker = || {
            let mut own = Vec::new();
            loop {
                let job = next.fetch_add(1, Ordering::Relaxed);
                let Some(&(subject, theta)) = jobs.get(job) else { return own };
                own.push((job, work(subject, theta, job as u64 + 1)));
            }
        };
        let handles: Vec<_> = (0..threads).map(|_| scope.spawn(worker)).collect();
        handles.into_iter().flat_map(|handle| handle.join().unwrap()).collect()
    });
    results.sort_by_key(|(job, _)| *job);
    results.into_iter().map(|(_, result)| result).collect()
}

/// A view at an azimuth that no axis of the frame favours.
fn view(theta: f64) -> Vector<f64> {
    Vector::from_angles(theta.to_radians(), 0.7)
}

/// Polar coordinates of the slope of the half vector about the mirror direction, where every lobe of a stack is centred:
/// x = r/(r+c) in [0, 1), and the azimuth in turns from that of the view.
struct Chart {
    wo: Vector<f64>,
    scale: f64,
}

impl Chart {
    fn coordinates(&self, wi: Vector<f64>) -> [f64; 2] {
        let h = half_vector(wi, self.wo);
        let r = (h.x * h.x + h.y * h.y).sqrt() / h.z;
        let turn = (h.y.atan2(h.x) - 0.7) / TAU;
        [r / (r + self.scale), turn - turn.floor()]
    }

    /// The direction, and the solid angle for 1 of the coordinates; none below the horizon.
    fn point(&self, [x, turn]: [f64; 2]) -> Option<(Vector<f64>, f64)> {
        let r = self.scale * x / (1.0 - x);
        let (sin, cos) = (turn * TAU + 0.7).sin_cos();
        let normal = Vector::new(r * cos, r * sin, 1.0).normalized();
        let along = normal.dot(self.wo);
        let wi = normal * (2.0 * along) - self.wo;
        // dω_i = 4(V·m)dω_m, dω_m = cos³·r·dr·dφ, dr = c·dx/(1−x)².
        let solid = 4.0 * along * normal.z.powi(3) * r * TAU * self.scale / (1.0 - x).powi(2);
        (wi.z > 0.0 && along > 0.0).then_some((wi, solid))
    }
}

/// The integral of a density over a rectangle of the chart: Gauss–Legendre 3×3, halved both ways until it holds still.
fn integrate(chart: &Chart, pdf: &dyn Fn(Vector<f64>) -> f64, low: [f64; 2], high: [f64; 2], tolerance: f64) -> f64 {
    fn rule(chart: &Chart, pdf: &dyn Fn(Vector<f64>) -> f64, low: [f64; 2], high: [f64; 2]) -> f64 {
        let nodes = [(-0.6f64.sqrt(), 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.6f64.sqrt(), 5.0 / 9.0)];
        let at = |axis: usize, node: f64| 0.5 * (low[axis] + high[axis] + node * (high[axis] - low[axis]));
        let mut sum = 0.0;
        for (a, wa) in nodes {
            for (b, wb) in nodes {
                if let Some((wi, solid)) = chart.point([at(0, a), at(1, b)]) {
                    sum += wa * wb * solid * pdf(wi);
                }
            }
        }
        0.25 * sum * (high[0] - low[0]) * (high[1] - low[1])
    }
    fn refine(
        chart: &Chart,
        pdf: &dyn Fn(Vector<f64>) -> f64,
        [low, high]: [[f64; 2]; 2],
        whole: f64,
        tolerance: f64,
        depth: usize,
    ) -> f64 {
        let middle = [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])];
        let quarters = [
            [low, middle],
            [[middle[0], low[1]], [high[0], middle[1]]],
            [[low[0], middle[1]], [middle[0], high[1]]],
            [middle, high],
        ];
        let parts = quarters.map(|[low, high]| rule(chart, pdf, low, high));
        let sum: f64 = parts.iter().sum();
        if (sum - whole).abs() <= tolerance || depth == 0 {
            return sum;
        }
        // An edge crosses two of the quarters.
        quarters
            .into_iter()
            .zip(parts)
            .map(|(quarter, part)| refine(chart, pdf, quarter, part, 0.5 * tolerance, depth - 1))
            .sum()
    }
    // First cut where the radius quadruples: the nodes of a wide ring would miss a narrow lobe at its centre.
    let mut sum = 0.0;
    let mut outer = high[0];
    while outer > low[0] {
        let r = 0.25 * outer / (1.0 - outer).max(1e-3);
        let inner = if r < 1e-4 { low[0] } else { (r / (1.0 + r)).max(low[0]) };
        let (low, high) = ([inner, low[1]], [outer, high[1]]);
        sum += refine(chart, pdf, [low, high], rule(chart, pdf, low, high), tolerance, 8);
        outer = inner;
    }
    sum
}

/// The regularised upper incomplete gamma function Q(a, x): the probability of a χ² above 2x with 2a degrees of freedom.
fn upper_gamma(a: f64, x: f64) -> f64 {
    // ln Γ(a) of an integer or half-integer a, by recursion.
    let mut ln_gamma = if (2.0 * a) % 2.0 == 1.0 { 0.5 * PI.ln() } else { 0.0 };
    let mut t = if (2.0 * a) % 2.0 == 1.0 { 0.5 } else { 1.0 };
    while t < a {
        ln_gamma += f64::ln(t);
        t += 1.0;
    }
    let front = (a * x.ln() - x - ln_gamma).exp();
    if x < a + 1.0 {
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        while term > 1e-16 * sum {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return 1.0 - front * sum;
    }
    // Lentz's continued fraction.
    let mut b = x + 1.0 - a;
    let mut c = 1e300;
    let mut d = 1.0 / b;
    let mut h = d;
    for i in 1..1000 {
        let an = -f64::from(i) * (f64::from(i) - a);
        b += 2.0;
        d = 1.0 / (an * d + b);
        c = b + an / c;
        h *= d * c;
        if (d * c - 1.0).abs() < 1e-15 {
            break;
        }
    }
    front * h
}

#[test]
fn upper_gamma_is_the_tail_of_chi_square() {
    // Tables: 5 % beyond 3.841 (1), 18.307 (10), 67.505 (50); 0.1 % beyond 10.828 (1), 149.449 (100).
    for (freedom, x, want) in
        [(1, 3.841459, 0.05), (10, 18.307038, 0.05), (50, 67.504807, 0.05), (100, 149.449253, 0.001)]
    {
        let got = upper_gamma(0.5 * f64::from(freedom), 0.5 * x);
        assert!((got / want - 1.0).abs() < 1e-5, "{freedom} {x}: {got}");
    }
}

/// The χ² test of a sampler against a density, and the integral of the density.
struct Outcome {
    p: f64,
    integral: f64,
    bins: usize,
}

const RINGS: usize = 12;
const SECTORS: usize = 6;
const SAMPLES: usize = 8000;

fn chi_square(
    wo: Vector<f64>,
    sample: &dyn Fn([f64; 3]) -> Option<Vector<f64>>,
    pdf: &dyn Fn(Vector<f64>) -> f64,
    seed: u64,
) -> Outcome {
    // Rings of about equal probability, from samples that the test does not use.
    let mut pilot = Random::new(seed ^ 0xdead_beef_0000);
    let unit = Chart { wo, scale: 1.0 };
    let mut radii: Vec<f64> =
        (0..2000).filter_map(|_| sample(pilot.triple())).map(|wi| unit.coordinates(wi)[0]).collect();
    radii.sort_by(f64::total_cmp);
    assert!(!radii.is_empty(), "no samples at all");
    let slope = |x: f64| x / (1.0 - x);
    let chart = Chart { wo, scale: slope(radii[radii.len() / 2]) };
    let mut rings = vec![0.0];
    rings.extend((1..RINGS).map(|ring| {
        let r = slope(radii[radii.len() * ring / RINGS]);
        r / (r + chart.scale)
    }));
    rings.push(1.0);

    let mut observed = vec![0.0; RINGS * SECTORS + 1];
    let mut random = Random::new(seed);
    for _ in 0..SAMPLES {
        let bin = match sample(random.triple()) {
            None => RINGS * SECTORS,
            Some(wi) => {
                let [x, turn] = chart.coordinates(wi);
                let ring = rings[1..RINGS].partition_point(|edge| *edge <= x);
                ring * SECTORS + ((turn * SECTORS as f64) as usize).min(SECTORS - 1)
            }
        };
        observed[bin] += 1.0;
    }
    let mut expected = Vec::new();
    for ring in 0..RINGS {
        for sector in 0..SECTORS {
            let turn = |sector: usize| sector as f64 / SECTORS as f64;
            let (low, high) = ([rings[ring], turn(sector)], [rings[ring + 1], turn(sector + 1)]);
            expected.push(SAMPLES as f64 * integrate(&chart, pdf, low, high, 3e-5));
        }
    }
    let integral = expected.iter().sum::<f64>() / SAMPLES as f64;
    expected.push((SAMPLES as f64 * (1.0 - integral)).max(0.0));

    // Bins are pooled until none expects fewer than five.
    let mut bins: Vec<(f64, f64)> = expected.into_iter().zip(observed).collect();
    bins.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut pooled: Vec<(f64, f64)> = Vec::new();
    let mut open = (0.0, 0.0);
    while let Some(bin) = bins.pop() {
        open = (open.0 + bin.0, open.1 + bin.1);
        if open.0 >= 5.0 {
            pooled.push(open);
            open = (0.0, 0.0);
        }
    }
    if let Some(last) = pooled.last_mut() {
        *last = (last.0 + open.0, last.1 + open.1);
    }
    let statistic: f64 = pooled.iter().map(|(e, o)| (o - e) * (o - e) / e).sum();
    let freedom = pooled.len() as f64 - 1.0;
    let p = if freedom > 0.0 { upper_gamma(0.5 * freedom, 0.5 * statistic.max(1e-9)) } else { 1.0 };
    Outcome { p, integral, bins: pooled.len() }
}

fn direction(sample: Option<Sample<f64>>) -> Option<Vector<f64>> {
    sample.map(|sample| sample.wi)
}

#[test]
fn samples_follow_their_density() {
    let outcomes = for_every_model(&THETAS, |subject, theta, seed| {
        let (stack, wo) = (&subject.stack, view(theta));
        let outcome = chi_square(wo, &|u| direction(stack.sample(wo, u)), &|wi| stack.pdf(wi, wo), seed);
        (format!("{} at {theta}°", subject.name), outcome)
    });
    // Šidák: all tests together are wrong in one of a hundred worlds.
    let threshold = 1.0 - 0.99f64.powf(1.0 / outcomes.len() as f64);
    let least = outcomes.iter().map(|(_, outcome)| outcome.p).fold(1.0, f64::min);
    println!("{} tests, smallest p {least:.2e}, threshold {threshold:.2e}", outcomes.len());
    for (case, outcome) in &outcomes {
        println!("{case:50} p {:.4}, ∫pdf {:.6}, {} bins", outcome.p, outcome.integral, outcome.bins);
        assert!(outcome.p > threshold, "{case}: p = {:.2e}", outcome.p);
        assert!(outcome.integral < 1.0 + 1e-3, "{case}: ∫pdf = {}", outcome.integral);
    }
}

/// The density integrates to 1 where nothing is lost: smooth facets away from grazing, bases anywhere.
#[test]
fn densities_integrate_to_one() {
    let cases = ["metal .002", "chromium", "coated_gold", "lambert", "oren_nayar .5"];
    let outcomes = for_all(&[0.0, 30.0, 60.0, 85.0], |subject, theta, seed| {
        let base = subject.name == "lambert" || subject.name.starts_with("oren_nayar");
        (cases.contains(&subject.name.as_str()) && (base || theta < 80.0)).then(|| {
            let (stack, wo) = (&subject.stack, view(theta));
            let outcome = chi_square(wo, &|u| direction(stack.sample(wo, u)), &|wi| stack.pdf(wi, wo), seed);
            (format!("{} at {theta}°", subject.name), outcome.integral)
        })
    });
    for (case, integral) in outcomes.into_iter().flatten() {
        assert!((integral - 1.0).abs() < 1e-3, "{case}: {integral}");
    }
}

/// χ² sees a missing factor: the compression of solid angles, the wrong index in it, Fresnel's part in the choice.
#[test]
fn wrong_densities_are_seen() {
    let stack = Stack::<f64, 3>::new(
        Model::Conserving,
        vec![
            Layer::new(Interface::dielectric(1.5, 0.1)),
            Layer::new(Interface::conductor([0.2, 1.0, 1.2], [4.0, 2.6, 2.4], 0.3)),
        ],
    )
    .unwrap();
    let wo = view(30.0);
    let sample = |u| direction(stack.sample(wo, u));
    let right = chi_square(wo, &sample, &|wi| stack.pdf(wi, wo), 5);
    assert!(right.p > 0.01, "{}", right.p);
    // Without cos_0/cos_k, which normalises to 1 no more but by little; with it twice.
    let ratio = |wi: Vector<f64>| brdf::refraction::cos_t(wi.z, 1.5) / wi.z;
    for (fault, power) in [("missing", 1), ("twice", -1)] {
        let normalised = |wi: Vector<f64>| stack.pdf(wi, wo) * (ratio(wi) / ratio(wo)).powi(power);
        let wrong = chi_square(wo, &sample, &normalised, 5);
        assert!(wrong.p < 1e-6, "{fault}: {}", wrong.p);
    }
}

#[test]
fn the_returned_density_is_pdf() {
    for_every_model(&[0.0, 45.0, 89.0], |subject, theta, seed| {
        let (wo, mut random) = (view(theta), Random::new(seed));
        let single = subject.stack.cast::<f32>();
        for _ in 0..200 {
            let u = random.triple();
            if let Some(sample) = subject.stack.sample(wo, u) {
                assert_eq!(sample.pdf, subject.stack.pdf(sample.wi, wo), "{} {theta}", subject.name);
                assert!((sample.wi.length_squared() - 1.0).abs() < 1e-14 && sample.wi.z > 0.0, "{}", subject.name);
            }
            if let Some(sample) = single.sample(wo.cast(), u.map(|u| u as f32)) {
                assert_eq!(sample.pdf, single.pdf(sample.wi, wo.cast()), "{} {theta}", subject.name);
                assert!((sample.wi.length_squared() - 1.0).abs() < 1e-5, "{} {sample:?}", subject.name);
            }
        }
    });
}

/// Finite inputs give finite results, and nothing at or below the horizon.
#[test]
fn corners_are_finite() {
    fn run<R: Real>(stack: &Stack<R, 3>, name: &str) {
        let numbers = [-1.0, 0.0, 1e-30, 0.25, 0.5, 1.0 - 1e-8, 1.0, 7e30];
        let directions = [90.0, 89.999_999, 89.9, 60.0, 1e-5, 0.0, 120.0, 180.0].map(|theta| view(theta).cast::<R>());
        for wo in directions {
            for index in 0..numbers.len().pow(3) {
                let pick = |place: usize| R::from_f64(numbers[index / numbers.len().pow(place as u32) % numbers.len()]);
                if let Some(Sample { wi, pdf }) = stack.sample(wo, [pick(0), pick(1), pick(2)]) {
                    let finite = [wi.x, wi.y, wi.z, pdf].iter().all(|x| x.to_f64().is_finite());
                    assert!(
                        finite && wi.z.to_f64() > 0.0 && pdf.to_f64() > 0.0,
                        "{name} {wo:?} {index}: {wi:?} {pdf:?}"
                    );
                    assert!(wo.z.to_f64() > 0.0, "{name}");
                }
            }
            for wi in directions {
                let pdf = stack.pdf(wi, wo).to_f64();
                assert!(pdf.is_finite() && pdf >= 0.0, "{name} {wi:?} {wo:?}: {pdf}");
                if wi.z.to_f64() <= 0.0 || wo.z.to_f64() <= 0.0 {
                    assert_eq!(pdf, 0.0, "{name}");
                }
            }
        }
    }
    for_every_model(&[0.0], |subject, _, _| {
        run(&subject.stack, &subject.name);
        run(&subject.stack.cast::<f32>(), &subject.name);
    });
}

/// What a Monte-Carlo estimate of the albedo is made of: the mean of each channel, its variance, the largest weight.
struct Estimate {
    mean: [f64; 3],
    variance: [f64; 3],
    largest: f64,
}

fn estimate(samples: usize, mut weight: impl FnMut() -> [f64; 3]) -> Estimate {
    let (mut sum, mut squares, mut largest) = ([0.0; 3], [0.0; 3], 0.0f64);
    for _ in 0..samples {
        for (channel, w) in weight().into_iter().enumerate() {
            sum[channel] += w;
            squares[channel] += w * w;
            largest = largest.max(w);
        }
    }
    let n = samples as f64;
    let mean = sum.map(|sum| sum / n);
    let mut variance = squares.map(|squares| squares / n);
    for (variance, mean) in variance.iter_mut().zip(mean) {
        *variance = (*variance - mean * mean).max(0.0);
    }
    Estimate { mean, variance, largest }
}

fn weight(stack: &Stack<f64, 3>, wo: Vector<f64>, u: [f64; 3]) -> [f64; 3] {
    match stack.sample(wo, u) {
        None => [0.0; 3],
        Some(Sample { wi, pdf }) => stack.evaluate(wi, wo).map(|f| f * wi.z / pdf),
    }
}

#[test]
fn weights_are_bounded() {
    let results = for_all(&[0.0, 45.0, 75.0, 85.0, 89.0, 89.9], |subject, theta, seed| {
        let (stack, wo) = (&subject.stack, view(theta));
        let mut random = Random::new(seed);
        let ours = estimate(4000, || weight(stack, wo, random.triple()));
        let share = ours.largest / ceiling(stack.layers(), stack.model(), wo);
        assert!(share < WEIGHT_BOUND, "{} at {theta}°: {} is {share} times the ceiling", subject.name, ours.largest);
        // Against the cosine at 45°, the relative standard deviation of one sample.
        let spread = (theta == 45.0).then(|| {
            let cosine = estimate(4000, || {
                let [_, a, b] = random.triple();
                let wi = brdf::sampling::cosine_hemisphere([a, b]);
                stack.evaluate(wi, wo).map(|f| f * PI)
            });
            [&ours, &cosine].map(|e| e.variance[1].sqrt() / e.mean[1])
        });
        (subject.name.clone(), theta, ours.largest, share, spread)
    });
    println!("{:45} largest weight at 0, 45, 75, 85, 89, 89.9°; share of the ceiling; s.d. at 45°, of cosine", "");
    for angles in results.chunks(6) {
        let weights: String = angles.iter().map(|(_, _, largest, ..)| format!("{largest:7.3}")).collect();
        let share = angles.iter().map(|(.., share, _)| *share).fold(0.0, f64::max);
        let [ours, cosine] = angles[1].4.unwrap_or_default();
        println!("{:45}{weights}  {share:6.2}  {ours:.3} {cosine:.3}", angles[0].0);
    }
}

#[cfg(feature = "check")]
#[test]
fn albedos_agree_with_quadrature() {
    use brdf::check::{Effort, Fixed, StackSubject, albedo};
    const SAMPLES: usize = 20_000;
    let effort = Effort { replicates: 0, evaluations: 12_000, ..Effort::default() };
    for_all(&[0.0, 60.0, 85.0], |subject, theta, seed| {
        let (stack, wo) = (&subject.stack, view(theta));
        let mut random = Random::new(seed ^ 0x00a1_bed0);
        let sampled = estimate(SAMPLES, || weight(stack, wo, random.triple()));
        let whole = albedo(&StackSubject::new("", stack.clone()), theta, 0.7f64.to_degrees(), Fixed::View, &effort);
        for channel in 0..3 {
            let (mean, want, bound) = (sampled.mean[channel], whole.value[channel], whole.error[channel]);
            let error = (sampled.variance[channel] / SAMPLES as f64).sqrt();
            assert!(
                (mean - want).abs() <= 4.0 * error + bound + 1e-9,
                "{} at {theta}°, channel {channel}: {mean} ± {error}, quadrature {want} ± {bound}",
                subject.name
            );
        }
    });
}

/// The closure of `coupled` reflects where no lobe points: samples must find it.
#[cfg(feature = "check")]
#[test]
fn coupled_stacks_are_sampled_without_bias() {
    use brdf::check::{Effort, Fixed, StackSubject, albedo};
    const SAMPLES: usize = 60_000;
    for name in ["clear_coat_over_copper", "varnish_over_concrete"] {
        let stack = brdf::material::stack::by_name(name).expect("a built-in stack").with_model(Model::Coupled);
        for theta in [0.0, 60.0, 85.0] {
            let wo = view(theta);
            let mut random = Random::new(0xc0_0b1e);
            if let Some(drawn) = stack.sample(wo, random.triple()) {
                assert_eq!(drawn.pdf, stack.pdf(drawn.wi, wo), "{name}");
            }
            let sampled = estimate(SAMPLES, || weight(&stack, wo, random.triple()));
            let subject = StackSubject::new("", stack.clone());
            let whole = albedo(&subject, theta, 0.7f64.to_degrees(), Fixed::View, &Effort::default());
            for channel in 0..3 {
                let (mean, want, bound) = (sampled.mean[channel], whole.value[channel], whole.error[channel]);
                let error = (sampled.variance[channel] / SAMPLES as f64).sqrt();
                assert!(
                    (mean - want).abs() <= 4.0 * error + bound,
                    "{name} at {theta}°, channel {channel}: {mean} ± {error}, quadrature {want} ± {bound}"
                );
            }
            // Measured 3.3; a pdf that misses a part of f would show weights without bound.
            assert!(sampled.largest < 6.0, "{name} at {theta}°: a weight of {}", sampled.largest);
        }
    }
}
