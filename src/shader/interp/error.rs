//! Why a function cannot be evaluated.

use crate::shader::ShaderError;
use core::fmt;

/// Why a program was not made or did not end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum InterpError {
    /// The WGSL is invalid, or the function is missing.
    Shader(ShaderError),
    /// A part of WGSL that the evaluator does not know: textures, derivatives, `f16`, subgroups.
    Unsupported {
        /// What it is.
        what: String,
        /// The function that uses it.
        function: String,
        /// The line of the source, from 1.
        line: Option<u32>,
    },
    /// More of something than the evaluator takes: instructions, registers, nesting.
    TooLarge(String),
    /// Arguments or buffers that do not fit the function.
    Arguments(String),
    /// More steps than the budget allows: a loop that does not end, or takes too long.
    Budget(u64),
    /// A control flow that an interval leaves open decides what is written to memory that invocations share.
    Open,
}

impl fmt::Display for InterpError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            InterpError::Shader(error) => error.fmt(f),
            InterpError::Unsupported { what, function, line: Some(line) } => {
                write!(f, "line {line}: `{function}` uses {what}, which the evaluator does not support")
            }
            InterpError::Unsupported { what, function, line: None } => {
                write!(f, "`{function}` uses {what}, which the evaluator does not support")
            }
            InterpError::TooLarge(what) => write!(f, "{what}"),
            InterpError::Arguments(reason) => f.write_str(reason),
            InterpError::Budget(steps) => {
                write!(f, "not finished after {steps} steps: a loop that does not end? `with_budget` allows more")
            }
            InterpError::Open => f.write_str(
                "intervals leave a branch open, and the function writes to memory that its invocations share",
            ),
        }
    }
}

impl std::error::Error for InterpError {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        match self {
            InterpError::Shader(error) => Some(error),
            _ => None,
        }
    }
}

impl From<ShaderError> for InterpError {
    fn from(error: ShaderError) -> Self {
        InterpError::Shader(error)
    }
}
