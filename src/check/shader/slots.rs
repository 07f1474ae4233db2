//! The values that a function waits for, one a scalar or vector, and the expression that each one gets.

use super::roles::{Direction, Known, ROLES, Role, is_colour, known, role};
use super::{Options, Returns};
use crate::check::family::{Parameter, Scale};
use crate::shader::source::{Compiled, Language};
use crate::shader::{Scalar, Type};

/// The scalars and vectors that one function may wait for.
const MOST_SLOTS: usize = 512;

/// A scalar or vector that a function waits for.
#[derive(Clone, Debug)]
pub(super) struct Slot {
    /// The parameter or variable that it is of: those of the function first, then those of the module.
    pub(super) root: usize,
    /// How it is reached from the module or the parameters: `mat.layers[0].alpha`.
    pub(super) path: String,
    /// The path without its root.
    pub(super) access: String,
    /// Its last name.
    name: String,
    pub(super) scalar: Scalar,
    /// 0 of what cannot be given: a matrix.
    pub(super) size: usize,
    /// Something that the function reaches reads it.
    needed: bool,
    /// The function that is named reads it; so does what is no parameter of it.
    read: bool,
    /// It has a value of its own.
    has_value: bool,
    /// A matrix from the local frame, in which it is the identity.
    is_frame: bool,
    pub(super) source: Source,
}

/// Where a slot's value comes from.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Source {
    /// It keeps what it has: zero, or its own value.
    Own,
    Geometry(Role),
    Numbers(Vec<f64>),
    /// The parameter of this number, in all components.
    Searched(usize),
    /// The identity.
    Frame,
}

/// Every value settled.
#[derive(Debug, Default)]
pub(super) struct Mapping {
    pub(super) slots: Vec<Slot>,
    pub(super) parameters: Vec<Parameter>,
    pub(super) notes: Vec<String>,
}

/// What is said of one name by `--map`, `--param`, `--range`.
struct Said<'a> {
    option: &'static str,
    name: &'a str,
    value: &'a str,
}

fn said(options: &Options) -> Result<Vec<Said<'_>>, String> {
    let lists = [("--map", &options.maps), ("--param", &options.values), ("--range", &options.ranges)];
    let mut all = Vec::new();
    for (option, texts) in lists {
        for text in texts {
            let Some((name, value)) = text.split_once('=') else {
                return Err(format!("{option} {text}: write NAME=…"));
            };
            all.push(Said { option, name: name.trim(), value: value.trim() });
        }
    }
    Ok(all)
}

/// Whether an option speaks of a variable.
pub(super) fn is_named(options: &Options, variable: &str) -> bool {
    let lists = [&options.maps, &options.values, &options.ranges];
    let name = |text: &String| text.split(['=', '.']).next().unwrap_or_default().trim().to_owned();
    lists.into_iter().flatten().any(|text| name(text) == variable)
}

