//! `brdf plan`: what must be computed of a stack, what was left out and why, and what an evaluation costs.

mod cost;

use crate::failure::Failure;
use crate::material::{self, AnyStack, Change, Material};
use brdf::batch::Level;
use brdf::layered::{Model, Stack, Widths};
use brdf::plan::{Applied, Operations, Options as Making, Path, Plan, Rule, Term};
use clap::Args;
use cost::{Costs, Units};
use serde_json::{Map, Value, json};
use std::io::{self, Write};
use std::process::ExitCode;

/// What `brdf plan` is asked for.
#[derive(Args)]
pub(crate) struct Options {
    /// Built-in stacks, stack files, or folders of stack files: several are planned as a scene.
    #[arg(required_unless_present = "rules")]
    stacks: Vec<String>,
    /// The largest error of F with which conductors may be fitted.
    #[arg(long, default_value_t = 0.0, value_parser = max_error)]
    error: f64,
    /// The model to plan the stacks for, in place of their own.
    #[arg(long, value_parser = material::model)]
    model: Option<Model>,
    /// How wide covered interfaces are taken, in place of the stacks' own rule.
    #[arg(long, value_parser = material::widths)]
    widths: Option<Widths>,
    /// Measure what each rule saves, by a stack that it applies to.
    #[arg(long, conflicts_with_all = ["stacks", "error", "model", "widths"])]
    rules: bool,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

fn max_error(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(error) if (0.0..=1.0).contains(&error) => Ok(error),
        _ => Err("must be a number in [0, 1]".to_owned()),
    }
}

pub(crate) fn run(options: &Options) -> Result<ExitCode, Failure> {
    if options.rules {
        rules(options.json)?
    } else {
        stacks(options)?
    }
    Ok(ExitCode::SUCCESS)
}

/// A stack that was planned.
struct Planned {
    name: String,
    model: Model,
    layers: usize,
    channels: usize,
    applied: Vec<Applied>,
    terms: Vec<Term>,
    costs: Costs,
}

impl Planned {
    fn new(material: &Material, error: f64) -> Result<Self, Failure> {
        match &material.stack {
            AnyStack::One(stack) => Self::of(&material.name, stack, error),
            AnyStack::Three(stack) => Self::of(&material.name, stack, error),
        }
    }

    fn of<const C: usize>(name: &str, stack: &Stack<f64, C>, error: f64) -> Result<Self, Failure> {
        let making = Making { max_error: error, ..Making::default() };
        let plan = Plan::with_options(stack, &making)
            .map_err(|problem| format!("{name}: {problem}; `--model` plans it for another"))?;
        Ok(Planned {
            name: name.to_owned(),
            model: plan.model(),
            layers: stack.layers().len(),
            channels: C,
            applied: plan.applied().to_vec(),
            terms: plan.terms().collect(),
            costs: cost::measure(&stack.cast(), &plan),
        })
    }

    fn operations(&self, path: Path) -> Operations {
        let mut sum = Operations::default();
        self.terms.iter().for_each(|term| sum += term.operations(path));
        sum
    }

    /// What the operations of an evaluation cost in ns: by `evaluate` in f32, then in a batch at each level.
    fn predicted(&self, units: &Units) -> Vec<(&'static str, f64)> {
        units.iter().map(|unit| (unit.name, self.operations(unit.path).cost(unit.ns))).collect()
    }

    fn json(&self, units: &Units) -> Value {
        let applied = |one: &Applied| json!({"rule": one.rule.name(), "layer": one.layer, "reason": one.rule.reason()});
        let term = |term: &Term| {
            json!({
                "name": term.name, "layer": term.layer, "channel": term.channel, "about": term.about,
                "operations": by_path(|path| term.operations(path)),
            })
        };
        let predicted: Map<String, Value> =
            self.predicted(units).into_iter().map(|(name, ns)| (name.to_owned(), ns.into())).collect();
        json!({
            "name": self.name, "model": self.model.name(), "layers": self.layers, "channels": self.channels,
            "applied": self.applied.iter().map(applied).collect::<Vec<_>>(),
            "terms": self.terms.iter().map(term).collect::<Vec<_>>(),
            "operations": by_path(|path| self.operations(path)),
            "predicted_ns": predicted,
            "measured_ns": self.costs.json(),
        })
    }

