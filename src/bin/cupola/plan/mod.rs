//! `cupola plan`: the views that a rig needs, their cost, and a picture of them on the sphere of
//! directions.

mod figures;
mod nodes;
mod picture;

use crate::canvas::refuse_other_endings;
use crate::failure::Failure;
use crate::patience::patiently;
use crate::planning::window_request;
use cupola::correct;
use cupola::rig::Favour;
use figures::Figures;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Plan the views of a rig and print their sizes, openings and cost.
#[derive(clap::Args)]
pub struct Arguments {
    /// Rig file or name of a preset
    #[arg(value_name = "FILE|PRESET")]
    rig: String,
    /// Window size in pixels to plan for [default: from the rig, or 1920x1200]
    #[arg(long, value_name = "WxH", value_parser = crate::arguments::size)]
    size: Option<(u32, u32)>,
    /// Prefer fewer views (cpu) or fewer texels (gpu) [default: from the rig]
    #[arg(long, value_name = "cpu|gpu", value_parser = crate::arguments::favour)]
    favour: Option<Favour>,
    /// Draw the views on the sphere of directions to a PNG file
    #[arg(long, value_name = "PLAN.png")]
    picture: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    nodes: nodes::Options,
}

/// Runs the subcommand.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    arguments.picture.as_deref().map_or(Ok(()), refuse_other_endings)?;
    let mut rig = cupola::rig::load(&arguments.rig)?;
    rig.views.favour = arguments.favour.unwrap_or(rig.views.favour);
    if nodes::run(&arguments.nodes, &rig, arguments.size, arguments.json)?.is_some() {
        return Ok(ExitCode::SUCCESS);
    }
    let rig = rig.with_all_outputs();
    let request = window_request(&rig, arguments.size);
    let start = Instant::now();
    let plan = patiently("planning the views", || correct::build(&rig, &request))?;
    let seconds = start.elapsed().as_secs_f64();
    let figures = Figures::of(&rig, &request, &plan, seconds);
    if arguments.json {
        let mut figures = figures.json(&plan.views);
        figures["cells"] = rig.views.cells.iter().map(|cell| cell.to_array()).collect();
        println!("{figures:#}");
    } else {
        print!("{figures}");
    }
    if let Some(file) = &arguments.picture {
        picture::write(file, &rig, &request, &plan.views, &figures)?;
    }
    Ok(ExitCode::SUCCESS)
}
