//! What a WGSL function takes and returns, flattened to 32-bit words.
//!
//! A row is the concatenation of the words of all arguments in their order: vectors by component, matrices column by
//! column, arrays by element, structs by member, without padding. A `bool` is a word that is 0 or not, 1 in results.

use core::fmt;

/// The words of one row above which a function is refused: kernels spell out each of them.
const MOST_WORDS: usize = 4096;

/// A 32-bit scalar of WGSL.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Scalar {
    /// `f32`.
    F32,
    /// `u32`.
    U32,
    /// `i32`.
    I32,
    /// `bool`, in a word of its own.
    Bool,
}

impl Scalar {
    /// The name in WGSL.
    pub fn name(self) -> &'static str {
        match self {
            Scalar::F32 => "f32",
            Scalar::U32 => "u32",
            Scalar::I32 => "i32",
            Scalar::Bool => "bool",
        }
    }
}

impl fmt::Display for Scalar {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A type made of 32-bit scalars. Displays as it is written in WGSL.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Type {
    /// `f32`, `u32`, `i32` or `bool`.
    Scalar(Scalar),
    /// `vecN<scalar>`, N from 2 to 4.
    Vector {
        /// The number of components.
        size: usize,
        /// Their type.
        scalar: Scalar,
    },
    /// `matCxR<f32>`, stored column by column.
    Matrix {
        /// The number of columns, from 2 to 4.
        columns: usize,
        /// The number of rows, from 2 to 4.
        rows: usize,
    },
    /// `array<element, length>`.
    Array {
        /// The type of one element.
        element: Box<Type>,
        /// The number of elements.
        length: usize,
    },
    /// A struct of the module.
    Struct {
        /// Its name.
        name: String,
        /// Its members in the order of declaration.
        members: Vec<Member>,
    },
}

/// A named part of a struct.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Member {
    /// The name in the module.
    pub name: String,
    /// The type.
    pub ty: Type,
}

/// One scalar of a flattened type.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Leaf {
    /// The path in WGSL: `cos_i`, `w.x`, `layers[1].alpha`, `m[0].y` (column 0).
    pub name: String,
    /// What the word holds.
    pub scalar: Scalar,
}

impl Type {
    /// The number of 32-bit words that the type flattens to.
    pub fn words(&self) -> usize {
        match self {
            Type::Scalar(_) => 1,
            Type::Vector { size, .. } => *size,
            Type::Matrix { columns, rows } => columns * rows,
            Type::Array { element, length } => element.words().saturating_mul(*length),
            Type::Struct { members, .. } => members.iter().fold(0, |sum, m| sum.saturating_add(m.ty.words())),
        }
    }

    /// The scalars that the type flattens to, in order, with paths that start at `root`.
    ///
    /// Under an empty root the members of a struct stand alone.
    pub fn leaves(&self, root: &str) -> Vec<Leaf> {
        let mut leaves = Vec::new();
        self.push_leaves(root, &mut leaves);
        leaves
    }

    fn push_leaves(&self, path: &str, leaves: &mut Vec<Leaf>) {
        let components = ["x", "y", "z", "w"];
        match self {
            Type::Scalar(scalar) => leaves.push(Leaf { name: path.to_owned(), scalar: *scalar }),
            Type::Vector { size, scalar } => {
                for component in &components[..*size] {
                    leaves.push(Leaf { name: join(path, component), scalar: *scalar });
                }
            }
            Type::Matrix { columns, rows } => {
                for column in 0..*columns {
                    Type::Vector { size: *rows, scalar: Scalar::F32 }.push_leaves(&format!("{path}[{column}]"), leaves);
                }
            }
            Type::Array { element, length } => {
                for index in 0..*length {
                    element.push_leaves(&format!("{path}[{index}]"), leaves);
                }
            }
            Type::Struct { members, .. } => {
                for member in members {
                    member.ty.push_leaves(&join(path, &member.name), leaves);
                }
            }
        }
    }

    /// A scalar, or a vector where there is a size.
    pub(super) fn of_value(size: Option<naga::VectorSize>, scalar: naga::Scalar) -> Result<Self, String> {
        let scalar = scalar_of(scalar)?;
        Ok(size.map_or(Type::Scalar(scalar), |size| Type::Vector { size: size as usize, scalar }))
    }

