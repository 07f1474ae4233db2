//! Shaders of others as subjects: a WGSL or GLSL function, judged without a GPU.
//!
//! [`ShaderFamily::load`] reads a renderer's file as it is ([`crate::shader::source`]), keeps the one function that is
//! named, and finds out from its signature what its parameters mean: directions and cosines by the names that renderers
//! give them, materials by theirs, the rest as [`Options`] say. What it assumed is in [`ShaderFamily::notes`].
//!
//! ```
//! use brdf::check::shader::{Options, ShaderFamily};
//! use brdf::check::{Family, Subject};
//!
//! let source = "
//! #define PI 3.14159265359
//! uniform sampler2D map;
//! varying vec2 vUv;
//! vec3 BRDF_Lambert(const in vec3 diffuseColor) { return diffuseColor / PI; }
//! void main() { gl_FragColor = vec4(BRDF_Lambert(texture2D(map, vUv).rgb), 1.0); }";
//! let options = Options { function: "BRDF_Lambert".into(), ..Options::default() };
//! let family = ShaderFamily::from_source("lambert.glsl", source, &options)?;
//! assert_eq!(family.parameters()[0].name, "diffuseColor");
//! let subject = family.subject(&[0.5]);
//! let mut f = [0.0; 3];
//! let up = brdf::Vector::new(0.0, 0.0, 1.0);
//! subject.evaluate(up, up, &mut f);
//! assert!((f[0] - 0.5 / std::f64::consts::PI).abs() < 1e-7);
//! # Ok::<(), brdf::shader::source::SourceError>(())
//! ```
//!
//! # Precision
//!
//! WGSL is evaluated in double precision with its literals exact. GLSL comes through naga's front end, whose literals are
//! rounded to f32: a constant may be off by 3e-8 of itself. Where a module cannot be retyped ([`Shader::in_double`]), everything is
//! evaluated in f32, and a note says so.

mod evaluate;
mod roles;
mod slots;
mod wrapper;

pub use crate::shader::source::{Language, SourceError, sniff};
pub use evaluate::ShaderSubject;

use super::family::{Family, Parameter};
use super::subject::Subject;
use crate::shader::interp::{InterpError, Program, Shader};
use crate::shader::source::{Environment, Source};
use core::fmt;
use core::str::FromStr;
use roles::Role;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// What the function returns: shaders often have the cosine of the light in it, and some a π too.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Returns {
    /// f, in sr⁻¹.
    #[default]
    Value,
    /// f·cosθᵢ.
    Cosine,
    /// π·f·cosθᵢ.
    PiCosine,
}

impl fmt::Display for Returns {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Returns::Value => "f",
            Returns::Cosine => "fcos",
            Returns::PiCosine => "pifcos",
        })
    }
}

impl FromStr for Returns {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "f" => Ok(Returns::Value),
            "fcos" => Ok(Returns::Cosine),
            "pifcos" => Ok(Returns::PiCosine),
            _ => Err(format!("`{text}` is none of f, fcos, pifcos")),
        }
    }
}

/// How to read a shader file, and what its function's parameters mean. Texts are read by [`ShaderFamily::load`].
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// The language; by content where it is none.
    pub language: Option<Language>,
    /// The function's name, with the types of its parameters where several have it: `F_Schlick(float, vec3)`.
    pub function: String,
    /// Directories that includes and imports are looked for in.
    pub include: Vec<PathBuf>,
    /// Macros: `NAME` or `NAME=VALUE`.
    pub defines: Vec<String>,
    /// Roles: `NAME=wi`, `wo`, `n`, `h`, `t`, `b`, one of them with `-`, or `n_dot_l` and its kin.
    ///
    /// A name is that of a parameter, of a uniform or other variable, or the path of a member: `material.roughness`, of which
    /// the end alone will do where it is the only one.
    pub maps: Vec<String>,
    /// Values: `NAME=VALUE`, numbers with commas between them for a vector, `true` or `false`.
    pub values: Vec<String>,
    /// What is searched: `NAME=LO..HI` or `NAME=LO..HI:log`. A value for the same name is where it starts.
    pub ranges: Vec<String>,
    /// What the function returns.
    pub returns: Returns,
    /// Which member of what it returns, or which `out` parameter; a sum is `A+B`.
    pub result: Option<String>,
}

/// A function of a shader file, its material open.
#[derive(Debug)]
pub struct ShaderFamily {
    name: String,
    signature: String,
    notes: Vec<String>,
    parameters: Vec<Parameter>,
    channels: usize,
    /// The directions that names alone told, and what they were taken for.
    directions: Vec<(String, Role)>,
    wgsl: String,
    double: Option<Program<f64>>,
    single: Program<f32>,
    error: OnceLock<String>,
}

