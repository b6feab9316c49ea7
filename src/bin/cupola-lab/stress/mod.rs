//! `cupola-lab stress`: random and adversarial rigs, matrices and overlaps, compared with results
//! in f64.

mod case;
mod clip;
mod driver;
mod lens;
mod light;
mod maps;
mod outside;
mod report;
mod rigs;
mod screens;

use crate::failure::Failure;
use crate::meshes::Folder;
use crate::random::Random;
use crate::terminal;
use driver::{Backend, Driver};
use report::{Finding, Report};
use std::process::ExitCode;

/// Search for random input for which Cupola's mathematics or the graphics driver fails.
///
/// Every case has its own seed and can be repeated with `cupola-lab stress --seed SEED --cases 1`.
/// The exit code is 1 if a bound is exceeded.
#[derive(clap::Args)]
pub struct Arguments {
    /// Stop after N output pixels have been compared
    #[arg(long, value_name = "N", default_value_t = 1_000_000)]
    pixels: u64,
    /// Seed of the first case; the seeds of the following cases are the following numbers
    #[arg(long, value_name = "S", default_value_t = 1)]
    seed: u64,
    /// Stop after N cases
    #[arg(long, value_name = "N")]
    cases: Option<u64>,
    /// Test only these parts [default: all]
    #[arg(long, value_delimiter = ',', value_name = "PART")]
    only: Vec<Part>,
    /// Driver that computes the maps of the parts maps, screens, outside and light
    #[arg(long, value_enum, default_value_t = Backend::Gl)]
    backend: Backend,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// Part of the test, as `--only` takes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Part {
    /// Maps of random rigs with pinholes, domemasters and flat pictures on domes
    Maps,
    /// Maps of all lenses and pictures on screens of all shapes
    Screens,
    /// Maps of projectors from inside to 20 radii, beyond the outlines of screens of all shapes
    Outside,
    /// Re-projection of clip coordinates in f32
    Clip,
    /// Lenses recovered from products of matrices
    Lens,
    /// Weights of overlapping projectors
    Light,
}

const PARTS: [Part; 6] = [Part::Maps, Part::Screens, Part::Outside, Part::Clip, Part::Lens, Part::Light];

/// Runs the subcommand.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let parts = if arguments.only.is_empty() { PARTS.to_vec() } else { arguments.only.clone() };
    let on_driver = parts.iter().any(|part| matches!(part, Part::Maps | Part::Screens | Part::Outside | Part::Light));
    let folder = Folder::new()?;
    let mut report = Report::new(arguments.seed);
    let bar = terminal::progress(arguments.pixels, "pixels");
    let mut case = 0;
    while report.compared() < arguments.pixels && arguments.cases.is_none_or(|most| case < most) {
        let seed = arguments.seed.wrapping_add(case);
        let driver = on_driver.then(|| Driver::new(arguments.backend, seed)).transpose()?;
        for &part in &parts {
            let mut random = Random::new(seed);
            let findings = match (part, &driver) {
                (Part::Maps, Some(driver)) => rigs::any(&mut random)
                    .map_err(Failure::from)
                    .and_then(|case| maps::case(&case, maps::size(&mut random), driver, &maps::DOMES)),
                (Part::Screens, Some(driver)) => screens::any(&mut random)
                    .map_err(Failure::from)
                    .and_then(|case| maps::case(&case, screens::size(&mut random), driver, &maps::SCREENS)),
                (Part::Outside, Some(driver)) => outside::any(&mut random, &folder)
                    .map_err(Failure::from)
                    .and_then(|case| maps::case(&case, maps::size(&mut random), driver, &maps::OUTSIDE)),
                (Part::Light, Some(driver)) => light::case(&mut random, driver),
                (Part::Clip, _) => Ok(clip::case(&mut random)),
                (Part::Lens, _) => Ok(lens::case(&mut random)),
                (Part::Maps | Part::Screens | Part::Outside | Part::Light, None) => Ok(Vec::new()),
            };
            report.add(seed, findings.unwrap_or_else(|failure| vec![Finding::refusal(failure.message)]));
        }
        case += 1;
        bar.set_position(report.compared().min(arguments.pixels));
    }
    bar.finish_and_clear();
    if arguments.json {
        println!("{:#}", report.json(case));
    } else {
        print!("{}", report.text(case));
    }
    Ok(if report.failed() { ExitCode::FAILURE } else { ExitCode::SUCCESS })
}
