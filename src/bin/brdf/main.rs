//! The command `brdf`.

mod failure;
mod list;
mod parity;
mod term;

use clap::{Parser, Subcommand};
use failure::Failure;
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

    /// Compare the WGSL twins with the Rust functions on every adapter.
    Parity(parity::Options),
}

fn main() -> ExitCode {
    // Mesa's device-selection layer complains on machines without a desktop session.
    let result = match Arguments::parse().command {
        Command::List(options) => list::run(&options),

        Command::Parity(options) => parity::run(&options),
    };
    match result {
        Ok(code) => code,
        Err(failure) => {
            if !failure.is_broken_pipe() {
                eprintln!("brdf: {failure}");
            }
            failure.exit_code()
        }
    }
}
