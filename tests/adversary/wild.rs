//! Finite inputs outside the terms' domains: what the crate's documentation promises of them ("Outside the domain").

use crate::stacks::decades;
use crate::strategy::Search;
use crate::terms::{Term, terms};
use crate::{generations, in_parallel};

/// What each argument of a term is, in order.
///
/// v: a direction or half vector (three numbers); c: a cosine; n: an index; k: its imaginary part; a: a width; s: a share of
/// 1 or an angle; x: any number ≥ 0.
fn kinds(term: &Term) -> &'static str {
    match (term.module, term.function) {
        ("fresnel", "dielectric" | "refracted_square") | ("refraction", "cos_t") => "cn",
        ("fresnel", "conductor" | "conductor_approx" | "lazanyi_uncorrected") => "cnk",
        ("fresnel", "normal_incidence") => "nk",
        ("fresnel", "schlick") => "cs",
        ("fresnel", "schlick_from_indices") => "cnn",
        ("fresnel", "lazanyi") => "cnksx",
        ("fresnel", "f82_tint") => "css",
        ("distribution", "beckmann" | "ggx" | "blinn") => "va",
        ("distribution", "gaussian") => "vax",
        ("distribution", _) => "vaa",
        ("masking", "v_cavity" | "kelemen") => "vv",
        ("masking", "projected_area_ggx" | "projected_area_beckmann") => "vaa",
        ("masking", _) => "vvaa",
        ("diffuse", "lambert") => "s",
        ("diffuse", "oren_nayar") => "vvs",
        ("diffuse", "oren_nayar_qualitative") => "vvss",
        ("refraction", "refract") => "vn",
        ("refraction", "refract_about") => "vvn",
        ("absorption", _) => "xxcc",
        ("phong", _) => "vvx",
        ("microfacet", "cos_half") => "vv",
        ("microfacet", "facets") => "vva",
        ("microfacet", _) => "vvnka",
        ("layered", "internal_reflection") => "ss",
        ("layered", _) => "vvnaxxnka",
        ("real", "erfcx") => "x",
        ("real", _) => "xx",
        (module, function) => panic!("{module}::{function} has no kinds"),
    }
}

/// The largest number of genes that a term's arguments take.
const GENES: usize = 13;

/// How far outside its domain an argument is drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Reach {
    /// Any length and side of a direction, any positive width, index and amount; cosines and shares in [0, 1].
    Extended,
    /// Also cosines and shares in [−2, 2].
    Unclamped,
}

/// Both ends of a range as often as what is between them.
fn ends(gene: f64, low: f64, high: f64) -> f64 {
    decades((1.5 * gene - 0.25).clamp(0.0, 1.0), low, high)
}

fn scalar(kind: char, gene: f64, reach: Reach) -> f64 {
    match kind {
        'c' | 's' if reach == Reach::Unclamped => 4.0 * gene - 2.0,
        'c' | 's' => (1.2 * gene - 0.1).clamp(0.0, 1.0),
        'n' => ends(gene, 1e-30, 1e30),
        'a' => ends(gene, 1e-30, 1e10),
        _ if gene < 0.2 => 0.0,
        _ => ends((gene - 0.2) / 0.8, 1e-30, 1e30),
    }
}

/// A direction above, on or below the horizon, of any length.
fn direction(genes: &[f64]) -> [f64; 3] {
    let cos = match genes[0] * 5.0 {
        g if g < 0.5 => 0.0,
        g if g < 1.0 => 1.0,
        g if g < 3.0 => decades(0.5 * (g - 1.0), 1e-20, 1.0),
        g => g - 4.0,
    };
    let sin = ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt();
    let phi = std::f64::consts::TAU * (genes[1] * 16.0).floor() / 16.0;
    let length = if genes[2] < 0.3 { 1.0 } else { ends((genes[2] - 0.3) / 0.7, 1e-20, 1e20) };
    [sin * phi.cos() * length, sin * phi.sin() * length, cos * length]
}