    fn print(&self, out: &mut impl Write, units: &Units) -> io::Result<()> {
        let plural = if self.layers == 1 { "" } else { "s" };
        writeln!(out, "{}  {}, {} layer{plural}", self.name, self.model.name(), self.layers)?;
        for Applied { rule, layer } in &self.applied {
            writeln!(out, "  left out  layer {layer}  {:18} {}", rule.name(), rule.reason())?;
        }
        for term in &self.terms {
            let channel = term.channel.map_or(String::new(), |channel| format!("channel {channel}: "));
            writeln!(out, "  computed  layer {}  {:22} {channel}{}", term.layer, term.name, term.about)?;
        }
        for (name, path) in PATHS {
            writeln!(out, "  counted   {name:12} {}", counts(self.operations(path)))?;
        }
        write!(out, "  predicted")?;
        for (name, ns) in self.predicted(units) {
            write!(out, "  {name} {ns:.1} ns")?;
        }
        let Costs { general, plan, batch, level, .. } = &self.costs;
        writeln!(
            out,
            "\n  measured   Stack::evaluate {general:.1} ns, Plan::evaluate {plan:.1} ns, a batch at {} {batch:.2} ns",
            level.name()
        )
    }
}

/// The names of the paths in `--json`.
const PATHS: [(&str, Path); 3] = [("scalar", Path::Scalar), ("batch", Path::Batch), ("fused_batch", Path::FusedBatch)];

fn by_path(operations: impl Fn(Path) -> Operations) -> Value {
    let one = |(name, path): (&str, Path)| {
        let kinds = Operations::KINDS.iter().zip(operations(path).counts());
        (name.to_owned(), Value::Object(kinds.map(|(kind, count)| ((*kind).to_owned(), count.into())).collect()))
    };
    Value::Object(PATHS.into_iter().map(one).collect())
}

fn counts(operations: Operations) -> String {
    let kinds = Operations::KINDS.iter().zip(operations.counts());
    let words: Vec<String> =
        kinds.filter(|(_, count)| *count > 0).map(|(kind, count)| format!("{count} {kind}")).collect();
    words.join(", ")
}

/// The materials of these names; of a folder every stack file in it.
fn load(names: &[String], change: Change) -> Result<Vec<Material>, Failure> {
    let mut materials = Vec::new();
    for name in names {
        if !std::path::Path::new(name).is_dir() {
            materials.push(material::load(name, change)?);
            continue;
        }
        let mut files = Vec::new();
        for entry in std::fs::read_dir(name).map_err(|error| format!("{name}: {error}"))? {
            let path = entry?.path();
            if path.extension().is_some_and(|extension| extension == "toml") {
                files.push(path.to_str().ok_or_else(|| format!("{}: not UTF-8", path.display()))?.to_owned());
            }
        }
        if files.is_empty() {
            return Err(format!("{name} has no stack files (*.toml)").into());
        }
        files.sort();
        for file in files {
            materials.push(material::load(&file, change)?);
        }
    }
    Ok(materials)
}

fn stacks(options: &Options) -> Result<(), Failure> {
    let change = Change { model: options.model, widths: options.widths };
    let materials = load(&options.stacks, change)?;
    let planned =
        materials.iter().map(|material| Planned::new(material, options.error)).collect::<Result<Vec<_>, _>>()?;
    let units = cost::units();
    let scene = (planned.len() > 1).then(|| Scene::new(&planned));
    let mut out = io::stdout().lock();
    if options.json {
        let plan = json!({
            "stacks": planned.iter().map(|planned| planned.json(&units)).collect::<Vec<_>>(),
            "scene": scene.map(|scene| scene.json()),
            "units_ns": units.iter().map(|unit| (unit.name.to_owned(), unit.json())).collect::<Map<_, _>>(),
        });
        writeln!(out, "{plan:#}")?;
        return Ok(());
    }
    for planned in &planned {
        planned.print(&mut out, &units)?;
        writeln!(out)?;
    }
    if let Some(scene) = scene {
        scene.print(&mut out)?;
        writeln!(out)?;
    }
    writeln!(out, "UNITS (ns an operation in one evaluation, measured just now)")?;
    for unit in &units {
        let kinds = Operations::KINDS.iter().zip(unit.ns);
        let words: Vec<String> = kinds.map(|(kind, ns)| format!("{kind} {ns:.3}")).collect();
        writeln!(out, "  {:10} {}", unit.name, words.join(", "))?;
    }
    Ok(())
}

