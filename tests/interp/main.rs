//! The evaluator of WGSL: the twins mean what the Rust functions compute, and other shaders what WGSL says.
#![cfg(feature = "gpu")]

mod twins;
