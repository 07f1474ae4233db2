//! `brdf eval`: JSON Lines in, the same objects with the results out.
//!
//! All lines are read first, so that an adapter runs each term once over all its lines; answers keep the lines' order.
//! A line that cannot be answered comes back with an `error` in place of results.

use crate::failure::Failure;
use crate::material::{self, AnyStack, Change};
use crate::output::complain;
use crate::term::{self, Field, Kind, Results, Term, read_fields};
use brdf::Vector;
use brdf::gpu::{Gpu, GpuError, StackBuffers};
use brdf::layered::Model;
use brdf::layered::description::{Description, Node, Value as Leaf};
use brdf::parity::{Twin, map_twin, stack_arguments, stack_twin, text_double, text_single, twins};
use brdf::walk;
use clap::{Args, ValueEnum};
use serde_json::{Map, Value};
use std::collections::BTreeMap;
use std::io::{self, BufRead, BufWriter, Write};
use std::process::ExitCode;

/// What `brdf eval` is asked for.
#[derive(Args)]
pub(crate) struct Options {
    /// What computes the terms.
    #[arg(long = "as", value_enum, default_value_t = Mode::F64)]
    mode: Mode,
    /// The adapter for `--as gpu`, by words of its name or backend; see `brdf list`.
    #[arg(long)]
    adapter: Option<String>,
    /// Walks for each stack under the model `walk`.
    #[arg(long, default_value_t = walk::Options::default().samples, value_parser = clap::value_parser!(u32).range(2..))]
    walks: u32,
    /// Print JSON, as it always does.
    #[arg(long)]
    json: bool,
    /// Seed of the walks.
    #[arg(long, default_value_t = walk::Options::default().seed)]
    seed: u32,
}

/// What computes the terms.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Mode {
    /// The Rust functions in single precision.
    F32,
    /// The Rust functions in double precision.
    F64,
    /// The WGSL twins evaluated on the CPU in single precision.
    Wgsl,
    /// The WGSL twins evaluated on the CPU in double precision.
    Wgsl64,
    /// The WGSL twins on an adapter.
    Gpu,
}

