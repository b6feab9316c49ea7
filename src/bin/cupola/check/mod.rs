//! `cupola check`: is a rig valid, and what does it say?

pub mod describe;
pub mod words;

use crate::Failure;
use cupola::rig::{Rig, presets};
use cupola::views::{Request, ViewPlan};
use serde_json::json;
use std::process::ExitCode;

/// Greatest texture of today's graphics hardware, for plans that are made without asking one.
pub const LARGEST_ATLAS: u32 = 16384;

/// Check a rig and describe it in words.
#[derive(clap::Args)]
pub struct Arguments {
    /// Rig file, or a preset's name
    #[arg(value_name = "FILE|PRESET", required_unless_present = "presets")]
    rig: Option<String>,
    /// List the presets instead
    #[arg(long, conflicts_with = "rig")]
    presets: bool,
    /// Size of the window to plan for in pixels [default: what the rig says, or 1920x1200]
    #[arg(long, value_name = "WxH", value_parser = crate::arguments::size)]
    size: Option<(u32, u32)>,
    /// Print the preset's or the rig file's text, to start a file of one's own
    #[arg(long, conflicts_with_all = ["json", "size"])]
    print: bool,
    /// Answer in JSON
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
    let rig = match cupola::rig::load(name) {
        Ok(rig) => rig,
        Err(error) if arguments.json => {
            let problems: Vec<&str> = error.message.lines().collect();
            println!("{:#}", json!({ "valid": false, "problems": problems }));
            return Ok(ExitCode::from(2));
        }
        Err(error) => return Err(error.into()),
    };
    let window = arguments.size.or_else(|| rig.extent()).unwrap_or((1920, 1200));
    let plan = plan(&rig, window)?;
    if arguments.json {
        println!("{:#}", describe::json(&rig, window, &plan));
    } else {
        print!("{}", describe::words(&rig, window, &plan));
    }
    Ok(ExitCode::SUCCESS)
}

/// Plans the views for a window of `window` pixels.
fn plan(rig: &Rig, window: (u32, u32)) -> Result<ViewPlan, Failure> {
    let output_sizes = rig.layout(window).iter().map(|[_, _, width, height]| (*width, *height)).collect();
    let request = Request { output_sizes, window, panel: false, primary: false, max_atlas: LARGEST_ATLAS };
    Ok(cupola::views::plan(rig, &request)?)
}

/// The TOML text of a rig.
fn text(name: &str) -> Result<String, Failure> {
    match presets().iter().find(|preset| preset.name == name) {
        Some(preset) => Ok(preset.text.to_owned()),
        None => std::fs::read_to_string(name).map_err(|error| Failure::usage(format!("{name}: {error}"))),
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