/// Finds out where every value comes from.
pub(super) fn map(compiled: &Compiled<'_>, options: &Options) -> Result<Mapping, String> {
    let mut mapping = Mapping::default();
    let entry = &compiled.entry;
    for (root, (parameter, written)) in entry.parameters.iter().zip(&entry.written).enumerate() {
        // What GLSL's `out` and `inout` hold is a result first; a pointer of WGSL is how large structs are passed.
        let is_result = *written && compiled.language() == Language::Glsl;
        let first = mapping.slots.len();
        walk(&parameter.ty, root, &parameter.name, "", true, is_result, compiled, &mut mapping.slots)?;
        let read = compiled.reads(&parameter.name);
        mapping.slots.iter_mut().skip(first).for_each(|slot| slot.read = read);
    }
    for (index, input) in compiled.inputs.iter().enumerate() {
        let root = entry.parameters.len() + index;
        walk(&input.ty, root, &input.name, "", true, input.has_value, compiled, &mut mapping.slots)?;
    }
    let said = said(options)?;
    let mut told: Vec<[Option<&str>; 3]> = vec![[None; 3]; mapping.slots.len()];
    for said in &said {
        let index =
            named(&mapping.slots, said.name).map_err(|what| format!("{} {}: {what}", said.option, said.name))?;
        let which = ["--map", "--param", "--range"].iter().position(|option| *option == said.option).unwrap_or(0);
        if let Some(slot) = told.get_mut(index).and_then(|slots| slots.get_mut(which))
            && slot.replace(said.value).is_some()
        {
            return Err(format!("{} {}: given twice", said.option, said.name));
        }
    }
    let mut open: Vec<String> = Vec::new();
    for (index, told) in told.into_iter().enumerate() {
        let Some(mut slot) = mapping.slots.get(index).cloned() else { continue };
        let path = slot.path.clone();
        let source = match told {
            [Some(_), Some(_), _] | [Some(_), _, Some(_)] => {
                return Err(format!("`{path}`: --map and --param or --range say two things"));
            }
            [Some(text), None, None] => Some(geometry(&slot, text)?),
            [None, value, Some(range)] => Some(searched(&slot, range, value, &mut mapping.parameters)?),
            [None, Some(value), None] => Some(Source::Numbers(numbers(&slot, value)?)),
            [None, None, None] if slot.has_value || !slot.needed => Some(Source::Own),
            [None, None, None] if !slot.read => Some(unread(&slot)),
            [None, None, None] => guessed(&slot, &mut mapping),
        };
        match source {
            Some(source) => slot.source = source,
            None => open.push(format!("`{path}`")),
        }
        if let Some(place) = mapping.slots.get_mut(index) {
            *place = slot;
        }
    }
    // Members of a struct and globals that nobody reads are many and none of the caller's business; a parameter is.
    let mut idle: Vec<&str> = Vec::new();
    for slot in mapping.slots.iter().filter(|slot| slot.root < entry.parameters.len() && !slot.read) {
        if slot.source == Source::Own && slot.access.is_empty() && slot.needed && !slot.has_value {
            idle.push(&slot.path);
        }
    }
    let idle = idle.into_iter().map(|path| format!("{path} = 0: the function does not read it")).collect::<Vec<_>>();
    // A tangent alone makes no BRDF: then `x` and `y` are something else.
    let is_of_light = |slot: &Slot| match slot.source {
        Source::Geometry(Role::Along(d, _)) => matches!(d, Direction::Wi | Direction::Wo | Direction::Half),
        Source::Geometry(Role::Cosine(..)) => true,
        _ => false,
    };
    if !mapping.slots.iter().any(is_of_light) {
        let is_guess = |slot: &&Slot| {
            let along =
                matches!(slot.source, Source::Geometry(Role::Along(Direction::Tangent | Direction::Bitangent, _)));
            along && !is_named(options, &slot.path)
        };
        open.extend(mapping.slots.iter().filter(is_guess).map(|slot| format!("`{}`", slot.path)));
    }
    if !open.is_empty() {
        return Err(format!(
            "it is not clear what {} of `{}` {}: say --map NAME=ROLE (a role is one of {ROLES}), --param NAME=VALUE or \
             --range NAME=LO..HI[:log]",
            open.join(", "),
            entry.signature(compiled.language()),
            if open.len() == 1 { "is" } else { "are" },
        ));
    }
    // A reflectance alone is Lambert's, and nothing at all its 1/π; what a caller names is meant.
    let is_brdf = |slot: &Slot| match slot.source {
        Source::Geometry(_) => true,
        Source::Searched(_) | Source::Numbers(_) => is_colour(&slot.name) || is_named(options, &slot.path),
        Source::Own | Source::Frame => false,
    };
    if !entry.parameters.is_empty() && !mapping.slots.iter().any(is_brdf) {
        return Err(format!(
            "`{}` takes no direction and no reflectance: it is a number, no BRDF. Is another function meant? What it reads \
             may be given with --map NAME=ROLE, --param NAME=VALUE or --range NAME=LO..HI[:log]",
            entry.signature(compiled.language()),
        ));
    }
    for direction in [Direction::Wi, Direction::Wo] {
        let is_it = |slot: &&Slot| slot.source == Source::Geometry(Role::Along(direction, false));
        let claims: Vec<&str> = mapping.slots.iter().filter(is_it).map(|slot| slot.path.as_str()).collect();
        let all_said = claims.iter().all(|claim| is_named(options, claim));
        if claims.len() > 1 && !all_said {
            return Err(format!(
                "{} all look like {direction} in `{}`: say which is which with --map NAME=ROLE",
                claims.join(", "),
                entry.signature(compiled.language())
            ));
        }
    }
    mapping.notes.insert(0, roles_note(&mapping.slots, options.returns));
    mapping.notes.extend(idle);
    for slot in &mapping.slots {
        if slot.source == Source::Own && slot.needed && slot.root >= entry.parameters.len() {
            mapping.notes.push(format!("{}: its own value, 0 where it states none (--param {0}=… sets it)", slot.path));
        }
    }
    Ok(mapping)
}

