//! The function that is evaluated: from two directions and the open parameters to f, around the one that was named.

use super::slots::Mapping;
use super::{Options, Returns, ShaderFamily};
use crate::shader::source::{Compiled, Language, type_name};
use crate::shader::{Scalar, Type};

/// A place that f may be in: what it is called, how it is written, and its components.
struct Place {
    name: String,
    expression: String,
    size: usize,
}

/// Writes the function; returns it and the number of channels.
pub(super) fn wrapper(
    compiled: &Compiled<'_>,
    mapping: &Mapping,
    options: &Options,
) -> Result<(String, usize), String> {
    let entry = &compiled.entry;
    let language = compiled.language();
    let wgsl = language == Language::Wgsl;
    let mut body = String::new();
    let mut line = |text: String| {
        body.push_str("    ");
        body.push_str(&text);
        body.push('\n');
    };
    let vector = if wgsl { "vec3<f32>" } else { "vec3" };
    let local = |ty: &str, name: &str, value: &str| {
        let value = if value.is_empty() { String::new() } else { format!(" = {value}") };
        if wgsl { format!("var {name}: {ty}{value};") } else { format!("{ty} {name}{value};") }
    };
    if mapping.slots.iter().any(|slot| slot.needs_half()) {
        let number = if wgsl { "f32" } else { "float" };
        line(local(vector, "judged_h", &format!("{vector}(0.0, 0.0, 1.0)")));
        line(local(number, "judged_length", "length(judged_wi + judged_wo)"));
        // Opposite directions have no half vector; any is as good.
        line("if (judged_length > 0.0) { judged_h = (judged_wi + judged_wo) / judged_length; }".to_owned());
    }
    for (index, input) in compiled.inputs.iter().enumerate() {
        for slot in mapping.slots.iter().filter(|slot| slot.root == entry.parameters.len() + index) {
            if let Some(value) = slot.expression(language) {
                line(format!("{}{} = {value};", input.name, slot.access));
            }
        }
    }
    let mut arguments = Vec::new();
    let mut places: Vec<Place> = Vec::new();
    for (index, (parameter, written)) in entry.parameters.iter().zip(&entry.written).enumerate() {
        let name = format!("judged_a{index}_");
        line(local(&type_name(&parameter.ty, language), &name, ""));
        for slot in mapping.slots.iter().filter(|slot| slot.root == index) {
            if let Some(value) = slot.expression(language) {
                line(format!("{name}{} = {value};", slot.access));
            }
        }
        // A pointer of WGSL is mostly how a struct is passed: it holds the result where nothing is returned.
        if *written && (!wgsl || entry.result.is_none()) {
            collect(&parameter.ty, &parameter.name, &name, &mut places);
        }
        arguments.push(if *written && wgsl { format!("&{name}") } else { name });
    }
    let call = format!("{}({})", entry.name, arguments.join(", "));
    match &entry.result {
        Some(ty) => {
            line(local(&type_name(ty, language), "judged_result", &call));
            let at = places.len();
            collect(ty, "", "judged_result", &mut places);
            // What is returned comes before what is written.
            places.rotate_left(at);
        }
        None => line(format!("{call};")),
    }
    let (value, size) = chosen(compiled, &places, options)?;
    let ty = match (wgsl, size) {
        (true, 1) => "f32",
        (false, 1) => "float",
        _ => vector,
    };
    line(local(ty, "judged_f", &value));
    if options.returns != Returns::Value {
        // Below the horizon and in it there is no f to be had from what has the cosine in it.
        line(format!("if (judged_wi.z <= 0.0) {{ return {ty}(0.0); }}"));
    }
    line(match options.returns {
        Returns::Value => "return judged_f;".to_owned(),
        Returns::Cosine => "return judged_f / judged_wi.z;".to_owned(),
        Returns::PiCosine => "return judged_f / (3.141592653589793 * judged_wi.z);".to_owned(),
    });
    let mut parameters = vec!["judged_wi".to_owned(), "judged_wo".to_owned()];
    let mut types = vec![vector; 2];
    for index in 0..mapping.parameters.len() {
        parameters.push(format!("judged_p{index}_"));
        types.push(if wgsl { "f32" } else { "float" });
    }
    let declared = parameters.iter().zip(&types);
    let declared: Vec<String> =
        declared.map(|(name, ty)| if wgsl { format!("{name}: {ty}") } else { format!("{ty} {name}") }).collect();
    let (name, declared) = (ShaderFamily::ENTRY, declared.join(", "));
    let head = if wgsl { format!("fn {name}({declared}) -> {ty}") } else { format!("{ty} {name}({declared})") };
    Ok((format!("{head} {{\n{body}}}\n"), if size == 1 { 1 } else { 3 }))
}

/// The numbers and vectors of a value.
fn collect(ty: &Type, name: &str, expression: &str, places: &mut Vec<Place>) {
    match ty {
        Type::Scalar(Scalar::F32) => {
            places.push(Place { name: name.to_owned(), expression: expression.to_owned(), size: 1 });
        }
        // Two numbers are no colour, but each may be the one that is wanted.
        Type::Vector { size: 2, scalar: Scalar::F32 } => {
            for part in ["x", "y"] {
                let name = if name.is_empty() { part.to_owned() } else { format!("{name}.{part}") };
                places.push(Place { name, expression: format!("{expression}.{part}"), size: 1 });
            }
        }
        Type::Vector { size, scalar: Scalar::F32 } if *size > 2 => {
            places.push(Place { name: name.to_owned(), expression: expression.to_owned(), size: *size });
        }
        Type::Struct { members, .. } if places.len() < 256 => {
            for member in members {
                let own = &member.name;
                let name = if name.is_empty() { own.clone() } else { format!("{name}.{own}") };
                collect(&member.ty, &name, &format!("{expression}.{own}"), places);
            }
        }
        _ => {}
    }
}

/// The expression of f, and its components.
fn chosen(compiled: &Compiled<'_>, places: &[Place], options: &Options) -> Result<(String, usize), String> {
    let signature = compiled.entry.signature(compiled.language());
    let expression = |place: &Place| match place.size {
        4 => format!("{}.xyz", place.expression),
        _ => place.expression.clone(),
    };
    let names = || places.iter().map(|p| p.name.as_str()).filter(|n| !n.is_empty()).collect::<Vec<_>>().join(", ");
    let Some(wanted) = &options.result else {
        return match places {
            [first, ..] if first.name.is_empty() => Ok((expression(first), first.size.min(3))),
            [only] => Ok((expression(only), only.size.min(3))),
            [] => Err(format!("`{signature}` returns neither a number nor a vector of 3 or 4")),
            _ => Err(format!("which result of `{signature}` is the BRDF? say --result {} (a sum is A+B)", names())),
        };
    };
    let mut sum: Vec<(String, usize)> = Vec::new();
    for part in wanted.split('+').map(str::trim) {
        let found = places.iter().find(|place| place.name == part);
        let Some(found) = found else {
            return Err(match names() {
                names if names.is_empty() => {
                    format!("--result {part}: `{signature}` has one result, which needs no name")
                }
                names => format!("--result {part}: `{signature}` has the results {names}"),
            });
        };
        sum.push((expression(found), found.size.min(3)));
    }
    let size = sum.first().map_or(1, |(_, size)| *size);
    if sum.iter().any(|(_, other)| *other != size) {
        return Err(format!("--result {wanted}: numbers and vectors cannot be added"));
    }
    let parts: Vec<String> = sum.into_iter().map(|(expression, _)| expression).collect();
    Ok((parts.join(" + "), size))
}
