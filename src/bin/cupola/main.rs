//! The `cupola` command: runs programs on domes and helps to set domes up.
//!
//! Each subcommand has a file or a folder. Exit codes: 0 success, 1 failure, 2 invalid arguments or
//! an invalid rig; `run` exits with the program's code. Measuring tools for developers are in the
//! command `cupola-lab`.

#![cfg_attr(not(fuzzing), forbid(unsafe_code))]
// The fuzz target `serve` is this program with the entry point of libFuzzer.
#![cfg_attr(fuzzing, no_main, allow(dead_code))]

// Before the others, which use its macros.
#[macro_use]
#[path = "../shared/output.rs"]
mod output;

#[path = "../shared/arguments.rs"]
mod arguments;
#[path = "../shared/display.rs"]
mod display;
#[path = "../shared/failure.rs"]
mod failure;
#[path = "../shared/planning.rs"]
mod planning;
#[cfg(test)]
#[path = "../../testing/random.rs"]
mod random;
#[path = "../shared/terminal.rs"]
mod terminal;

mod calibrate;
mod canvas;
mod check;
mod convert;
mod ctl;
mod decimal;
mod doctor;
mod input;
mod inspect;
mod launch;
#[cfg(feature = "manual")]
mod manual;
mod map;
mod node;
mod patience;
mod pattern;
mod pipe;
mod plan;
mod play;
mod record;
mod run;
mod serve;
mod setup;
mod simulate;
mod stream;
mod tune;
mod window;

use clap::Parser;
use std::process::ExitCode;

/// Puts existing OpenGL and Vulkan programs, unmodified, on domes.
#[derive(Parser)]
#[command(
    name = "cupola",
    version,
    arg_required_else_help = true,
    after_help = "\
First steps:
  cupola doctor                    what this machine has
  cupola run glxgears              a program as a fisheye picture
  cupola serve -- glxgears         the same in a browser, with all keys of the rig
  cupola setup dome.toml           a rig for your own dome

Exit codes: 0 success; 1 failure; 2 wrong arguments, a wrong rig or a file that cannot be read. Commands that start a
program exit with its code, 128 + N if signal N ended it, and 126 or 127 if it cannot be started."
)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(clap::Subcommand)]
enum Command {
    Run(run::Arguments),
    Play(play::Arguments),
    Record(record::Arguments),
    Stream(stream::Arguments),
    Node(node::Arguments),
    Input(input::Arguments),
    Window(window::Arguments),
    Serve(serve::Arguments),
    Ctl(ctl::Arguments),
    Inspect(inspect::Arguments),
    Setup(setup::Arguments),
    Check(check::Arguments),
    Doctor(doctor::Arguments),
    Plan(plan::Arguments),
    Pattern(pattern::Arguments),
    Calibrate(calibrate::Arguments),
    Convert(convert::Arguments),
    Map(map::Arguments),
    Simulate(simulate::Arguments),
    Tune(tune::Arguments),
    #[cfg(feature = "manual")]
    #[command(hide = true)]
    Manual(manual::Arguments),
    #[command(hide = true)]
    Probe(launch::probe::Arguments),
}

fn main() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::Run(arguments) => run::run(arguments),
        Command::Play(arguments) => play::run(arguments),
        Command::Record(arguments) => record::run(arguments),
        Command::Stream(arguments) => stream::run(&arguments),
        Command::Node(arguments) => node::run(arguments),
        Command::Input(arguments) => input::run(&arguments),
        Command::Window(arguments) => window::run(&arguments),
        Command::Serve(arguments) => serve::run(arguments),
        Command::Ctl(arguments) => ctl::run(&arguments),
        Command::Inspect(arguments) => inspect::run(arguments),
        Command::Setup(arguments) => setup::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Plan(arguments) => plan::run(&arguments),
        Command::Pattern(arguments) => pattern::run(&arguments),
        Command::Calibrate(arguments) => calibrate::run(&arguments),
        Command::Convert(arguments) => convert::run(&arguments),
        Command::Map(arguments) => map::run(&arguments),
        Command::Simulate(arguments) => simulate::run(&arguments),
        Command::Tune(arguments) => tune::run(&arguments),
        Command::Doctor(arguments) => doctor::run(&arguments),
        #[cfg(feature = "manual")]
        Command::Manual(arguments) => manual::run(&arguments),
        Command::Probe(arguments) => launch::probe::run(&arguments),
    };
    failure::exit_code("cupola", result)
}
