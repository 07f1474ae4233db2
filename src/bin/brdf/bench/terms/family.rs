//! The families of terms: which variants each has, what they are held against, and where.

use super::cpu::{Planned, Runner, Shaped};
use super::formula::*;
use crate::failure::Failure;
use brdf::Vector;
use brdf::material::metal;

/// How an error is measured.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(in crate::bench) enum Measure {
    /// |have − want|.
    Absolute,
    /// |have − want| / |want|.
    Relative,
}

impl Measure {
    pub(in crate::bench) fn name(self) -> &'static str {
        match self {
            Measure::Absolute => "absolute",
            Measure::Relative => "relative",
        }
    }
}

/// What the inputs of a family are.
#[derive(Clone, Copy)]
pub(super) enum Inputs {
    /// A cosine, equally spread over [0, 1].
    Cosine,
    /// The half vectors of [`Inputs::Lobe`].
    Half,
    /// A direction above the horizon, and its mirror image in a facet drawn from Beckmann's distribution.
    Lobe,
    /// Two directions above the horizon.
    Pair,
}

/// A way to compute a family's quantity.
pub(super) struct Variant {
    pub(super) name: &'static str,
    pub(super) runner: Box<dyn Runner>,
    /// The body of its WGSL function. Those without come last.
    pub(super) wgsl: Option<&'static str>,
}

