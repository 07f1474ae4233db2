//! The stacks that a command is given: built-in names and stack files.

use brdf::Real;
use brdf::layered::description::{Description, DescriptionError};
use brdf::layered::{Model, Stack};
use brdf::material::stack;
use std::path::Path;

/// A stack of one channel or three.
#[derive(Clone, Debug)]
pub(crate) enum AnyStack {
    One(Stack<f64, 1>),
    Three(Stack<f64, 3>),
}

impl AnyStack {
    /// The stack of a description, under another model if one is given.
    pub(crate) fn new(description: &Description, model: Option<Model>) -> Result<Self, DescriptionError> {
        let stack = match description.channels() {
            1 => AnyStack::One(description.stack()?),
            _ => AnyStack::Three(description.stack()?),
        };
        Ok(stack.with_model(model))
    }

    /// The same stack under another model, if one is given.
    pub(crate) fn with_model(self, model: Option<Model>) -> Self {
        match (self, model) {
            (AnyStack::One(stack), Some(model)) => AnyStack::One(stack.with_model(model)),
            (AnyStack::Three(stack), Some(model)) => AnyStack::Three(stack.with_model(model)),
            (stack, None) => stack,
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
    pub(crate) fn evaluate<R: Real>(&self, wi: brdf::Vector<R>, wo: brdf::Vector<R>) -> Vec<R> {
        match self {
            AnyStack::One(stack) => stack.cast::<R>().evaluate(wi, wo).to_vec(),
            AnyStack::Three(stack) => stack.cast::<R>().evaluate(wi, wo).to_vec(),
        }
    }

    pub(crate) fn model(&self) -> Model {
        match self {
            AnyStack::One(stack) => stack.model(),
            AnyStack::Three(stack) => stack.model(),
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

/// Every built-in material.
pub(crate) fn built_in() -> Vec<Material> {
    let material = |m: stack::BuiltIn| Material { name: m.name.to_owned(), stack: AnyStack::Three(m.stack) };
    stack::built_in().into_iter().map(material).collect()
}

/// The built-in material of this name, else the one in the stack file of this path.
pub(crate) fn load(name: &str, model: Option<Model>) -> Result<Material, String> {
    if let Some(stack) = stack::by_name(name) {
        return Ok(Material { name: name.to_owned(), stack: AnyStack::Three(stack).with_model(model) });
    }
    if !Path::new(name).exists() {
        return Err(format!("{name} is neither a built-in material (see `brdf list`) nor a file"));
    }
    let text = std::fs::read_to_string(name).map_err(|error| format!("{name}: {error}"))?;
    let locate = |error: DescriptionError| format!("{name}: {error}");
    let description = Description::from_toml(&text).map_err(locate)?;
    let stack = AnyStack::new(&description, model).map_err(locate)?;
    Ok(Material { name: description.name.unwrap_or_else(|| name.to_owned()), stack })
}

/// Reads the name of a model.
pub(crate) fn model(name: &str) -> Result<Model, String> {
    Model::from_name(name)
        .ok_or_else(|| format!("`{name}` is no model; there are {}", Model::ALL.map(Model::name).join(", ")))
}