    /// The flattened form of a type of naga's, or what kind of type it is that has none.
    pub(super) fn of(module: &naga::Module, handle: naga::Handle<naga::Type>) -> Result<Self, String> {
        let ty = &module.types[handle];
        match &ty.inner {
            naga::TypeInner::Scalar(scalar) => Ok(Type::Scalar(scalar_of(*scalar)?)),
            naga::TypeInner::Vector { size, scalar } => {
                Ok(Type::Vector { size: *size as usize, scalar: scalar_of(*scalar)? })
            }
            naga::TypeInner::Matrix { columns, rows, scalar } => match scalar_of(*scalar)? {
                Scalar::F32 => Ok(Type::Matrix { columns: *columns as usize, rows: *rows as usize }),
                other => Err(format!("a matrix of {other}")),
            },
            naga::TypeInner::Array { base, size, .. } => {
                let length = match size {
                    naga::ArraySize::Constant(length) => length.get() as usize,
                    naga::ArraySize::Pending(_) => return Err("an array whose length is an override".to_owned()),
                    naga::ArraySize::Dynamic => return Err("a runtime-sized array".to_owned()),
                };
                Ok(Type::Array { element: Box::new(Type::of(module, *base)?), length })
            }
            naga::TypeInner::Struct { members, .. } => {
                let name = ty.name.clone().unwrap_or_default();
                if name.is_empty() || name.starts_with("__") {
                    return Err("a struct that WGSL has no name for".to_owned());
                }
                let members = members.iter().enumerate().map(|(index, member)| {
                    let member_name = member.name.clone().unwrap_or_else(|| format!("member{index}"));
                    match Type::of(module, member.ty) {
                        Ok(ty) => Ok(Member { name: member_name, ty }),
                        Err(what) => Err(format!("{what}, in the member `{member_name}` of `{name}`")),
                    }
                });
                let members = members.collect::<Result<_, _>>()?;
                Ok(Type::Struct { name, members })
            }
            naga::TypeInner::Pointer { .. } | naga::TypeInner::ValuePointer { .. } => Err("a pointer".to_owned()),
            naga::TypeInner::Atomic(_) => Err("an atomic".to_owned()),
            naga::TypeInner::Image { .. } => Err("a texture".to_owned()),
            naga::TypeInner::Sampler { .. } => Err("a sampler".to_owned()),
            _ => Err("a resource, not a value".to_owned()),
        }
    }
}

impl fmt::Display for Type {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Type::Scalar(scalar) => scalar.fmt(f),
            Type::Vector { size, scalar } => write!(f, "vec{size}<{scalar}>"),
            Type::Matrix { columns, rows } => write!(f, "mat{columns}x{rows}<f32>"),
            Type::Array { element, length } => write!(f, "array<{element}, {length}>"),
            Type::Struct { name, .. } => f.write_str(name),
        }
    }
}

/// A named argument of a function.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Parameter {
    /// The name in the module.
    pub name: String,
    /// The type.
    pub ty: Type,
}

/// What a function takes and returns. Displays as its declaration in WGSL.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Signature {
    /// The function's name.
    pub name: String,
    /// Its arguments in order.
    pub parameters: Vec<Parameter>,
    /// What it returns, if anything.
    pub result: Option<Type>,
}

impl Signature {
    /// The number of words in one row of arguments.
    pub fn input_words(&self) -> usize {
        self.parameters.iter().fold(0, |sum, parameter| sum.saturating_add(parameter.ty.words()))
    }

    /// The number of words in one row of results; 0 where nothing is returned.
    pub fn output_words(&self) -> usize {
        self.result.as_ref().map_or(0, Type::words)
    }

    /// The scalars of one row of arguments.
    pub fn inputs(&self) -> Vec<Leaf> {
        self.parameters.iter().flat_map(|parameter| parameter.ty.leaves(&parameter.name)).collect()
    }

    /// The scalars of one row of results: a struct's members under their own names, anything else under `value`.
    pub fn outputs(&self) -> Vec<Leaf> {
        match &self.result {
            None => Vec::new(),
            Some(result @ Type::Struct { .. }) => result.leaves(""),
            Some(result) => result.leaves("value"),
        }
    }

    pub(super) fn of(module: &naga::Module, name: &str, function: &naga::Function) -> Result<Self, String> {
        let refuse = |part: String, what: String| {
            format!(
                "{part} of `{name}` is {what}: only f32, u32, i32, bool and types made of them can be rows of words"
            )
        };
        let parameters = function.arguments.iter().enumerate().map(|(index, argument)| {
            let parameter = argument.name.clone().unwrap_or_else(|| format!("argument{index}"));
            match Type::of(module, argument.ty) {
                Ok(ty) => Ok(Parameter { name: parameter, ty }),
                Err(what) => Err(refuse(format!("the parameter `{parameter}`"), what)),
            }
        });
        let parameters = parameters.collect::<Result<_, _>>()?;
        let result = match &function.result {
            Some(result) => Some(Type::of(module, result.ty).map_err(|what| refuse("the result".to_owned(), what))?),
            None => None,
        };
        let signature = Signature { name: name.to_owned(), parameters, result };
        let words = signature.input_words().max(signature.output_words());
        if words > MOST_WORDS {
            return Err(format!("`{name}` takes or returns {words} words: {MOST_WORDS} are the most a row may have"));
        }
        Ok(signature)
    }
}

