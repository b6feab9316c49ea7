//! `cupola ctl`: sends requests to a running `cupola serve`. It also holds the time of a program
//! without a server.

use crate::failure::Failure;
use crate::launch::held::{self, Request};
use crate::pattern::direction;
use crate::serve::control::Command;
use crate::serve::marks::NewMark;
use crate::serve::pattern::Choice;
use crate::serve::socket;
use serde_json::Value;
use std::path::PathBuf;
use std::process::ExitCode;

/// Control a running `cupola serve` of the same user: change keys, undo, save, show patterns, mark
/// and solve, start, stop and hold programs.
#[derive(clap::Args)]
pub struct Arguments {
    /// Socket of the server, as it printed it [default: the one that was started first]
    #[arg(long, value_name = "FILE")]
    socket: Option<PathBuf>,
    /// Process number of the `cupola run` without a server whose time is held [default: the only
    /// one]
    #[arg(long, value_name = "NUMBER", conflicts_with = "socket")]
    run: Option<u32>,
    /// Print the answer as JSON
    #[arg(long, global = true)]
    json: bool,
    #[command(subcommand)]
    action: Action,
}

#[derive(clap::Subcommand)]
enum Action {
    /// Print the rig and the program, with times and memory
    Stats,
    /// List all keys of the rig with their values and ranges
    Keys,
    /// Print the value of a key
    Get {
        /// For example output.front.yaw
        key: String,
    },
    /// Change keys: all of the changes are made, or none
    Set {
        /// In quotes, for example 'viewer.position=[0,0,1]'
        #[arg(required = true, value_name = "KEY=VALUE")]
        changes: Vec<String>,
    },
    /// Remove keys, which then have their defaults: all of them or none
    Unset {
        /// For example viewer.yaw
        #[arg(required = true)]
        keys: Vec<String>,
    },
    /// Undo the last change
    Undo,
    /// Redo the last undone change
    Redo,
    /// Write the changes to the rig file
    Save {
        /// Save even if another program has changed the file
        #[arg(long)]
        replace: bool,
    },
    /// Open another rig that the server was started with, or a preset
    Rig {
        /// Name of the rig
        name: String,
        /// Open it even if there are unsaved changes
        #[arg(long)]
        replace: bool,
    },
    /// Show a test pattern instead of the program, or the program again
    Pattern {
        /// Parts as for `cupola pattern --parts`, or off
        #[arg(value_delimiter = ',', required_unless_present = "at", value_name = "PART,…|off")]
        parts: Vec<String>,
        /// A cross in this direction, degrees; may be given several times
        #[arg(long, value_name = "AZIMUTH,ELEVATION", allow_hyphen_values = true, value_parser = direction)]
        at: Vec<[f64; 2]>,
        /// Name of the only output that is not black
        #[arg(long, value_name = "NAME")]
        only: Option<String>,
        /// Distance between lines of a grid, degrees
        #[arg(long, value_name = "DEGREES")]
        step: Option<f64>,
    },
    /// Add a mark for the calibration: the place of an output's picture that lights a known
    /// direction. Pixels are those of the running program's picture, otherwise those of the rig
    #[command(allow_negative_numbers = true)]
    Mark {
        /// Name of the output
        output: String,
        /// Pixels from the left
        x: f64,
        /// Pixels from the top
        y: f64,
        /// Degrees: 0 = front, 90 = right
        azimuth: f64,
        /// Degrees above the horizon
        elevation: f64,
    },
    /// Remove a mark
    Unmark {
        /// Number of its line in the file of marks
        line: usize,
    },
    /// Solve the outputs that have marks, and change the rig
    Solve {
        /// Other unknown numbers besides the pose: fov, shift, radial, tangential, mirror
        #[arg(value_delimiter = ',', value_name = "PART,…")]
        parts: Vec<String>,
    },
    /// Start a program: one that the server was started with, or any other after `--`
    Start {
        /// Name of a program that the server was started with
        program: Option<String>,
        /// Another program with its arguments
        #[arg(last = true)]
        command: Vec<String>,
    },
    /// Stop the program
    Stop,
    /// Hold the time of a program with a virtual clock (--clock)
    Pause,
    /// Let its time go on
    Resume,
    /// Let its time go on by single frames, and hold it then
    Step {
        /// Number of frames
        #[arg(value_name = "N", default_value_t = 1)]
        frames: u64,
    },
    /// End the server and the program
    Quit,
}

