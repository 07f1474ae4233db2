//! `brdf list`: what there is to evaluate, check and run on.

use crate::failure::Failure;
use crate::term::TERMS;
use brdf::layered::Model;
use brdf::material::built_in::{self, Named};
use brdf::material::{metal::METALS, stack};
use clap::Args;
use serde_json::{Value, json};
use std::io::{self, Write};
use std::process::ExitCode;

/// What `brdf list` is asked for.
#[derive(Args)]
pub(crate) struct Options {
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(options: &Options) -> Result<ExitCode, Failure> {
    let adapters = brdf::gpu::adapters();
    let mut out = io::stdout().lock();
    if options.json {
        let terms: Vec<Value> = TERMS
            .iter()
            .map(|term| {
                json!({
                    "name": term.name,
                    "fields": term.fields.iter().map(|field| field.name).collect::<Vec<_>>(),
                    "function": format!("{}::{}", term.function.0, term.function.1),
                })
            })
            .collect();
        let materials: Vec<Value> =
            stack::built_in().iter().map(|material| json!({"name": material.name, "about": material.about})).collect();
        let metals: Vec<Value> = METALS
            .iter()
            .map(|metal| {
                json!({
                    "name": metal.name, "n": metal.n, "k": metal.k,
                    "wavelengths_nm": metal.wavelengths, "source": metal.source,
                })
            })
            .collect();
        let listing = json!({
            "terms": terms,
            "materials": materials,
            "surfaces": built_in::all().iter_mut().map(surface).collect::<Vec<_>>(),
            "models": Model::ALL.map(Model::name),
            "metals": metals,
            "adapters": adapters.iter().map(ToString::to_string).collect::<Vec<_>>(),
        });
        writeln!(out, "{listing:#}")?;
        return Ok(ExitCode::SUCCESS);
    }
    writeln!(out, "TERMS (brdf eval)")?;
    for term in TERMS {
        let fields: Vec<_> = term.fields.iter().map(|field| field.name).collect();
        writeln!(out, "  {:32} {}", term.name, fields.join(", "))?;
    }
    writeln!(out, "  {:32} stack (a name, a file or inline), model, wi, wo", "stack")?;
    writeln!(out, "\nSTACKS (brdf check, eval, plan, render, shader)")?;
    for material in stack::built_in() {
        writeln!(out, "  {:32} {}", material.name, material.about)?;
    }
    writeln!(out, "\nMATERIALS, which vary over a surface (brdf check, render, bench materials)")?;
    for named in &mut built_in::all() {
        let names: Vec<_> = named.parameters().iter().map(|parameter| parameter.name).collect();
        writeln!(out, "  {:32} {}; --set {}", named.name, named.about, names.join(", "))?;
    }
    writeln!(out, "\nMODELS (of a stack)\n  {}", Model::ALL.map(Model::name).join(", "))?;
    writeln!(out, "\nMETALS (of a stack file)")?;
    for metal in METALS {
        let index = |i: usize| format!("{}+{}i", metal.n[i], metal.k[i]);
        writeln!(out, "  {:32} {:16} {:16} {:16} {}", metal.name, index(0), index(1), index(2), metal.source)?;
    }
    writeln!(out, "\nADAPTERS (brdf parity)")?;
    if adapters.is_empty() {
        writeln!(out, "  none; a software one is in Debian's mesa-vulkan-drivers")?;
    }
    for adapter in adapters {
        writeln!(out, "  {adapter}")?;
    }
    Ok(ExitCode::SUCCESS)
}

/// A built-in material with the numbers that may be changed.
fn surface(named: &mut Named) -> Value {
    let parameters: Vec<Value> = named
        .parameters()
        .iter()
        .map(|parameter| {
            json!({"name": parameter.name, "value": *parameter.value, "range": [parameter.range.start(), parameter.range.end()]})
        })
        .collect();
    json!({"name": named.name, "about": named.about, "parameters": parameters})
}
