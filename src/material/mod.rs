//! Measured data and the stacks built of it.
//!
//! [`metal`] holds indices of refraction, [`stack`] the built-in stacks, [`patina`] the documents' patina terms.

pub mod metal;
pub mod patina;
pub mod stack;
