//! The stacks that a command is given: built-in names and stack files.

use brdf::layered::description::{Description, DescriptionError, Node, Value};
use brdf::layered::{Model, Stack, Widths};
use brdf::material::description::MaterialFile;
use brdf::material::finish::Body;
use brdf::material::{Part, built_in, stack};
use brdf::render::texture;
use brdf::{Real, Vector, walk};
use std::path::Path;

/// What a command asks of every stack in place of what the stack says.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Change {
    pub(crate) model: Option<Model>,
    pub(crate) widths: Option<Widths>,
}

/// A stack of one channel or three.
#[derive(Clone, Debug)]
pub(crate) enum AnyStack {
    One(Stack<f64, 1>),
    Three(Stack<f64, 3>),
}

impl AnyStack {
    /// The stack of a description, changed.
    pub(crate) fn new(description: &Description, change: Change) -> Result<Self, DescriptionError> {
        let stack = match description.channels() {
            1 => AnyStack::One(description.stack()?),
            _ => AnyStack::Three(description.stack()?),
        };
        Ok(stack.changed(change))
    }

    /// The same layers under another model and rule of widths.
    pub(crate) fn changed(self, change: Change) -> Self {
        fn one<const C: usize>(stack: Stack<f64, C>, change: Change) -> Stack<f64, C> {
            let model = change.model.unwrap_or(stack.model());
            let stack = stack.with_model(model);
            match change.widths {
                Some(widths) => stack.with_widths(widths),
                None => stack,
            }
        }
        match self {
            AnyStack::One(stack) => AnyStack::One(one(stack, change)),
            AnyStack::Three(stack) => AnyStack::Three(one(stack, change)),
        }
    }

    /// The stack over three channels, as the twins take it.
    pub(crate) fn three(&self) -> Stack<f64, 3> {
        match self {
            AnyStack::One(stack) => stack.cast::<f64>().broadcast(),
            AnyStack::Three(stack) => stack.cast(),
        }
    }

    /// The same in f32.
    pub(crate) fn three_single(&self) -> Stack<f32, 3> {
        self.three().cast()
    }

    /// The BRDF in a number type, a value for each channel.
    pub(crate) fn evaluate<R: Real>(&self, wi: Vector<R>, wo: Vector<R>) -> Vec<R> {
        match self {
            AnyStack::One(stack) => stack.cast::<R>().evaluate(wi, wo).to_vec(),
            AnyStack::Three(stack) => stack.cast::<R>().evaluate(wi, wo).to_vec(),
        }
    }

    /// The f of the walk and its standard error, for each channel.
    pub(crate) fn walk(&self, wi: Vector<f64>, wo: Vector<f64>, options: &walk::Options) -> (Vec<f64>, Vec<f64>) {
        fn one<const C: usize>(estimate: walk::Estimate<C>) -> (Vec<f64>, Vec<f64>) {
            (estimate.mean.to_vec(), estimate.standard_error.to_vec())
        }
        match self {
            AnyStack::One(stack) => one(walk::evaluate(stack, wi, wo, options)),
            AnyStack::Three(stack) => one(walk::evaluate(stack, wi, wo, options)),
        }
    }

    pub(crate) fn model(&self) -> Model {
        match self {
            AnyStack::One(stack) => stack.model(),
            AnyStack::Three(stack) => stack.model(),
        }
    }

    /// How many layers there are.
    pub(crate) fn layers(&self) -> usize {
        match self {
            AnyStack::One(stack) => stack.layers().len(),
            AnyStack::Three(stack) => stack.layers().len(),
        }
    }

    pub(crate) fn channels(&self) -> usize {
        match self {
            AnyStack::One(_) => 1,
            AnyStack::Three(_) => 3,
        }
    }
}

/// A stack under a name.
#[derive(Clone, Debug)]
pub(crate) struct Material {
    pub(crate) name: String,
    pub(crate) stack: AnyStack,
}

