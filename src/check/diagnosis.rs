//! What is likely wrong with a subject that fails: causes that are known to look like that, each by a test of its own.
//!
//! A cause is named only where its own test holds, not where it is merely possible. `tests/corpus` plants each of them, and
//! asserts that none is named of another. Whether D and G use different α is not told from f alone; give the terms to
//! [`weak_white_furnace`](super::limits::weak_white_furnace).

use super::marginals::glance;
use super::pairs::Class;
use super::report::{Check, Report};
use super::subject::{Fixed, Pair, Subject, from_fn};
use super::verdict::Verdict;
use super::{Options, Profile};
use crate::frame::{Vector, half_vector};
use core::f64::consts::{FRAC_1_PI, PI};

/// A fault that is known by its looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Cause {
    /// f·cos is returned.
    Cosine,
    /// π·f·cos is returned.
    PiCosine,
    /// f times the cosine of the view is returned: the directions are swapped.
    Swapped,
    /// Scaled so that every view sees an albedo of 1, without the light's share.
    ViewScaled,
    /// A factor of one direction alone.
    OneSided,
    /// π times too bright.
    MissingPi,
    /// 4 times too bright.
    MissingQuarter,
    /// 4/π times too bright.
    PiForQuarter,
    /// No masking under a denominator of cosines.
    Unmasked,
    /// No denominator of cosines.
    NoDenominator,
    /// A diffuse and a specular term that share no energy.
    Unweighted,
    /// NaN over a part of the hemisphere.
    NegativeBase,
    /// Not finite at the normal.
    AtNormal,
    /// Not finite at grazing.
    AtGrazing,
    /// Not finite at wi = wo.
    AtRetro,
    /// Not finite at the mirror direction.
    AtMirror,
    /// Negative somewhere.
    Unclamped,
    /// Not isotropic where both widths are equal.
    AnisotropicLimit,
}

impl Cause {
    /// Every cause.
    pub const ALL: [Cause; 18] = [
        Cause::Cosine,
        Cause::PiCosine,
        Cause::Swapped,
        Cause::ViewScaled,
        Cause::OneSided,
        Cause::MissingPi,
        Cause::MissingQuarter,
        Cause::PiForQuarter,
        Cause::Unmasked,
        Cause::NoDenominator,
        Cause::Unweighted,
        Cause::NegativeBase,
        Cause::AtNormal,
        Cause::AtGrazing,
        Cause::AtRetro,
        Cause::AtMirror,
        Cause::Unclamped,
        Cause::AnisotropicLimit,
    ];

    /// What to look for, in words.
    pub const fn text(self) -> &'static str {
        match self {
            Cause::Cosine => {
                "f/cos is reciprocal and f is not: the subject seems to return f·cos; check it with --returns fcos"
            }
            Cause::PiCosine => {
                "f/cos is reciprocal and reflects up to π: the subject seems to return π·f·cos; check it with --returns pifcos"
            }
            Cause::Swapped => {
                "f divided by the view's cosine is reciprocal: f·cos with light and view swapped; map wi and wo the other way round"
            }
            Cause::ViewScaled => {
                "f is scaled by a function of the view alone, so every furnace image is right and the light fixed is not; multiply by \
                 the same function of the light"
            }
            Cause::OneSided => {
                "a factor depends on one of the directions alone; give the other one the same factor, or drop it"
            }
            Cause::MissingPi => "the albedo is π times what it can be: 1/π is missing",
            Cause::MissingQuarter => "the albedo is 4 times what it can be: the 4 of 4·(N·L)·(N·V) is missing",
            Cause::PiForQuarter => {
                "the albedo is 4/π times what it can be: a denominator π·(N·L)·(N·V) with a D that is normalised already; it is \
                 4·(N·L)·(N·V)"
            }
            Cause::Unmasked => {
                "the albedo grows like 1/cosθ towards grazing: (N·L)·(N·V) in a denominator that no masking term G makes up for"
            }
            Cause::NoDenominator => {
                "divided by 4·(N·L)·(N·V), f would conserve energy: that denominator is missing, or multiplied by"
            }
            Cause::Unweighted => {
                "a diffuse and a specular term each conserve energy, and their sum does not: weight the diffuse one by what the \
                 specular one leaves"
            }
            Cause::NegativeBase => {
                "NaN over a whole part of the hemisphere: pow of a negative base, or sqrt or acos out of its domain"
            }
            Cause::AtNormal => {
                "not finite along the normal alone: an azimuth, or a division by sinθ, where there is none"
            }
            Cause::AtGrazing => "not finite at grazing alone: a division by a cosine that goes to 0",
            Cause::AtRetro => {
                "not finite at wi = wo alone: a division by a distance or an angle between them, or acos of a number above 1"
            }
            Cause::AtMirror => {
                "not finite where the half vector is the normal alone: a division by sinθ of the half vector"
            }
            Cause::Unclamped => "negative: a cosine or a difference that is not clamped with max(…, 0)",
            Cause::AnisotropicLimit => {
                "both widths are equal, and f still changes when both directions turn about the normal: the anisotropic form does not \
                 reduce to the isotropic one"
            }
        }
    }
}

