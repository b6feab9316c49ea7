//! `cupola plan`: which views a rig needs, what they cost, and how they lie on the sphere of directions.

mod canvas;
mod figures;
mod optimise;
mod picture;

use crate::Failure;
use cupola::correct;
use cupola::rig::Favour;
use cupola::views::Request;
use figures::Figures;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

/// Plan the views of a rig: what they show, what they cost, and a picture of them.
#[derive(clap::Args)]
pub struct Arguments {
    /// Rig file, or a preset's name
    #[arg(value_name = "FILE|PRESET")]
    rig: String,
    /// Size of the window to plan for in pixels [default: what the rig says, or 1920x1200]
    #[arg(long, value_name = "WxH", value_parser = crate::arguments::size)]
    size: Option<(u32, u32)>,
    /// Save the processor's work (fewer views) or the graphics card's (fewer texels) [default: what the rig says]
    #[arg(long, value_name = "cpu|gpu", value_parser = favour)]
    favour: Option<Favour>,
    /// Search for the best cells with so many views, and print them for the rig file
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u8).range(1..=24))]
    views: Option<u8>,
    /// Search for the best cells with 1 to 8 views, and print them where they are cheaper than the usual plan
    #[arg(long, conflicts_with = "views")]
    optimise: bool,
    /// How many sets of cells are tried for each number of views
    #[arg(long, value_name = "N", default_value_t = 20_000)]
    steps: u32,
    /// Draw the views on the sphere of directions, as a PNG file
    #[arg(long, value_name = "PLAN.png")]
    picture: Option<PathBuf>,
    /// Answer in JSON
    #[arg(long)]
    json: bool,
}

/// Runs the subcommand.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let mut rig = cupola::rig::load(&arguments.rig)?;
    rig.views.favour = arguments.favour.unwrap_or(rig.views.favour);
    let window = arguments.size.or_else(|| rig.extent()).unwrap_or((1920, 1200));
    let output_sizes = rig.layout(window).iter().map(|[_, _, width, height]| (*width, *height)).collect();
    let max_atlas = crate::check::LARGEST_ATLAS;
    let request = Request { output_sizes, window, panel: false, primary: false, max_atlas };
    let searched = arguments.optimise || arguments.views.is_some();
    if searched {
        optimise::optimise(&mut rig, &request, arguments.views.map(usize::from), arguments.steps)?;
    }
    let start = Instant::now();
    let plan = correct::build(&rig, &request)?;
    let seconds = start.elapsed().as_secs_f64();
    let figures = Figures::of(&rig, &request, &plan, seconds);
    if arguments.json {
        let mut figures = figures.json(&plan.views);
        figures["cells"] = rig.views.cells.iter().map(|cell| cell.to_array()).collect();
        println!("{figures:#}");
    } else {
        print!("{figures}");
        if searched && !rig.views.cells.is_empty() {
            print!("{}", optimise::text(&rig.views.cells));
        } else if searched {
            println!("no cells are cheaper than this");
        }
    }
    if let Some(file) = &arguments.picture {
        picture::write(file, &rig, &request, &plan.views, &figures)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn favour(text: &str) -> Result<Favour, String> {
    match text {
        "cpu" => Ok(Favour::Processor),
        "gpu" => Ok(Favour::Graphics),
        _ => Err("expected cpu or gpu".to_owned()),
    }
}
