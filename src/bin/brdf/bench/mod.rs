//! `brdf bench`: run time against error.

mod chart;
mod clock;
mod document;
mod host;
mod layered;
mod machine;
mod materials;
mod offline;
mod shaders;
mod terms;
mod timed;

use crate::failure::Failure;
use clap::{Args, Subcommand};
use std::process::ExitCode;

/// What `brdf bench` is asked for.
#[derive(Args)]
pub(crate) struct Options {
    #[command(subcommand)]
    subject: Subject,
}

#[derive(Subcommand)]
enum Subject {
    /// Every variant of the terms and of a whole BRDF: error against time, scalar, in batches and on adapters.
    Terms(terms::Options),
    /// The models of layered stacks against the walk: albedo, f, time and tables.
    Layered(layered::Options),
    /// The WGSL of stacks against the general kernel, on every adapter.
    Shaders(shaders::Options),
    /// The documents' materials against Phong with the same features, on every adapter.
    Materials(materials::Options),
    /// Paths a second of the offline mode, for a sphere of each stack and material.
    Offline(offline::Options),
    /// The measured peak of this processor: multiply-adds, divides, roots and copying.
    Machine(machine::Options),
    /// Writes docs/performance.md and its charts from measurements made now.
    Document(document::Options),
}

pub(crate) fn run(options: &Options) -> Result<ExitCode, Failure> {
    match &options.subject {
        Subject::Terms(options) => terms::run(options),
        Subject::Layered(options) => layered::run(options),
        Subject::Shaders(options) => shaders::run(options),
        Subject::Materials(options) => materials::run(options),
        Subject::Offline(options) => offline::run(options),
        Subject::Machine(options) => machine::run(options),
        Subject::Document(options) => document::run(options),
    }
}
