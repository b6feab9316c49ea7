//! `cupola-lab calibrate`: measures how well the solvers of `cupola calibrate` find a known rig.
//!
//! `world` has the rig, its rough description and the camera. `trials` makes marks and sightings
//! with errors, solves them and compares with the limit of Cramér and Rao; `plot` draws the result.
//! `photographs` takes the camera's photographs of the patterns, decodes and solves them; `render`
//! renders them, with the light of `lamps`.

mod lamps;
mod photographs;
mod plot;
mod render;
mod trials;
mod world;

use crate::failure::Failure;
use photographs::Photographed;
use serde_json::json;
use std::path::PathBuf;
use std::process::ExitCode;

/// Measure how well `cupola calibrate` finds the projectors of planetarium-6, from marks and from
/// photographs with errors.
#[derive(clap::Args)]
pub struct Arguments {
    /// Rigs that are made and solved for each noise
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..))]
    runs: u32,
    /// Also render, decode and solve photographs of 12 megapixels, which takes up to an hour
    #[arg(long)]
    photographs: bool,
    /// Write a plot of error against noise to this file
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// Runs the subcommand.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let series = trials::all(arguments.runs)?;
    if !arguments.json {
        series.iter().for_each(|series| print!("{}", series.table()));
    }
    if let Some(file) = &arguments.plot {
        std::fs::write(file, plot::errors(&series))
            .map_err(|error| Failure::new(format!("{} cannot be written: {error}", file.display())))?;
    }
    let done = |found: &Photographed| {
        if !arguments.json {
            print!("{}", found.table());
        }
    };
    let photographed = arguments.photographs.then(|| photographs::measured(done)).transpose()?;
    if arguments.json {
        let tables = |found: Vec<Photographed>| found.iter().map(Photographed::json).collect::<Vec<_>>();
        let series: Vec<_> = series.iter().map(trials::Series::json).collect();
        println!("{:#}", json!({ "series": series, "photographs": photographed.map(tables) }));
    }
    Ok(ExitCode::SUCCESS)
}