/// What a line asks for.
enum Question {
    Term { term: &'static Term, fields: Vec<f64> },
    Stack { stack: AnyStack, wi: Vector<f64>, wo: Vector<f64> },
}

const DIRECTIONS: &[Field] =
    &[Field { name: "wi", kind: Kind::Direction }, Field { name: "wo", kind: Kind::Direction }];

pub(crate) fn run(options: &Options) -> Result<ExitCode, Failure> {
    // An adapter that is missing is said before any input is waited for.
    let gpu = match options.mode {
        Mode::Gpu => Some(Gpu::open(options.adapter.as_deref())?),
        _ => None,
    };
    let (mut questions, mut objects) = (Vec::new(), Vec::new());
    let mut bad_lines = 0;
    for (index, line) in io::stdin().lock().split(b'\n').enumerate() {
        let line = line?;
        if line.iter().all(u8::is_ascii_whitespace) {
            continue;
        }
        let (mut object, parsed) = match serde_json::from_slice::<Map<String, Value>>(&line) {
            Ok(object) => {
                let question = question(&object);
                (object, question)
            }
            Err(error) => (Map::new(), Err(format!("not a JSON object: {error}"))),
        };
        match parsed {
            Ok(question) => questions.push((objects.len(), question)),
            Err(problem) => {
                bad_lines += 1;
                complain(&format_args!("line {}: {problem}", index + 1));
                object.insert("error".to_owned(), problem.into());
            }
        }
        objects.push(object);
    }
    let answers = match (gpu, options.mode) {
        (Some(gpu), _) => by_twin(&questions, |twin, rows, stacks| on_adapter(&gpu, twin, rows, stacks))?,
        (None, Mode::Wgsl) => by_twin(&questions, text_single)?,
        (None, Mode::Wgsl64) => by_twin(&questions, text_double)?,
        (None, _) => questions.iter().map(|(_, question)| on_cpu(question, options)).collect(),
    };
    for ((index, _), results) in questions.iter().zip(answers) {
        objects[*index].extend(results.into_iter().map(|(name, value)| (name.to_owned(), value)));
    }
    let mut out = BufWriter::new(io::stdout().lock());
    for object in &objects {
        serde_json::to_writer(&mut out, object).map_err(io::Error::from)?;
        out.write_all(b"\n")?;
    }
    out.flush()?;
    if bad_lines > 0 {
        return Err(format!("{bad_lines} of {} lines could not be answered", objects.len()).into());
    }
    Ok(ExitCode::SUCCESS)
}

fn question(object: &Map<String, Value>) -> Result<Question, String> {
    let name = match object.get("term") {
        Some(Value::String(name)) => name.as_str(),
        Some(other) => return Err(format!("`term` is {other}, it must be a name; see `brdf list`")),
        None => return Err("`term` is missing; see `brdf list`".to_owned()),
    };
    if name == "stack" {
        return stack_question(object);
    }
    let term = term::by_name(name).ok_or_else(|| format!("`{name}` is no term; see `brdf list`"))?;
    Ok(Question::Term { term, fields: read_fields(term.fields, object)? })
}

fn stack_question(object: &Map<String, Value>) -> Result<Question, String> {
    fn named<T>(
        object: &Map<String, Value>,
        key: &str,
        read: fn(&str) -> Result<T, String>,
    ) -> Result<Option<T>, String> {
        match object.get(key) {
            None => Ok(None),
            Some(Value::String(name)) => read(name).map(Some),
            Some(other) => Err(format!("`{key}` is {other}, it must be a name")),
        }
    }
    let change =
        Change { model: named(object, "model", material::model)?, widths: named(object, "widths", material::widths)? };
    let stack = match object.get("stack") {
        Some(Value::String(name)) => material::load(name, change)?.stack,
        Some(tree @ Value::Object(_)) => {
            let description = Description::from_node(&node(tree)).map_err(|error| format!("stack: {error}"))?;
            AnyStack::new(&description, change).map_err(|error| format!("stack: {error}"))?
        }
        Some(other) => return Err(format!("`stack` is {other}, it must be a name, a file or an object with `layer`")),
        None => return Err("`stack` is missing: a name, a file or an object with `layer`".to_owned()),
    };
    let d = read_fields(DIRECTIONS, object)?;
    Ok(Question::Stack { stack, wi: Vector::new(d[0], d[1], d[2]), wo: Vector::new(d[3], d[4], d[5]) })
}

/// The stack tree of a JSON value.
fn node(value: &Value) -> Node {
    let leaf = match value {
        Value::Null => Leaf::Other("null".to_owned()),
        Value::Bool(flag) => Leaf::Flag(*flag),
        Value::Number(number) => Leaf::Number(number.as_f64().unwrap_or(f64::NAN)),
        Value::String(text) => Leaf::Text(text.clone()),
        Value::Array(items) => Leaf::List(items.iter().map(node).collect()),
        Value::Object(members) => Leaf::Table(members.iter().map(|(key, value)| (key.clone(), node(value))).collect()),
    };
    leaf.into()
}

fn on_cpu(question: &Question, options: &Options) -> Results {
    let mode = options.mode;
    match question {
        Question::Term { term, fields } => {
            let twin = twin(term.function);
            let results = if mode == Mode::F64 {
                (twin.double)(&(term.arguments)(fields))
            } else {
                let fields: Vec<f64> = fields.iter().map(|x| f64::from(*x as f32)).collect();
                let arguments: Vec<f32> = (term.arguments)(&fields).into_iter().map(|x| x as f32).collect();
                (twin.single)(&arguments).into_iter().map(f64::from).collect()
            };
            (term.results)(fields, &results)
        }
        Question::Stack { stack, wi, wo } if stack.model() == Model::Walk => {
            let walks = walk::Options { samples: options.walks, seed: options.seed, ..walk::Options::default() };
            let (f, error) = stack.walk(*wi, *wo, &walks);
            [stack_results(&f), vec![("standard_error", numbers(&error))]].concat()
        }
        Question::Stack { stack, wi, wo } => {
            let f: Vec<f64> = if mode == Mode::F64 {
                stack.evaluate(*wi, *wo)
            } else {
                stack.evaluate::<f32>(wi.cast(), wo.cast()).into_iter().map(f64::from).collect()
            };
            stack_results(&f)
        }
    }
}

fn stack_results(f: &[f64]) -> Results {
    vec![("f", numbers(f))]
}

fn numbers(values: &[f64]) -> Value {
    values.iter().map(|x| term::json(*x)).collect()
}

/// The function of this module and name in both languages. Every term's function has a twin, which a test asserts.
fn twin((module, function): (&str, &str)) -> Twin {
    let all = twins();
    let position = all.iter().position(|twin| twin.module == module && twin.function == function);
    all[position.expect("every term has a twin")]
}

/// The results of a twin on an adapter.
fn on_adapter(gpu: &Gpu, twin: &Twin, rows: &[Vec<f64>], stacks: &StackBuffers) -> Result<Vec<Vec<f64>>, GpuError> {
    let rows: Vec<Vec<f32>> = rows.iter().map(|row| row.iter().map(|x| *x as f32).collect()).collect();
    let outputs = map_twin(gpu, twin, &rows, stacks)?;
    let row = |values: &[f32]| values.iter().map(|x| f64::from(*x)).collect();
    Ok(outputs.values.chunks_exact(outputs.names.len()).map(row).collect())
}

/// Answers all questions by the WGSL twins, one run for each function.
fn by_twin(
    questions: &[(usize, Question)],
    run: impl Fn(&Twin, &[Vec<f64>], &StackBuffers) -> Result<Vec<Vec<f64>>, GpuError>,
) -> Result<Vec<Results>, Failure> {
    let mut groups: BTreeMap<(&str, &str), Vec<usize>> = BTreeMap::new();
    for (index, (_, question)) in questions.iter().enumerate() {
        let function = match question {
            Question::Term { term, .. } => term.function,
            Question::Stack { stack, .. } if stack_twin(stack.model()).is_none() => {
                let model = stack.model().name();
                return Err(Failure::Input(format!(
                    "the model {model} has no twin that is evaluated here; use --as f64"
                )));
            }
            Question::Stack { stack, .. } => ("layered", stack.model().name()),
        };
        groups.entry(function).or_default().push(index);
    }
    let mut answers: Vec<Results> = vec![Vec::new(); questions.len()];
    for (function, members) in groups {
        let mut stacks = StackBuffers::default();
        let rows: Vec<Vec<f64>> = members
            .iter()
            .map(|index| match &questions[*index].1 {
                Question::Term { term, fields } => (term.arguments)(fields),
                Question::Stack { stack, wi, wo, .. } => {
                    let place = stack_arguments(&stack.three(), &mut stacks);
                    place.into_iter().map(f64::from).chain([wi.x, wi.y, wi.z, wo.x, wo.y, wo.z]).collect()
                }
            })
            .collect();
        for (index, values) in members.into_iter().zip(run(&twin(function), &rows, &stacks)?) {
            answers[index] = match &questions[index].1 {
                Question::Term { term, fields } => (term.results)(fields, &values),
                Question::Stack { stack, .. } => stack_results(&values[..stack.channels()]),
            };
        }
    }
    Ok(answers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_term_has_a_twin_of_its_arity() {
        for term in term::TERMS {
            let all = twins();
            let found = all.iter().find(|twin| (twin.module, twin.function) == term.function);
            assert!(found.is_some(), "{}", term.name);
        }
    }

    #[test]
    fn a_bad_line_says_what_is_wrong() {
        for (line, want) in [
            ("{}", "`term` is missing"),
            (r#"{"term": 3}"#, "`term` is 3"),
            (r#"{"term": "fresnel.magic"}"#, "`fresnel.magic` is no term"),
            (r#"{"term": "fresnel.dielectric", "cos": 0.5}"#, "`eta` is missing; the term reads cos, eta"),
            (r#"{"term": "fresnel.dielectric", "cos": 2, "eta": 1.5}"#, "`cos` is 2, it must be a number in [0, 1]"),
            (r#"{"term": "distribution.ggx", "h": [0, 0], "alpha": 1}"#, "`h` is [0,0], it must be three numbers"),
            (r#"{"term": "stack", "stack": "nothing"}"#, "nothing is neither a built-in stack or material"),
            (r#"{"term": "stack", "stack": {"layer": []}, "wi": [0, 0, 1], "wo": [0, 0, 1]}"#, "stack: "),
            (r#"{"term": "stack", "stack": "glass", "model": "x"}"#, "`x` is no model; there are elek"),
            (r#"{"term": "stack", "stack": "glass", "wi": [0, 0, 2], "wo": [0, 0, 1]}"#, "`wi` is [0,0,2]"),
        ] {
            let object = serde_json::from_str(line).expect("a JSON object");
            let error = question(&object).err().unwrap_or_default();
            assert!(error.contains(want), "{line}: {error}");
        }
    }
}
