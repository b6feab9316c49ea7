//! `cupola-lab cells`: a search for better cells than those of a cube, for the rig file.

mod search;

use crate::failure::Failure;
use crate::planning::window_request;
use crate::terminal;
use cupola::correct::{self, Plan};
use cupola::rig::{Favour, Rig, Views};
use cupola::views::{self, Request};
use glam::DVec3;
use serde_json::json;
use std::process::ExitCode;

/// Search for the cells of a rig whose views have the fewest texels, and print them for the rig
/// file.
///
/// The result is the same in every run.
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
    /// Number of views [default: 1 to 8; no cells are printed where the usual plan is cheaper]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u8).range(1..=24))]
    views: Option<u8>,
    /// Number of sets of cells that are tried for each number of views
    #[arg(long, value_name = "N", default_value_t = 20_000)]
    steps: u32,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// Greatest number of views that is tried without `--views`.
const MOST_VIEWS: usize = 8;

/// Steps of the progress bar for each number of views.
const PARTS: u64 = 1000;

/// Runs the subcommand.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let mut rig = cupola::rig::load(&arguments.rig)?;
    rig.views.favour = arguments.favour.unwrap_or(rig.views.favour);
    let request = window_request(&rig, arguments.size);
    let (rig, plan) = best(&rig, &request, arguments.views.map(usize::from), arguments.steps)?;
    let report = views::report(&plan.views, &rig, &request.output_sizes);
    let count = plan.views.views.len();
    if arguments.json {
        let cells: Vec<[f64; 3]> = rig.views.cells.iter().map(|cell| cell.to_array()).collect();
        println!("{:#}", json!({ "cells": cells, "views": count, "texels_per_pixel": report.texels_per_pixel }));
        return Ok(ExitCode::SUCCESS);
    }
    println!("{}: {count} views, {:.3} texels per pixel", rig.name, report.texels_per_pixel);
    if rig.views.cells.is_empty() {
        println!("no cells are cheaper than this");
    } else {
        print!("{}", text(&rig.views.cells));
    }
    Ok(ExitCode::SUCCESS)
}

/// The rig with the cells of the cheapest plan found, and that plan. Without a number of views the
/// plan without cells competes too.
fn best(rig: &Rig, request: &Request, count: Option<usize>, steps: u32) -> Result<(Rig, Plan), Failure> {
    let plain = Rig { views: Views { cells: Vec::new(), ..rig.views.clone() }, ..rig.clone() };
    let counts = count.map_or(1..=MOST_VIEWS, |count| count..=count);
    let bar = terminal::progress(PARTS * counts.clone().count() as u64, "‰");
    let cost = |rig: &Rig, plan: &Plan| views::cost(&plan.views, rig);
    let mut best: Option<(f64, Rig, Plan)> = None;
    if count.is_none() {
        let plan = correct::build(&plain, request)?;
        best = Some((cost(&plain, &plan), plain.clone(), plan));
    }
    for (index, views) in (0..).zip(counts) {
        let progress = &mut |part: f64| bar.set_position(PARTS * index + (part * PARTS as f64) as u64);
        let found = views::with_cell_costs(&plain, request, |costs| search::search(costs, views, steps, progress))?;
        let Some(cells) = found else { continue };
        let mut candidate = plain.clone();
        candidate.views.cells = cells.into_iter().map(short).collect();
        // Cells that barely fit into a perspective view may not fit when they are sampled finely.
        let Ok(plan) = correct::build(&candidate, request) else { continue };
        let cost = cost(&candidate, &plan);
        if best.as_ref().is_none_or(|(least, ..)| cost < *least) {
            best = Some((cost, candidate, plan));
        }
    }
    bar.finish_and_clear();
    best.map(|(_, rig, plan)| (rig, plan)).ok_or_else(|| {
        Failure::usage("this number of perspective views cannot show all outputs; try --views with a greater number")
    })
}

/// Rounded to four decimal places.
fn short(vector: DVec3) -> DVec3 {
    (vector * 1e4).round() / 1e4
}

/// The cells as text for the rig file.
fn text(cells: &[DVec3]) -> String {
    let rows: Vec<String> = cells.iter().map(|cell| format!("    [{}, {}, {}],\n", cell.x, cell.y, cell.z)).collect();
    format!("\n[views]\ncells = [\n{}]\n", rows.concat())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn printed_cells_can_be_read() {
        let cells = [DVec3::new(0.1, -2.0, 1e-3), DVec3::new(0.0, 0.25, -1.0)];
        let rig = text(&cells) + "[[output]]\nkind = \"domemaster\"\n";
        let rig = cupola::rig::parse(&rig, "rig.toml", Path::new("")).map_err(|error| error.to_string());
        assert_eq!(rig.expect("a rig").views.cells, cells);
    }
}
