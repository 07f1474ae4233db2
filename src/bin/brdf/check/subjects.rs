//! What to judge, from the arguments: built-in materials, files, folders of files.

use super::pinned::pin;
use super::shaders::Shaders;
use super::twins::Twins;
use crate::failure::Failure;
use crate::material::{self, AnyStack, Change, Material};
use brdf::Vector;
use brdf::check::explorer::Explorer;
use brdf::check::merl::Merl;
use brdf::check::output::Figures;
use brdf::check::shader::Language;
use brdf::check::sniff::{Kind, Refused, sniff};
use brdf::check::{self, Family, MaterialFamily, Profile, Report, StackSubject, Subject};
use brdf::gpu::Gpu;
use brdf::layered::{Model, Widths};
use clap::Args;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// What is judged, and how it is read.
#[derive(Args)]
pub(crate) struct Reading {
    /// Built-in stacks or materials, files or folders of files; without any, every built-in stack.
    subjects: Vec<String>,
    /// The model to judge stacks under, in place of their own.
    #[arg(long, value_parser = material::model)]
    pub(super) model: Option<Model>,
    /// How wide covered interfaces are taken, in place of the stacks' own rule.
    #[arg(long, value_parser = material::widths)]
    pub(super) widths: Option<Widths>,
    /// Set a parameter, which is then not searched.
    #[arg(long = "param", value_name = "NAME=VALUE")]
    values: Vec<String>,
    /// Search a parameter over this range, each magnitude alike with `:log`.
    #[arg(long = "range", value_name = "NAME=LO..HI[:log]")]
    ranges: Vec<String>,
    #[command(flatten)]
    shaders: Shaders,
}

/// Something to judge that has not been read.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Source {
    name: String,
    /// Whether it was met in a folder, where not every file is meant.
    met: bool,
}

/// Why a source cannot be judged.
pub(super) struct Refusal {
    /// One line.
    pub(super) reason: String,
    /// Whether it is not meant to be: no BRDF at all, and met in a folder.
    pub(super) passed_over: bool,
}

impl From<String> for Refusal {
    fn from(reason: String) -> Self {
        Refusal { reason, passed_over: false }
    }
}

impl Source {
    /// What the user calls it.
    pub(super) fn name(&self) -> &str {
        &self.name
    }
}

/// A subject that is ready to be judged.
pub(super) enum Judged {
    /// One BRDF, its parameters fixed.
    Subject(Box<dyn Subject>),
    /// A BRDF whose parameters are searched.
    Family(Box<dyn Family>),
}

/// A subject, and what else a report says of it.
pub(super) struct Loaded {
    /// What is judged.
    pub(super) judged: Judged,
    /// What it was read as.
    pub(super) kind: String,
    /// The stack behind it, whose twin can be compared.
    pub(super) stack: Option<AnyStack>,
    /// The profile that suits it, if that is not the default one.
    pub(super) profile: Option<Profile>,
    /// What went wrong while it was evaluated, asked for after the checks.
    pub(super) fault: Option<Box<dyn Fn() -> Option<String>>>,
    /// What was assumed when it was read, one line each.
    pub(super) notes: Vec<String>,
    /// Runs the member with these values on an adapter.
    pub(super) gpu: Option<Box<RunOnGpu>>,
    /// Tries to prove it finite and not negative.
    pub(super) prove: Option<Box<Prove>>,
}

type Prove = dyn Fn(&check::prove::Options) -> Result<check::prove::Proof, String>;

/// f of every channel of many pairs, one after the other, for the values of the parameters; or why the adapter refuses.
type RunOnGpu = dyn Fn(&Gpu, &[f64], &[(Vector<f32>, Vector<f32>)]) -> Result<Vec<f32>, String>;

impl Loaded {
    pub(super) fn new(judged: Judged, kind: impl Into<String>) -> Self {
        Loaded {
            judged,
            kind: kind.into(),
            stack: None,
            profile: None,
            fault: None,
            notes: Vec::new(),
            gpu: None,
            prove: None,
        }
    }

    /// The first error of an evaluation, if there was one.
    pub(super) fn fault(&self) -> Option<String> {
        self.fault.as_ref().and_then(|fault| fault())
    }

