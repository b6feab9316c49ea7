//! `cupola-lab bench`: run time and error of Cupola's correction and of the corrections of other
//! programs.

mod contest;
mod division;
mod methods;
mod peers;
mod plot;
mod processor;
mod quality;
mod report;
mod scenes;

use crate::failure::Failure;
use crate::terminal;
use std::path::PathBuf;
use std::process::ExitCode;

/// Measure run time and error of Cupola's correction methods and of those of other programs.
///
/// Times are ratios to the time of one bilinear full-screen picture of the same size; all methods
/// are measured in turn. Errors are those of the map from pixels to directions, compared with the
/// exact map.
#[derive(clap::Args)]
pub struct Arguments {
    /// Use small pictures and few rounds (at most two minutes on two processors)
    #[arg(long)]
    quick: bool,
    /// Number of rounds [default: 15, or 5 with --quick]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..10_000))]
    rounds: Option<u32>,
    /// Measure only scenes whose name contains this text
    #[arg(long, value_name = "NAME", default_value = "")]
    scene: String,
    /// Write the results to a JSON file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write the results to a CSV file
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Write plots of time against error (SVG) and maps of the errors (PNG) to a folder
    #[arg(long, value_name = "DIR")]
    plots: Option<PathBuf>,
}

/// Name of the scene that measures the division of primitives instead of corrections of pictures.
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
            "no scene has {:?} in its name; the scenes are {}, {DIVISION}",
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
            .map_err(|error| Failure::new(format!("{} cannot be created: {error}", directory.display())))?;
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