/// What several stacks need together.
struct Scene {
    stacks: usize,
    /// Terms and rules, each with the number of stacks that need it or that it was applied to.
    terms: Vec<(&'static str, usize)>,
    rules: Vec<(Rule, usize)>,
}

impl Scene {
    fn new(planned: &[Planned]) -> Self {
        let needing = |name| planned.iter().filter(|one| one.terms.iter().any(|term| term.name == name)).count();
        let under = |rule| planned.iter().filter(|one| one.applied.iter().any(|applied| applied.rule == rule)).count();
        Scene {
            stacks: planned.len(),
            terms: Term::NAMES.map(|name| (name, needing(name))).to_vec(),
            rules: Rule::ALL.map(|rule| (rule, under(rule))).to_vec(),
        }
    }

    fn needless(&self) -> Vec<&'static str> {
        self.terms.iter().filter(|(_, count)| *count == 0).map(|(name, _)| *name).collect()
    }

    fn json(&self) -> Value {
        let used = self.terms.iter().filter(|(_, count)| *count > 0);
        json!({
            "stacks": self.stacks,
            "terms": used.map(|(name, count)| json!({"name": name, "stacks": count})).collect::<Vec<_>>(),
            "rules": self.rules.iter().filter(|(_, count)| *count > 0)
                .map(|(rule, count)| json!({"rule": rule.name(), "stacks": count})).collect::<Vec<_>>(),
            "needless": self.needless(),
        })
    }

    fn print(&self, out: &mut impl Write) -> io::Result<()> {
        writeln!(out, "SCENE of {} stacks", self.stacks)?;
        for (name, count) in self.terms.iter().filter(|(_, count)| *count > 0) {
            writeln!(out, "  {count:4} need     {name}")?;
        }
        for (rule, count) in self.rules.iter().filter(|(_, count)| *count > 0) {
            writeln!(out, "  {count:4} leave out by {rule}")?;
        }
        writeln!(out, "  no stack needs {}", self.needless().join(", "))
    }
}

/// What a rule saves on its example.
struct Saving {
    rule: Rule,
    with: Costs,
    without: Costs,
}

impl Saving {
    fn new(rule: Rule) -> Result<Self, Failure> {
        let stack = rule.example();
        let skip = [rule];
        let without = Making { without: &skip, ..Making::default() };
        let plan = |making| Plan::with_options(&stack, making).map_err(|problem| problem.to_string());
        let (with, without) = (plan(&Making::default())?, plan(&without)?);
        let [with, without] = cost::measure_both(&stack.cast(), [&with, &without]);
        Ok(Saving { rule, with, without })
    }
}

fn rules(json: bool) -> Result<(), Failure> {
    let savings = Rule::ALL.into_iter().map(Saving::new).collect::<Result<Vec<_>, _>>()?;
    let mut out = io::stdout().lock();
    if json {
        let one = |saving: &Saving| {
            json!({
                "rule": saving.rule.name(), "reason": saving.rule.reason(),
                "with_ns": saving.with.json(), "without_ns": saving.without.json(),
                "general_over_plan": saving.with.general / saving.with.plan,
                "without_over_with_scalar": saving.without.plan / saving.with.plan,
                "without_over_with_batch": saving.without.batch / saving.with.batch,
            })
        };
        writeln!(out, "{:#}", json!({"rules": savings.iter().map(one).collect::<Vec<_>>()}))?;
        return Ok(());
    }
    let level = Level::detect();
    writeln!(out, "RULES  ns an evaluation of three channels, and what the rule saves; batches at {}", level.name())?;
    writeln!(
        out,
        "{:18} {:>9} {:>9} {:>9} {:>7} {:>7}   {:>9} {:>9} {:>7}",
        "", "general", "without", "plan", "general", "without", "without", "batch", "without"
    )?;
    for Saving { rule, with, without } in &savings {
        writeln!(
            out,
            "{:18} {:9.1} {:9.1} {:9.1} {:6.2}× {:6.2}×   {:9.2} {:9.2} {:6.2}×",
            rule.name(),
            with.general,
            without.plan,
            with.plan,
            with.general / with.plan,
            without.plan / with.plan,
            without.batch,
            with.batch,
            without.batch / with.batch
        )?;
    }
    Ok(())
}
