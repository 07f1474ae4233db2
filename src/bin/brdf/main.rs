//! The command `brdf`.

mod bench;
mod check;
mod eval;
mod failure;
mod gallery;
mod list;
mod material;
mod merge;
mod output;
mod parity;
mod plan;
mod plot;
mod render;
mod shader;
mod term;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Reflectance maths with GPU twins: evaluate terms and stacks, and judge their physical plausibility.
#[derive(Parser)]
#[command(version, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// List the terms, materials, models, metals and adapters.
    List(list::Options),
    /// Evaluate terms and stacks: JSON Lines in, the same objects with the results out.
    Eval(eval::Options),
    /// Judge physical plausibility: stacks, materials, shaders, measured BRDFs, folders of their files.
    Check(check::Options),
    /// Put the reports of the shards of one check together.
    Merge(merge::Options),
    /// Compare the WGSL twins with the Rust functions on every adapter.
    Parity(parity::Options),
    /// Measure run time against error.
    Bench(bench::Options),
    /// Print the WGSL of stacks: what they need and nothing else, or the general kernels.
    Shader(shader::Options),
    /// Say what must be computed of a stack, what was left out and why, and what it costs.
    Plan(plan::Options),
    /// Draw a term as SVG.
    Plot(plot::Options),
    /// Take a picture of a material.
    Render(render::Options),
}

fn main() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::List(options) => list::run(&options),
        Command::Eval(options) => eval::run(&options),
        Command::Check(options) => check::run(&options),
        Command::Merge(options) => merge::run(&options),
        Command::Parity(options) => parity::run(&options),
        Command::Bench(options) => bench::run(&options),
        Command::Shader(options) => shader::run(&options),
        Command::Plan(options) => plan::run(&options),
        Command::Plot(options) => plot::run(&options),
        Command::Render(options) => render::run(&options),
    };
    match result {
        Ok(code) => code,
        Err(failure) => {
            if !failure.is_broken_pipe() {
                output::complain(&failure);
            }
            failure.exit_code()
        }
    }
}
