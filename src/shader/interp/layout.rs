//! Types as lists of scalars: how many, of which kind, and where in a buffer.

use naga::{ArraySize, Handle, Scalar, ScalarKind, Type, TypeInner};

/// The scalars that one type may flatten to.
pub(super) const MOST_LEAVES: u32 = 1 << 16;
/// How deep types may nest.
const DEEPEST: u32 = 64;

/// What a leaf holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// A real number, in this many bytes.
    Real(u8),
    Signed,
    Unsigned,
    Bool,
    /// The exponent that `frexp` gives of an f64, an i64 to naga: it can be read and converted, and nothing else.
    Exponent,
}

/// A scalar of a flattened type and its offset in a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Leaf {
    pub(super) kind: Kind,
    pub(super) offset: u32,
}

/// The flattened size of every type of a module: `Err` says what is in the way.
pub(super) struct Layout<'a> {
    module: &'a naga::Module,
    sizes: Vec<Result<Size, String>>,
}

#[derive(Clone, Copy)]
struct Size {
    leaves: u32,
    depth: u32,
}

pub(super) fn kind_of(scalar: Scalar) -> Result<Kind, String> {
    match (scalar.kind, scalar.width) {
        (ScalarKind::Float, 4 | 8) => Ok(Kind::Real(scalar.width)),
        (ScalarKind::Sint, 4) => Ok(Kind::Signed),
        (ScalarKind::Uint, 4) => Ok(Kind::Unsigned),
        (ScalarKind::Bool, _) => Ok(Kind::Bool),
        (ScalarKind::Sint, 8) => Ok(Kind::Exponent),
        (ScalarKind::Float, _) => Err("f16".to_owned()),
        (_, width) => Err(format!("integers of {} bits", 8 * u32::from(width))),
    }
}

impl<'a> Layout<'a> {
    pub(super) fn new(module: &'a naga::Module) -> Self {
        let mut sizes: Vec<Result<Size, String>> = Vec::new();
        // A type is made of types before it.
        for (_, ty) in module.types.iter() {
            let size = size_of(module, &sizes, &ty.inner);
            sizes.push(size);
        }
        Layout { module, sizes }
    }

    /// The scalars of a type; those of a runtime-sized array are left out.
    pub(super) fn leaves(&self, ty: Handle<Type>) -> Result<u32, String> {
        self.size(ty).map(|size| size.leaves)
    }

    fn size(&self, ty: Handle<Type>) -> Result<Size, String> {
        self.sizes.get(ty.index()).cloned().unwrap_or_else(|| Err("a type that is not in the module".to_owned()))
    }

    /// The scalars of a type in order, with their offsets from `offset` on.
    pub(super) fn flatten(&self, ty: Handle<Type>, offset: u32, out: &mut Vec<Leaf>) -> Result<(), String> {
        self.size(ty)?;
        match &self.module.types[ty].inner {
            TypeInner::Scalar(scalar) | TypeInner::Atomic(scalar) => {
                out.push(Leaf { kind: kind_of(*scalar)?, offset });
            }
            TypeInner::Vector { size, scalar } => vector(*size, *scalar, offset, out)?,
            TypeInner::Matrix { columns, rows, scalar } => {
                // A column of three takes the room of four.
                let stride = if *rows as u32 == 3 { 4 } else { *rows as u32 } * u32::from(scalar.width);
                for column in 0..*columns as u32 {
                    vector(*rows, *scalar, offset.saturating_add(column * stride), out)?;
                }
            }
            TypeInner::Array { base, size, stride } => {
                for index in 0..fixed_length(self.module, *size).unwrap_or(0) {
                    self.flatten(*base, offset.saturating_add(index.saturating_mul(*stride)), out)?;
                }
            }
            TypeInner::Struct { members, .. } => {
                for member in members {
                    self.flatten(member.ty, offset.saturating_add(member.offset), out)?;
                }
            }
            other => return Err(opaque(other)),
        }
        Ok(())
    }

    /// The kinds of a type's scalars.
    pub(super) fn kinds(&self, ty: Handle<Type>) -> Result<Vec<Kind>, String> {
        let mut leaves = Vec::new();
        self.flatten(ty, 0, &mut leaves)?;
        Ok(leaves.into_iter().map(|leaf| leaf.kind).collect())
    }