/// Fills in the likely cause of each failure in double precision.
pub(super) fn explain(subject: &dyn Subject, report: &mut Report, options: &Options<'_>) {
    if options.profile == Profile::Measured || subject.channels() == 0 {
        return;
    }
    let failed =
        |check: Check| report.findings.iter().any(|f| f.check == check && !f.single && f.verdict == Verdict::Fail);
    let mut causes: Vec<(Check, Cause)> = Vec::new();
    if failed(Check::Finite) {
        causes.extend(broken(subject, options.seed).map(|cause| (Check::Finite, cause)));
    }
    if failed(Check::Sign) {
        causes.push((Check::Sign, Cause::Unclamped));
    }
    if failed(Check::Reciprocity) {
        if let Some(cause) = asymmetry(subject, report, options.seed) {
            causes.extend([Check::Reciprocity, Check::Energy].map(|check| (check, cause)));
        }
    } else if failed(Check::Energy) && !failed(Check::Sign) {
        causes.extend(excess(subject, report, options.seed).map(|cause| (Check::Energy, cause)));
    }
    for finding in report.findings.iter_mut().filter(|f| !f.single && f.verdict == Verdict::Fail) {
        if let Some((_, cause)) = causes.iter().find(|(check, _)| *check == finding.check) {
            finding.cause = cause.text().into();
        }
    }
}

fn values(subject: &dyn Subject, pairs: &[Pair]) -> Vec<f64> {
    let mut f = vec![0.0; pairs.len() * subject.channels()];
    subject.evaluate_many(pairs, &mut f);
    f
}

/// Where alone it is not finite.
fn broken(subject: &dyn Subject, seed: u32) -> Option<Cause> {
    const EACH: usize = 256;
    let n = subject.channels();
    let mut all: Vec<Pair> = Vec::new();
    let mut share = 0.0;
    for class in Class::ALL {
        let pairs: Vec<Pair> = (0..EACH).map(|i| class.pair(i, seed)).collect();
        let f = values(subject, &pairs);
        let bad = pairs.iter().zip(f.chunks_exact(n)).filter(|(_, f)| f.iter().any(|f| !f.is_finite()));
        let bad: Vec<Pair> = bad.map(|(&pair, _)| pair).collect();
        if class == Class::Hemisphere {
            share = bad.len() as f64 / EACH as f64;
        }
        all.extend(bad);
    }
    if share > 0.02 {
        return Some(Cause::NegativeBase);
    }
    let only = |where_is: &dyn Fn(Vector<f64>, Vector<f64>) -> bool| {
        !all.is_empty() && all.iter().all(|&(wi, wo)| where_is(wi, wo))
    };
    let across = |h: Vector<f64>| h.sin_squared() / h.length_squared().max(f64::MIN_POSITIVE);
    if only(&|wi, wo| (wi - wo).length_squared() < 1e-12) {
        Some(Cause::AtRetro)
    } else if only(&|wi, wo| across(half_vector(wi, wo)) < 1e-12) {
        Some(Cause::AtMirror)
    } else if only(&|wi, wo| wi.sin_squared().min(wo.sin_squared()) < 1e-12) {
        Some(Cause::AtNormal)
    } else if only(&|wi, wo| wi.z.min(wo.z) < 0.02) {
        Some(Cause::AtGrazing)
    } else {
        None
    }
}

