//! Measured data and the stacks built of it.
//!
//! [`metal`] holds indices of refraction, [`stack`] the built-in stacks, [`patina`] the documents' patina terms. [`brushed`]
//! is a metal with a grain, [`kubelka_munk`] a film that scatters, [`flake`] the documents' flakes and [`glint`] flakes whose
//! energy is the same at every distance.

pub mod brushed;
pub mod flake;
pub mod glint;
pub mod kubelka_munk;
pub mod metal;
pub mod patina;
pub mod stack;