    /// f of pairs on the adapter, where there is one and the subject has a twin; or why the adapter refuses it.
    pub(super) fn on_gpu(
        &self,
        values: &[f64],
        twins: &Twins,
        pairs: &[(Vector<f32>, Vector<f32>)],
    ) -> Option<Result<Vec<f32>, String>> {
        self.gpu.as_ref().zip(twins.gpu.as_ref()).map(|(run, gpu)| run(gpu, values, pairs))
    }

    /// What pictures are drawn from.
    pub(super) fn figures(&self, values: &[f64], twins: &Twins) -> Figures {
        let run = |pairs: &[(Vector<f32>, Vector<f32>)]| self.on_gpu(values, twins, pairs).and_then(Result::ok);
        match &self.judged {
            Judged::Subject(subject) => Figures::new(&**subject, Vec::new(), Some(&run)),
            Judged::Family(family) => Figures::of_family(&**family, values, Some(&run)),
        }
    }
}

/// A family that others look at as well.
pub(super) struct Shared<F>(pub(super) Arc<F>);

impl<F: Family + Send> Family for Shared<F> {
    fn name(&self) -> String {
        self.0.name()
    }
    fn parameters(&self) -> &[check::Parameter] {
        self.0.parameters()
    }
    fn subject(&self, values: &[f64]) -> Box<dyn Subject + '_> {
        self.0.subject(values)
    }
}

impl Reading {
    fn change(&self) -> Change {
        Change { model: self.model, widths: self.widths }
    }

    /// Everything that is asked for, in order of its name: each shard of a run must count alike.
    pub(super) fn sources(&self) -> Result<Vec<Source>, Failure> {
        let given = |name: String| Source { name, met: false };
        let mut sources: Vec<Source> = Vec::new();
        if let Some(file) = self.shaders.file() {
            sources.push(given(file.clone()));
        } else if self.subjects.is_empty() {
            sources.extend(material::stacks().into_iter().map(|material| given(material.name)));
        }
        for subject in &self.subjects {
            if !material::is_built_in(subject) && Path::new(subject).is_dir() {
                walk(Path::new(subject), &mut sources)?;
            } else {
                sources.push(given(subject.clone()));
            }
        }
        // By name, and what was given before what was met.
        sources.sort();
        sources.dedup_by(|later, first| later.name == first.name);
        Ok(sources)
    }

    /// The arguments that name a subject and say how it is read.
    pub(super) fn arguments(&self, source: &Source) -> Vec<String> {
        let mut words = self.shaders.arguments(&source.name);
        for range in &self.ranges {
            words.extend(["--range".to_owned(), range.clone()]);
        }
        for value in &self.values {
            words.extend(["--param".to_owned(), value.clone()]);
        }
        if let Some(model) = self.model {
            words.extend(["--model".to_owned(), model.name().to_owned()]);
        }
        if let Some(widths) = self.widths {
            words.extend(["--widths".to_owned(), widths.name().to_owned()]);
        }
        words
    }