/// Variants that are compared with each other.
pub(super) struct Family {
    /// As the command line names it.
    pub(super) name: &'static str,
    /// The name of its picture and the key of its table.
    pub(super) slug: &'static str,
    pub(super) title: &'static str,
    pub(super) measure: Measure,
    /// What the error is held against, in words.
    pub(super) truth: &'static str,
    /// The variant whose f64 instance is the truth of all; without one, each is held against its own.
    pub(super) exact: Option<usize>,
    /// A second error: against this variant, as a share of its peak.
    pub(super) stands_for: Option<(usize, &'static str)>,
    pub(super) inputs: Inputs,
    /// The results of an evaluation.
    pub(super) channels: usize,
    pub(super) constants: Constants,
    pub(super) variants: Vec<Variant>,
}

/// Every name that the command takes.
pub(super) const NAMES: [&str; 5] = ["fresnel", "distribution", "masking", "diffuse", "whole"];

/// Variants from a table of names, formulas and WGSL.
macro_rules! variants {
    ($constants:expr, $inputs:literal -> $outputs:literal: $($name:literal $formula:ident $wgsl:literal;)*) => {
        vec![$(Variant {
            name: $name,
            runner: Box::new(Shaped::<_, $inputs, $outputs>($formula($constants.clone()))),
            wgsl: Some($wgsl),
        },)*]
    };
}

/// The families of these names, in order; all for none.
pub(super) fn families(wanted: &[String]) -> Result<Vec<Family>, Failure> {
    if let Some(unknown) = wanted.iter().find(|name| !NAMES.contains(&name.as_str())) {
        return Err(format!("{unknown}: no such family of terms; there are {}", NAMES.join(", ")).into());
    }
    let asked = |name: &str| wanted.is_empty() || wanted.iter().any(|wanted| wanted == name);
    let copper = metal::by_name("copper_elek").ok_or_else(|| "copper_elek is missing".to_owned())?;
    let unfit = |error: Box<dyn std::error::Error>| Failure::from(error.to_string());
    let copper = Constants::metal(copper).map_err(unfit)?;
    let mut families = Vec::new();
    if asked("fresnel") {
        families.push(metals(copper.clone()));
        families.push(glass(Constants::new([1.5; 3], [0.0; 3]).map_err(unfit)?));
    }
    for (name, family) in
        [("distribution", distribution as fn(_) -> _), ("masking", masking), ("diffuse", diffuse), ("whole", whole)]
    {
        if asked(name) {
            families.push(family(copper.clone()));
        }
    }
    Ok(families)
}

fn metals(constants: Constants) -> Family {
    Family {
        name: "fresnel",
        slug: "fresnel-metal",
        title: "Fresnel reflectance of copper, RGB",
        measure: Measure::Absolute,
        truth: "the exact conductor in f64",
        exact: Some(0),
        stands_for: None,
        inputs: Inputs::Cosine,
        channels: 3,
        variants: variants! { constants, 1 -> 3:
            "exact conductor" Conductor "return _conductor(a);";
            "Fit 12" FitTwelve "return _fit_twelve(a);";
            "Fit 8" FitEight "return _fit_eight(a);";
            "table, 128 × 8 bits" TableBytes "return _table_bytes(a);";
            "table, 128 × f32, √cos" TableRoots "return _table_roots(a);";
            "Lazányi, corrected" Lazanyi "return _lazanyi(a);";
            "F82-tint" Tinted "return _tinted(a);";
            "Mihaylov eq. 3.6" ConductorApprox "return _conductor_approx(a);";
            "Lazányi, uncorrected" LazanyiUncorrected "return _lazanyi_uncorrected(a);";
            "Schlick from F0" Schlick "return _schlick(a);";
        },
        constants,
    }
}

fn glass(constants: Constants) -> Family {
    Family {
        name: "fresnel",
        slug: "fresnel-glass",
        title: "Fresnel reflectance of glass, n = 1.5, RGB",
        measure: Measure::Absolute,
        truth: "the exact dielectric in f64",
        exact: Some(0),
        stands_for: None,
        inputs: Inputs::Cosine,
        channels: 3,
        variants: variants! { constants, 1 -> 3:
            "exact dielectric" Dielectric "return _dielectric(a);";
            "exact conductor, κ = 0" Conductor "return _conductor(a);";
            "Fit 12" FitTwelve "return _fit_twelve(a);";
            "Fit 8" FitEight "return _fit_eight(a);";
            "table, 128 × 8 bits" TableBytes "return _table_bytes(a);";
            "table, 128 × f32, √cos" TableRoots "return _table_roots(a);";
            "Lazányi, corrected" Lazanyi "return _lazanyi(a);";
            "F82-tint" Tinted "return _tinted(a);";
            "Mihaylov eq. 3.6" ConductorApprox "return _conductor_approx(a);";
            "Schlick from F0" Schlick "return _schlick(a);";
        },
        constants,
    }
}

fn distribution(constants: Constants) -> Family {
    Family {
        name: "distribution",
        slug: "distribution",
        title: "distributions of facets, α = .3",
        measure: Measure::Relative,
        truth: "the same formula in f64",
        exact: None,
        stands_for: Some((0, "as Beckmann's, relative to its peak")),
        inputs: Inputs::Half,
        channels: 1,
        variants: variants! { constants, 3 -> 1:
            "Beckmann" Beckmann "return vec3f(distribution::beckmann(vec3f(a, b, c), _alpha()), 0.0, 0.0);";
            "GGX" Ggx "return vec3f(distribution::ggx(vec3f(a, b, c), _alpha()), 0.0, 0.0);";
            "Blinn" Blinn "return vec3f(distribution::blinn(vec3f(a, b, c), _alpha()), 0.0, 0.0);";
            "Gaussian" Gaussian
                "return vec3f(distribution::gaussian(vec3f(a, b, c), _alpha(), _normalisation()), 0.0, 0.0);";
        },
        constants,
    }
}

fn masking(constants: Constants) -> Family {
    Family {
        name: "masking",
        slug: "masking",
        title: "masking and shadowing V = G/(4 NL NV), α = .3",
        measure: Measure::Relative,
        truth: "the same formula in f64",
        exact: None,
        stands_for: None,
        inputs: Inputs::Lobe,
        channels: 1,
        variants: variants! { constants, 6 -> 1:
            "V-cavity" VCavity "return vec3f(masking::v_cavity(c, f, vec3f(a + d, b + e, c + f)).visibility, 0.0, 0.0);";
            "Kelemen" Kelemen "return vec3f(masking::kelemen(c, f, vec3f(a + d, b + e, c + f)).visibility, 0.0, 0.0);";
            "Smith GGX" SmithGgx
                "return vec3f(masking::smith_ggx(vec3f(a, b, c), vec3f(d, e, f), _alpha(), _alpha()).visibility, 0.0, 0.0);";
            "Smith GGX, separable" SmithGgxSeparable
                "return vec3f(masking::smith_ggx_separable(vec3f(a, b, c), vec3f(d, e, f), _alpha(), _alpha()).visibility, 0.0, 0.0);";
            "Smith Beckmann" SmithBeckmann
                "return vec3f(masking::smith_beckmann(vec3f(a, b, c), vec3f(d, e, f), _alpha(), _alpha()).visibility, 0.0, 0.0);";
            "Smith Beckmann, separable" SmithBeckmannSeparable
                "return vec3f(masking::smith_beckmann_separable(vec3f(a, b, c), vec3f(d, e, f), _alpha(), _alpha()).visibility, 0.0, 0.0);";
        },
        constants,
    }
}

fn diffuse(constants: Constants) -> Family {
    Family {
        name: "diffuse",
        slug: "diffuse",
        title: "diffuse reflection, σ = .3, one channel",
        measure: Measure::Relative,
        truth: "Oren and Nayar's model in full, in f64",
        exact: Some(0),
        stands_for: None,
        inputs: Inputs::Pair,
        channels: 1,
        variants: variants! { constants, 6 -> 1:
            "Oren–Nayar, full" OrenNayar
                "let parts = diffuse::oren_nayar(vec3f(a, b, c), vec3f(d, e, f), _sigma());
                return vec3f(max(_albedo() * 0.318309886 * (parts.direct + _albedo() * parts.interreflection), 0.0), 0.0, 0.0);";
            "Oren–Nayar, qualitative" OrenNayarQualitative
                "return vec3f(diffuse::oren_nayar_qualitative(vec3f(a, b, c), vec3f(d, e, f), _sigma(), _albedo()), 0.0, 0.0);";
            "Lambert" Lambert "return vec3f(select(0.0, diffuse::lambert(_albedo()), c > 0.0 && f > 0.0), 0.0, 0.0);";
        },
        constants,
    }
}

fn whole(constants: Constants) -> Family {
    let planned = |name, max_error| {
        let runner = Planned::new(&constants, max_error)?;
        Some(Variant { name, runner: Box::new(runner), wgsl: None })
    };
    let planned = [planned(PLANNED, 0.0), planned("a plan, F fitted to 1e-6", 1e-6)];
    let mut family = general(constants.clone());
    family.variants.extend(planned.into_iter().flatten());
    family
}

/// The exact BRDF as a plan evaluates it.
pub(super) const PLANNED: &str = "a plan, exact";

fn general(constants: Constants) -> Family {
    Family {
        name: "whole",
        slug: "whole",
        title: "Torrance–Sparrow of rough copper, α = .3, RGB",
        measure: Measure::Relative,
        truth: "the BRDF with the exact conductor in f64",
        exact: Some(0),
        stands_for: None,
        inputs: Inputs::Lobe,
        channels: 3,
        variants: variants! { constants, 6 -> 3:
            "exact conductor" RoughConductor "return _rough(a, b, c, d, e, f) * _conductor(_half(a, b, c, d, e, f));";
            "Fit 12" RoughFitTwelve "return _rough(a, b, c, d, e, f) * _fit_twelve(_half(a, b, c, d, e, f));";
            "Fit 8" RoughFitEight "return _rough(a, b, c, d, e, f) * _fit_eight(_half(a, b, c, d, e, f));";
            "Lazányi, corrected" RoughLazanyi "return _rough(a, b, c, d, e, f) * _lazanyi(_half(a, b, c, d, e, f));";
            "F82-tint" RoughTinted "return _rough(a, b, c, d, e, f) * _tinted(_half(a, b, c, d, e, f));";
            "Mihaylov eq. 3.6" RoughConductorApprox
                "return _rough(a, b, c, d, e, f) * _conductor_approx(_half(a, b, c, d, e, f));";
            "Lazányi, uncorrected" RoughLazanyiUncorrected
                "return _rough(a, b, c, d, e, f) * _lazanyi_uncorrected(_half(a, b, c, d, e, f));";
            "Schlick from F0" RoughSchlick "return _rough(a, b, c, d, e, f) * _schlick(_half(a, b, c, d, e, f));";
        },
        constants,
    }
}

/// The WGSL of a whole BRDF, beside [`WGSL`].
pub(super) const ROUGH: &str = "
fn _rough(a: f32, b: f32, c: f32, d: f32, e: f32, f: f32) -> f32 {
    return microfacet::facets(vec3f(a, b, c), vec3f(d, e, f), _alpha()).lobe;
}
fn _half(a: f32, b: f32, c: f32, d: f32, e: f32, f: f32) -> f32 {
    return microfacet::cos_half(vec3f(a, b, c), vec3f(d, e, f));
}
";

impl Inputs {
    /// The numbers of an evaluation.
    pub(super) fn words(self) -> usize {
        match self {
            Inputs::Cosine => 1,
            Inputs::Half => 3,
            Inputs::Lobe | Inputs::Pair => 6,
        }
    }