/// Why f is not reciprocal: a factor of one direction.
fn asymmetry(subject: &dyn Subject, report: &Report, seed: u32) -> Option<Cause> {
    const TRIPLES: usize = 256;
    /// Several times the rounding of quotients of f.
    const SAME: f64 = 1e-7;
    let n = subject.channels();
    let mut pairs: Vec<Pair> = Vec::new();
    for i in 0..TRIPLES {
        let ((a, b), (c, _)) = (Class::Hemisphere.pair(i, seed), Class::Hemisphere.pair(i + TRIPLES, seed));
        pairs.extend([(a, b), (b, a), (b, c), (c, b), (c, a), (a, c)]);
    }
    let f = values(subject, &pairs);
    let (mut by_light, mut by_view, mut one_sided, mut of_light, mut seen) = (true, true, true, true, 0);
    for (triple, f) in pairs.chunks_exact(6).zip(f.chunks_exact(6 * n)) {
        for channel in 0..n {
            let at = |i: usize| f[i * n + channel];
            if (0..6).any(|i| !at(i).is_finite() || at(i).abs() < 1e-12) {
                continue;
            }
            seen += 1;
            let same = |a: f64, b: f64| (a - b).abs() <= SAME * a.abs().max(b.abs());
            let (a, b) = triple[0];
            by_light &= same(at(0) / a.z, at(1) / b.z);
            by_view &= same(at(0) / b.z, at(1) / a.z);
            one_sided &= same(at(0) * at(2) * at(4), at(1) * at(3) * at(5));
            of_light &= same(at(0), at(5)) && same(at(1), at(2)) && same(at(3), at(4));
        }
    }
    if seen < TRIPLES / 8 {
        return None;
    }
    let fails = |fixed| report.energy(fixed).is_some_and(|finding| finding.verdict == Verdict::Fail);
    // Without the cosine it must be a BRDF, but for a scale: s/NV is symmetric over NL as well, and grows without bound.
    let stripped =
        |factor: fn(Vector<f64>, Vector<f64>) -> f64| brightest(&scaled(subject, factor), &[0.0, 45.0, 75.0, 88.0]);
    if by_light {
        let most = stripped(|wi, _| 1.0 / wi.z);
        if most < 1.03 * PI {
            return Some(if most > 1.01 { Cause::PiCosine } else { Cause::Cosine });
        }
    }
    if by_view && stripped(|_, wo| 1.0 / wo.z) < 1.03 * PI {
        Some(Cause::Swapped)
    } else if one_sided && !of_light && !fails(Fixed::View) && fails(Fixed::Light) {
        // A function of the light alone is the same for every view too, and nothing is scaled.
        Some(Cause::ViewScaled)
    } else if one_sided {
        Some(Cause::OneSided)
    } else {
        None
    }
}

/// The subject times a function.
fn scaled(subject: &dyn Subject, factor: impl Fn(Vector<f64>, Vector<f64>) -> f64 + Sync) -> impl Subject {
    from_fn("scaled", subject.channels(), move |wi: Vector<f64>, wo: Vector<f64>, f: &mut [f64]| {
        subject.evaluate(wi, wo, f);
        let factor = if wi.z > 0.0 && wo.z > 0.0 { factor(wi, wo) } else { 0.0 };
        f.iter_mut().for_each(|f| *f *= factor);
    })
}

/// The largest albedo at some views, roughly.
fn brightest(subject: &dyn Subject, thetas: &[f64]) -> f64 {
    thetas.iter().fold(0.0, |most, &theta| glance(subject, theta, 0.0, Fixed::View).0.peak().1.max(most))
}

