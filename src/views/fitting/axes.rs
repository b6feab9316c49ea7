//! Direction and roll of a view's axis with which it needs the fewest texels.
//!
//! The axis only chooses the plane of the picture: the opening is off-centre as needed.

use crate::geom::pose;
use crate::views::fitting::fit::{Fit, Patch, fit};
use glam::{DMat3, DVec3};

/// A view's axes, opening and resolution.
#[derive(Clone, Copy, Debug)]
pub(crate) struct OrientedView {
    /// Viewer axes → view axes.
    pub rotation: DMat3,
    /// Opening and resolution.
    pub fit: Fit,
}

/// Returns the single view with the fewest texels that shows `fine`. The search uses `coarse`,
/// samples of the same directions. `None` if some direction would lie more than 83° from every axis
/// that was tried.
///
/// Tries a grid of 3×3 axes and 4 rolls around the mean direction, then [`refined`] from the best
/// two. Deterministic.
pub(crate) fn tightest(coarse: &Patch, fine: &Patch, quality: f64) -> Option<OrientedView> {
    let base = facing(coarse.middle());
    let mut starts: Vec<(f64, DMat3)> = Vec::new();
    for yaw in [0.0, -0.2, 0.2] {
        for pitch in [0.0, -0.2, 0.2] {
            for roll in [0.0, 0.4, -0.4, 0.8] {
                let axes = base * pose::rotation(yaw, pitch, roll);
                starts.push((texels(coarse, axes, quality), axes));
            }
        }
    }
    starts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let best = starts.iter().take(2).filter(|start| start.0.is_finite());
    best.map(|start| refined(coarse, start.1, quality))
        .filter_map(|axes| {
            let rotation = axes.transpose();
            Some(OrientedView { rotation, fit: fit(rotation, fine, quality, true)? })
        })
        .min_by(|a, b| a.fit.texels().total_cmp(&b.fit.texels()))
}

/// Returns better axes near `axes` (local → viewer), by the simplex of Nelder and Mead (1965).
pub(crate) fn refined(samples: &Patch, axes: DMat3, quality: f64) -> DMat3 {
    let turned = |[yaw, pitch, roll]: [f64; 3]| axes * pose::rotation(yaw, pitch, roll);
    let cost = |at: [f64; 3]| texels(samples, turned(at), quality).ln();
    turned(nelder_mead(cost, [0.0; 3], 0.1, 90))
}

/// Returns the number of texels that a view with `axes` (local → viewer) needs for `samples`;
/// infinite if it cannot show them.
pub(crate) fn texels(samples: &Patch, axes: DMat3, quality: f64) -> f64 {
    fit(axes.transpose(), samples, quality, false).map_or(f64::INFINITY, |fit| fit.texels())
}

/// Returns the axes (local → parent) of a camera that looks along `direction`, upright where that
/// is defined.
pub(crate) fn facing(direction: DVec3) -> DMat3 {
    let back = -direction.normalize_or(DVec3::NEG_Z);
    let hint = if back.y.abs() > 0.99 { DVec3::NEG_Z * back.y.signum() } else { DVec3::Y };
    let right = hint.cross(back).normalize_or(DVec3::X);
    DMat3::from_cols(right, back.cross(right), back)
}

/// Minimises `cost` from `start` by the simplex of Nelder and Mead (1965), in at most `steps`
/// steps.
fn nelder_mead(cost: impl Fn([f64; 3]) -> f64, start: [f64; 3], size: f64, steps: usize) -> [f64; 3] {
    let mut simplex = vec![(cost(start), start)];
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
