//! The table of terms: what they are called with, over which numbers, and what they should reach.

use crate::inputs::{self, DIMENSIONS, Point, alpha, cosine, diffuse_pair, flat, half, index, log, pair, share, upper};
use crate::naive;
use brdf::batch::{self, Kernel, Level};
use brdf::layered::{self, Interface, Layer, Model, Stack};
use brdf::plan::Plan;
use brdf::single::Single;
use brdf::{Real, Vector};
use brdf::{absorption, diffuse, distribution, fresnel, masking, microfacet, phong, refraction};
use std::f64::consts::PI;

/// A term over the numbers `R`: arguments in, results out, of which there are at most three.
type Form<R> = fn(&[R]) -> [R; 3];

/// A term over slices, with the instructions of a level: arguments in, of which those that it has not are 0s, results out.
type Batch = fn(Level, [&[f32]; DIMENSIONS], [&mut [f32]; 3]);

/// How far a term may be off in a batch, where that is not the target.
#[derive(Clone, Copy)]
pub(crate) struct Limit {
    pub(crate) ulp: f64,
    /// What the ULP are those of where the result is smaller: the size of what cancels in it.
    pub(crate) scale: fn(&[f64]) -> f64,
}

/// One row: a function of the crate.
pub(crate) struct Term {
    pub(crate) module: &'static str,
    pub(crate) function: &'static str,
    /// A name for each result; empty where there is one.
    pub(crate) results: &'static [&'static str],
    /// Where it is measured.
    pub(crate) domain: &'static str,
    /// The largest error in ULP that the project asks for.
    pub(crate) target: Option<f64>,
    /// The smallest result that is measured, 0 for any.
    pub(crate) least: f64,
    /// The arguments that a point stands for.
    pub(crate) draw: fn(&Point) -> Vec<f32>,
    pub(crate) single: Form<f32>,
    pub(crate) double: Form<f64>,
    /// In f32 throughout.
    pub(crate) plain: Form<Single>,
    /// Many at once.
    pub(crate) batch: Batch,
    /// The limit of a batch; else the target.
    pub(crate) limit: Option<Limit>,
    /// Where a batch is measured.
    pub(crate) steady: fn(&[f64]) -> bool,
    /// As the documents print it.
    pub(crate) naive: Option<Form<f32>>,
    /// Whether the result is 0 by decree in f32: an exponent beyond [`Real::EXP_LIMIT`].
    pub(crate) past: fn(&[f64]) -> bool,
    /// Whether a result may be negative: a component of a vector, a part of a sum.
    pub(crate) signed: bool,
}

impl Term {
    pub(crate) fn name(&self) -> String {
        format!("{}::{}", self.module, self.function)
    }

    /// The limit of a batch: its own, else the target.
    pub(crate) fn batch_limit(&self) -> Option<Limit> {
        let target = self.target.map(|ulp| Limit { ulp, scale: |_| 0.0 });
        self.limit.or(target)
    }

    /// Whether a result is large enough to be measured. Where no light gets through there is nothing to be off by: total
    /// reflection, g² below 0.
    pub(crate) fn measures(&self, want: f64) -> bool {
        want.abs() >= self.least && !(self.function == "refracted_square" && want < 0.0)
    }
}

/// Fills up to three results.
trait Results<R> {
    fn three(self) -> [R; 3];
}
impl<R: Real> Results<R> for R {
    fn three(self) -> [R; 3] {
        [self, R::ZERO, R::ZERO]
    }
}
impl<R: Real> Results<R> for [R; 2] {
    fn three(self) -> [R; 3] {
        [self[0], self[1], R::ZERO]
    }
}
impl<R: Real> Results<R> for Vector<R> {
    fn three(self) -> [R; 3] {
        [self.x, self.y, self.z]
    }
}
impl<R: Real> Results<R> for fresnel::Fresnel<R> {
    fn three(self) -> [R; 3] {
        [self.reflectance, self.transmittance, R::ZERO]
    }
}
impl<R: Real> Results<R> for masking::Masking<R> {
    fn three(self) -> [R; 3] {
        [self.g, self.visibility, R::ZERO]
    }
}

fn vector<R: Real>(a: &[R]) -> Vector<R> {
    Vector::new(a[0], a[1], a[2])
}

/// The exponent of Beckmann's distribution at the half vector of a pair.
fn exponent_of_pair(a: &[f64], alpha: f64) -> f64 {
    let h = vector(a) + vector(&a[3..]);
    h.sin_squared() / (h.z * h.z * alpha * alpha)
}

