//! Reports as JSON. `docs/report.md` describes every field; [`VERSION`] changes when one changes its meaning or goes.

use super::figures::{Figures, Grid, Series};
use super::{Entry, Outcome, Run};
use crate::check::energy::Albedo;
use crate::check::family::Parameter;
use crate::check::report::{Coverage, Finding, Place, Report, Values};
use crate::frame::Vector;
use serde_json::{Map, Value, json};

/// The version of the schema that [`Run::to_json`] writes and [`Run::from_json`] reads.
pub const VERSION: u64 = 2;

impl Run {
    /// The run as JSON text, keys in alphabetical order: equal runs give equal bytes.
    pub fn to_json(&self) -> String {
        let value = json!({
            "schema": "brdf-check",
            "version": VERSION,
            "tool": self.tool,
            "verdict": self.verdict().name(),
            "exit_code": self.exit_code(),
            "twins": self.twins,
            "total": self.total,
            "shard": self.shard.map(|shard| json!({"number": shard.number, "of": shard.of})),
            "reports": self.entries.iter().map(entry).collect::<Vec<_>>(),
        });
        format!("{value:#}\n")
    }
}

/// A number, or the name of one that JSON cannot write.
pub(super) fn number(x: f64) -> Value {
    if x.is_finite() {
        json!(x)
    } else if x.is_nan() {
        json!("NaN")
    } else if x > 0.0 {
        json!("Infinity")
    } else {
        json!("-Infinity")
    }
}

fn numbers(values: &[f64]) -> Value {
    values.iter().copied().map(number).collect()
}

fn entry(entry: &Entry) -> Value {
    let mut fields = Map::new();
    fields.insert("index".into(), json!(entry.index));
    fields.insert("source".into(), json!(entry.source));
    fields.insert("kind".into(), json!(entry.kind));
    fields.insert("subject".into(), json!(entry.name()));
    fields.insert("verdict".into(), json!(entry.verdict_name()));
    match &entry.outcome {
        Outcome::Judged { report, figures } => {
            fill(&mut fields, report);
            if let Some(figures) = figures {
                fields.insert("figures".into(), drawing(figures));
            }
        }
        Outcome::Refused { reason, accepted } => {
            fields.insert("reason".into(), json!(reason));
            fields.insert("accepted".into(), json!(accepted));
        }
    }
    Value::Object(fields)
}

fn fill(fields: &mut Map<String, Value>, report: &Report) {
    fields.insert("channels".into(), json!(report.channel_names));
    fields.insert("findings".into(), report.findings.iter().map(finding).collect());
    fields.insert("albedos".into(), report.albedos.iter().map(albedo).collect());
    fields.insert("coverage".into(), coverage(&report.coverage));
    fields.insert("notes".into(), json!(report.notes));
}

fn vector(v: Vector<f64>) -> Value {
    numbers(&[v.x, v.y, v.z])
}

fn finding(finding: &Finding) -> Value {
    let place = match finding.place {
        Place::Everywhere => Value::Null,
        Place::Marginal { theta, phi, fixed } => {
            json!({"theta": number(theta), "phi": number(phi), "fixed": fixed.name()})
        }
        Place::Pair { wi, wo } => json!({"wi": vector(wi), "wo": vector(wo)}),
    };
    let parameter = |(name, value): &(String, f64)| json!({"name": name, "value": number(*value)});
    let values = |values: &Values| json!({"f64": numbers(&values.double), "f32": numbers(&values.single), "gpu": numbers(&values.gpu)});
    json!({
        "check": finding.check.name(),
        "precision": if finding.single { "f32" } else { "f64" },
        "verdict": finding.verdict.name(),
        "binding": finding.binding,
        "accepted": finding.accepted,
        "value": number(finding.value),
        "error": number(finding.error),
        "limit": number(finding.limit),
        "place": place,
        "channel": finding.channel.as_ref().map(|(index, name)| json!({"index": index, "name": name})),
        "note": finding.note,
        "parameters": finding.parameters.iter().map(parameter).collect::<Vec<_>>(),
        "values": finding.values.as_ref().map(values),
        "cause": finding.cause,
        "again": finding.again,
        "line": finding.to_string(),
    })
}

fn albedo(albedo: &Albedo) -> Value {
    json!({
        "theta": number(albedo.theta),
        "phi": number(albedo.phi),
        "fixed": albedo.fixed.name(),
        "value": numbers(&albedo.value),
        "error": numbers(&albedo.error),
        "cross_check": numbers(&albedo.cross_check),
        "standard_error": numbers(&albedo.standard_error),
        "agrees": albedo.agrees,
        "non_finite": albedo.non_finite,
        "evaluations": albedo.evaluations,
    })
}

fn coverage(coverage: &Coverage) -> Value {
    let Coverage { seed, budget, evaluations, integrals, pairs, restarts, anisotropic, parameters, members } = coverage;
    let parameter = |parameter: &Parameter| {
        let Parameter { name, low, high, default, scale } = parameter;
        json!({
            "name": name,
            "low": number(*low),
            "high": number(*high),
            "default": number(*default),
            "scale": scale.name(),
        })
    };
    json!({
        "seed": seed,
        "budget": budget,
        "evaluations": evaluations,
        "integrals": integrals,
        "pairs": pairs,
        "restarts": restarts,
        "anisotropic": anisotropic,
        "parameters": parameters.iter().map(parameter).collect::<Vec<_>>(),
        "members": members,
    })
}

fn drawing(figures: &Figures) -> Value {
    let parameter = |(name, value): &(String, f64)| json!({"name": name, "value": number(*value)});
    let sweep = |(parameter, grid): &(String, Grid)| json!({"parameter": parameter, "map": map(grid)});
    json!({
        "parameters": figures.parameters.iter().map(parameter).collect::<Vec<_>>(),
        "albedo": figures.albedo.iter().map(series).collect::<Vec<_>>(),
        "lobes": figures.lobes.iter().map(series).collect::<Vec<_>>(),
        "reciprocity": map(&figures.reciprocity),
        "validity": map(&figures.validity),
        "precision": figures.precision.iter().map(series).collect::<Vec<_>>(),
        "sweep": figures.sweep.as_ref().map(sweep),
    })
}

/// A map as one string of numbers a row: a number a line would be most of a report's length.
fn map(grid: &Grid) -> Value {
    let row = |row: &[f64]| row.iter().map(|x| word(*x)).collect::<Vec<_>>().join(" ");
    let rows: Vec<String> = grid.values.chunks(grid.x.len().max(1)).map(row).collect();
    json!({"x": row(&grid.x), "y": row(&grid.y), "rows": rows})
}

fn series(series: &Series) -> Value {
    let row = |row: &[f64]| row.iter().map(|x| word(*x)).collect::<Vec<_>>().join(" ");
    json!({"name": series.name, "x": row(&series.x), "y": row(&series.y), "error": row(&series.error)})
}

/// A number as text that reads back to itself: `NaN`, `inf` and `-inf` included.
fn word(x: f64) -> String {
    format!("{x}")
}
