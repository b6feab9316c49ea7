//! The dome, the viewer, the program's camera and the outputs, with their positions.
//!
//! Types here are validated, and angles are in radians. [`load`] and [`parse`] read them from TOML
//! in metres and degrees; `docs/rig-file.md` describes the file key by key.
//!
//! A rig passes three steps: `reading` takes typed values out of the parsed TOML and stores their
//! lines; `schema` has the keys and the ranges of single values; `validate` has the conditions
//! between values. All of them add to one list of problems, so that one message shows all mistakes.

mod layout;
mod mask;
mod model;
mod presets;
mod profiles;
mod reading;
mod schema;
mod validate;

use crate::error::{Error, ErrorKind, Result};
use std::io::Read;
use std::os::unix::fs::FileTypeExt;
use std::path::Path;

pub use crate::formats::Levels;
pub use mask::read_mask;
pub use model::black::{Black, BlackValues};
pub use model::blend::{AngleRamp, Blend, DomeAngle, RampShape};
pub use model::calibration::{Calibration, CalibrationValues};
pub use model::content::{Content, ContentKind, Stereo};
pub use model::flip::Flip;
pub use model::method::{Divider, Method};
pub use model::nodes::{Node, Place};
pub use model::overrides::Overrides;
pub use model::response::{RESPONSE_STEPS, Response, Transfer};
pub use model::views::{Duplicate, Favour, Filter, Resolution, ViewMethod, Views};
pub use model::{Camera, Dome, Output, OutputKind, Overlay, OwnWindow, Rig, Viewer, WindowSwaps};
pub use presets::{Preset, presets};
pub use profiles::{Chosen, Defaults, Profile, Profiles};
pub use reading::accepted_keys::{Accepts, DefaultValue, Key};

/// Longest rig file, bytes.
const LONGEST_RIG: u64 = 1 << 20;

/// Reads a rig: `name_or_path` is a preset's name (see [`presets()`]) or else the path of a TOML
/// file.
///
/// A name that is also a file in the working directory means the preset; write `./name` for the
/// file.
///
/// # Errors
/// [`ErrorKind::Io`] if there is no such preset and no readable file, [`ErrorKind::InvalidRig`]
/// with every problem of the file (file, line, key, reason, remedy; one per line) if it is no valid
/// rig.
pub fn load(name_or_path: &str) -> Result<Rig> {
    load_with(name_or_path, &Defaults::default())
}

/// Reads a rig as [`load`] does, with `defaults` for keys of the program that the rig does not
/// have.
///
/// # Errors
/// As [`load`].
pub fn load_with(name_or_path: &str, defaults: &Defaults) -> Result<Rig> {
    if let Some(preset) = presets::find(name_or_path) {
        return parse_with(preset.text, preset.name, Path::new(""), defaults);
    }
    let path = Path::new(name_or_path);
    let text = read_text(path, name_or_path, |error| unreadable(name_or_path, error))?;
    parse_with(&text, name_or_path, path.parent().unwrap_or(Path::new("")), defaults)
}

/// Reads the text of a rig file as it is.
///
/// # Errors
/// Those of the system, text that is not UTF-8, and named pipes: reading one waits until somebody
/// writes, perhaps for ever. Other pipes, such as `/dev/stdin`, are read.
pub fn text_of_file(path: &Path) -> std::io::Result<String> {
    refuse_named_pipe(path)?;
    std::fs::read_to_string(path)
}

/// Fails if a file is a named pipe itself, not only a link to an open pipe.
fn refuse_named_pipe(path: &Path) -> std::io::Result<()> {
    match std::fs::symlink_metadata(path).is_ok_and(|data| data.file_type().is_fifo()) {
        true => Err(std::io::Error::other("it is a named pipe, which is not waited for; give a file")),
        false => Ok(()),
    }
}

/// Reads the text of a file, which is called `name` in messages; `unreadable` explains a failure.
fn read_text(path: &Path, name: &str, unreadable: impl Fn(&std::io::Error) -> String) -> Result<String> {
    let mut text = Vec::new();
    // The file may be a pipe, whose length is not known.
    refuse_named_pipe(path)
        .and_then(|()| std::fs::File::open(path))
        .and_then(|file| file.take(LONGEST_RIG + 1).read_to_end(&mut text))
        .map_err(|error| Error::new(ErrorKind::Io, unreadable(&error)))?;
    if text.len() as u64 > LONGEST_RIG {
        return Err(too_long(name));
    }
    String::from_utf8(text).map_err(|error| {
        let line = 1 + error.as_bytes()[..error.utf8_error().valid_up_to()].iter().filter(|&&b| b == b'\n').count();
        let message = format!("{name}:{line}: the file is not UTF-8 text; save it as UTF-8");
        Error::new(ErrorKind::InvalidRig, message)
    })
}

/// Reads a rig from TOML text. `file_name` appears in messages. Without directory and extension it
/// is the rig's name, if the text gives none. Paths in the text are relative to `directory` (empty:
/// the working directory).
///
/// # Errors
/// [`ErrorKind::InvalidRig`] with every problem of the text, as [`load`].
pub fn parse(text: &str, file_name: &str, directory: &Path) -> Result<Rig> {
    parse_with(text, file_name, directory, &Defaults::default())
}

fn parse_with(text: &str, file_name: &str, directory: &Path, defaults: &Defaults) -> Result<Rig> {
    if text.len() as u64 > LONGEST_RIG {
        return Err(too_long(file_name));
    }
    let mut problems = reading::problems::Problems::new(text);
    let rig = schema::read(text, file_name, directory, defaults, &mut problems);
    // Problems between values count only if no value was refused: missing values would cause
    // further, misleading problems.
    if let Some(rig) = rig.as_ref().filter(|_| problems.is_empty()) {
        validate::check(rig, &mut problems);
    }
    match rig {
        Some(mut rig) if problems.is_empty() => {
            (rig.outputs, rig.beside) = rig.outputs.into_iter().partition(|output| output.shown);
            Ok(rig)
        }
        _ => Err(Error::new(ErrorKind::InvalidRig, problems.message(file_name))),
    }
}

/// Keys that the rig in `text` has or may have, with the values that each accepts. Tables that the
/// text lacks are left out.
pub fn keys(text: &str, file_name: &str, directory: &Path) -> Vec<Key> {
    let mut problems = reading::problems::Problems::noting_keys(text);
    // Problems do not matter here.
    let _ = schema::read(text, file_name, directory, &Defaults::default(), &mut problems);
    problems.keys()
}

fn too_long(file_name: &str) -> Error {
    Error::new(
        ErrorKind::InvalidRig,
        format!("{file_name}: is longer than {LONGEST_RIG} bytes, the limit for rigs and profiles"),
    )
}

/// Explains why `name_or_path` is neither a preset nor a readable file, and names the preset that
/// was perhaps meant.
fn unreadable(name_or_path: &str, error: &std::io::Error) -> String {
    let names: Vec<&str> = presets().iter().map(|preset| preset.name).collect();
    let file = format!("the rig {name_or_path:?} is not a preset, and reading it as a file failed: {error}");
    match reading::problems::closest(name_or_path, &names) {
        Some(name) => format!("{file}; did you mean the preset `{name}`?"),
        None => format!("{file}; presets are {}", names.join(", ")),
    }
}