/// The arguments that genes stand for.
fn row(kinds: &str, genes: &[f64], reach: Reach) -> Vec<f32> {
    let (mut row, mut at) = (Vec::new(), 0);
    for kind in kinds.chars() {
        if kind == 'v' {
            row.extend(direction(&genes[at..at + 3]).map(|x| x as f32));
            at += 3;
        } else {
            row.push(scalar(kind, genes[at], reach) as f32);
            at += 1;
        }
    }
    row
}

/// The results in both precisions.
pub(crate) fn results(term: &Term, row: &[f32]) -> [Vec<f64>; 2] {
    let wide: Vec<f64> = row.iter().map(|x| f64::from(*x)).collect();
    let count = term.results.len();
    [(term.single)(row)[..count].iter().map(|x| f64::from(*x)).collect(), (term.double)(&wide)[..count].to_vec()]
}

/// How close results are to what must not be: infinite where they are there, else the decades of the largest.
fn badness(term: &Term, results: &[Vec<f64>], reach: Reach) -> f64 {
    let one = |x: &f64| match reach {
        _ if x.is_nan() => f64::INFINITY,
        // A refracted direction of a long one may be longer than any number.
        Reach::Extended if term.module != "refraction" && x.is_infinite() => f64::INFINITY,
        Reach::Extended if !term.signed && *x < 0.0 => f64::INFINITY,
        _ => x.abs().clamp(1e-300, 1e300).log10().abs(),
    };
    results.iter().flatten().map(one).fold(0.0, f64::max)
}

#[test]
fn no_finite_input_gives_a_nan() {
    let jobs =
        [Reach::Extended, Reach::Unclamped].into_iter().flat_map(|reach| terms().into_iter().map(move |t| (t, reach)));
    let broken = in_parallel(jobs.collect(), |(term, reach)| {
        let kinds = kinds(&term);
        let search = Search { genes: GENES, generations: generations(150), restarts: 4, seed: 9 };
        let find = search.run(|genes| badness(&term, &results(&term, &row(kinds, genes, reach)), reach));
        let row = row(kinds, &find.genes, reach);
        let results = results(&term, &row);
        (find.fitness == f64::INFINITY).then(|| format!("{} {reach:?}: {results:?} at {row:?}", term.name()))
    });
    let broken: Vec<_> = broken.into_iter().flatten().collect();
    assert!(broken.is_empty(), "{}", broken.join("\n"));
}

/// Whether a term of two directions, or of a half vector, is dark where one is at or below the horizon.
fn goes_dark(term: &Term) -> bool {
    match term.module {
        "distribution" | "phong" | "layered" => term.function != "internal_reflection",
        "masking" => !term.function.starts_with("projected"),
        "diffuse" => term.function != "lambert",
        "microfacet" => term.function != "cos_half",
        _ => false,
    }
}

#[test]
fn nothing_is_lit_below_the_horizon() {
    for term in terms().into_iter().filter(goes_dark) {
        let kinds = kinds(&term);
        let search = Search { genes: GENES, generations: generations(100), restarts: 2, seed: 6 };
        let find = search.run(|genes| {
            let mut row = row(kinds, genes, Reach::Extended);
            // `v_cavity` and `kelemen` are handed the half vector of the two in this table.
            let below = if kinds.starts_with("vv") && genes[0] < 0.5 { 5 } else { 2 };
            row[below] = -row[below].abs();
            results(&term, &row).into_iter().flatten().map(f64::abs).fold(0.0, f64::max)
        });
        assert!(find.fitness == 0.0, "{}: {} at {:?}", term.name(), find.fitness, find.genes);
    }
}

#[test]
fn numbers_that_are_not_finite_cause_no_panic() {
    const NUMBERS: [f32; 6] = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, -f32::MAX, 1e-45];
    for term in terms() {
        let kinds = kinds(&term);
        let width = row(kinds, &[0.4; GENES], Reach::Extended).len();
        for seed in 0..2_000u32 {
            let genes: [f64; 4] = brdf::walk::random::random(3, seed, 0);
            let mut row = row(kinds, &[genes[0]; GENES], Reach::Extended);
            for (i, number) in [genes[1], genes[2], genes[3]].into_iter().enumerate() {
                row[(seed as usize * 7 + i * 3) % width] = NUMBERS[(number * 6.0) as usize];
            }
            let _ = results(&term, &row);
        }
    }
}
