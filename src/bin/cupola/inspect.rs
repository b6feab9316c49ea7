//! `cupola inspect`: runs a program and writes a page about one of its frames.

use crate::failure::Failure;
use crate::run::{self, Inspection};
use std::path::PathBuf;
use std::process::ExitCode;

/// Show how Cupola understands a program: write a page with the passes, draws, matrices and
/// pictures of one frame.
#[derive(clap::Args)]
#[group(skip)]
#[command(after_help = "\
The page is one file that every browser shows. It describes the first frame after --seconds (10 if nothing is given),
or the frame --frames; then the program ends. Ctrl-C, or another signal, describes the frame that follows it.")]
pub struct Arguments {
    /// The page to write
    #[arg(long, short, value_name = "FILE.html", default_value = "inspect.html")]
    output: PathBuf,
    #[command(flatten)]
    run: run::Started,
}

/// Runs the subcommand. Returns the exit code of the program.
pub fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
    run::run_and_inspect(arguments.run, Some(Inspection { output: arguments.output }))
}