    /// Where that is, in words.
    pub(super) fn domain(self) -> &'static str {
        match self {
            Inputs::Cosine => "cosines equally spread over [0, 1]",
            Inputs::Half => "half vectors drawn from Beckmann's distribution",
            Inputs::Lobe => {
                "a direction with a cosine ≥ .02, and its mirror image in a facet of Beckmann's distribution"
            }
            Inputs::Pair => "pairs of directions with cosines ≥ .02",
        }
    }

    /// This many inputs, a column for each number.
    pub(super) fn columns(self, count: usize, alpha: f64) -> Vec<Vec<f32>> {
        let mut columns = vec![Vec::with_capacity(count); self.words()];
        // Roberts 2018: the root of x⁵ = x + 1 gives the steps of a sequence in four dimensions.
        const G: f64 = 1.167_303_978_261_418_7;
        for index in 1u32.. {
            if columns[0].len() >= count {
                break;
            }
            let u: [f64; 4] = std::array::from_fn(|axis| (0.5 + f64::from(index) * G.powi(-(axis as i32 + 1))).fract());
            let direction = |cos: f64, turn: f64| Vector::<f64>::from_angles(cos.acos(), std::f64::consts::TAU * turn);
            let wi = direction(LEAST_COSINE + (1.0 - LEAST_COSINE) * u[0], u[1]);
            let wo = if let Inputs::Pair = self {
                direction(LEAST_COSINE + (1.0 - LEAST_COSINE) * u[2], u[3])
            } else {
                // Beckmann's slopes: 1 − exp(−tan²θ/α²) is equally spread.
                let facet = direction(1.0 / (1.0 - alpha * alpha * (1.0 - u[2]).ln()).sqrt(), u[3]);
                facet * (2.0 * wi.dot(facet)) - wi
            };
            if wo.z < LEAST_COSINE {
                continue;
            }
            let h = wi + wo;
            let row: &[f64] = match self {
                // Both ends belong to it.
                Inputs::Cosine => &[columns[0].len() as f64 / (count - 1) as f64],
                Inputs::Half => &[h.x, h.y, h.z],
                Inputs::Lobe | Inputs::Pair => &[wi.x, wi.y, wi.z, wo.x, wo.y, wo.z],
            };
            for (column, value) in columns.iter_mut().zip(row) {
                column.push(*value as f32);
            }
        }
        columns
    }
}

/// Closer to the horizon than this a lobe is cut off by it.
const LEAST_COSINE: f64 = 0.02;
