//! The pieces of Burley's principled model (2012), and of its relatives in engines.

use crate::diffuse::burley;
use crate::microfacet::{ggx, ggx_smith, schlick, smith, torrance_sparrow};
use crate::{Case, Energy, judge_all, of, one};
use brdf::check::{self, Cause, Check, Effort, Fixed};
use brdf::{Vector, half_vector};
use std::f64::consts::{FRAC_1_PI, PI};

/// GTR1, normalised.
fn gtr1(h: Vector<f64>, a: f64) -> f64 {
    let square = a * a;
    let nh = h.z * h.z / h.length_squared();
    (square - 1.0) / (PI * square.ln() * (1.0 + (square - 1.0) * nh))
}

/// The albedo of GGX along cosθ or its root, with straight lines between.
struct Table {
    albedos: Vec<f64>,
    power: f64,
}

impl Table {
    /// `power` is 1 for even steps in cosθ, ½ for the root, which is dense where masking bends.
    fn new(alpha: f64, n: usize, power: f64) -> Self {
        let subject = one("GGX", ggx_smith(alpha)).subject;
        let effort = Effort { target: 1e-4, replicates: 0, ..Effort::default() };
        let at = |i: usize| {
            let cos = (i as f64 / n as f64).powf(1.0 / power).clamp(1e-5, 1.0);
            check::albedo(&*subject, cos.acos().to_degrees(), 0.0, Fixed::View, &effort).value[0]
        };
        Table { albedos: (0..=n).map(at).collect(), power }
    }
    fn at(&self, cos: f64) -> f64 {
        let n = self.albedos.len() - 1;
        let u = cos.clamp(0.0, 1.0).powf(self.power) * n as f64;
        let i = (u as usize).min(n - 1);
        self.albedos[i] + (self.albedos[i + 1] - self.albedos[i]) * (u - i as f64)
    }
    /// 2∫ E μ dμ by midpoints in μ = x², of the same straight lines.
    fn mean(&self) -> f64 {
        let steps = 16 * self.albedos.len();
        let term = |k: usize| {
            let x = (k as f64 + 0.5) / steps as f64;
            4.0 * self.at(x * x) * x * x * x / steps as f64
        };
        (0..steps).map(term).sum()
    }
}

fn kulla_conty(alpha: f64, entries: usize, power: f64) -> Case {
    let table = Table::new(alpha, entries - 1, power);
    let mean = table.mean();
    one(format!("Kulla–Conty α={alpha}, {entries}, μ^{power}"), move |wi, wo| {
        let missing = (1.0 - table.at(wi.z)) * (1.0 - table.at(wo.z)) / (PI * (1.0 - mean));
        ggx_smith(alpha)(wi, wo) + missing
    })
}

fn view_scaled(alpha: f64) -> Case {
    let table = Table::new(alpha, 512, 0.5);
    one(format!("view-scaled GGX α={alpha}"), move |wi, wo| ggx_smith(alpha)(wi, wo) / table.at(wo.z))
}

#[test]
fn compensation() {
    judge_all(&[
        // 1 but for the table.
        kulla_conty(1.0, 257, 1.0).peaks(1.0),
        kulla_conty(0.3, 257, 1.0).peaks(1.0),
        kulla_conty(0.03, 257, 1.0).energy(Energy::NotFail),
        kulla_conty(0.01, 257, 1.0).energy(Energy::NotFail),
        // Passes each furnace and reaches 1.58 with the light fixed at 80°.
        view_scaled(1.0)
            .marginals(Energy::At(1.0, 2e-3), Energy::Over)
            .fails(Check::Reciprocity)
            .cause(Cause::ViewScaled),
        view_scaled(0.5)
            .marginals(Energy::At(1.0, 2e-3), Energy::Over)
            .fails(Check::Reciprocity)
            .cause(Cause::ViewScaled),
    ]);
}

#[test]
fn principled_pieces() {
    judge_all(&[
        // Burley's clearcoat: GTR1 of .1…, F₀ = .04, G of α = .25, a quarter of it.
        one("clearcoat gloss=1", |wi, wo| {
            0.25 * gtr1(half_vector(wi, wo), 0.001) * schlick(wi, wo, 0.04) * smith(wi, wo, 0.25, 0.25)
        }),
        one("clearcoat gloss=0", |wi, wo| {
            0.25 * gtr1(half_vector(wi, wo), 0.1) * schlick(wi, wo, 0.04) * smith(wi, wo, 0.25, 0.25)
        })
        .energy(Energy::Grid),
        // As published: the product of two one-sided G of .25, without a denominator.
        one("clearcoat as published", |wi, wo| {
            let g = |c: f64| 1.0 / (c + (0.0625 + (1.0 - 0.0625) * c * c).sqrt());
            0.25 * gtr1(half_vector(wi, wo), 0.1) * schlick(wi, wo, 0.04) * g(wi.z) * g(wo.z)
        })
        .grid(),
        one("sheen", |wi, wo| {
            let vh = 0.5 * half_vector(wi, wo).length_squared().sqrt();
            (1.0 - vh).max(0.0).powi(5)
        })
        .grid(),
        one("diffuse + sheen", |wi, wo| {
            let vh = 0.5 * half_vector(wi, wo).length_squared().sqrt();
            burley(0.5)(wi, wo) + (1.0 - vh).max(0.0).powi(5)
        })
        .grid(),
        one("subsurface (Hanrahan–Krueger) r=.5", |wi, wo| {
            let f90 = 0.25 * half_vector(wi, wo).length_squared() * 0.5;
            let side = |c: f64| 1.0 + (f90 - 1.0) * (1.0 - c).powi(5);
            1.25 * FRAC_1_PI * (side(wi.z) * side(wo.z) * (1.0 / (wi.z + wo.z) - 0.5) + 0.5)
        })
        .grid(),
        one("plastic: Burley + GGX", |wi, wo| {
            burley(0.5)(wi, wo) + ggx(half_vector(wi, wo), 0.25) * smith(wi, wo, 0.25, 0.25) * schlick(wi, wo, 0.04)
        })
        .grid(),
        // Known: 1.040 at the normal, 1.82 at 89.9°.
        one("Lambert + GGX unweighted α=.01", |wi, wo| FRAC_1_PI + ggx_smith(0.01)(wi, wo) * schlick(wi, wo, 0.04))
            .reaches(1.82)
            .cause(Cause::Unweighted),
        one("Lambert + Torrance–Sparrow α=.1", |wi, wo| FRAC_1_PI + torrance_sparrow(0.1)(wi, wo))
            .energy(Energy::Fail(1.99, 0.02))
            .cause(Cause::Unweighted),
        of(Colours),
    ]);
}

/// Three channels, of which one gives out more than it gets.
struct Colours;

impl brdf::check::Subject for Colours {
    fn name(&self) -> String {
        "grey, white, grey metal".into()
    }
    fn channels(&self) -> usize {
        3
    }
    fn evaluate(&self, wi: Vector<f64>, wo: Vector<f64>, f: &mut [f64]) {
        let lobe = if wi.z > 0.0 && wo.z > 0.0 { ggx_smith(0.2)(wi, wo) } else { 0.0 };
        f.copy_from_slice(&[0.5, 1.0, 0.25].map(|tint| tint * lobe));
    }
}