/// Why a reciprocal f reflects too much.
fn excess(subject: &dyn Subject, report: &Report, seed: u32) -> Option<Cause> {
    let mut row: Vec<(f64, f64)> = report
        .albedos
        .iter()
        .filter(|albedo| albedo.fixed == Fixed::View && albedo.phi == 0.0)
        .map(|albedo| (albedo.theta, albedo.peak().1))
        .collect();
    row.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (&first, &last) = (row.first()?, row.last()?);
    let most = row.iter().fold(0.0f64, |most, &(_, albedo)| most.max(albedo));
    let steep =
        |(a, fa): (f64, f64), (b, fb): (f64, f64)| (fb / fa).ln() / (a.to_radians().cos() / b.to_radians().cos()).ln();
    // As far as f·cos counts, a constant above 1/π is Lambert's ρ.
    if let Some(constant) = constant(subject, seed) {
        return (constant > 1.001 * FRAC_1_PI && constant <= 1.0).then_some(Cause::MissingPi);
    }
    if let Some(&before) = row.iter().rev().find(|&&(theta, _)| (80.0..89.6).contains(&theta))
        && last.0 > before.0 + 0.1
        && steep(before, last) > 0.6
    {
        return Some(Cause::Unmasked);
    }
    let near = |factor: f64| (0.97 * factor..=1.005 * factor).contains(&most);
    let upright = |factor: f64, share: f64| {
        first.0 < 1.0 && row.iter().filter(|(theta, _)| *theta <= 60.0).all(|(_, albedo)| *albedo >= share * factor)
    };
    if near(PI) && upright(PI, 0.28) {
        return Some(Cause::MissingPi);
    }
    if near(4.0) && upright(4.0, 0.28) {
        return Some(Cause::MissingQuarter);
    }
    if near(4.0 / PI) && upright(4.0 / PI, 0.85) {
        return Some(Cause::PiForQuarter);
    }
    let falls = |factor: &(dyn Fn(Vector<f64>, Vector<f64>) -> f64 + Sync)| {
        let with = scaled(subject, factor);
        [0.0, 45.0, 75.0].iter().all(|&theta| (0.7..1.02).contains(&brightest(&with, &[theta])))
    };
    let middle = row.iter().find(|(theta, _)| *theta >= 60.0).copied().unwrap_or(first);
    if last.1 < 0.2 * middle.1
        && (falls(&|wi, wo| 0.25 / (wi.z * wo.z)) || falls(&|wi, wo| 0.25 * PI / (wi.z * wo.z).powi(2)))
    {
        return Some(Cause::NoDenominator);
    }
    if unweighted(subject, &row, seed) { Some(Cause::Unweighted) } else { None }
}

/// f, if it is the same everywhere in the first channel.
fn constant(subject: &dyn Subject, seed: u32) -> Option<f64> {
    let pairs: Vec<Pair> = (0..128).map(|i| Class::Hemisphere.pair(i, seed)).collect();
    let f = values(subject, &pairs);
    let n = subject.channels();
    let brightest = (0..n).reduce(|a, b| if f[b] > f[a] { b } else { a })?;
    let each = || f.iter().skip(brightest).step_by(n).copied();
    let (low, high) = (each().fold(f64::INFINITY, f64::min), each().fold(f64::NEG_INFINITY, f64::max));
    (high.is_finite() && high - low <= 1e-9 * high).then_some(high)
}

/// Whether f is a constant plus a lobe, each of which keeps its energy.
///
/// The constant is what f comes back to over a part of the hemisphere; the lobe must rise over it several times.
fn unweighted(subject: &dyn Subject, row: &[(f64, f64)], seed: u32) -> bool {
    let pairs: Vec<Pair> = (0..512).map(|i| Class::Hemisphere.pair(i, seed)).collect();
    let n = subject.channels();
    let f = values(subject, &pairs);
    (0..n).any(|channel| {
        let mut each: Vec<f64> = f.iter().skip(channel).step_by(n).copied().filter(|f| f.is_finite()).collect();
        each.sort_by(f64::total_cmp);
        let Some(&floor) = each.first() else { return false };
        // A twentieth of all pairs within a percent.
        let flat = each.get(each.len() / 20).is_some_and(|f| *f <= 1.01 * floor);
        let upright = Vector::<f64>::from_angles(0.3, 0.0);
        let mut peak = vec![0.0; n];
        subject.evaluate(Vector::new(-upright.x, -upright.y, upright.z), upright, &mut peak);
        let diffuse = PI * floor;
        let whole = |albedo: f64| (0.0..=1.02).contains(&albedo);
        flat && diffuse > 0.02
            && whole(diffuse)
            && peak[channel] > 3.0 * floor
            && row.iter().all(|&(_, albedo)| whole((albedo - diffuse).max(0.0)))
    })
}
