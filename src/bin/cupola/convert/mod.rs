//! `cupola convert`: converts rigs and calibration files to the formats of other programs.

mod calibration;
mod options;
mod projector;
mod rig;
mod sgct;
mod source;
mod target;
mod written;

pub use options::Arguments;

use crate::failure::Failure;
use options::Format;
use serde_json::json;
use std::process::ExitCode;

/// Runs the subcommand.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let format = Format::of(&arguments.to)?;
    let source = source::open(arguments)?;
    let mut notes = source.notes().to_vec();
    let written = match (&source, format) {
        (source::Source::Sgct { config, .. }, Format::Rig) => {
            sgct::rigs(&arguments.to, &arguments.from, config, &mut notes)?
        }
        (source::Source::Sgct { .. }, _) => {
            return Err(Failure::usage("a configuration of SGCT becomes a rig; expected a name that ends in .toml"));
        }
        _ => target::write(arguments, format, &source.channels(arguments)?)?,
    };
    if arguments.json {
        let files: Vec<_> = written.iter().map(written::Written::json).collect();
        println!("{:#}", json!({ "files": files, "notes": notes }));
        return Ok(ExitCode::SUCCESS);
    }
    for note in &notes {
        eprintln!("cupola: {note}");
    }
    for file in &written {
        println!("{}", file.words());
    }
    Ok(ExitCode::SUCCESS)
}
