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
pub use rig::quoted;
pub use written::save;

use crate::failure::Failure;
use options::Format;
use serde_json::json;
use source::Channel;
use std::path::Path;
use std::process::ExitCode;
use written::Written;

/// Files that a conversion wrote, and remarks for the user.
pub struct Conversion {
    written: Vec<Written>,
    notes: Vec<String>,
}

impl Conversion {
    /// The rigs among the files.
    pub fn rigs(&self) -> impl Iterator<Item = &Path> {
        self.written.iter().map(|file| file.path.as_path()).filter(|path| options::ending(path) == "toml")
    }

    /// Description as JSON.
    pub fn json(&self) -> serde_json::Value {
        let files: Vec<_> = self.written.iter().map(Written::json).collect();
        json!({ "files": files, "notes": self.notes })
    }

    /// Prints the files, and the remarks to standard error.
    pub fn tell(&self) {
        self.notes.iter().for_each(|note| eprintln!("cupola: {note}"));
        self.written.iter().for_each(|file| println!("{}", file.words()));
    }
}

/// Runs the subcommand.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let conversion = convert(arguments)?;
    if arguments.json {
        println!("{:#}", conversion.json());
    } else {
        conversion.tell();
    }
    Ok(ExitCode::SUCCESS)
}

/// Converts, without an answer to the user.
pub fn convert(arguments: &Arguments) -> Result<Conversion, Failure> {
    let format = Format::of(&arguments.to)?;
    refuse_to_replace(&arguments.to, arguments.force)?;
    let source = source::open(arguments)?;
    let mut notes = source.notes().to_vec();
    let written = match (&source, format) {
        (source::Source::Sgct { config, .. }, Format::Rig) => sgct::rigs(arguments, config, &mut notes)?,
        (source::Source::Sgct { .. }, _) => {
            return Err(Failure::usage("a configuration of SGCT becomes a rig; expected a name that ends in .toml"));
        }
        _ => {
            let channels = source.channels(arguments)?;
            let written = target::write(arguments, format, &channels)?;
            if !matches!(format, Format::Rig | Format::Mpcdi) {
                notes.extend(lost_dome(&arguments.to, &channels));
            }
            if format == Format::Rig && channels.iter().all(|channel| channel.dome.is_none()) {
                notes.push(format!(
                    "{} does not say how the dome is tilted and how far it reaches down: {} has a tilt of 0° and a coverage \
                     of 180°. Correct [dome] there if that is wrong",
                    arguments.from,
                    arguments.to.display()
                ));
            }
            written
        }
    };
    Ok(Conversion { written, notes })
}

/// Remark about a dome that a format has no place for, unless it is the one that readers assume.
fn lost_dome(to: &Path, channels: &[Channel]) -> Option<String> {
    let dome = channels.iter().find_map(|channel| channel.dome)?;
    let (tilt, coverage) = (dome.tilt.to_degrees(), dome.coverage.to_degrees());
    (tilt != 0.0 || coverage != 180.0).then(|| {
        format!(
            "{} has no place for the dome's tilt ({tilt:.2}°) and coverage ({coverage:.2}°): set them where it is read",
            to.display()
        )
    })
}

/// Fails if one of the files exists and must not be replaced.
fn refuse_to_replace_any(files: impl IntoIterator<Item = std::path::PathBuf>, force: bool) -> Result<(), Failure> {
    files.into_iter().try_for_each(|file| refuse_to_replace(&file, force))
}

/// Fails if a file exists that must not be replaced: it may have been changed by hand. Links are
/// refused when they are written.
pub fn refuse_to_replace(file: &Path, force: bool) -> Result<(), Failure> {
    match std::fs::symlink_metadata(file).is_ok_and(|data| data.is_file()) && !force {
        true => Err(Failure::usage(format!("{} exists; give another name, or --force to replace it", file.display()))),
        false => Ok(()),
    }
}