    /// Reads a subject, or says in one line why it cannot be judged.
    pub(super) fn load(&self, source: &Source) -> Result<Loaded, Refusal> {
        let name = &source.name;
        if self.shaders.file().is_some() {
            if Path::new(name).is_dir() {
                return Err(format!(
                    "{name}: is a folder, and --wgsl and --glsl take a file: without them a folder is searched"
                )
                .into());
            }
            return Ok(self.shaders.load(name, Language::Wgsl, &self.values, &self.ranges)?);
        }
        if material::is_built_in(name) || !Path::new(name).exists() {
            return Ok(self.load_built_in(name)?);
        }
        let at = |error: &dyn std::fmt::Display| format!("{name}: {error}");
        let bytes = std::fs::read(name).map_err(|error| at(&error))?;
        let kind = match sniff(&bytes) {
            // The reader of stacks says better what a torn stack file lacks.
            Err(Refused::Empty | Refused::Text) if name.ends_with(".toml") => Kind::Stack,
            Err(refused) => {
                let passed_over = source.met && !matches!(refused, Refused::NotYet(_));
                return Err(Refusal { reason: at(&refused), passed_over });
            }
            Ok(kind) => kind,
        };
        match kind {
            Kind::Merl => {
                let merl = Merl::parse(name, &bytes).map_err(|error| at(&error))?;
                self.without_parameters(name)?;
                let profile = Some(Profile::Measured);
                Ok(Loaded { profile, ..Loaded::new(Judged::Subject(Box::new(merl)), "MERL") })
            }
            Kind::Explorer => {
                let text = String::from_utf8_lossy(&bytes);
                let explorer = Arc::new(Explorer::parse(name, &text).map_err(|error| at(&error))?);
                let profile = explorer.profile();
                let family = pin(Box::new(Shared(Arc::clone(&explorer))), &self.values, &self.ranges);
                let fault = move || explorer.error();
                Ok(Loaded {
                    profile: Some(profile),
                    fault: Some(Box::new(fault)),
                    ..Loaded::new(Judged::Family(Box::new(family.map_err(|error| at(&error))?)), "BRDF Explorer")
                })
            }
            // What was read is the text: a pipe has it once.
            Kind::Stack => Ok(self.load_text(name, &String::from_utf8(bytes).map_err(|error| at(&error))?)?),
            Kind::Wgsl | Kind::Glsl if !Path::new(name).is_file() => {
                let problem =
                    "is no file, and what it holds is read: name it by --wgsl or --glsl, or write it to a file";
                Err(at(&problem).into())
            }
            Kind::Wgsl => Ok(self.shaders.load(name, Language::Wgsl, &self.values, &self.ranges)?),
            Kind::Glsl => Ok(self.shaders.load(name, Language::Glsl, &self.values, &self.ranges)?),
        }
    }

    /// A built-in stack or material.
    fn load_built_in(&self, name: &str) -> Result<Loaded, String> {
        match material::varying(name)? {
            None => self.plain(material::load(name, self.change())?),
            Some(_) => {
                let family = MaterialFamily::built_in(name).ok_or_else(|| format!("{name} cannot be made"))?;
                self.varying(name, family, None)
            }
        }
    }

    /// A stack or a material, from the text of a file of TOML.
    fn load_text(&self, name: &str, text: &str) -> Result<Loaded, String> {
        let Some(file) = material::described(name, text)? else {
            return self.plain(material::read(name, text, self.change())?);
        };
        if let Some(part) = material::walking_part(&file.material) {
            return Err(format!("{name}: part[{part}]: {NOISE}; choose `coupled`"));
        }
        let lack = brdf::wgsl::material(&file.material).err().map(|error| format!("no adapter runs it: {error}"));
        let called = file.name.map(|called| format!("{called} of {name}"));
        self.varying(name, MaterialFamily::new(called.unwrap_or_else(|| name.to_owned()), &file.material), lack)
    }

    /// A material, and why no adapter runs it, if none does.
    fn varying(&self, name: &str, family: MaterialFamily, lack: Option<String>) -> Result<Loaded, String> {
        let option = self.model.map(|_| "--model").or(self.widths.map(|_| "--widths"));
        if let Some(option) = option {
            return Err(format!("{name}: {option} is about stacks, and this material says itself what its layers do"));
        }
        let family = Arc::new(family);
        let pinned = pin(Box::new(Shared(Arc::clone(&family))), &self.values, &self.ranges);
        let pinned = Arc::new(pinned.map_err(|error| format!("{name}: {error}"))?);
        let (faulty, whole) = (Arc::clone(&family), Arc::clone(&pinned));
        let run: Box<RunOnGpu> =
            Box::new(move |gpu, values, pairs| family.evaluate_on(gpu, &whole.whole(values), pairs));
        Ok(Loaded {
            fault: Some(Box::new(move || faulty.error().map(str::to_owned))),
            gpu: lack.is_none().then_some(run),
            notes: lack.into_iter().collect(),
            ..Loaded::new(Judged::Family(Box::new(Shared(pinned))), "material")
        })
    }

    /// A stack, which has no parameters.
    fn plain(&self, material: Material) -> Result<Loaded, String> {
        if material.stack.model() == Model::Walk {
            return Err(format!("{}: {NOISE}; use --model coupled, or `brdf bench layered`", material.name));
        }
        self.without_parameters(&material.name)?;
        Ok(from_stack(material))
    }