impl fmt::Display for Signature {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "fn {}(", self.name)?;
        for (index, parameter) in self.parameters.iter().enumerate() {
            let separator = if index == 0 { "" } else { ", " };
            write!(f, "{separator}{}: {}", parameter.name, parameter.ty)?;
        }
        match &self.result {
            Some(result) => write!(f, ") -> {result}"),
            None => write!(f, ")"),
        }
    }
}

fn join(path: &str, part: &str) -> String {
    if path.is_empty() { part.to_owned() } else { format!("{path}.{part}") }
}

fn scalar_of(scalar: naga::Scalar) -> Result<Scalar, String> {
    match (scalar.kind, scalar.width) {
        (naga::ScalarKind::Float, 4) => Ok(Scalar::F32),
        (naga::ScalarKind::Uint, 4) => Ok(Scalar::U32),
        (naga::ScalarKind::Sint, 4) => Ok(Scalar::I32),
        (naga::ScalarKind::Bool, _) => Ok(Scalar::Bool),
        (naga::ScalarKind::Float, width) => Err(format!("f{}", 8 * width)),
        (naga::ScalarKind::Uint, width) => Err(format!("u{}", 8 * width)),
        (naga::ScalarKind::Sint, width) => Err(format!("i{}", 8 * width)),
        (naga::ScalarKind::AbstractInt | naga::ScalarKind::AbstractFloat, _) => Err("an abstract number".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::Module;

    fn names(leaves: &[super::Leaf]) -> Vec<String> {
        leaves.iter().map(|leaf| format!("{}:{}", leaf.name, leaf.scalar)).collect()
    }

    #[test]
    fn types_flatten_in_order() {
        let source = "
            alias Spectrum = vec3f;
            struct Layer { alpha: f32, eta: Spectrum, on: bool }
            struct Fresnel { reflectance: f32, w: vec2<f32> }
            fn f(c: f32, l: array<Layer, 2>, m: mat2x3<f32>, i: i32, n: vec2<u32>) -> Fresnel {
                return Fresnel(c, vec2f(0.0));
            }
            fn g(x: vec3<bool>) -> mat2x2f { return mat2x2f(); }
            fn none() {}";
        let module = Module::parse(source).unwrap();
        let f = module.function("f").unwrap();
        let want = "fn f(c: f32, l: array<Layer, 2>, m: mat2x3<f32>, i: i32, n: vec2<u32>) -> Fresnel";
        assert_eq!(f.to_string(), want);
        assert_eq!(f.input_words(), 1 + 2 * 5 + 6 + 1 + 2);
        assert_eq!(f.output_words(), 3);
        let leaves = names(&f.inputs());
        assert_eq!(leaves.len(), f.input_words());
        assert_eq!(
            leaves[1..6],
            ["l[0].alpha:f32", "l[0].eta.x:f32", "l[0].eta.y:f32", "l[0].eta.z:f32", "l[0].on:bool"]
        );
        assert_eq!(leaves[11..15], ["m[0].x:f32", "m[0].y:f32", "m[0].z:f32", "m[1].x:f32"]);
        assert_eq!(leaves[17..], ["i:i32", "n.x:u32", "n.y:u32"]);
        assert_eq!(names(&f.outputs()), ["reflectance:f32", "w.x:f32", "w.y:f32"]);

        let g = module.function("g").unwrap();
        assert_eq!(names(&g.inputs()), ["x.x:bool", "x.y:bool", "x.z:bool"]);
        assert_eq!(names(&g.outputs()), ["value[0].x:f32", "value[0].y:f32", "value[1].x:f32", "value[1].y:f32"]);
        assert_eq!(module.function("none").unwrap().result, None);
    }

    #[test]
    fn other_types_are_refused_by_parameter() {
        let cases = [
            ("fn f(x: f32, p: ptr<function, f32>) -> f32 { return x; }", "`p`", "a pointer"),
            ("fn f(image: texture_2d<f32>) -> f32 { return 0.0; }", "`image`", "a texture"),
            ("fn f(s: sampler) -> f32 { return 0.0; }", "`s`", "a sampler"),
            ("enable f16; fn f(h: vec2<f16>) -> f32 { return 0.0; }", "`h`", "f16"),
            ("fn f(d: f64) -> f32 { return 0.0; }", "`d`", "f64"),
            ("struct S { a: f32, b: f64 } fn f(s: S) -> f32 { return 0.0; }", "`s`", "f64, in the member `b` of `S`"),
            ("fn f(x: f32) -> f64 { return 0.0; }", "the result", "f64"),
            ("fn f(x: array<array<f32, 100>, 100>) -> f32 { return 0.0; }", "`f`", "10000 words"),
        ];
        for (source, part, what) in cases {
            let error = Module::parse(source).unwrap().function("f").unwrap_err().to_string();
            assert!(error.contains(part) && error.contains(what), "{error}");
        }
    }
}
