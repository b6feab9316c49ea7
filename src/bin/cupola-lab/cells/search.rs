//! A search for the cells that need the fewest texels with a given number of views.
//!
//! The cost of views is neither smooth nor convex in the borders of their cells. The search is an
//! evolution strategy with one parent (Rechenberg 1973) and several starts: it takes random steps,
//! longer ones after a success and shorter ones after a failure. It is deterministic, and far too
//! slow for planning: the result is stored in the rig.

use crate::random::Random;
use cupola::views::CellCosts;
use glam::DVec3;

/// Number of different sets of cells from which the search starts. It continues with the best of
/// them.
const STARTS: u32 = 8;

/// Share of all steps that the starts take together.
const PART_OF_STARTS: f64 = 0.5;

/// Factors on the length of steps after a success and after a failure. They balance where one step
/// in five succeeds.
const LONGER: f64 = 1.4;
const SHORTER: f64 = 0.919;

/// A set of cells during the search.
#[derive(Clone, Debug)]
struct Candidate {
    vectors: Vec<DVec3>,
    cost: f64,
    step: f64,
}

/// Searches for `count` cells with few texels. Returns the vectors of the cells, as a rig's
/// `[views] cells` has them, or `None` if no cells were found that perspective views can show.
///
/// `steps` is the number of sets of cells that are tried, at least a hundred for each view.
/// `progress` is called with the part that is done, 0…1.
pub fn search(costs: &CellCosts, count: usize, steps: u32, progress: &mut dyn FnMut(f64)) -> Option<Vec<DVec3>> {
    let (known, directions) = (costs.cube(), costs.directions());
    let steps = steps.max(100 * count as u32);
    let each = (PART_OF_STARTS * f64::from(steps)) as u32 / STARTS;
    let all = f64::from((2 * STARTS * each).max(1));
    let mut done = 0.0;
    let mut advance = |candidate: &mut Candidate, random: &mut Random, steps: u32| {
        for _ in 0..steps {
            step(costs, candidate, random);
            done += 1.0;
            progress(done / all);
        }
    };
    let mut best: Option<(Candidate, Random)> = None;
    for start in 0..STARTS {
        let mut random = Random::new(u64::from(start) + 1);
        let vectors =
            if start == 0 { adapted(&known, count, &mut random) } else { spread(&directions, count, &mut random) };
        let cost = costs.texels(&vectors, f64::INFINITY);
        let mut candidate = Candidate { vectors, cost, step: 0.3 };
        advance(&mut candidate, &mut random, each);
        if best.as_ref().is_none_or(|(other, _)| candidate.cost < other.cost) {
            best = Some((candidate, random));
        }
    }
    let (mut candidate, mut random) = best?;
    advance(&mut candidate, &mut random, STARTS * each);
    progress(1.0);
    candidate.cost.is_finite().then_some(candidate.vectors)
}

/// `count` of the vectors `known`. If there are fewer, some are taken twice, the second time a
/// little moved.
fn adapted(known: &[DVec3], count: usize, random: &mut Random) -> Vec<DVec3> {
    let vector = |index: usize| match known.get(index % known.len().max(1)) {
        Some(&vector) if index < known.len() => vector,
        Some(&vector) => vector + normal(random) * 0.1,
        None => random.direction(),
    };
    (0..count).map(vector).collect()
}

/// `count` of the directions, each far from those before it.
fn spread(all: &[DVec3], count: usize, random: &mut Random) -> Vec<DVec3> {
    let mut vectors: Vec<DVec3> = Vec::with_capacity(count);
    for _ in 0..count {
        // The farthest of a few random ones, so that starts differ.
        let tried = (0..12).filter_map(|_| all.get((random.unit() * all.len() as f64) as usize).copied());
        let nearest = |direction: DVec3| vectors.iter().map(|other| other.dot(direction)).fold(-1.0, f64::max);
        let farthest = tried.min_by(|a, b| nearest(*a).total_cmp(&nearest(*b)));
        vectors.push(farthest.unwrap_or_else(|| random.direction()));
    }
    vectors
}

/// Moves one of the vectors, or all of them, and keeps the result if it is cheaper.
fn step(costs: &CellCosts, candidate: &mut Candidate, random: &mut Random) {
    let mut vectors = candidate.vectors.clone();
    let one = (random.unit() < 0.7).then(|| (random.unit() * vectors.len() as f64) as usize);
    for (index, vector) in vectors.iter_mut().enumerate() {
        if one.is_none_or(|one| one == index) {
            *vector += normal(random) * candidate.step;
        }
    }
    let cost = costs.texels(&vectors, candidate.cost);
    if cost < candidate.cost {
        (candidate.vectors, candidate.cost) = (vectors, cost);
        candidate.step = (candidate.step * LONGER).min(0.5);
    } else {
        // Steps this short change nothing. Longer ones may still find something.
        candidate.step = if candidate.step < 1e-4 { 0.1 } else { candidate.step * SHORTER };
    }
}

/// Three numbers with a normal distribution (Box and Muller 1958).
fn normal(random: &mut Random) -> DVec3 {
    let mut one = || {
        let radius = (-2.0 * random.unit().max(1e-300).ln()).sqrt();
        radius * (random.unit() * std::f64::consts::TAU).cos()
    };
    DVec3::new(one(), one(), one())
}

#[cfg(test)]
mod tests {
    use super::*;
    use cupola::views::{plan, report, with_cell_costs};
    use std::path::Path;

    #[test]
    fn the_search_finds_good_cells_and_the_same_every_time() {
        let text = "[dome]\ncoverage = 360\n[[output]]\nkind = \"domemaster\"\naperture = 180\ntilt = 90\n";
        let mut rig = cupola::rig::parse(text, "rig.toml", Path::new("")).expect("a rig");
        let request = crate::planning::request(vec![(4096, 4096)], (4096, 4096));
        let found = |steps: u32, views: usize| {
            let mut last = 0.0;
            let mut progress = |part: f64| {
                assert!((last..=1.0).contains(&part));
                last = part;
            };
            let cells = with_cell_costs(&rig, &request, |costs| search(costs, views, steps, &mut progress));
            assert_eq!(last, 1.0);
            cells.expect("outputs that share views")
        };
        assert_eq!(found(300, 2), None, "two views cannot show a half sphere");
        let cells = found(800, 6).expect("six views can");
        assert_eq!(found(800, 6), Some(cells.clone()));
        rig.views.cells = cells;
        let plan = plan(&rig, &request).expect("a plan");
        let report = report(&plan, &rig, &request.output_sizes);
        // The search begins with the faces of a cube, 1.400 with five views, and uses coarse
        // samples. With its usual number of steps six views get below 1.37.
        assert!(plan.views.len() <= 6 && report.texels_per_pixel < 1.43, "{report} {:?}", rig.views.cells);
    }
}