/// Runs the subcommand.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    if let Some(request) = request(&arguments.action) {
        return hold(arguments, request);
    }
    let answer = socket::ask(arguments.socket.as_deref(), &command(&arguments.action)).map_err(Failure::new)?;
    match &arguments.action {
        _ if arguments.json => println!("{answer:#}"),
        Action::Stats => print_state(&answer),
        Action::Keys => answer.as_array().into_iter().flatten().for_each(print_key),
        Action::Get { .. } => println!("{}", shown(&answer)),
        Action::Solve { .. } => {
            let lines = answer["solved"].as_array().into_iter().flatten().filter_map(Value::as_str);
            lines.for_each(|line| println!("{line}"));
        }
        _ => {}
    }
    Ok(ExitCode::SUCCESS)
}

/// Request for the program's time.
fn request(action: &Action) -> Option<Request> {
    match action {
        Action::Pause => Some(Request::Hold),
        Action::Resume => Some(Request::Release),
        Action::Step { frames } => Some(Request::Step(*frames)),
        _ => None,
    }
}

/// Holds the time of the server's program, or of a program without a server, and waits until its
/// picture is complete.
fn hold(arguments: &Arguments, request: Request) -> Result<ExitCode, Failure> {
    let state = match page(arguments).map_err(Failure::new)? {
        Some(page) => held::apply(&page, request).and_then(|_| held::until_it_stands(|| held::state(&page))),
        None => {
            let ask =
                |command| socket::ask(arguments.socket.as_deref(), command).map(|mut state| state["clock"].take());
            ask(&command(&arguments.action)).and_then(|_| held::until_it_stands(|| ask(&Command::State {})))
        }
    };
    let state = state.map_err(Failure::new)?;
    if arguments.json {
        println!("{state:#}");
    } else {
        println!("{}", held::words(&state));
    }
    Ok(ExitCode::SUCCESS)
}

/// Page of the chosen program; `None` if a server is asked.
fn page(arguments: &Arguments) -> Result<Option<PathBuf>, String> {
    if arguments.socket.is_some() || (arguments.run.is_none() && socket::is_there()) {
        return Ok(None);
    }
    let pages = held::all();
    let number = |page: &PathBuf| page.to_string_lossy().rsplit_once('-').and_then(|(_, number)| number.parse().ok());
    let found = pages.iter().filter(|page| arguments.run.is_none_or(|run| number(page) == Some(run)));
    match found.collect::<Vec<_>>()[..] {
        [page] => Ok(Some(page.clone())),
        [] => Err(match arguments.run {
            Some(run) => format!("--run {run}: no cupola run with this number runs a program with a virtual clock"),
            None => "no program with a virtual clock runs; start it with cupola run --clock 60".to_owned(),
        }),
        [..] => {
            let numbers = pages.iter().filter_map(number).map(|number: u32| number.to_string()).collect::<Vec<_>>();
            Err(format!("several programs have a virtual clock; choose one with --run: {}", numbers.join(", ")))
        }
    }
}

fn command(action: &Action) -> Command {
    match action {
        Action::Stats => Command::State {},
        Action::Keys => Command::Keys {},
        Action::Get { key } => Command::Get { key: key.clone() },
        Action::Set { changes } => Command::Set { changes: changes.clone(), remove: Vec::new(), gesture: None },
        Action::Unset { keys } => Command::Set { changes: Vec::new(), remove: keys.clone(), gesture: None },
        Action::Undo => Command::Undo {},
        Action::Redo => Command::Redo {},
        Action::Save { replace } => Command::Save { replace: *replace },
        Action::Rig { name, replace } => Command::Rig { name: name.clone(), replace: *replace },
        Action::Pattern { parts, at, only, step } => {
            let parts = if parts[..] == ["off"] { Vec::new() } else { parts.clone() };
            Command::Pattern(Choice { parts, step: *step, only: only.clone(), at: at.clone(), cursor: None })
        }
        Action::Mark { output, x, y, azimuth, elevation } => {
            Command::Mark(NewMark { output: output.clone(), x: *x, y: *y, azimuth: *azimuth, elevation: *elevation })
        }
        Action::Unmark { line } => Command::Unmark { line: *line },
        Action::Solve { parts } => Command::Solve { parts: parts.clone() },
        Action::Start { program, command } => {
            Command::Start { program: program.clone(), command: (!command.is_empty()).then(|| command.clone()) }
        }
        Action::Stop => Command::Stop {},
        Action::Pause => Command::Pause {},
        Action::Resume => Command::Resume {},
        Action::Step { frames } => Command::Step { frames: *frames },
        Action::Quit => Command::Quit {},
    }
}

/// Text for the value of a key, or for a missing one.
fn shown(key: &Value) -> String {
    // Lists and tables are shown as the file has them.
    match (key["toml"].as_str(), &key["value"], &key["default"]) {
        (Some(text), ..) => text.to_owned(),
        (None, Value::Null, Value::Null) => "not set".to_owned(),
        (None, Value::Null, default) => format!("{default} (default)"),
        (None, value, _) => value.to_string(),
    }
}

