//! Shader functions as subjects, from the arguments.

use super::subjects::{Judged, Loaded, Shared};
use brdf::check::prove::{self, ShaderFormula};
use brdf::check::shader::{Language, Options, Returns, ShaderFamily};
use clap::Args;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// How shader files are read.
#[derive(Args)]
pub(crate) struct Shaders {
    /// A WGSL or WESL file, whatever its content looks like.
    #[arg(long, value_name = "FILE", requires = "function", conflicts_with = "subjects")]
    pub(super) wgsl: Option<String>,
    /// A GLSL file, whatever its content looks like.
    #[arg(long, value_name = "FILE", requires = "function", conflicts_with_all = ["subjects", "wgsl"])]
    pub(super) glsl: Option<String>,
    /// The function of a shader file that is judged; `NAME(vec3, float)` tells overloads apart.
    #[arg(long = "fn", value_name = "NAME")]
    function: Option<String>,
    /// Where includes and imports of shaders are looked for.
    #[arg(short = 'I', value_name = "DIR")]
    include: Vec<PathBuf>,
    /// Define a macro for shaders.
    #[arg(short = 'D', value_name = "NAME[=VALUE]")]
    defines: Vec<String>,
    /// What a parameter of the function stands for: wi, wo, n, h, t, b, n_dot_l, …
    #[arg(long = "map", value_name = "NAME=ROLE")]
    maps: Vec<String>,
    /// What the function returns: f, fcos (times the light's cosine), pifcos (times π too).
    #[arg(long, default_value = "f")]
    returns: Returns,
    /// Which member of the struct that the function returns, or which `out` parameter.
    #[arg(long, value_name = "MEMBER")]
    result: Option<String>,
}

impl Shaders {
    /// The file that is named as a shader.
    pub(super) fn file(&self) -> Option<&String> {
        self.wgsl.as_ref().or(self.glsl.as_ref())
    }

    /// The arguments that name a file and say how it is read.
    pub(super) fn arguments(&self, name: &str) -> Vec<String> {
        let file = if self.wgsl.is_some() {
            vec!["--wgsl".to_owned(), name.to_owned()]
        } else if self.glsl.is_some() {
            vec!["--glsl".to_owned(), name.to_owned()]
        } else {
            vec![name.to_owned()]
        };
        let paths = self.include.iter().map(|path| ("-I", path.to_string_lossy().into_owned()));
        let returns = Some(self.returns).filter(|returns| *returns != Returns::default());
        let rest = (self.function.iter().map(|function| ("--fn", function.clone())))
            .chain(paths)
            .chain(self.defines.iter().map(|define| ("-D", define.clone())))
            .chain(self.maps.iter().map(|map| ("--map", map.clone())))
            .chain(returns.map(|returns| ("--returns", returns.to_string())))
            .chain(self.result.iter().map(|result| ("--result", result.clone())));
        file.into_iter().chain(rest.flat_map(|(option, value)| [option.to_owned(), value])).collect()
    }

    /// Reads the function of a file.
    pub(super) fn load(
        &self,
        path: &str,
        sniffed: Language,
        values: &[String],
        ranges: &[String],
    ) -> Result<Loaded, String> {
        let function = self
            .function
            .clone()
            .ok_or_else(|| format!("{path}: --fn NAME is missing: which function of the shader is the BRDF?"))?;
        let language = match (&self.wgsl, &self.glsl) {
            (Some(_), _) => Language::Wgsl,
            (_, Some(_)) => Language::Glsl,
            _ => sniffed,
        };
        let options = Options {
            language: Some(language),
            function,
            include: self.include.clone(),
            defines: self.defines.clone(),
            maps: self.maps.clone(),
            values: values.to_vec(),
            ranges: ranges.to_vec(),
            returns: self.returns,
            result: self.result.clone(),
        };
        let family = ShaderFamily::load(Path::new(path), &options).map_err(|error| error.to_string())?;
        let family = Arc::new(family);
        let (faulty, run, proved) = (Arc::clone(&family), Arc::clone(&family), Arc::clone(&family));
        let kind = if language == Language::Wgsl { "WGSL" } else { "GLSL" };
        Ok(Loaded {
            notes: family.notes().to_vec(),
            fault: Some(Box::new(move || faulty.error().map(str::to_owned))),
            gpu: Some(Box::new(move |gpu, values, pairs| {
                run.evaluate_on(gpu, values, pairs).map_err(|error| error.to_string())
            })),
            prove: Some(Box::new(move |options| {
                let formula = ShaderFormula::new(&proved).map_err(|error| error.to_string())?;
                Ok(prove::prove(&formula, options))
            })),
            ..Loaded::new(Judged::Family(Box::new(Shared(family))), kind)
        })
    }
}