const LIMIT: f64 = f32::EXP_LIMIT as f64;

fn stack<R: Real>(a: &[R]) -> [Layer<R, 1>; 2] {
    [
        Layer::new(Interface::dielectric(a[6], a[7])).over([a[8]], a[9]),
        Layer::new(Interface::conductor([a[10]], [a[11]], a[12])),
    ]
}

/// A coat of [1.1, 2.5] and a depth to 10 over any conductor, both of any width from 1e-3.
fn stack_inputs(p: &Point) -> Vec<f32> {
    let width = |u: f64| log(u, 1e-3, 1.0) as f32;
    let coat = width(p[5]);
    let [n, k] = index(p[9], p[10]);
    let sigma = log(p[7], 1e-3, 10.0) as f32;
    let numbers = [(1.1 + 1.4 * p[6]) as f32, coat, sigma, p[8] as f32, n, k, width(p[11])];
    // Half of the pairs mirror about a facet of the coat, half about one of the base.
    flat(&pair(if p[12] < 0.5 { coat } else { numbers[6] }, p), &numbers)
}

/// Each stack planned, and its batch of one.
fn planned(model: Model, level: Level, a: [&[f32]; DIMENSIONS], [f, ..]: [&mut [f32]; 3]) {
    for (i, f) in f.chunks_mut(1).enumerate() {
        let point = a.map(|column| f64::from(column[i]));
        let stack = Stack::new(model, stack(&point).to_vec()).expect("in the ranges");
        let plan = Plan::new(&stack).expect("a closed form");
        let one = |c: usize| &a[c][i..=i];
        let (wi, wo) = ([one(0), one(1), one(2)], [one(3), one(4), one(5)]);
        plan.evaluate_batch_at(level, wi, wo, [f]).expect("slices of one length");
    }
}

macro_rules! term {
    ($list:ident, $module:ident::$function:ident $results:expr, $domain:literal, $draw:expr, |$a:ident| $body:expr
        $(, target $target:literal)? $(, naive |$b:ident| $naive:expr)? $(, past |$c:ident| $past:expr)?
        $(, least $least:literal)? $(, signed $signed:literal)?
        $(, batch $limit:literal $(of |$d:ident| $scale:expr)?)?) => {{
        #[inline(always)]
        fn evaluate<R: Real>($a: &[R]) -> [R; 3] {
            Results::<R>::three($body)
        }
        struct Batched;
        impl Kernel<DIMENSIONS, 3> for Batched {
            #[inline(always)]
            fn evaluate<R: Real<Wide = R>>(&self, arguments: [R; DIMENSIONS]) -> [R; 3] {
                evaluate(&arguments)
            }
        }
        #[allow(unused_mut, unused_assignments)]
        let term = {
            let mut term = Term {
                module: stringify!($module),
                function: stringify!($function),
                results: &$results,
                domain: $domain,
                target: None,
                least: 0.0,
                draw: $draw,
                single: evaluate::<f32>,
                double: evaluate::<f64>,
                plain: evaluate::<Single>,
                batch: |level, arguments, results| {
                    batch::map_at(level, &Batched, arguments, results).expect("slices of one length");
                },
                limit: None,
                steady: |_| true,
                naive: None,
                past: |_| false,
                signed: false,
            };
            $(term.target = Some($target);)?
            $(term.naive = Some(|$b: &[f32]| Results::<f32>::three($naive));)?
            $(term.past = |$c: &[f64]| $past > LIMIT;)?
            $(term.least = $least;)?
            $(term.signed = $signed;)?
            $(
                term.limit = Some(Limit { ulp: $limit, scale: |_| 0.0 });
                $(term.limit = Some(Limit { ulp: $limit, scale: |$d: &[f64]| $scale });)?
            )?
            term
        };
        $list.push(term);
    }};
}

/// Has the last term evaluated by plans in a batch.
fn plan_last(terms: &mut [Term], batch: Batch, steady: fn(&[f64]) -> bool) {
    if let Some(last) = terms.last_mut() {
        (last.batch, last.steady) = (batch, steady);
    }
}

/// Whether an index has no critical angle to speak of: (η+iκ)² − sin² stays at least .1 from 0.
fn steady(eta: f64, kappa: f64) -> bool {
    let real = eta * eta - 1.0 - kappa * kappa;
    let distance = real.max(-real - 1.0).max(0.0);
    distance.hypot(2.0 * eta * kappa) >= 0.1
}