fn roles_note(slots: &[Slot], returns: Returns) -> String {
    let roles: Vec<String> = slots
        .iter()
        .filter_map(|slot| match slot.source {
            Source::Geometry(role) => Some(format!("{} = {role}", slot.path)),
            _ => None,
        })
        .collect();
    let roles = if roles.is_empty() { "depends on no direction".to_owned() } else { roles.join(", ") };
    format!("{roles}; taken to return {returns}")
}

#[allow(clippy::too_many_arguments)] // the state of one recursion
fn walk(
    ty: &Type,
    root: usize,
    path: &str,
    access: &str,
    needed: bool,
    has_value: bool,
    compiled: &Compiled<'_>,
    slots: &mut Vec<Slot>,
) -> Result<(), String> {
    if slots.len() >= MOST_SLOTS {
        return Err(format!("`{path}`: the function waits for more than {MOST_SLOTS} values"));
    }
    // Of `a.layers[2]` the name is `layers`.
    let name = path.rsplit('.').next().unwrap_or(path).split('[').next().unwrap_or_default().to_owned();
    let slot = |scalar, size| Slot {
        root,
        path: path.to_owned(),
        access: access.to_owned(),
        name: name.clone(),
        scalar,
        size,
        needed,
        read: true,
        has_value,
        is_frame: false,
        source: Source::Own,
    };
    match ty {
        Type::Scalar(scalar) => slots.push(slot(*scalar, 1)),
        Type::Vector { size, scalar } => slots.push(slot(*scalar, *size)),
        Type::Matrix { columns, rows } => {
            let is_frame = (*columns, *rows) == (3, 3) && name.to_ascii_lowercase().contains("tbn");
            slots.push(Slot { is_frame, ..slot(Scalar::F32, 0) });
        }
        // What nobody reads is not spelled out, however large it is.
        _ if !needed => {}
        Type::Array { element, length } => {
            for index in 0..*length {
                let (path, access) = (format!("{path}[{index}]"), format!("{access}[{index}]"));
                walk(element, root, &path, &access, needed, has_value, compiled, slots)?;
            }
        }
        Type::Struct { members, .. } => {
            for member in members {
                let needed = needed && compiled.uses_member(&member.name);
                let (path, access) = (format!("{path}.{}", member.name), format!("{access}.{}", member.name));
                walk(&member.ty, root, &path, &access, needed, has_value, compiled, slots)?;
            }
        }
    }
    Ok(())
}

/// The slot of a path, or of the end of one where only one ends so.
fn named(slots: &[Slot], name: &str) -> Result<usize, String> {
    if let Some(index) = slots.iter().position(|slot| slot.path == name) {
        return Ok(index);
    }
    let end = format!(".{name}");
    let ends: Vec<usize> =
        (0..slots.len()).filter(|at| slots.get(*at).is_some_and(|s| s.path.ends_with(&end))).collect();
    let paths = |which: &[usize]| {
        let named = which.iter().filter_map(|at| slots.get(*at)).map(|slot| slot.path.as_str());
        named.take(40).collect::<Vec<_>>().join(", ")
    };
    match ends.as_slice() {
        [only] => Ok(*only),
        [] if slots.is_empty() => Err("the function waits for no value".to_owned()),
        [] => Err(format!(
            "there is no such value; the function waits for {}",
            paths(&(0..slots.len()).collect::<Vec<_>>())
        )),
        several => Err(format!("which of {}?", paths(several))),
    }
}

fn geometry(slot: &Slot, text: &str) -> Result<Source, String> {
    let role = Role::parse(text).map_err(|what| format!("--map {}={text}: {what}", slot.path))?;
    let fits = slot.scalar == Scalar::F32 && (role.size() == slot.size || (role.size() == 3 && slot.size == 4));
    if !fits {
        let wanted = if role.size() == 1 { "a single number" } else { "a vector of 3 numbers" };
        return Err(format!("--map {}={text}: the role is {wanted}, which `{}` is not", slot.path, slot.path));
    }
    Ok(Source::Geometry(role))
}

fn number(text: &str) -> Result<f64, String> {
    let value = match text.trim() {
        "true" => 1.0,
        "false" => 0.0,
        text => text.parse::<f64>().map_err(|_| format!("`{text}` is not a number"))?,
    };
    // A literal beyond f32 is no shader's.
    if value.abs() <= f64::from(f32::MAX) {
        Ok(value)
    } else {
        Err(format!("`{}` is not a number of 32 bits", text.trim()))
    }
}

