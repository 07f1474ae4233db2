//! Evaluates WGSL on the CPU: any function of any valid module, in f32, f64 or intervals.
//!
//! A [`Program`] runs one function over rows of arguments, a block of rows at a time: each instruction runs over all lanes
//! of the block before the next one does, and masks tell which lanes a branch or loop concerns. The number type is a
//! parameter:
//!
//! | number | shader from | what it tells |
//! |---|---|---|
//! | `f32` | [`Shader::parse`] | what a device computes, within what WGSL allows |
//! | `f64` | [`Shader::in_double`] | what the shader means, apart from its rounding |
//! | [`WgslInterval`](crate::interval::WgslInterval) | [`Shader::in_double`] | everything that WGSL's accuracy table allows |
//!
//! # Intervals
//!
//! A comparison may stay open. `select` and the logical operators go on with what is known; a branch, a loop or a whole
//! number that depends on it makes the lane go on as several lanes, one for each way, and the results of a row are the hull
//! of all of them. A row that would need more than [`MOST_WAYS`] lanes, or that does not end, has unbounded results; so
//! has a row that the steps of its block no longer suffice for.
//!
//! A subnormal argument, literal or number of a buffer may count as 0, as WGSL allows.
//!
//! # Speed
//!
//! In f32 on one thread about 60 million rows a second of `distribution::ggx`, an eighth of the vectorised native loop, and
//! 0.75 million of `layered::conserving` over a metal, a ninth to a fourteenth (`examples/interp_speed.rs`).
//!
//! # What differs from a device
//!
//! * An index out of bounds, taken as unsigned, means the last element: `a[-1]` too. Integers wrap, x/0 = x, x % 0 = 0, as WGSL has it.
//! * Invocations of a plain function are workgroups of one. Those of an entry point run in lockstep as a workgroup.
//! * Textures, derivatives, `discard`, subgroups, ray tracing, `f16` and integers of other than 32 bits are refused.
//! * A program that takes too many steps ends with an error, over intervals with unbounded results: see
//!   [`Program::with_budget`].

mod bounds;
mod code;
mod depth;
mod error;
mod layout;
mod lower;
mod machine;
mod mask;
mod number;
mod opaque;
mod program;
mod retype;
mod words;

pub(crate) use depth::bounded;
pub use error::InterpError;
#[doc(hidden)]
pub use number::{Number, Whole};
pub use program::{Buffers, Cell, MOST_WAYS, Program};

use crate::shader::{Module, ShaderError};

/// A method of [`Real`](crate::Real) that a function of the shader is known to stand for.
///
/// A call of such a function becomes the method. Interval arithmetic cannot see that the two halves of an error-free
/// transformation cancel, and in double precision a polynomial good to f32 is a formula of its own: what such functions
/// do is tested by themselves, and not again in everything that calls them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Known {
    /// [`Real::sum_exact`](crate::Real::sum_exact), two results.
    SumExact,
    /// [`Real::product_exact`](crate::Real::product_exact), two results.
    ProductExact,
    /// [`Real::exp_product`](crate::Real::exp_product).
    ExpProduct,
    /// [`Real::ln_one_plus`](crate::Real::ln_one_plus).
    LnOnePlus,
    /// [`Real::angle`](crate::Real::angle).
    Angle,
    /// [`Real::erfcx`](crate::Real::erfcx).
    Erfcx,
    /// [`Real::unit_circle`](crate::Real::unit_circle), two results.
    UnitCircle,
}

/// A WGSL module to evaluate, as written or in double precision.
#[derive(Clone, Debug)]
pub struct Shader {
    /// What is evaluated.
    module: Module,
    /// The module as written, where the other is in double precision: buffers are laid out by it.
    written: Option<Module>,
    text: String,
}

impl Shader {
    /// Parses a module, to be evaluated as written: literals are rounded to f32.
    ///
    /// # Errors
    /// Those of [`Module::parse`]; more than 500 operators around one operand or 250 `else if` around one statement.
    pub fn parse(source: &str) -> Result<Self, ShaderError> {
        depth::bounded(source)?;
        Ok(Shader { module: Module::parse(source)?, written: None, text: source.to_owned() })
    }

    /// Parses a module, to be evaluated in double precision: each `f32` is an `f64`, and literals are exact to that.
    ///
    /// Where a number meets its bits (`bitcast`, `pack2x16float` and their kin) it is rounded to f32. Arguments, results
    /// and buffers stay as written.
    ///
    /// # Errors
    /// Those of [`Shader::parse`]; `f16`; and, rarely, a module that is only valid in single precision. Such a module
    /// passes f32 between shader stages, or has constants whose types ask for constants of floating point: an array length
    /// or a `case` computed from some within a function, a vector constant made of another vector constant, arithmetic of
    /// whole numbers converted (`f32(2u) * f32(N)`). naga computes no constants of f64; others are kept from it.
    pub fn in_double(source: &str) -> Result<Self, ShaderError> {
        depth::bounded(source)?;
        let written = Module::parse(source)?;
        let text = retype::in_double(source, &written)?;
        let (module, text) = match Module::parse(&text) {
            Ok(module) => (module, text),
            Err(error) => {
                Self::unfolded(source).map_err(|_| ShaderError::plain(format!("in double precision, {error}")))?
            }
        };
        Ok(Shader { module, written: Some(written), text })
    }

    /// The module in double precision and its text, where it has constant expressions of floating point.
    fn unfolded(source: &str) -> Result<(Module, String), ShaderError> {
        let text = opaque::unfolded(source)?;
        let text = retype::in_double(&text, &Module::parse(&text)?)?;
        Ok((Module::parse(&text)?, text))
    }

    /// The module as written.
    pub fn written(&self) -> &Module {
        self.written.as_ref().unwrap_or(&self.module)
    }

    fn text(&self) -> &str {
        &self.text
    }
}
