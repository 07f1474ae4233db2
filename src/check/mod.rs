//! The judge of physical plausibility.
mod chart;
mod crosscheck;
pub mod energy;
mod lobes;
mod quadrature;
pub mod subject;
pub mod verdict;
#[cfg(test)]
mod corpus;
pub use energy::{Albedo, Effort, albedo};
pub use subject::{Fixed, FromFn, Subject, from_fn};
pub use verdict::{TOLERANCE, Verdict};
