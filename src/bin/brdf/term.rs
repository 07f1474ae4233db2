//! The terms that `brdf eval` knows: their fields, the function behind each, and the names of its results.

use brdf::distribution::gaussian_normalisation;
use serde_json::{Map, Value};

/// The results of a line, by name.
pub(crate) type Results = Vec<(&'static str, Value)>;

/// A term of `brdf eval`.
pub(crate) struct Term {
    /// The name in the field `term`.
    pub(crate) name: &'static str,
    /// The fields it reads, in order.
    pub(crate) fields: &'static [Field],
    /// The module and the function that computes it, in Rust and in WGSL.
    pub(crate) function: (&'static str, &'static str),
    /// The function's arguments from the fields' numbers.
    pub(crate) arguments: fn(&[f64]) -> Vec<f64>,
    /// The results from the fields' numbers and the function's results.
    pub(crate) results: fn(&[f64], &[f64]) -> Results,
}

/// A field of a term.
pub(crate) struct Field {
    pub(crate) name: &'static str,
    pub(crate) kind: Kind,
}

/// What a field may hold.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// A number in [0, 1].
    Fraction,
    /// A number above 0.
    Positive,
    /// A number of 0 or more.
    NonNegative,
    /// Any number.
    Number,
    /// Three numbers, a unit vector.
    Direction,
    /// Three numbers, not all 0.
    Vector,
}

impl Kind {
    /// What is allowed, in words.
    pub(crate) fn allowed(self) -> &'static str {
        match self {
            Kind::Fraction => "a number in [0, 1]",
            Kind::Positive => "a number greater than 0",
            Kind::NonNegative => "a number of 0 or more",
            Kind::Number => "a number",
            Kind::Direction => "three numbers, a unit vector",
            Kind::Vector => "three numbers, not all 0",
        }
    }

    fn accepts(self, numbers: &[f64]) -> bool {
        let squared: f64 = numbers.iter().map(|x| x * x).sum();
        match self {
            Kind::Fraction => (0.0..=1.0).contains(&numbers[0]),
            Kind::Positive => numbers[0] > 0.0,
            Kind::NonNegative => numbers[0] >= 0.0,
            Kind::Number => true,
            // Directions may come rounded to single precision.
            Kind::Direction => (squared - 1.0).abs() < 1e-5,
            Kind::Vector => squared > 0.0,
        }
    }
}

/// The term of this name.
pub(crate) fn by_name(name: &str) -> Option<&'static Term> {
    TERMS.iter().find(|term| term.name == name)
}

/// Reads a term's fields from an object, as flat numbers.
pub(crate) fn read_fields(fields: &[Field], object: &Map<String, Value>) -> Result<Vec<f64>, String> {
    let mut numbers = Vec::new();
    for field in fields {
        let value = object.get(field.name).ok_or_else(|| {
            let names: Vec<_> = fields.iter().map(|field| field.name).collect();
            format!("`{}` is missing; the term reads {}", field.name, names.join(", "))
        })?;
        let refuse = || format!("`{}` is {value}, it must be {}", field.name, field.kind.allowed());
        let several = matches!(field.kind, Kind::Direction | Kind::Vector);
        let read = match value {
            Value::Array(items) if several && items.len() == 3 => {
                items.iter().map(Value::as_f64).collect::<Option<Vec<_>>>()
            }
            Value::Number(number) if !several => number.as_f64().map(|number| vec![number]),
            _ => None,
        };
        let read = read.filter(|read| field.kind.accepts(read)).ok_or_else(refuse)?;
        numbers.extend(read);
    }
    Ok(numbers)
}

/// A number as JSON; one that JSON cannot hold becomes null.
pub(crate) fn json(number: f64) -> Value {
    Value::from(number)
}

macro_rules! fields {
    ($($name:ident: $kind:ident),+) => { &[$(Field { name: stringify!($name), kind: Kind::$kind }),+] };
}

/// Arguments that are the fields as they stand.
fn same(fields: &[f64]) -> Vec<f64> {
    fields.to_vec()
}

macro_rules! results {
    ($($name:ident),+) => {
        |_, results| [$(stringify!($name)),+].into_iter().zip(results.iter().map(|x| json(*x))).collect()
    };
}

/// The directions' cosines and half vector.
fn cosines_and_half(f: &[f64]) -> Vec<f64> {
    vec![f[2], f[5], f[0] + f[3], f[1] + f[4], f[2] + f[5]]
}

fn oren_nayar(fields: &[f64], parts: &[f64]) -> Results {
    let albedo = fields[7];
    let first = albedo * std::f64::consts::FRAC_1_PI * parts[0];
    let second = albedo * albedo * std::f64::consts::FRAC_1_PI * parts[1];
    vec![("f", json((first + second).max(0.0))), ("L1", json(first)), ("L2", json(second))]
}