/// Every built-in stack.
pub(crate) fn stacks() -> Vec<Material> {
    let material = |m: stack::BuiltIn| Material { name: m.name.to_owned(), stack: AnyStack::Three(m.stack) };
    stack::built_in().into_iter().map(material).collect()
}

/// A material that varies over a surface, which is no single stack.
pub(crate) enum Varying {
    /// It is built in under its name.
    BuiltIn,
    /// What a material file describes.
    File(Box<MaterialFile>),
}

/// Whether a stack or a material of this name is built in.
pub(crate) fn is_built_in(name: &str) -> bool {
    stack::by_name(name).is_some() || built_in::by_name(name).is_some()
}

/// The first part of a material whose stack is under the model `walk`.
pub(crate) fn walking_part(material: &brdf::material::Material) -> Option<usize> {
    let walks = |part: &Part| matches!(&part.finish.body, Body::Whole(stack) if stack.model() == Model::Walk);
    material.parts().iter().position(walks)
}

/// The material that a name or a file stands for; nothing where it is a stack, or neither.
pub(crate) fn varying(name: &str) -> Result<Option<Varying>, String> {
    if stack::by_name(name).is_some() {
        return Ok(None);
    }
    if built_in::by_name(name).is_some() {
        return Ok(Some(Varying::BuiltIn));
    }
    if !Path::new(name).is_file() {
        return Ok(None);
    }
    let text = text_of(name)?;
    Ok(described(name, &text)?.map(|file| Varying::File(Box::new(file))))
}

fn text_of(name: &str) -> Result<String, String> {
    std::fs::read_to_string(name).map_err(|error| format!("{name}: {error}"))
}

/// The material that the text of a file describes; nothing where it is a stack.
pub(crate) fn described(name: &str, text: &str) -> Result<Option<MaterialFile>, String> {
    let node = Node::from_toml(text).map_err(|error| format!("{name}: {error}"))?;
    is_material(&node).then(|| texture::parse_material(Path::new(name), text)).transpose()
}

/// Whether a tree is a material's, which has parts or is one that is built in, and no stack's, which has layers of its own.
fn is_material(node: &Node) -> bool {
    let Value::Table(entries) = &node.value else { return false };
    entries.iter().any(|(key, _)| matches!(key.as_str(), "part" | "material"))
}

/// The built-in stack of this name, else the one in the stack file of this path.
pub(crate) fn load(name: &str, change: Change) -> Result<Material, String> {
    if let Some(stack) = stack::by_name(name) {
        return Ok(Material { name: name.to_owned(), stack: AnyStack::Three(stack).changed(change) });
    }
    if built_in::by_name(name).is_some() {
        return Err(varies(name));
    }
    if !Path::new(name).exists() {
        return Err(format!("{name} is neither a built-in stack or material (see `brdf list`) nor a file"));
    }
    read(name, &text_of(name)?, change)
}

/// The stack in the text of a file.
pub(crate) fn read(name: &str, text: &str, change: Change) -> Result<Material, String> {
    let locate = |error: DescriptionError| format!("{name}: {error}");
    let description = Description::from_toml(text).map_err(|error| match Node::from_toml(text) {
        Ok(node) if is_material(&node) => varies(name),
        _ => locate(error),
    })?;
    let stack = AnyStack::new(&description, change).map_err(locate)?;
    Ok(Material { name: description.name.unwrap_or_else(|| name.to_owned()), stack })
}

fn varies(name: &str) -> String {
    format!(
        "{name} is a material that varies over a surface, and a stack is wanted; `brdf check` judges it, `brdf render` shows it"
    )
}

/// Reads the name of a model.
pub(crate) fn model(name: &str) -> Result<Model, String> {
    Model::from_name(name)
        .ok_or_else(|| format!("`{name}` is no model; there are {}", Model::ALL.map(Model::name).join(", ")))
}

/// Reads the name of a rule of widths.
pub(crate) fn widths(name: &str) -> Result<Widths, String> {
    Widths::from_name(name)
        .ok_or_else(|| format!("`{name}` is no rule of widths; there are {}", Widths::ALL.map(Widths::name).join(", ")))
}
