//! A search for the cells that need the fewest texels with a given number of views.
//!
//! What views cost is neither smooth nor convex in where their cells meet, so this is an evolution strategy with one
//! parent (Rechenberg 1973) from several starts: random steps, longer after a success and shorter after a failure.
//! Deterministic, and far too slow for planning: its result is kept in the rig.

use super::partition::{Task, diagram};
use super::samples::Samples;
use crate::geom::random::Random;
use glam::DVec3;

/// Searches begin from so many different sets of cells; the best of them are gone on with.
const STARTS: u32 = 8;

/// The part of all steps that the starts are given together.
const PART_OF_STARTS: f64 = 0.5;

/// After a success steps are so much longer, after a failure shorter: one in five succeeds where neither wins.
const LONGER: f64 = 1.4;
const SHORTER: f64 = 0.919;

/// One set of cells on its way.
#[derive(Clone, Debug)]
struct Candidate {
    vectors: Vec<DVec3>,
    cost: f64,
    step: f64,
}

/// The vectors of a [`diagram`] of `count` cells, of about the fewest texels, and these; `None` where no such cells were
/// found that perspective views can show. `steps`: how many sets of cells are tried, at least a hundred for each view.
/// The first start is `known`, with cells divided or left out until there are `count`. `progress` is told which part is
/// done, 0…1.
pub(crate) fn search(
    task: &Task,
    known: &[DVec3],
    count: usize,
    steps: u32,
    progress: &mut dyn FnMut(f64),
) -> Option<(Vec<DVec3>, f64)> {
    let steps = steps.max(100 * count as u32);
    let each = (PART_OF_STARTS * f64::from(steps)) as u32 / STARTS;
    let all = f64::from((2 * STARTS * each).max(1));
    let mut done = 0.0;
    let mut advance = |candidate: &mut Candidate, random: &mut Random, steps: u32| {
        for _ in 0..steps {
            step(task, candidate, random);
            done += 1.0;
            progress(done / all);
        }
    };
    let mut best: Option<(Candidate, Random)> = None;
    for start in 0..STARTS {
        let mut random = Random::new(u64::from(start) + 1);
        let vectors =
            if start == 0 { adapted(known, count, &mut random) } else { spread(task.coarse, count, &mut random) };
        let cost = cost(task, &vectors, f64::INFINITY);
        let mut candidate = Candidate { vectors, cost, step: 0.3 };
        advance(&mut candidate, &mut random, each);
        if best.as_ref().is_none_or(|(other, _)| candidate.cost < other.cost) {
            best = Some((candidate, random));
        }
    }
    let (mut candidate, mut random) = best?;
    advance(&mut candidate, &mut random, STARTS * each);
    progress(1.0);
    candidate.cost.is_finite().then_some((candidate.vectors, candidate.cost))
}

/// `known` with as many vectors as asked for: some twice, a little apart, or some left out.
fn adapted(known: &[DVec3], count: usize, random: &mut Random) -> Vec<DVec3> {
    let vector = |index: usize| match known.get(index % known.len().max(1)) {
        Some(&vector) if index < known.len() => vector,
        Some(&vector) => vector + normal(random) * 0.1,
        None => random.direction(),
    };
    (0..count).map(vector).collect()
}

/// `count` of the directions that outputs show, each far from those before it, as unit vectors.
fn spread(outputs: &[&Samples], count: usize, random: &mut Random) -> Vec<DVec3> {
    let all: Vec<DVec3> = outputs.iter().flat_map(|samples| samples.iter()).map(|sample| sample.direction).collect();
    let mut vectors: Vec<DVec3> = Vec::with_capacity(count);
    for _ in 0..count {
        // Not simply the farthest, so that starts differ.
        let tried = (0..12).filter_map(|_| all.get((random.unit() * all.len() as f64) as usize).copied());
        let nearest = |direction: DVec3| vectors.iter().map(|other| other.dot(direction)).fold(-1.0, f64::max);
        let farthest = tried.min_by(|a, b| nearest(*a).total_cmp(&nearest(*b)));
        vectors.push(farthest.unwrap_or_else(|| random.direction()));
    }
    vectors
}

/// Moves one of the vectors, or all, and keeps that where it is cheaper.
fn step(task: &Task, candidate: &mut Candidate, random: &mut Random) {
    let mut vectors = candidate.vectors.clone();
    let one = (random.unit() < 0.7).then(|| (random.unit() * vectors.len() as f64) as usize);
    for (index, vector) in vectors.iter_mut().enumerate() {
        if one.is_none_or(|one| one == index) {
            *vector += normal(random) * candidate.step;
        }
    }
    let cost = cost(task, &vectors, candidate.cost);
    if cost < candidate.cost {
        (candidate.vectors, candidate.cost) = (vectors, cost);
        candidate.step = (candidate.step * LONGER).min(0.5);
    } else {
        // Where steps are too short to matter, longer ones may still find something.
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

/// Texels of all cells together; any number above `limit` where it is more.
fn cost(task: &Task, vectors: &[DVec3], limit: f64) -> f64 {
    let mut sum = 0.0;
    for cell in diagram(vectors) {
        sum += task.texels(&cell);
        if sum > limit {
            break;
        }
    }
    sum
}