fn refracted(_: &[f64], w: &[f64]) -> Results {
    let total = w[2] <= 0.0;
    vec![("w", if total { Value::Null } else { w.iter().map(|x| json(*x)).collect() })]
}

/// Every term but `stack`, whose fields are not numbers.
#[rustfmt::skip]
pub(crate) const TERMS: &[Term] = &[
    Term { name: "fresnel.dielectric", fields: fields![cos: Fraction, eta: Positive], function: ("fresnel", "dielectric"), arguments: same, results: results![F, T] },
    Term { name: "fresnel.conductor", fields: fields![cos: Fraction, n: Positive, k: NonNegative], function: ("fresnel", "conductor"), arguments: same, results: results![F, T] },
    Term { name: "fresnel.conductor_approx", fields: fields![cos: Fraction, n: Positive, k: NonNegative], function: ("fresnel", "conductor_approx"), arguments: same, results: results![F] },
    Term { name: "fresnel.schlick", fields: fields![cos: Fraction, f0: Fraction], function: ("fresnel", "schlick"), arguments: same, results: results![F, T] },
    Term { name: "fresnel.lazanyi", fields: fields![cos: Fraction, n: Positive, k: NonNegative, a: Number, exponent: Positive], function: ("fresnel", "lazanyi"), arguments: same, results: results![F] },
    Term { name: "fresnel.f82_tint", fields: fields![cos: Fraction, f0: Fraction, tint: Fraction], function: ("fresnel", "f82_tint"), arguments: same, results: results![F] },
    Term { name: "distribution.beckmann", fields: fields![h: Vector, alpha: Positive], function: ("distribution", "beckmann"), arguments: same, results: results![D] },
    Term { name: "distribution.ggx", fields: fields![h: Vector, alpha: Positive], function: ("distribution", "ggx"), arguments: same, results: results![D] },
    Term { name: "distribution.blinn", fields: fields![h: Vector, alpha: Positive], function: ("distribution", "blinn"), arguments: same, results: results![D] },
    Term { name: "distribution.gaussian", fields: fields![h: Vector, alpha: Positive], function: ("distribution", "gaussian"), arguments: |f| [f, &[gaussian_normalisation(f[3])]].concat(), results: results![D] },
    Term { name: "masking.v_cavity", fields: fields![wi: Direction, wo: Direction], function: ("masking", "v_cavity"), arguments: cosines_and_half, results: results![G, vis] },
    Term { name: "masking.kelemen", fields: fields![wi: Direction, wo: Direction], function: ("masking", "kelemen"), arguments: cosines_and_half, results: results![G, vis] },
    Term { name: "masking.smith_ggx", fields: fields![wi: Direction, wo: Direction, alpha_x: Positive, alpha_y: Positive], function: ("masking", "smith_ggx"), arguments: same, results: results![G, vis] },
    Term { name: "masking.smith_beckmann", fields: fields![wi: Direction, wo: Direction, alpha_x: Positive, alpha_y: Positive], function: ("masking", "smith_beckmann"), arguments: same, results: results![G, vis] },
    Term { name: "diffuse.oren_nayar", fields: fields![wi: Direction, wo: Direction, sigma: NonNegative, albedo: Fraction], function: ("diffuse", "oren_nayar"), arguments: |f| f[..7].to_vec(), results: oren_nayar },
    Term { name: "diffuse.oren_nayar_qualitative", fields: fields![wi: Direction, wo: Direction, sigma: NonNegative, albedo: Fraction], function: ("diffuse", "oren_nayar_qualitative"), arguments: same, results: results![f] },
    Term { name: "refraction.refract", fields: fields![w: Direction, eta: Positive], function: ("refraction", "refract"), arguments: same, results: refracted },
    Term { name: "absorption", fields: fields![sigma: NonNegative, thickness: NonNegative, cos_i: Fraction, cos_o: Fraction], function: ("absorption", "transmittance"), arguments: same, results: results![a] },
    Term { name: "phong.phong", fields: fields![wi: Direction, wo: Direction, exponent: NonNegative], function: ("phong", "phong"), arguments: same, results: results![f] },
    Term { name: "phong.blinn_phong", fields: fields![wi: Direction, wo: Direction, exponent: NonNegative], function: ("phong", "blinn_phong"), arguments: same, results: results![f] },
    Term { name: "layered.internal_reflection", fields: fields![F: Fraction, G: Fraction], function: ("layered", "internal_reflection"), arguments: |f| vec![1.0 - f[0], f[1]], results: results![t] },
    Term { name: "microfacet.torrance_sparrow", fields: fields![wi: Direction, wo: Direction, n: Positive, k: NonNegative, alpha: Positive], function: ("microfacet", "torrance_sparrow"), arguments: same, results: results![f, F, T, D, G] },
    Term { name: "material.patina_extent", fields: fields![extent: Number, transition: NonNegative, value: Fraction], function: ("patina", "patina_extent"), arguments: same, results: results![factor] },
];