/// Every term of the crate that has an error to speak of.
#[rustfmt::skip]
pub(crate) fn terms() -> Vec<Term> {
    let mut t = Vec::new();
    term!(t, fresnel::dielectric ["F", "T"], "cos [1e-6, 1], η [1/4, 4]; critical angles",
        |p| inputs::incidence(p), |a| fresnel::dielectric(a[0], a[1]),
        target 8.0, naive |a| naive::dielectric(a[0], a[1]));
    term!(t, fresnel::refracted_square [""], "cos [1e-6, 1], η [1/4, 4]; critical angles",
        |p| inputs::incidence(p), |a| fresnel::refracted_square(a[0], a[1]),
        naive |a| a[0] * a[0] + a[1] * a[1] - 1.0, signed true, batch 1.0);
    term!(t, fresnel::conductor ["F", "T"], "cos [1e-6, 1], n [.02, 8], κ [0, 12]; critical angles",
        |p| inputs::conductor(p), |a| fresnel::conductor(a[0], a[1], a[2]),
        target 8.0, naive |a| naive::conductor(a[0], a[1], a[2]));
    term!(t, fresnel::conductor_approx [""], "cos [1e-6, 1], n [.02, 8], κ [0, 12]",
        |p| inputs::conductor(p), |a| fresnel::conductor_approx(a[0], a[1], a[2]),
        naive |a| naive::conductor_approx(a[0], a[1], a[2]), batch 8.0);
    term!(t, fresnel::normal_incidence [""], "n [.02, 8], κ [0, 12]",
        |p| index(p[0], p[1]).to_vec(), |a| fresnel::normal_incidence(a[0], a[1]), batch 8.0);
    term!(t, fresnel::schlick ["F", "T"], "cos [1e-6, 1], F₀ [0, 1]",
        |p| vec![cosine(p[0]), share(p[1])], |a| fresnel::schlick(a[0], a[1]),
        target 4.0, naive |a| naive::schlick(a[0], a[1]));
    term!(t, fresnel::schlick_from_indices ["F", "T"], "cos [1e-6, 1], n [1, 3] both",
        |p| vec![cosine(p[0]), (1.0 + 2.0 * p[1]) as f32, (1.0 + 2.0 * p[2]) as f32],
        |a| fresnel::schlick_from_indices(a[0], a[1], a[2]),
        target 4.0, naive |a| naive::schlick_from_indices(a[0], a[1], a[2]));
    term!(t, fresnel::lazanyi_uncorrected [""], "cos [1e-6, 1], n [.02, 8], κ [0, 12]",
        |p| inputs::conductor(p), |a| fresnel::lazanyi_uncorrected(a[0], a[1], a[2]),
        target 8.0, naive |a| naive::lazanyi_uncorrected(a[0], a[1], a[2]));
    term!(t, fresnel::lazanyi [""], "the same, a [−1, 3], exponent [1, 12]",
        |p| { let mut a = inputs::conductor(p); a.extend([(4.0 * p[4] - 1.0) as f32, (1.0 + 11.0 * p[5]) as f32]); a },
        |a| fresnel::lazanyi(a[0], a[1], a[2], a[3], a[4]),
        target 8.0, naive |a| naive::lazanyi(a[0], a[1], a[2], a[3], a[4]),
        batch 8.0 of |a| fresnel::lazanyi_uncorrected(a[0], a[1], a[2]).max(1e-30));
    term!(t, fresnel::f82_tint [""], "cos [1e-6, 1], F₀ and tint [0, 1]",
        |p| vec![cosine(p[0]), share(p[1]), share(p[2])], |a| fresnel::f82_tint(a[0], a[1], a[2]),
        batch 8.0 of |a| fresnel::schlick(a[0], a[1]).reflectance);

    term!(t, distribution::beckmann [""], "α [1e-4, 1], tanθ to 1e4·α, any length of h",
        |p| { let a = alpha(p[3]); flat(&[half(a, p)], &[a]) }, |a| distribution::beckmann(vector(a), a[3]),
        target 8.0, naive |a| naive::beckmann(vector(a), a[3]),
        past |a| vector(a).sin_squared() / (a[2] * a[3]).powi(2));
    term!(t, distribution::beckmann_anisotropic [""], "the same, α [1e-4, 1] along each axis",
        |p| flat(&[half(alpha(p[3]), p)], &[alpha(p[3]), alpha(p[4])]),
        |a| distribution::beckmann_anisotropic(vector(a), a[3], a[4]),
        target 8.0, past |a| ((a[0] / a[3]).powi(2) + (a[1] / a[4]).powi(2)) / (a[2] * a[2]));
    term!(t, distribution::ggx [""], "α [1e-4, 1], tanθ to 1e4·α, any length of h",
        |p| { let a = alpha(p[3]); flat(&[half(a, p)], &[a]) }, |a| distribution::ggx(vector(a), a[3]),
        target 6.0, naive |a| naive::ggx(vector(a), a[3]));
    term!(t, distribution::ggx_anisotropic [""], "the same, α [1e-4, 1] along each axis",
        |p| flat(&[half(alpha(p[3]), p)], &[alpha(p[3]), alpha(p[4])]),
        |a| distribution::ggx_anisotropic(vector(a), a[3], a[4]), target 6.0);
    term!(t, distribution::blinn [""], "α [1e-4, 1], tanθ to 1e4·α, any length of h",
        |p| { let a = alpha(p[3]); flat(&[half(a, p)], &[a]) }, |a| distribution::blinn(vector(a), a[3]),
        naive |a| naive::blinn(vector(a), a[3]),
        past |a| (1.0 / (a[3] * a[3]) - 1.0) * (vector(a).sin_squared() / (a[2] * a[2])).ln_1p(), batch 16.0);
    term!(t, distribution::blinn_anisotropic [""], "the same, α [1e-4, 1] along each axis",
        |p| flat(&[half(alpha(p[3]), p)], &[alpha(p[3]), alpha(p[4])]),
        |a| distribution::blinn_anisotropic(vector(a), a[3], a[4]),
        past |a| {
            let s = vector(a).sin_squared();
            (((a[0] / a[3]).powi(2) + (a[1] / a[4]).powi(2)) / s - 1.0) * (s / (a[2] * a[2])).ln_1p()
        }, batch 16.0);
    term!(t, distribution::gaussian [""], "the same, c = 1/(πα²)",
        |p| { let a = alpha(p[3]); flat(&[half(a, p)], &[a, (1.0 / (PI * f64::from(a).powi(2))) as f32]) },
        |a| distribution::gaussian(vector(a), a[3], a[4]),
        naive |a| naive::gaussian(vector(a), a[3], a[4]),
        past |a| (vector(a).sin_squared().sqrt().atan2(a[2]) / a[3]).powi(2), batch 128.0);

    term!(t, masking::v_cavity ["G", "V"], "cos [1e-6, 1], h = wi + wo rounded",
        |p| flat(&pair(alpha(p[5]), p), &[]), |a| masking::v_cavity(a[2], a[5], vector(a) + vector(&a[3..])),
        target 4.0, naive |a| naive::v_cavity(vector(a), vector(&a[3..])));
    term!(t, masking::smith_ggx ["G", "V"], "cos [1e-6, 1], α [1e-4, 1] along each axis",
        |p| flat(&[upper(p[0], p[1]), upper(p[2], p[3])], &[alpha(p[5]), alpha(p[6])]),
        |a| masking::smith_ggx(vector(a), vector(&a[3..]), a[6], a[7]),
        target 4.0, naive |a| naive::smith_ggx(vector(a), vector(&a[3..]), a[6], a[7]));
    term!(t, masking::smith_ggx_separable ["G", "V"], "cos [1e-6, 1], α [1e-4, 1] along each axis",
        |p| flat(&[upper(p[0], p[1]), upper(p[2], p[3])], &[alpha(p[5]), alpha(p[6])]),
        |a| masking::smith_ggx_separable(vector(a), vector(&a[3..]), a[6], a[7]),
        target 4.0, naive |a| naive::smith_ggx_separable(vector(a), vector(&a[3..]), a[6], a[7]));
    term!(t, masking::smith_beckmann ["G", "V"], "cos [1e-6, 1], α [1e-4, 1] along each axis",
        |p| flat(&[upper(p[0], p[1]), upper(p[2], p[3])], &[alpha(p[5]), alpha(p[6])]),
        |a| masking::smith_beckmann(vector(a), vector(&a[3..]), a[6], a[7]), target 4.0);
    term!(t, masking::smith_beckmann_separable ["G", "V"], "cos [1e-6, 1], α [1e-4, 1] along each axis",
        |p| flat(&[upper(p[0], p[1]), upper(p[2], p[3])], &[alpha(p[5]), alpha(p[6])]),
        |a| masking::smith_beckmann_separable(vector(a), vector(&a[3..]), a[6], a[7]), target 4.0);
    term!(t, masking::kelemen ["G", "V"], "cos [1e-6, 1], h = wi + wo rounded",
        |p| flat(&pair(alpha(p[5]), p), &[]), |a| masking::kelemen(a[2], a[5], vector(a) + vector(&a[3..])),
        target 4.0, naive |a| naive::kelemen(vector(a), vector(&a[3..])));
    term!(t, masking::projected_area_ggx [""], "cos [1e-6, 1], α [1e-4, 1] along each axis",
        |p| flat(&[upper(p[0], p[1])], &[alpha(p[5]), alpha(p[6])]),
        |a| masking::projected_area_ggx(vector(a), a[3], a[4]), batch 4.0);
    term!(t, masking::projected_area_beckmann [""], "cos [1e-6, 1], α [1e-4, 1] along each axis",
        |p| flat(&[upper(p[0], p[1])], &[alpha(p[5]), alpha(p[6])]),
        |a| masking::projected_area_beckmann(vector(a), a[3], a[4]), batch 4.0);

    term!(t, diffuse::lambert [""], "ρ [0, 1]", |p| vec![share(p[0])], |a| diffuse::lambert(a[0]), batch 2.0);
    term!(t, diffuse::oren_nayar ["direct", "interreflection"], "cos [1e-6, 1], σ [0, π/2]",
        |p| flat(&diffuse_pair(p), &[(p[5] * PI / 2.0) as f32]),
        |a| { let f = diffuse::oren_nayar(vector(a), vector(&a[3..]), a[6]); [f.direct, f.interreflection] },
        target 16.0, naive |a| naive::oren_nayar(vector(a), vector(&a[3..]), a[6]), signed true, batch 16.0 of |_a| 0.5);
    term!(t, diffuse::oren_nayar_qualitative [""], "cos [1e-6, 1], σ [0, π/2], ρ [0, 1]",
        |p| flat(&diffuse_pair(p), &[(p[5] * PI / 2.0) as f32, p[6] as f32]),
        |a| diffuse::oren_nayar_qualitative(vector(a), vector(&a[3..]), a[6], a[7]),
        target 16.0, naive |a| naive::oren_nayar_qualitative(vector(a), vector(&a[3..]), a[6], a[7]));

    term!(t, refraction::cos_t [""], "cos [1e-6, 1], η [1/4, 4]; critical angles",
        |p| inputs::incidence(p), |a| refraction::cos_t(a[0], a[1]),
        target 4.0, naive |a| naive::cos_t(a[0], a[1]));
    term!(t, refraction::refract ["x", "y", "z"], "the same",
        |p| { let a = inputs::incidence(p); flat(&[inputs::direction(f64::from(a[0]), p[4])], &a[1..]) },
        |a| refraction::refract(vector(a), a[3]), target 4.0, signed true);
    term!(t, refraction::refract_about ["x", "y", "z"], "cos [1e-6, 1], about half vectors, η [0.4, 2.5]",
        |p| {
            let [wi, wo] = pair(alpha(p[5]), p);
            flat(&[wi, (wi + wo).normalized()], &[log(p[6], 0.4, 2.5) as f32])
        },
        |a| refraction::refract_about(vector(a), vector(&a[3..]), a[6]), target 4.0, signed true);
    term!(t, absorption::transmittance [""], "σ [1e-4, 100], d [1e-4, 10], cos [1e-6, 1]",
        |p| vec![log(p[0], 1e-4, 100.0) as f32, log(p[1], 1e-4, 10.0) as f32, cosine(p[2]), cosine(p[3])],
        |a| absorption::transmittance(a[0], a[1], a[2], a[3]),
        target 8.0, naive |a| naive::transmittance(a[0], a[1], a[2], a[3]),
        past |a| a[0] * a[1] * (1.0 / a[2] + 1.0 / a[3]));

    term!(t, phong::phong [""], "cos [1e-6, 1], n [.01, 1e6]",
        |p| { let n = log(p[5], 0.01, 1e6); flat(&pair((2.0 / (n + 2.0)).sqrt() as f32, p), &[n as f32]) },
        |a| phong::phong(vector(a), vector(&a[3..]), a[6]),
        naive |a| naive::phong(vector(a), vector(&a[3..]), a[6]),
        past |a| {
            let mirrored = Vector::new(-a[0], -a[1], a[2]);
            -a[6] * (-(0.5 * (mirrored + vector(&a[3..]) * -1.0).length_squared()).min(1.0)).ln_1p()
        }, batch 16.0);
    term!(t, phong::blinn_phong [""], "cos [1e-6, 1], n [.01, 1e6]",
        |p| { let n = log(p[5], 0.01, 1e6); flat(&pair((2.0 / (n + 2.0)).sqrt() as f32, p), &[n as f32]) },
        |a| phong::blinn_phong(vector(a), vector(&a[3..]), a[6]),
        naive |a| naive::blinn_phong(vector(a), vector(&a[3..]), a[6]),
        past |a| 0.5 * a[6] * (exponent_of_pair(a, 1.0)).ln_1p(), batch 16.0);

    term!(t, microfacet::cos_half [""], "cos [1e-6, 1]", |p| flat(&pair(alpha(p[5]), p), &[]),
        |a| microfacet::cos_half(vector(a), vector(&a[3..])),
        naive |a| vector(&a[3..]).dot((vector(a) + vector(&a[3..])).normalized()), batch 4.0);
    term!(t, microfacet::facets ["lobe", "D"], "cos [1e-6, 1], α [1e-4, 1]",
        |p| { let a = alpha(p[5]); flat(&pair(a, p), &[a]) },
        |a| { let f = microfacet::facets(vector(a), vector(&a[3..]), a[6]); [f.lobe, f.d] },
        target 32.0, past |a| exponent_of_pair(a, a[6]));
    term!(t, microfacet::torrance_sparrow [""], "cos [1e-6, 1], n [.02, 8], κ [0, 12], α [1e-4, 1]",
        |p| { let a = alpha(p[5]); let [n, k] = index(p[6], p[7]); flat(&pair(a, p), &[n, k, a]) },
        |a| microfacet::torrance_sparrow(vector(a), vector(&a[3..]), a[6], a[7], a[8]).f,
        target 32.0, naive |a| naive::torrance_sparrow(vector(a), vector(&a[3..]), a[6], a[7], a[8]),
        past |a| exponent_of_pair(a, a[8]));

    term!(t, layered::internal_reflection [""], "T and G [0, 1]", |p| vec![share(p[0]), share(p[1])],
        |a| layered::internal_reflection(a[0], a[1]), naive |a| 1.0 - a[1] + a[1] * a[0]);
    term!(t, layered::conserving [""], "two layers: cos [1e-6, 1], coat n [1.1, 2.5], σd to 10, base n [.02, 8], κ [0, 12], both α [1e-3, 1]; f > 1e-8",
        stack_inputs, |a| { let [f] = layered::conserving(&stack(a), vector(a), vector(&a[3..])); f },
        target 12.0, least 1e-8, batch 40.0);
    plan_last(&mut t, |level, a, f| planned(Model::Conserving, level, a, f), |a| steady(a[10] / a[6], a[11] / a[6]));
    term!(t, layered::elek [""], "the same",
        stack_inputs, |a| { let [f] = layered::elek(&stack(a), vector(a), vector(&a[3..])); f },
        target 12.0, least 1e-8, batch 40.0);
    plan_last(&mut t, |level, a, f| planned(Model::Elek, level, a, f), |a| steady(a[10], a[11]));
    term!(t, layered::weidlich_wilkie [""], "the same",
        stack_inputs, |a| { let [f] = layered::weidlich_wilkie(&stack(a), vector(a), vector(&a[3..])); f },
        target 12.0, least 1e-8, batch 64.0);
    plan_last(&mut t, |level, a, f| planned(Model::WeidlichWilkie, level, a, f), |a| steady(a[10] / a[6], a[11] / a[6]));

    term!(t, real::erfcx [""], "x [1e-6, 1e4]", |p| vec![log(p[0], 1e-6, 1e4) as f32], |a| a[0].erfcx(), batch 6.0);
    term!(t, real::exp_product [""], "a, b [1e-6, 1e3]",
        |p| vec![log(p[0], 1e-6, 1e3) as f32, log(p[1], 1e-6, 1e3) as f32], |a| a[0].exp_product(a[1]),
        naive |a| (-(a[0] * a[1])).exp(), past |a| a[0] * a[1], batch 2.0);
    t
}
