//! `cupola bench`: run time against error, of our correction and of those by which other programs correct.

mod contest;
mod division;
mod methods;
mod peers;
mod plot;
mod processor;
mod quality;
mod report;
mod scenes;

use crate::{Failure, terminal};
use std::path::PathBuf;
use std::process::ExitCode;

/// Measure run time and error of corrections, ours and others'.
///
/// Times are ratios to drawing one bilinear full-screen picture of the same size, all measured in turn; errors are
/// those of the map from pixels to directions, against the exact one.
#[derive(clap::Args)]
pub struct Arguments {
    /// Small pictures and few rounds: at most two minutes on two processors
    #[arg(long)]
    quick: bool,
    /// Rounds [default: 15, or 5 if quick]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..10_000))]
    rounds: Option<u32>,
    /// Only the scenes with this in their names
    #[arg(long, value_name = "NAME", default_value = "")]
    scene: String,
    /// Write the results as JSON
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write the results as CSV
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Write time against error (SVG) and maps of the errors (PNG) there
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,
}

/// The scene whose primitives are divided rather than its picture corrected.
const DIVISION: &str = "division of triangles";

/// Runs the subcommand.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let rounds = arguments.rounds.unwrap_or(if arguments.quick { 5 } else { 15 });
    let mut contests = Vec::new();
    let mut scenes = scenes::all(arguments.quick)?;
    let names: Vec<_> = scenes.iter().map(|scene| scene.name).collect();
    scenes.retain(|scene| scene.name.contains(&arguments.scene));
    let divides = DIVISION.contains(&arguments.scene);
    if scenes.is_empty() && !divides {
        return Err(Failure::usage(format!(
            "no scene is called {:?}; there are {}, {DIVISION}",
            arguments.scene,
            names.join(", ")
        )));
    }
    for scene in scenes {
        let spinner = terminal::spinner(&format!("{}: preparing", scene.name));
        let contest = contest::run(scene, rounds, |phase| spinner.set_message(phase))?;
        spinner.finish_and_clear();
        print!("{}", report::table(&contest));
        contests.push(contest);
    }
    let divided = divides.then(|| division::run(arguments.quick));
    if let Some(divided) = &divided {
        print!("{}", division::table(divided));
    }
    let write = |path: &PathBuf, text: &str| {
        std::fs::write(path, text)
            .map_err(|error| Failure::new(format!("{} cannot be written: {error}", path.display())))
    };
    if let Some(path) = &arguments.json {
        write(path, &format!("{:#}\n", report::json(&contests, divided.as_ref())))?;
    }
    if let Some(path) = &arguments.csv {
        write(path, &report::csv(&contests))?;
    }
    if let Some(directory) = &arguments.plots {
        std::fs::create_dir_all(directory)
            .map_err(|error| Failure::new(format!("{} cannot be made: {error}", directory.display())))?;
        for contest in &contests {
            write(&directory.join(format!("{}.svg", contest.scene.file_name())), &plot::scatter(contest))?;
            plot::error_maps(contest, directory)?;
        }
        if let Some(divided) = &divided {
            write(&directory.join("division.svg"), &division::plot(divided))?;
        }
    }
    Ok(ExitCode::SUCCESS)
}
