//! One tight off-axis view for an output: where its axis points and how it is rolled.

use super::fit::{Fit, Fitter};
use super::samples::Samples;
use crate::geom::pose;
use glam::{DMat3, DVec3};

/// A view of its own for an output.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Single {
    /// Viewer axes → view axes.
    pub rotation: DMat3,
    /// Opening and resolution.
    pub fit: Fit,
}

/// The single view with the fewest texels that shows `fine` (searched on `coarse`, the same
/// output's), or `None` where some direction would lie more than 83° from any axis tried.
///
/// The axis only chooses the plane of the picture: the opening is off-centre as needed. The search
/// is a grid of 3×3 axes and 4 rolls around the mean direction, then Nelder and Mead (1965) from
/// the best two. Deterministic.
pub(crate) fn tightest(coarse: &Samples, fine: &Samples, quality: f64) -> Option<Single> {
    if fine.is_empty() {
        return None;
    }
    let base = facing(coarse.mean_direction());
    let cost = |at: [f64; 3]| {
        let rotation = (base * pose::rotation(at[0], at[1], at[2])).transpose();
        fit(coarse, rotation, quality, false).map_or(f64::INFINITY, |fit| fit.texels().ln())
    };
    let mut starts: Vec<(f64, [f64; 3])> = Vec::new();
    for yaw in [0.0, -0.2, 0.2] {
        for pitch in [0.0, -0.2, 0.2] {
            for roll in [0.0, 0.4, -0.4, 0.8] {
                starts.push((cost([yaw, pitch, roll]), [yaw, pitch, roll]));
            }
        }
    }
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut best: Option<Single> = None;
    for (start_cost, start) in starts.into_iter().take(2).filter(|start| start.0.is_finite()) {
        let found = nelder_mead(cost, start, start_cost, 0.1, 90);
        let rotation = (base * pose::rotation(found[0], found[1], found[2])).transpose();
        if let Some(fit) = fit(fine, rotation, quality, true)
            && best.is_none_or(|best| fit.texels() < best.fit.texels())
        {
            best = Some(Single { rotation, fit });
        }
    }
    best
}

fn fit(samples: &Samples, rotation: DMat3, quality: f64, fine: bool) -> Option<Fit> {
    let mut fitter = Fitter::new(rotation);
    if !fitter.add_all(samples) {
        return None;
    }
    fitter.fit(quality, fine)
}

/// Axes (local → parent) of a camera that looks along `direction`, upright where that means something.
pub(crate) fn facing(direction: DVec3) -> DMat3 {
    let back = -direction.normalize_or(DVec3::NEG_Z);
    let hint = if back.y.abs() > 0.99 { DVec3::NEG_Z * back.y.signum() } else { DVec3::Y };
    let right = hint.cross(back).normalize_or(DVec3::X);
    DMat3::from_cols(right, back.cross(right), back)
}

/// Minimises `cost` from `start` by the simplex of Nelder and Mead (1965), in at most `steps` steps.
fn nelder_mead(cost: impl Fn([f64; 3]) -> f64, start: [f64; 3], start_cost: f64, size: f64, steps: usize) -> [f64; 3] {
    let mut simplex = vec![(start_cost, start)];
    for axis in 0..3 {
        let mut corner = start;
        corner[axis] += size;
        simplex.push((cost(corner), corner));
    }
    let towards = |from: [f64; 3], to: [f64; 3], part: f64| -> [f64; 3] {
        std::array::from_fn(|axis| from[axis] + part * (to[axis] - from[axis]))
    };
    for _ in 0..steps {
        simplex.sort_by(|a, b| a.0.total_cmp(&b.0));
        if simplex[3].0 - simplex[0].0 < 1e-4 {
            break;
        }
        let worst = simplex[3];
        let middle: [f64; 3] =
            std::array::from_fn(|axis| (simplex[0].1[axis] + simplex[1].1[axis] + simplex[2].1[axis]) / 3.0);
        let evaluated = |part: f64| {
            let at = towards(middle, worst.1, part);
            (cost(at), at)
        };
        let reflected = evaluated(-1.0);
        let replacement = if reflected.0 < simplex[0].0 {
            let expanded = evaluated(-2.0);
            Some(if expanded.0 < reflected.0 { expanded } else { reflected })
        } else if reflected.0 < simplex[2].0 {
            Some(reflected)
        } else {
            let contracted = evaluated(if reflected.0 < worst.0 { -0.5 } else { 0.5 });
            (contracted.0 < worst.0.min(reflected.0)).then_some(contracted)
        };
        match replacement {
            Some(corner) => simplex[3] = corner,
            None => {
                let best = simplex[0].1;
                for corner in &mut simplex[1..] {
                    corner.1 = towards(best, corner.1, 0.5);
                    corner.0 = cost(corner.1);
                }
            }
        }
    }
    simplex.sort_by(|a, b| a.0.total_cmp(&b.0));
    simplex[0].1
}
