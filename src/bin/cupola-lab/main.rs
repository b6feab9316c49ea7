//! The `cupola-lab` command: measuring tools for developers of Cupola.
//!
//! Each subcommand has a folder. Exit codes: 0 success, 1 failure or an exceeded bound, 2 invalid
//! arguments or an invalid rig. Only `trial` calls graphics drivers directly, and only there is
//! `unsafe` allowed.

#![deny(unsafe_code)]

// Before the others, which use its macros.
#[macro_use]
#[path = "../shared/output.rs"]
mod output;

#[path = "../shared/arguments.rs"]
mod arguments;
#[path = "../shared/display.rs"]
mod display;
mod environment;
#[path = "../shared/failure.rs"]
mod failure;
mod meshes;
#[path = "../shared/planning.rs"]
mod planning;
#[path = "../../testing/random.rs"]
mod random;
#[path = "../shared/terminal.rs"]
mod terminal;

mod accuracy;
mod bench;
mod calibrate;
mod calls;
mod cells;
mod conformance;
mod content;
mod stress;
mod structure;
#[allow(unsafe_code, reason = "calls OpenGL and Vulkan directly")]
mod trial;

use clap::Parser;
use std::process::ExitCode;

/// Measures Cupola: run time, accuracy, behaviour on random input.
#[derive(Parser)]
#[command(name = "cupola-lab", version, arg_required_else_help = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(clap::Subcommand)]
enum Command {
    Bench(bench::Arguments),
    Accuracy(accuracy::Arguments),
    Stress(stress::Arguments),
    Cells(cells::Arguments),
    Structure(structure::Arguments),
    Conformance(conformance::Arguments),
    Calls(calls::Arguments),
    Calibrate(calibrate::Arguments),
    Content(content::Arguments),
}

fn main() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::Bench(arguments) => bench::run(&arguments),
        Command::Accuracy(arguments) => accuracy::run(&arguments),
        Command::Stress(arguments) => stress::run(&arguments),
        Command::Cells(arguments) => cells::run(&arguments),
        Command::Structure(arguments) => structure::run(&arguments),
        Command::Conformance(arguments) => conformance::run(&arguments),
        Command::Calls(arguments) => calls::run(&arguments),
        Command::Calibrate(arguments) => calibrate::run(&arguments),
        Command::Content(arguments) => content::run(&arguments),
    };
    failure::exit_code("cupola-lab", result)
}