    /// The runtime-sized array that ends a type: its element, its stride in bytes, and where it starts.
    pub(super) fn runtime_array(&self, ty: Handle<Type>) -> Option<(Handle<Type>, u32, u32)> {
        match &self.module.types[ty].inner {
            TypeInner::Array { base, size: ArraySize::Dynamic, stride } => Some((*base, *stride, 0)),
            TypeInner::Struct { members, .. } => {
                let last = members.last()?;
                match &self.module.types[last.ty].inner {
                    TypeInner::Array { base, size: ArraySize::Dynamic, stride } => Some((*base, *stride, last.offset)),
                    _ => None,
                }
            }
            _ => None,
        }
    }
}

fn vector(size: naga::VectorSize, scalar: Scalar, offset: u32, out: &mut Vec<Leaf>) -> Result<(), String> {
    let kind = kind_of(scalar)?;
    for i in 0..size as u32 {
        out.push(Leaf { kind, offset: offset.saturating_add(i * u32::from(scalar.width)) });
    }
    Ok(())
}

/// The length of an array, none where it is only known at run time.
pub(super) fn fixed_length(module: &naga::Module, size: ArraySize) -> Option<u32> {
    match size {
        ArraySize::Constant(length) => Some(length.get()),
        ArraySize::Dynamic => None,
        ArraySize::Pending(handle) => {
            let init = module.overrides[handle].init?;
            match module.global_expressions[init] {
                naga::Expression::Literal(naga::Literal::U32(length)) => Some(length),
                naga::Expression::Literal(naga::Literal::I32(length)) => u32::try_from(length).ok(),
                _ => None,
            }
        }
    }
}

fn size_of(module: &naga::Module, sizes: &[Result<Size, String>], inner: &TypeInner) -> Result<Size, String> {
    let of = |ty: Handle<Type>| sizes.get(ty.index()).cloned().unwrap_or_else(|| Err("a type of itself".to_owned()));
    let checked = |leaves: Option<u32>, depth: u32| match leaves {
        Some(leaves) if leaves <= MOST_LEAVES && depth <= DEEPEST => Ok(Size { leaves, depth }),
        _ => Err(format!("a type of more than {MOST_LEAVES} scalars or {DEEPEST} levels")),
    };
    match inner {
        TypeInner::Scalar(scalar) | TypeInner::Atomic(scalar) => {
            kind_of(*scalar)?;
            checked(Some(1), 1)
        }
        TypeInner::Vector { size, scalar } => {
            kind_of(*scalar)?;
            checked(Some(*size as u32), 1)
        }
        TypeInner::Matrix { columns, rows, scalar } => {
            kind_of(*scalar)?;
            checked(Some(*columns as u32 * *rows as u32), 1)
        }
        TypeInner::Array { base, size, .. } => {
            let element = of(*base)?;
            let length = match size {
                ArraySize::Dynamic => 0,
                size => fixed_length(module, *size).ok_or("an array whose length is a computed override")?,
            };
            checked(element.leaves.checked_mul(length), element.depth + 1)
        }
        TypeInner::Struct { members, .. } => {
            let (mut leaves, mut depth) = (Some(0u32), 1);
            for member in members {
                let size = of(member.ty)?;
                leaves = leaves.and_then(|sum| sum.checked_add(size.leaves));
                depth = depth.max(size.depth + 1);
            }
            checked(leaves, depth)
        }
        // A pointer is no value, and its type is in the arena all the same.
        other => Err(opaque(other)),
    }
}

/// What kind of type has no scalars.
fn opaque(inner: &TypeInner) -> String {
    match inner {
        TypeInner::Image { .. } => "a texture",
        TypeInner::Sampler { .. } => "a sampler",
        TypeInner::AccelerationStructure { .. } | TypeInner::RayQuery { .. } => "ray tracing",
        TypeInner::BindingArray { .. } => "a binding array",
        TypeInner::CooperativeMatrix { .. } => "a cooperative matrix",
        TypeInner::Pointer { .. } | TypeInner::ValuePointer { .. } => "a pointer as a value",
        _ => "a type without a value",
    }
    .to_owned()
}
