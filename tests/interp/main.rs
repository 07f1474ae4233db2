//! The evaluator of WGSL: the twins mean what the Rust functions compute, and other shaders what WGSL says.
#![cfg(feature = "gpu")]

#[path = "../adapters/mod.rs"]
mod adapters;
mod builtins;
mod confirmed;
mod hostile;
mod intervals;
mod programs;
mod twins;
