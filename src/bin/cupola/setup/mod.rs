//! `cupola setup`: writes a first rig, from monitors, a few measures and the positions of
//! projectors, or from another program's calibration.

mod monitors;
mod options;
mod places;
mod questions;
mod text;

pub use options::Arguments;

use crate::check::describe;
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
    let wanted = match &arguments.from {
        Some(source) => take_over(source, arguments).map(|()| false)?,
        None => write_first_rig(arguments)?,
    };
    patterns(arguments, wanted || arguments.show)?;
    if !arguments.json {
        next_steps(arguments);
    }
    Ok(ExitCode::SUCCESS)
}

/// Converts a calibration, and prints the description of each rig by `cupola check`.
fn take_over(source: &str, arguments: &Arguments) -> Result<(), Failure> {
    let conversion = convert::convert(&convert::Arguments::to_rig(source, &arguments.file, arguments.force))?;
    let mut answer = conversion.json();
    let mut words = String::new();
    let mut rigs = Vec::new();
    for file in conversion.rigs() {
        let name = file.display().to_string();
        let rig = cupola::rig::load(&name)
            .map_err(|error| Failure::usage(format!("{name} is written, but not valid yet:\n{}", error.message)))?
            .with_all_outputs()
            .into_owned();
        let request = window_request(&rig, None);
        let plan = cupola::views::plan(&rig, &request)?;
        rigs.push(describe::json(&rig, request.window, &plan));
        words += &format!("\n{name}: {}", describe::words(&rig, request.window, &plan));
    }
    if arguments.json {
        answer["rigs"] = rigs.into();
        println!("{answer:#}");
    } else {
        conversion.tell();
        print!("{words}");
    }
    Ok(())
}

/// Asks for values that the options leave open, and writes the rig. Returns whether the user then
/// wants to see its patterns.
fn write_first_rig(arguments: &Arguments) -> Result<bool, Failure> {
    let mut notes = Vec::new();
    let found = match Monitors::find(arguments.xrandr.as_deref()) {
        Ok(found) => found,
        Err(why) if arguments.xrandr.is_some() => return Err(Failure::usage(format!("--xrandr: {why}"))),
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
    let asks = stdin.is_terminal() && arguments.xrandr.is_none() && arguments.monitors.is_empty() && found.0.len() > 1;
    let names = asks.then(|| found.show_names());
    let monitors = questions.monitors(arguments, &found)?;
    drop(names);
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
        return Ok(false);
    }
    notes.iter().for_each(|note| eprintln!("cupola: {note}"));
    println!("{}: outputs: {}", arguments.file.display(), outputs.len());
    let is_open = arguments.patterns.is_none() && !arguments.show && arguments.xrandr.is_none();
    Ok(is_open && std::env::var_os("DISPLAY").is_some() && questions.shows_patterns())
}

/// Fails, and writes nothing, if `cupola check` would refuse the rig.
fn accepted(text: &str, file: &Path) -> Result<(), Failure> {
    let folder = file.parent().unwrap_or(Path::new("."));
    let planned = cupola::rig::parse(text, ANSWERS, folder).and_then(|rig| {
        let request = window_request(&rig, None);
        cupola::views::plan(&rig, &request).map(drop)
    });
    planned.map_err(|error| {
        let problems: Vec<_> = error.message.lines().map(without_line).collect();
        Failure::usage(format!("{}\nnothing was written", problems.join("\n")))
    })
}

/// Replaces the name of the file in messages about a rig that was not written.
const ANSWERS: &str = "the rig";

/// Removes the line number from a message, because the user never sees the text.
fn without_line(message: &str) -> &str {
    let rest = message.strip_prefix(ANSWERS).unwrap_or(message);
    rest.trim_start_matches(|c: char| c == ':' || c.is_ascii_digit()).trim_start()
}

/// Writes numbered patterns if that is requested, and shows them if `shown`.
fn patterns(arguments: &Arguments, shown: bool) -> Result<(), Failure> {
    if arguments.patterns.is_some() || shown {
        let rig = arguments.file.display().to_string();
        pattern::run(&pattern::Arguments::numbered(rig, arguments.patterns.clone(), shown))?;
    }
    Ok(())
}

/// Prints the next steps after a first rig.
fn next_steps(arguments: &Arguments) {
    let file = arguments.file.display();
    let see = format!("see how the projectors meet with `cupola pattern {file} --show`");
    match arguments.from {
        Some(_) => eprintln!("cupola: next: compare the description above with your dome; {see}"),
        None => eprintln!(
            "cupola: next: read what `cupola check {file}` says; {see}; \
             correct the angles with `cupola tune {file} output.NAME.yaw=…`"
        ),
    }
}
