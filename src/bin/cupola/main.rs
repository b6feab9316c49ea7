//! The `cupola` command: runs programs on domes, and helps to set domes up.
//!
//! One file for each subcommand. Exit codes: 0 success, 1 failure, 2 wrong arguments or rig; `run` exits
//! as the program does.

#![forbid(unsafe_code)]

mod accuracy;
mod arguments;
mod bench;
mod check;
mod convert;
mod doctor;
mod launch;
mod map;
mod plan;
mod run;
mod simulate;
mod stress;
mod terminal;
mod tune;

use clap::Parser;
use std::process::ExitCode;

/// Puts existing OpenGL programs, unmodified, on domes.
#[derive(Parser)]
#[command(name = "cupola", version, arg_required_else_help = true)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(clap::Subcommand)]
enum Command {
    Run(run::Arguments),
    Check(check::Arguments),
    Doctor(doctor::Arguments),
    Plan(plan::Arguments),
    Convert(convert::Arguments),
    Map(map::Arguments),
    Simulate(simulate::Arguments),
    Accuracy(accuracy::Arguments),
    Stress(stress::Arguments),
    Tune(tune::Arguments),
    Bench(bench::Arguments),
    #[command(hide = true)]
    Probe(launch::probe::Arguments),
}

/// A message for people and the exit code that goes with it.
struct Failure {
    message: String,
    code: u8,
}

impl Failure {
    /// A failure with exit code 1.
    fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), code: 1 }
    }

    /// A failure of what the user gave, with exit code 2.
    fn usage(message: impl Into<String>) -> Self {
        Self { message: message.into(), code: 2 }
    }
}

impl From<cupola::Error> for Failure {
    fn from(error: cupola::Error) -> Self {
        let code = match error.kind {
            cupola::ErrorKind::InvalidArgument | cupola::ErrorKind::InvalidRig | cupola::ErrorKind::Io => 2,
            _ => 1,
        };
        Self { message: error.message, code }
    }
}

fn main() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::Run(arguments) => run::run(arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Plan(arguments) => plan::run(&arguments),
        Command::Convert(arguments) => convert::run(&arguments),
        Command::Map(arguments) => map::run(&arguments),
        Command::Simulate(arguments) => simulate::run(&arguments),
        Command::Accuracy(arguments) => accuracy::run(&arguments),
        Command::Stress(arguments) => stress::run(&arguments),
        Command::Tune(arguments) => tune::run(&arguments),
        Command::Bench(arguments) => bench::run(&arguments),
        Command::Doctor(arguments) => doctor::run(&arguments),
        Command::Probe(arguments) => launch::probe::run(&arguments),
    };
    match result {
        Ok(code) => code,
        Err(failure) => {
            for line in failure.message.lines() {
                eprintln!("cupola: {line}");
            }
            ExitCode::from(failure.code)
        }
    }
}