    /// Refuses parameters where there are none to set.
    fn without_parameters(&self, name: &str) -> Result<(), String> {
        match self.values.iter().chain(&self.ranges).next() {
            None => Ok(()),
            Some(word) => Err(format!("{name}: `{word}` sets a parameter, and this subject has none")),
        }
    }
}

/// Why the walk is not judged.
const NOISE: &str = "the walk's f is a mean of random numbers, whose noise would be judged in place of the layers";

/// Adds the files of a folder, its own folders included.
fn walk(folder: &Path, sources: &mut Vec<Source>) -> Result<(), Failure> {
    let at = |error: std::io::Error| format!("{}: {error}", folder.display());
    for entry in std::fs::read_dir(folder).map_err(at)? {
        let path: PathBuf = entry.map_err(at)?.path();
        let hidden = path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
        // A pipe may never be written to.
        let is_stream = path.metadata().is_ok_and(|about| !about.is_file() && !about.is_dir());
        // A link to a folder can lead back to itself.
        if hidden || is_stream || (path.is_symlink() && path.is_dir()) {
            continue;
        }
        if path.is_dir() {
            walk(&path, sources)?;
        } else {
            sources.push(Source { name: path.to_string_lossy().into_owned(), met: true });
        }
    }
    Ok(())
}

fn from_stack(material: Material) -> Loaded {
    let Material { name, stack } = material;
    let subject: Box<dyn Subject> = match stack.clone() {
        AnyStack::One(stack) => Box::new(StackSubject::new(name, stack)),
        AnyStack::Three(stack) => Box::new(StackSubject::new(name, stack)),
    };
    let kind = stack.model().name().to_owned();
    Loaded { stack: Some(stack), ..Loaded::new(Judged::Subject(subject), kind) }
}

impl Judged {
    /// Judges it.
    pub(super) fn check(&self, options: &check::Options<'_>) -> Report {
        match self {
            Judged::Subject(subject) => check::check(&**subject, options),
            Judged::Family(family) => check::check_family(&**family, options),
        }
    }

    fn family(&self) -> Option<&dyn Family> {
        match self {
            Judged::Subject(_) => None,
            Judged::Family(family) => Some(&**family),
        }
    }

    /// The values of the parameters: those named, defaults else.
    pub(super) fn values(&self, named: &[(String, f64)]) -> Vec<f64> {
        let parameters = self.family().map_or(&[][..], Family::parameters);
        let value = |parameter: &check::Parameter| {
            let found = named.iter().find(|(name, _)| *name == parameter.name);
            found.map_or(parameter.default, |(_, value)| *value)
        };
        parameters.iter().map(value).collect()
    }

    /// The parameters and their values, by name.
    pub(super) fn named(&self, values: &[f64]) -> Vec<(String, f64)> {
        let parameters = self.family().map_or(&[][..], Family::parameters);
        parameters.iter().map(|parameter| parameter.name.clone()).zip(values.iter().copied()).collect()
    }

    /// Refuses values of parameters that there are not, or beyond their range.
    pub(super) fn knows(&self, named: &[(String, f64)]) -> Result<(), String> {
        let parameters = self.family().map_or(&[][..], Family::parameters);
        for (name, value) in named {
            match parameters.iter().find(|parameter| parameter.name == *name) {
                Some(parameter) if (parameter.low..=parameter.high).contains(value) => {}
                Some(parameter) => {
                    return Err(format!("--at: {name}={value} lies outside of {}..{}", parameter.low, parameter.high));
                }
                None => {
                    let known: Vec<&str> = parameters.iter().map(|parameter| parameter.name.as_str()).collect();
                    let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
                    return Err(format!("--at: `{name}` is no open parameter; there are {known}"));
                }
            }
        }
        Ok(())
    }

    /// Does something with the member that has these values.
    pub(super) fn member<T>(&self, values: &[f64], then: impl FnOnce(&dyn Subject) -> T) -> T {
        match self {
            Judged::Subject(subject) => then(&**subject),
            Judged::Family(family) => then(&*family.subject(values)),
        }
    }
}
