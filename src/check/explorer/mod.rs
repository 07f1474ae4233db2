//! Analytic BRDFs in the format of Disney's BRDF Explorer: `.brdf`.
//!
//! A file holds parameters and a function `vec3 BRDF(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y)` in GLSL, which returns f in
//! sr⁻¹: the tool multiplies by the cosine itself. [`Explorer`] is a [`Family`] whose parameters are the file's: a float
//! over its slider, a bool as 0 or 1, a colour as three numbers in [0, 1], `baseColor.r` and so on. A default outside its
//! range widens it. A float whose range is above 0 and spans a factor of 100 is searched by magnitude.
//!
//! The shader is compiled as it stands, with its parameters as globals, and evaluated in f64 and in f32 with N = +z,
//! X = +x, Y = +y. What an error says of lines are lines of the file.
//!
//! ```
//! use brdf::check::{self, Explorer, Family};
//!
//! let file = Explorer::parse("lambert.brdf", "analytic
//! ::begin parameters
//! float reflectance 0 1 1
//! ::end parameters
//! ::begin shader
//! vec3 BRDF(vec3 L, vec3 V, vec3 N, vec3 X, vec3 Y) { return vec3(reflectance / 3.14159265358979); }
//! ::end shader").unwrap();
//! let report = check::check_family(&file, &check::Options { budget: 100_000, ..Default::default() });
//! assert_eq!(report.verdict(), check::Verdict::Pass, "{report}");
//! ```
//!
//! # Single terms
//! A file with only a distribution, a masking or a Fresnel term, or that shows angles, is no BRDF, and its energy means
//! nothing: judge it by [`Profile::Term`]. [`Explorer::is_term`] has the rule.

pub mod grammar;
mod translate;

use super::Profile;
use super::family::{Family, Parameter, Scale};
use super::subject::Subject;
use crate::frame::Vector;
use crate::shader::interp::{Buffers, Cell, Number, Program};
use core::fmt;
use core::sync::atomic::{AtomicBool, Ordering};
use grammar::{File, Kind};
use std::sync::Mutex;

/// The steps of a block of pairs before a loop counts as endless: a thousand times those of the longest public file.
const BUDGET: u64 = 2_000_000;
/// The ratio of a range's ends from which on magnitudes are searched alike.
const MAGNITUDES: f64 = 100.0;
/// Pairs that are evaluated together.
const BLOCK: usize = 256;

/// An analytic BRDF of a file, its parameters open.
#[derive(Debug)]
pub struct Explorer {
    name: String,
    parameters: Vec<Parameter>,
    double: Program<f64>,
    single: Program<f32>,
    wgsl: String,
    samples: bool,
    failed: AtomicBool,
    error: Mutex<Option<String>>,
}

/// Why a file cannot be judged. Displays as one line, with the line of the file where there is one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExplorerError {
    line: Option<usize>,
    message: String,
}

impl ExplorerError {
    fn at(line: usize, message: impl Into<String>) -> Self {
        ExplorerError { line: Some(line), message: message.into() }
    }

    fn plain(message: impl Into<String>) -> Self {
        ExplorerError { line: None, message: message.into() }
    }

    /// The line of the file, from 1.
    pub fn line(&self) -> Option<usize> {
        self.line
    }
}

impl fmt::Display for ExplorerError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.line {
            Some(line) => write!(f, "line {line}: {}", self.message),
            None => f.write_str(&self.message),
        }
    }
}

impl std::error::Error for ExplorerError {}

impl Explorer {
    /// Reads the text of a file and compiles its shader.
    ///
    /// # Errors
    /// A line against the grammar; a shader that does not compile, or uses what the evaluator does not know (textures,
    /// derivatives); one that does not come to an end for the default parameters.
    pub fn parse(name: impl Into<String>, text: &str) -> Result<Self, ExplorerError> {
        let file = File::parse(text)?;
        let translated = translate::translate(&file)?;
        let explorer = Explorer {
            name: name.into(),
            parameters: parameters(&file),
            double: translated.double.with_budget(BUDGET),
            single: translated.single.with_budget(BUDGET),
            wgsl: translated.wgsl,
            samples: file.samples,
            failed: AtomicBool::new(false),
            error: Mutex::new(None),
        };
        let defaults: Vec<f64> = explorer.parameters.iter().map(|parameter| parameter.default).collect();
        let up = Vector::from_angles(0.5, 0.3);
        explorer.member(&defaults).evaluate(up, Vector::from_angles(1.1, 2.0), &mut [0.0; 3]);
        match explorer.error() {
            Some(error) => Err(ExplorerError::plain(error)),
            None => Ok(explorer),
        }
    }

    /// The module that is evaluated.
    pub fn wgsl(&self) -> &str {
        &self.wgsl
    }

    /// The first error of an evaluation, if there was one: a loop that did not end. Results from then on are NaN.
    pub fn error(&self) -> Option<String> {
        self.error.lock().map_or(None, |error| error.clone())
    }

    /// Whether the file holds directions' densities too (`isFunc`), which are not judged.
    pub fn has_sampler(&self) -> bool {
        self.samples
    }

