//! `cupola plan --optimise`: the search for better cells than those of a cube.

use crate::{Failure, terminal};
use cupola::correct::{self, Plan};
use cupola::rig::Rig;
use cupola::views::{self, Request};
use glam::DVec3;

/// Numbers of views that are tried where none is asked for.
const MOST_VIEWS: usize = 8;

/// Parts of a step on the progress bar.
const PARTS: u64 = 1000;

/// Gives `rig` the cells of the cheapest plan found, with `count` views or any number up to eight; keeps it as it is
/// where its own plan is cheaper and no number was asked for.
pub fn optimise(rig: &mut Rig, request: &Request, count: Option<usize>, steps: u32) -> Result<(), Failure> {
    let plain = Rig { views: cupola::rig::Views { cells: Vec::new(), ..rig.views.clone() }, ..rig.clone() };
    let counts = count.map_or(1..=MOST_VIEWS, |count| count..=count);
    let bar = terminal::progress(PARTS * counts.clone().count() as u64, "‰");
    let mut best: Option<(f64, Rig)> = None;
    if count.is_none() {
        best = Some((cost(&plain, &correct::build(&plain, request)?), plain.clone()));
    }
    for (index, views) in (0..).zip(counts) {
        let progress = &mut |part: f64| bar.set_position(PARTS * index + (part * PARTS as f64) as u64);
        let Some(cells) = views::optimise(&plain, request, views, steps, progress)? else { continue };
        let mut candidate = plain.clone();
        candidate.views.cells = cells.into_iter().map(short).collect();
        // Cells that hardly fit into a perspective view may not fit when they are sampled finely.
        let Ok(plan) = correct::build(&candidate, request) else { continue };
        let cost = cost(&candidate, &plan);
        if best.as_ref().is_none_or(|(least, _)| cost < *least) {
            best = Some((cost, candidate));
        }
    }
    bar.finish_and_clear();
    *rig = best.map(|(_, rig)| rig).ok_or_else(|| {
        Failure::usage("so few perspective views cannot show what the outputs do; try --views with a greater number")
    })?;
    Ok(())
}

fn cost(rig: &Rig, plan: &Plan) -> f64 {
    views::cost(&plan.views, rig)
}

/// As many digits as matter.
fn short(vector: DVec3) -> DVec3 {
    (vector * 1e4).round() / 1e4
}

/// The key for the rig file.
pub fn text(cells: &[DVec3]) -> String {
    let rows: Vec<String> = cells.iter().map(|cell| format!("    [{}, {}, {}],\n", cell.x, cell.y, cell.z)).collect();
    format!("\n[views]\ncells = [\n{}]\n", rows.concat())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn what_is_printed_can_be_read() {
        let cells = [DVec3::new(0.1, -2.0, 1e-3), DVec3::new(0.0, 0.25, -1.0)];
        let rig = text(&cells) + "[[output]]\nkind = \"domemaster\"\n";
        let rig = cupola::rig::parse(&rig, "rig.toml", Path::new("")).map_err(|error| error.to_string());
        assert_eq!(rig.expect("a rig").views.cells, cells);
    }
}