impl ShaderFamily {
    /// The function of [`ShaderFamily::wgsl`] that takes wi, wo and the parameters, and returns f.
    pub const ENTRY: &'static str = "judged_value";

    /// Reads a file.
    ///
    /// # Errors
    /// A file that cannot be read; those of [`ShaderFamily::from_source`].
    pub fn load(path: &Path, options: &Options) -> Result<Self, SourceError> {
        let name = path.display().to_string();
        let bytes = std::fs::read(path).map_err(|error| SourceError::of(&name, error.to_string()))?;
        let text = String::from_utf8(bytes).map_err(|error| {
            let at = error.utf8_error().valid_up_to();
            SourceError::of(&name, format!("not a shader: byte {at} is not UTF-8"))
        })?;
        Self::from_source(&name, &text, options)
    }

    /// Reads a text, `name` being its path or what errors are to call it.
    ///
    /// # Errors
    /// Neither WGSL nor GLSL; what the preprocessor, the compiler or the evaluator refuses, at its place; a function that
    /// is not there; a parameter whose meaning is open, with the signature and how to say it; a function that does
    /// not end.
    pub fn from_source(name: &str, text: &str, options: &Options) -> Result<Self, SourceError> {
        let mut family = Self::read(name, text, options)?;
        if family.is_dark() {
            for (path, role) in &family.directions {
                let mut turned = options.clone();
                turned.maps.push(format!("{path}=-{role}"));
                if Self::read(name, text, &turned).is_ok_and(|turned| !turned.is_dark()) {
                    let what = format!(
                        "`{}` is never above 0 with {path} = {role}, and is with -{role}: if {path} points into the surface, \
                         say --map {path}=-{role}; if it does not, --map {path}={role}",
                        family.signature
                    );
                    return Err(SourceError::of(name, what));
                }
            }
            family.notes.push("f was not above 0 for any of the directions tried first: is this all of it?".to_owned());
        }
        Ok(family)
    }

    fn read(name: &str, text: &str, options: &Options) -> Result<Self, SourceError> {
        let Some(language) = options.language.or_else(|| sniff(text)) else {
            return Err(SourceError::of(name, "neither WGSL nor GLSL: it has no function of either"));
        };
        let environment = Environment { include: options.include.clone(), defines: options.defines.clone() };
        let source = Source::load(name, text, language, &environment)?;
        let compiled = source.compile(&options.function, &|variable| slots::is_named(options, variable))?;
        let mut mapping = slots::map(&compiled, options).map_err(|what| compiled.error(what))?;
        let (wrapper, channels) =
            wrapper::wrapper(&compiled, &mapping, options).map_err(|what| compiled.error(what))?;
        let wgsl = compiled.with(&wrapper)?;
        let refuse = |error: InterpError| compiled.error(evaluate::explained(&error, &options.function));
        let single = Shader::parse(&wgsl).map_err(|error| refuse(error.into()))?;
        let single = Program::new(&single, Self::ENTRY).map_err(refuse)?;
        let double = Shader::in_double(&wgsl).map_err(InterpError::from);
        let double = match double.and_then(|shader| Program::new(&shader, Self::ENTRY)) {
            Ok(program) => Some(program),
            Err(error) => {
                mapping.notes.push(format!("evaluated in single precision: {error}"));
                None
            }
        };
        let directions = mapping.told_by_names(options);
        for (path, role) in directions.iter().filter(|(path, _)| compiled.negates(path)) {
            mapping.notes.push(format!("{path} is negated: if it points into the surface, say --map {path}=-{role}"));
        }
        let family = ShaderFamily {
            name: format!("{} of {name}", compiled.entry.name),
            signature: compiled.entry.signature(language),
            notes: mapping.notes,
            parameters: mapping.parameters,
            channels,
            directions,
            wgsl,
            double,
            single,
            error: OnceLock::new(),
        };
        family.probe().map_err(|what| compiled.error(what))?;
        Ok(family)
    }

    /// What was assumed, a line each: the roles found, the defaults chosen.
    pub fn notes(&self) -> &[String] {
        &self.notes
    }

    /// The function's declaration.
    pub fn signature(&self) -> &str {
        &self.signature
    }

    /// The numbers that f has: 1 or 3.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// The module that is evaluated, in which [`ShaderFamily::ENTRY`] is the function.
    pub fn wgsl(&self) -> &str {
        &self.wgsl
    }

    /// Why an evaluation failed, if one has: a loop that does not end for some directions. What was measured since is
    /// NaN, and no verdict.
    pub fn error(&self) -> Option<&str> {
        self.error.get().map(String::as_str)
    }
}

impl Family for ShaderFamily {
    fn name(&self) -> String {
        self.name.clone()
    }
    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }
    fn subject(&self, values: &[f64]) -> Box<dyn Subject + '_> {
        Box::new(ShaderSubject::new(self, values))
    }
}
