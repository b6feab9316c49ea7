//! `cupola setup`: a first rig, from monitors, a few measures and the places of projectors, or from
//! another program's calibration.

mod monitors;
mod options;
mod places;
mod questions;
mod text;

pub use options::Arguments;

use crate::convert;
use crate::failure::Failure;
use crate::pattern;
use crate::planning::window_request;
use monitors::Monitors;
use questions::Questions;
use serde_json::json;
use std::io::IsTerminal;
use std::path::Path;
use std::process::ExitCode;

/// Runs the subcommand.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    arguments.check()?;
    convert::refuse_to_replace(&arguments.file, arguments.force)?;
    match &arguments.from {
        Some(source) => {
            let code =
                convert::run(&convert::Arguments::to_rig(source, &arguments.file, arguments.force, arguments.json))?;
            if code != ExitCode::SUCCESS {
                return Ok(code);
            }
        }
        None => write_first_rig(arguments)?,
    }
    patterns(arguments)?;
    if !arguments.json {
        next_steps(&arguments.file);
    }
    Ok(ExitCode::SUCCESS)
}

/// Asks for what the options leave open, and writes the rig.
fn write_first_rig(arguments: &Arguments) -> Result<(), Failure> {
    let mut notes = Vec::new();
    let found = match Monitors::find(arguments.xrandr.as_deref()) {
        Ok(found) => found,
        Err(why) => {
            notes.push(format!("{why}; the outputs share the program's window in a grid"));
            Monitors::none()
        }
    };
    let stdin = std::io::stdin();
    let mut questions = match stdin.is_terminal() {
        true => Questions::of(stdin.lock(), std::io::stderr()),
        false => Questions::none(),
    };
    let monitors = questions.monitors(arguments, &found)?;
    let room = questions.room(arguments)?;
    let outputs = questions.outputs(arguments, &room, &monitors, &mut notes)?;
    let name = arguments.file.file_stem().unwrap_or_default().to_string_lossy();
    let text = text::rig(&name, &room, &outputs);
    accepted(&text, &arguments.file)?;
    convert::save(&arguments.file, text.as_bytes())?;
    if arguments.json {
        let answer = json!({
            "file": arguments.file.display().to_string(),
            "outputs": outputs.len(),
            "monitors": monitors.json(),
            "notes": notes,
        });
        println!("{answer:#}");
        return Ok(());
    }
    notes.iter().for_each(|note| eprintln!("cupola: {note}"));
    println!("{}: outputs: {}", arguments.file.display(), outputs.len());
    Ok(())
}

/// Fails if `cupola check` would refuse the rig: nothing is written then.
fn accepted(text: &str, file: &Path) -> Result<(), Failure> {
    let folder = file.parent().unwrap_or(Path::new("."));
    let planned = cupola::rig::parse(text, "the rig of these answers", folder).and_then(|rig| {
        let request = window_request(&rig, None);
        cupola::views::plan(&rig, &request).map(drop)
    });
    planned.map_err(|error| Failure::usage(format!("{}\nNothing was written. The rig was:\n{text}", error.message)))
}

/// Writes and shows the numbered patterns that were asked for.
fn patterns(arguments: &Arguments) -> Result<(), Failure> {
    if arguments.patterns.is_some() || arguments.show {
        let rig = arguments.file.display().to_string();
        pattern::run(&pattern::Arguments::numbered(rig, arguments.patterns.clone(), arguments.show))?;
    }
    Ok(())
}

/// Says what comes after a first rig.
fn next_steps(file: &Path) {
    let file = file.display();
    eprintln!(
        "cupola: next: read what `cupola check {file}` says; \
         see how the projectors meet with `cupola pattern {file} --show`; \
         correct the angles with `cupola tune {file} output.NAME.yaw=…`"
    );
}