fn numbers(slot: &Slot, text: &str) -> Result<Vec<f64>, String> {
    let of = |what: String| format!("--param {}={text}: {what}", slot.path);
    if slot.size == 0 {
        return Err(of("a matrix cannot be given".to_owned()));
    }
    let values = text.split(',').map(number).collect::<Result<Vec<_>, _>>().map_err(of)?;
    match values.len() {
        1 => Ok(values.repeat(slot.size)),
        count if count == slot.size => Ok(values),
        count => Err(of(format!("{count} numbers for {} components", slot.size))),
    }
}

fn searched(slot: &Slot, range: &str, value: Option<&str>, parameters: &mut Vec<Parameter>) -> Result<Source, String> {
    let of = |what: String| format!("--range {}={range}: {what}", slot.path);
    if slot.size == 0 {
        return Err(of("a matrix cannot be searched".to_owned()));
    }
    let (bounds, scale) = match range.split_once(':') {
        None => (range, Scale::Linear),
        Some((bounds, "log")) => (bounds, Scale::Logarithmic),
        Some((_, other)) => return Err(of(format!("`{other}` is not `log`"))),
    };
    let Some((low, high)) = bounds.split_once("..") else { return Err(of("write LO..HI or LO..HI:log".to_owned())) };
    let (low, high) = (number(low).map_err(of)?, number(high.trim_start_matches('=')).map_err(of)?);
    if low >= high {
        return Err(of("the first number must be below the second".to_owned()));
    }
    if scale == Scale::Logarithmic && low <= 0.0 {
        return Err(of("a logarithmic range begins above 0".to_owned()));
    }
    let middle = if scale == Scale::Logarithmic { (low * high).sqrt() } else { 0.5 * (low + high) };
    let default = match (value, known(&slot.name, slot.size)) {
        (Some(value), _) => number(value).map_err(|what| format!("--param {}={value}: {what}", slot.path))?,
        (None, Some(Known::Searched { default, .. } | Known::Fixed(default))) if (low..=high).contains(&default) => {
            default
        }
        _ => middle,
    };
    if !(low..=high).contains(&default) {
        return Err(of(format!("the value {default} is outside of it")));
    }
    let scale = if slot.scalar == Scalar::Bool { Scale::Switch } else { scale };
    parameters.push(Parameter { name: slot.path.clone(), low, high, default, scale });
    Ok(Source::Searched(parameters.len() - 1))
}

/// What nothing depends on: its role, for whoever reads the notes, or 0.
fn unread(slot: &Slot) -> Source {
    let role = role(&slot.name, slot.size).filter(|_| slot.scalar == Scalar::F32);
    role.map_or(Source::Own, Source::Geometry)
}

/// What the name alone says.
fn guessed(slot: &Slot, mapping: &mut Mapping) -> Option<Source> {
    if slot.is_frame {
        mapping.notes.push(format!("{} = the local frame", slot.path));
        return Some(Source::Frame);
    }
    if slot.scalar != Scalar::F32 || slot.size == 0 {
        return None;
    }
    // `light.direction` says it with what it is a part of.
    let is_part =
        matches!(slot.name.to_ascii_lowercase().as_str(), "direction" | "dir" | "vector" | "vec" | "color" | "colour");
    let name = if is_part { slot.path.replace('.', "") } else { slot.name.clone() };
    if let Some(role) = role(&name, slot.size) {
        return Some(Source::Geometry(role));
    }
    let path = &slot.path;
    let grey = if slot.size > 1 { ", the same in all components" } else { "" };
    match known(&name, slot.size).or_else(|| known(&slot.name, slot.size))? {
        Known::Fixed(value) => {
            mapping.notes.push(format!("{path} = {value} (--param {path}=… for another)"));
            Some(Source::Numbers(vec![value; slot.size]))
        }
        Known::Searched { low, high, default, scale } => {
            let log = if scale == Scale::Logarithmic { ":log" } else { "" };
            mapping.notes.push(format!(
                "{path} = {default}{grey}, searched over {low}..{high}{log} (--param {path}=… or --range {path}=… for another)"
            ));
            mapping.parameters.push(Parameter { name: path.clone(), low, high, default, scale });
            Some(Source::Searched(mapping.parameters.len() - 1))
        }
    }
}

