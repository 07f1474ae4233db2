//! What to judge, from the arguments: built-in materials, stack files.

use crate::material::{self, AnyStack, Change, Material};
use brdf::check::{Family, StackSubject, Subject};
use brdf::layered::Model;

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
}

/// The stacks that are asked for: by name, or every built-in one.
pub(super) fn stacks(names: &[String], change: Change) -> Result<Vec<Material>, String> {
    let materials: Vec<Material> = if names.is_empty() {
        let judged = |m: Material| Material { stack: m.stack.changed(change), ..m };
        material::built_in().into_iter().map(judged).collect()
    } else {
        // Every file is read before the first is judged: bad input stops the command early.
        names.iter().map(|name| material::load(name, change)).collect::<Result<_, _>>()?
    };
    match materials.iter().find(|material| material.stack.model() == Model::Walk) {
        None => Ok(materials),
        Some(noisy) => Err(format!(
            "{}: the walk's f is a mean of random numbers, whose noise would be judged in place of the stack; use --model \
             coupled, or `brdf bench layered`",
            noisy.name
        )),
    }
}

/// A stack as a subject.
pub(super) fn from_stack(material: Material) -> Loaded {
    let Material { name, stack } = material;
    let subject: Box<dyn Subject> = match stack.clone() {
        AnyStack::One(stack) => Box::new(StackSubject::new(name, stack)),
        AnyStack::Three(stack) => Box::new(StackSubject::new(name, stack)),
    };
    Loaded { judged: Judged::Subject(subject), kind: stack.model().name().to_owned(), stack: Some(stack) }
}
