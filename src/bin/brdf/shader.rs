//! `brdf shader`: the WGSL of stacks.

use crate::failure::Failure;
use crate::material::{self, Change, Material};
use brdf::gpu::StackBuffers;
use brdf::layered::Model;
use brdf::plan::Plan;
use brdf::shader::{Counts, Module};
use brdf::wgsl;
use clap::Args;
use serde_json::{Value, json};
use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

/// What `brdf shader` is asked for.
#[derive(Args)]
pub(crate) struct Options {
    /// Built-in stacks or stack files; of several, a scene that selects them by index.
    #[arg(required = true)]
    stacks: Vec<String>,
    /// The model in place of the stacks' own.
    #[arg(long, value_parser = material::model)]
    model: Option<Model>,
    /// What the stacks need and nothing else; the default.
    #[arg(long, conflicts_with = "general")]
    special: bool,
    /// The kernels that take any stack from a storage buffer.
    #[arg(long)]
    general: bool,
    /// Print sizes in naga's IR and in SPIR-V instead: special against general.
    #[arg(long)]
    count: bool,
    /// Print JSON.
    #[arg(long)]
    json: bool,
    /// Write to a file.
    #[arg(long)]
    out: Option<PathBuf>,
}

pub(crate) fn run(options: &Options) -> Result<ExitCode, Failure> {
    // Special is the default, so that the flag has nothing to choose.
    let Options { special: _, .. } = options;
    let change = Change { model: options.model, widths: None };
    let load = |name: &String| material::load(name, change);
    let materials: Vec<Material> = options.stacks.iter().map(load).collect::<Result<_, _>>()?;
    let text = if options.count || options.json {
        let (special, general) = (special(&materials)?, general(&materials)?);
        let counts = [("special", counts(&special)?), ("general", counts(&general)?)];
        if options.json {
            let mut object: serde_json::Map<String, Value> =
                counts.iter().map(|(name, counts)| ((*name).to_owned(), json!({"counts": as_json(counts)}))).collect();
            for (name, text) in [("special", special), ("general", general)] {
                if options.general == (name == "general") && !options.count {
                    object[name]["wgsl"] = text.into();
                }
            }
            format!("{:#}\n", Value::Object(object))
        } else {
            table(&counts)
        }
    } else if options.general {
        general(&materials)?
    } else {
        special(&materials)?
    };
    match &options.out {
        Some(path) => std::fs::write(path, text).map_err(|error| format!("{}: {error}", path.display()))?,
        None => io::stdout().lock().write_all(text.as_bytes())?,
    }
    Ok(ExitCode::SUCCESS)
}

/// The specialised module of the stacks, linked.
fn special(materials: &[Material]) -> Result<String, Failure> {
    let mut plans: Vec<(String, Plan<3>)> = Vec::new();
    for Material { name, stack } in materials {
        let plan = Plan::new(&stack.three()).map_err(|error| format!("{name}: {error}; see --model"))?;
        let identifier = wgsl::identifier(name);
        if plans.iter().any(|(other, _)| *other == identifier) {
            return Err(format!("{name}: the name `{identifier}` is given twice; rename one of the stacks").into());
        }
        plans.push((identifier, plan));
    }
    let text = match plans.as_slice() {
        [(name, plan)] => wgsl::specialise(plan, name),
        _ => {
            let named: Vec<_> = plans.iter().map(|(name, plan)| (name.as_str(), plan.clone())).collect();
            wgsl::specialise_scene(&named)
        }
    };
    Ok(wgsl::link(&text).map_err(|error| error.to_string())?)
}

/// The general kernels of the stacks' models, linked, with the bindings that they need.
fn general(materials: &[Material]) -> Result<String, Failure> {
    let mut root = String::from("import brdf::layered;\n");
    let mut models: Vec<Model> = Vec::new();
    for model in materials.iter().map(|material| material.stack.model()) {
        if !Model::CLOSED_FORM.contains(&model) {
            return Err(format!("the model {} has no closed form; see --model", model.name()).into());
        }
        if !models.contains(&model) {
            models.push(model);
            root += &format!(
                "\nfn evaluate_{0}(first: u32, count: u32, wi: vec3f, wo: vec3f) -> vec3f {{\n    return \
                 layered::{0}(first, count, wi, wo);\n}}\n",
                model.name()
            );
        }
    }
    let linked = wgsl::link(&root).map_err(|error| error.to_string())?;
    let bindings = StackBuffers::default().bindings(&linked);
    Ok(format!("{linked}\n{bindings}"))
}

/// The sizes of a module.
pub(crate) fn counts(source: &str) -> Result<Counts, Failure> {
    Ok(Module::parse(source).and_then(|module| module.counts()).map_err(|error| error.to_string())?)
}

pub(crate) fn as_json(counts: &Counts) -> Value {
    json!({
        "functions": counts.functions, "expressions": counts.expressions, "statements": counts.statements,
        "spirv_instructions": counts.instructions, "spirv_words": counts.words,
    })
}

fn table(rows: &[(&str, Counts)]) -> String {
    let mut text = format!(
        "{:8} {:>9} {:>11} {:>10} {:>18} {:>11}\n",
        "", "functions", "expressions", "statements", "SPIR-V operations", "SPIR-V words"
    );
    for (name, c) in rows {
        text += &format!(
            "{name:8} {:>9} {:>11} {:>10} {:>18} {:>11}\n",
            c.functions, c.expressions, c.statements, c.instructions, c.words
        );
    }
    text
}