    /// Whether the file is a single term or a debug view, by its name, as the public collection has it: `d_…`, `g_…`,
    /// `f_…`, `show…`, and `schlick.brdf`, which returns his Fresnel factor alone.
    pub fn is_term(name: &str) -> bool {
        let file = name.rsplit(['/', '\\']).next().unwrap_or(name);
        ["d_", "g_", "f_", "show"].iter().any(|prefix| file.starts_with(prefix)) || file == "schlick.brdf"
    }

    /// The profile that fits the file's name: [`Profile::Term`] for [`Explorer::is_term`], else [`Profile::Strict`].
    pub fn profile(&self) -> Profile {
        if Explorer::is_term(&self.name) { Profile::Term } else { Profile::Strict }
    }

    fn member(&self, values: &[f64]) -> Member<'_> {
        let given = values.iter().copied().chain(self.parameters.iter().skip(values.len()).map(|p| p.default));
        Member { file: self, values: given.take(self.parameters.len()).collect() }
    }

    /// Writes three numbers for each pair; `broken` from the first error on.
    fn run<N: Number>(
        &self,
        program: &Program<N>,
        pairs: &[(Vector<N>, Vector<N>)],
        values: &[N],
        f: &mut [N],
        broken: N,
    ) {
        let mut rows = Vec::with_capacity(pairs.len().min(BLOCK) * (6 + values.len()));
        for (pairs, f) in pairs.chunks(BLOCK).zip(f.chunks_mut(3 * BLOCK)) {
            f.fill(broken);
            if self.failed.load(Ordering::Relaxed) {
                continue;
            }
            rows.clear();
            for (wi, wo) in pairs {
                rows.extend([wi.x, wi.y, wi.z, wo.x, wo.y, wo.z].map(Cell::Real));
                rows.extend(values.iter().copied().map(Cell::Real));
            }
            match program.run(&rows, &mut Buffers::new()) {
                Ok(cells) => {
                    for (f, cell) in f.iter_mut().zip(cells) {
                        if let Cell::Real(value) = cell {
                            *f = value;
                        }
                    }
                }
                Err(error) => {
                    self.failed.store(true, Ordering::Relaxed);
                    if let Ok(mut first) = self.error.lock() {
                        first.get_or_insert_with(|| format!("BRDF: {error}"));
                    }
                }
            }
        }
    }
}

impl Family for Explorer {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn subject(&self, values: &[f64]) -> Box<dyn Subject + '_> {
        Box::new(self.member(values))
    }
}

/// The parameters of a file as numbers.
fn parameters(file: &File) -> Vec<Parameter> {
    let mut parameters = Vec::new();
    for declared in &file.parameters {
        let name = &declared.name;
        match declared.kind {
            Kind::Float { low, high, default } => {
                let (low, high) = (low.min(default), high.max(default));
                let scale = if low > 0.0 && high / low >= MAGNITUDES { Scale::Logarithmic } else { Scale::Linear };
                parameters.push(Parameter { name: name.clone(), low, high, default, scale });
            }
            Kind::Bool(on) => parameters.push(Parameter {
                name: name.clone(),
                low: 0.0,
                high: 1.0,
                default: f64::from(u8::from(on)),
                scale: Scale::Switch,
            }),
            Kind::Color(color) => {
                parameters.extend(color.into_iter().zip(["r", "g", "b"]).map(|(default, channel)| Parameter {
                    name: format!("{name}.{channel}"),
                    low: default.min(0.0),
                    high: default.max(1.0),
                    default,
                    scale: Scale::Linear,
                }))
            }
        }
    }
    parameters
}

/// A file with its parameters fixed.
struct Member<'a> {
    file: &'a Explorer,
    values: Vec<f64>,
}

impl Subject for Member<'_> {
    fn name(&self) -> String {
        self.file.name.clone()
    }

    fn channels(&self) -> usize {
        3
    }

    fn evaluate(&self, wi: Vector<f64>, wo: Vector<f64>, f: &mut [f64]) {
        self.evaluate_many(&[(wi, wo)], f);
    }

    fn evaluate_single(&self, wi: Vector<f32>, wo: Vector<f32>, f: &mut [f32]) -> bool {
        self.evaluate_single_many(&[(wi, wo)], f)
    }

    fn evaluate_many(&self, pairs: &[(Vector<f64>, Vector<f64>)], f: &mut [f64]) {
        self.file.run(&self.file.double, pairs, &self.values, f, f64::NAN);
    }

    fn evaluate_single_many(&self, pairs: &[(Vector<f32>, Vector<f32>)], f: &mut [f32]) -> bool {
        let values: Vec<f32> = self.values.iter().map(|value| *value as f32).collect();
        self.file.run(&self.file.single, pairs, &values, f, f32::NAN);
        true
    }

    fn notes(&self) -> Vec<String> {
        let mut notes: Vec<String> = self.file.error().into_iter().collect();
        if self.file.samples {
            notes.push("the file's isFunc, which draws directions, is not judged".to_owned());
        }
        notes
    }
}