fn print_key(key: &Value) {
    let accepts = match key["type"].as_str() {
        Some("number") => {
            format!("{} to {}, {}", key["least"], key["greatest"], key["what"].as_str().unwrap_or_default())
        }
        Some("whole" | "text" | "value") => key["what"].as_str().unwrap_or_default().to_owned(),
        Some("word") => {
            let words = key["words"].as_array().into_iter().flatten().filter_map(Value::as_str);
            words.collect::<Vec<_>>().join(", ")
        }
        _ => "true, false".to_owned(),
    };
    println!("{} = {}  # {accepts}", key["key"].as_str().unwrap_or_default(), shown(key));
}

fn print_state(state: &Value) {
    let rig = &state["rig"];
    let changed = if rig["changed"] == true { ", with changes that are not saved" } else { "" };
    println!("rig      {}{changed}", rig["name"].as_str().unwrap_or_default());
    let program = &state["program"];
    let name = program["name"].as_str().unwrap_or("none");
    println!("program  {name}{}", if program["runs"] == true { ", running" } else { "" });
    if let Some(why) = program["ended"].as_str() {
        println!("         ended: {why}");
    }
    let frame = state["frame_milliseconds"].as_f64().unwrap_or_default();
    if program["runs"] == true && frame > 0.0 {
        println!("frames   {frame:.1} ms from frame to frame");
    }
    if !state["clock"].is_null() {
        println!("clock    {}", held::words(&state["clock"]));
    }
    let megabytes = |name: &str| state["memory"][name].as_u64().unwrap_or_default() >> 20;
    println!("memory   {} MiB program, {} MiB server", megabytes("program"), megabytes("server"));
    for line in program["lines"].as_array().into_iter().flatten().filter_map(Value::as_str) {
        println!("         {line}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;
    use serde_json::json;

    #[derive(Parser)]
    struct Line {
        #[command(flatten)]
        arguments: Arguments,
    }

    #[test]
    fn keys_are_set_and_removed() {
        let request = |line: &[&str]| command(&Line::try_parse_from(line).expect("arguments").arguments.action);
        let words = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>();
        let set = Command::Set { changes: words(&["dome.tilt=3", "name=x"]), remove: Vec::new(), gesture: None };
        assert_eq!(request(&["ctl", "set", "dome.tilt=3", "name=x"]), set);
        let unset = Command::Set { changes: Vec::new(), remove: words(&["dome.tilt", "name"]), gesture: None };
        assert_eq!(request(&["ctl", "unset", "dome.tilt", "name"]), unset);
        assert!(Line::try_parse_from(["ctl", "unset"]).is_err());
        // What an older client sends removes nothing.
        let older = serde_json::from_str(r#"{ "do": "set", "changes": ["dome.tilt=3", "name=x"] }"#);
        assert_eq!(older.ok(), Some(set));
    }

    #[test]
    fn patterns_and_marks_are_those_of_the_page() {
        let request = |line: &[&str]| command(&Line::try_parse_from(line).expect("arguments").arguments.action);
        let cross = Choice { at: vec![[-45.0, 30.0]], ..Choice::default() };
        assert_eq!(request(&["ctl", "pattern", "--at", "-45,30"]), Command::Pattern(cross));
        let mark = NewMark { output: "a".into(), x: 10.5, y: 20.5, azimuth: -45.0, elevation: 30.0 };
        assert_eq!(request(&["ctl", "mark", "a", "10.5", "20.5", "-45", "30"]), Command::Mark(mark));
        assert_eq!(request(&["ctl", "unmark", "3"]), Command::Unmark { line: 3 });
        let parts = vec!["fov".to_owned(), "shift".to_owned()];
        assert_eq!(request(&["ctl", "solve", "fov,shift"]), Command::Solve { parts });
        assert!(Line::try_parse_from(["ctl", "pattern"]).is_err());
    }

    #[test]
    fn lists_are_shown_as_the_file_has_them() {
        let key = |toml: Value, value: Value| shown(&json!({ "toml": toml, "value": value, "default": "power" }));
        assert_eq!(key("{ red = 2 }".into(), Value::Null), "{ red = 2 }");
        assert_eq!(key(Value::Null, Value::Null), "\"power\" (default)");
        assert_eq!(key(Value::Null, 3.into()), "3");
    }

    #[test]
    fn json_is_accepted_before_and_after_the_action() {
        for line in [&["ctl", "--json", "keys"][..], &["ctl", "keys", "--json"], &["ctl", "pattern", "off", "--json"]] {
            let parsed = Line::try_parse_from(line).expect("arguments");
            assert!(parsed.arguments.json, "{line:?}");
        }
        assert!(!Line::try_parse_from(["ctl", "keys"]).expect("arguments").arguments.json);
    }
}
