//! `cupola check`: validates a rig and describes it.

pub mod describe;
mod numbers;
mod remarks;
pub mod words;

use crate::failure::Failure;
use crate::patience::patiently;
use crate::planning::window_request;
use cupola::rig::presets;
use serde_json::json;
use std::path::Path;
use std::process::ExitCode;

/// Validate a rig and describe it in words.
#[derive(clap::Args)]
pub struct Arguments {
    /// Rig file or name of a preset
    #[arg(value_name = "FILE|PRESET", required_unless_present = "presets")]
    rig: Option<String>,
    /// List the presets
    #[arg(long, conflicts_with = "rig")]
    presets: bool,
    /// Window size in pixels to plan for [default: from the rig, or 1920x1200]
    #[arg(long, value_name = "WxH", value_parser = crate::arguments::size)]
    size: Option<(u32, u32)>,
    /// Print the text of the preset or rig file, as a start for a new file
    #[arg(long, conflicts_with_all = ["json", "size"])]
    print: bool,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// Runs the subcommand.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let Some(name) = arguments.rig.as_deref().filter(|_| !arguments.presets) else {
        list_presets(arguments.json);
        return Ok(ExitCode::SUCCESS);
    };
    if arguments.print {
        print!("{}", text(name)?);
        return Ok(ExitCode::SUCCESS);
    }
    match described(name, arguments) {
        Ok(words) => print!("{words}"),
        Err(error) if arguments.json => {
            let problems: Vec<&str> = error.message.lines().collect();
            println!("{:#}", json!({ "valid": false, "problems": problems }));
            return Ok(ExitCode::from(2));
        }
        Err(error) => return Err(error.into()),
    }
    Ok(ExitCode::SUCCESS)
}

/// Description of a rig and its views, in words or as JSON.
fn described(name: &str, arguments: &Arguments) -> cupola::Result<String> {
    let rig = cupola::rig::load(name)?.with_all_outputs().into_owned();
    let request = window_request(&rig, arguments.size);
    let window = request.window;
    patiently("planning the views", || {
        let plan = cupola::views::plan(&rig, &request)?;
        Ok(match arguments.json {
            true => format!("{:#}\n", describe::json(&rig, window, &plan)),
            false => describe::words(&rig, window, &plan),
        })
    })
}

/// TOML text of a rig file or preset.
fn text(name: &str) -> Result<String, Failure> {
    match presets().iter().find(|preset| preset.name == name) {
        Some(preset) => Ok(preset.text.to_owned()),
        None => cupola::rig::text_of_file(Path::new(name)).map_err(|error| Failure::usage(format!("{name}: {error}"))),
    }
}

fn list_presets(as_json: bool) {
    if as_json {
        let list: Vec<_> =
            presets().iter().map(|preset| json!({ "name": preset.name, "summary": preset.summary })).collect();
        println!("{:#}", json!(list));
        return;
    }
    for preset in presets() {
        println!("{:18} {}", preset.name, preset.summary);
    }
}