impl Mapping {
    /// The slots that are the light or the view by their names alone, not by `--map`.
    pub(super) fn told_by_names(&self, options: &Options) -> Vec<(String, Role)> {
        let told = |slot: &Slot| match slot.source {
            Source::Geometry(role @ Role::Along(Direction::Wi | Direction::Wo, false)) if slot.read => {
                let mut said = options.maps.iter().filter_map(|map| map.split_once('='));
                let is_said = said.any(|(name, _)| slot.path.ends_with(name.trim()));
                (!is_said).then(|| (slot.path.clone(), role))
            }
            _ => None,
        };
        self.slots.iter().filter_map(told).collect()
    }
}

impl Slot {
    /// The slot's value as an expression of the language.
    pub(super) fn expression(&self, language: Language) -> Option<String> {
        let float =
            |size: usize| if language == Language::Wgsl { format!("vec{size}<f32>") } else { format!("vec{size}") };
        let scalar_name = match (language, self.scalar) {
            (Language::Wgsl, scalar) => scalar.name(),
            (Language::Glsl, Scalar::F32) => "float",
            (Language::Glsl, Scalar::I32) => "int",
            (Language::Glsl, Scalar::U32) => "uint",
            (Language::Glsl, Scalar::Bool) => "bool",
        };
        let convert = |value: String| match self.scalar {
            Scalar::F32 => value,
            Scalar::Bool => format!("({value} > 0.5)"),
            Scalar::I32 | Scalar::U32 => format!("{scalar_name}(round({value}))"),
        };
        let vector = |values: Vec<String>| match (language, self.scalar, values.len()) {
            (_, _, 1) => values.concat(),
            (Language::Wgsl, _, size) => format!("vec{size}<{scalar_name}>({})", values.join(", ")),
            (Language::Glsl, Scalar::F32, size) => format!("vec{size}({})", values.join(", ")),
            (Language::Glsl, scalar, size) => {
                format!("{}vec{size}({})", &scalar.name()[..1], values.join(", "))
            }
        };
        match &self.source {
            Source::Own => None,
            Source::Frame if language == Language::Wgsl => {
                Some("mat3x3<f32>(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)".to_owned())
            }
            Source::Frame => Some("mat3(1.0)".to_owned()),
            Source::Geometry(Role::Along(direction, negated)) => {
                let value = axis(*direction, &float(3));
                let value = if *negated { format!("(-{value})") } else { value };
                Some(if self.size == 4 { format!("{}({value}, 0.0)", float(4)) } else { value })
            }
            Source::Geometry(Role::Cosine(a, b)) => {
                use Direction::{Bitangent, Normal, Tangent, Wi, Wo};
                let component = |axis: &Direction| match axis {
                    Tangent => Some(".x"),
                    Bitangent => Some(".y"),
                    Normal => Some(".z"),
                    _ => None,
                };
                let (of, part) = match (component(a), component(b)) {
                    (Some(part), _) => (b, Some(part)),
                    (None, Some(part)) => (a, Some(part)),
                    (None, None) => (a, None),
                };
                Some(match (of, part) {
                    (Wi | Wo, Some(part)) => format!("{}{part}", axis(*of, &float(3))),
                    (_, Some(part)) => format!("clamp({}{part}, -1.0, 1.0)", axis(*of, &float(3))),
                    // Rounding must not make a cosine of more than 1, which nobody's dot product of unit vectors is.
                    (_, None) => format!("clamp(dot({}, {}), -1.0, 1.0)", axis(*a, &float(3)), axis(*b, &float(3))),
                })
            }
            Source::Numbers(values) => Some(vector(values.iter().map(|value| convert(literal(*value))).collect())),
            Source::Searched(index) => {
                let value = convert(format!("judged_p{index}_"));
                Some(vector(vec![value; self.size]))
            }
        }
    }

    /// Whether the half vector is asked for.
    pub(super) fn needs_half(&self) -> bool {
        use Direction::Half;
        match self.source {
            Source::Geometry(Role::Along(direction, _)) => direction == Half,
            Source::Geometry(Role::Cosine(a, b)) => a == Half || b == Half,
            _ => false,
        }
    }
}

fn axis(direction: Direction, vector: &str) -> String {
    match direction {
        Direction::Wi => "judged_wi".to_owned(),
        Direction::Wo => "judged_wo".to_owned(),
        Direction::Half => "judged_h".to_owned(),
        Direction::Normal => format!("{vector}(0.0, 0.0, 1.0)"),
        Direction::Tangent => format!("{vector}(1.0, 0.0, 0.0)"),
        Direction::Bitangent => format!("{vector}(0.0, 1.0, 0.0)"),
    }
}

fn literal(value: f64) -> String {
    format!("({value:?})")
}
