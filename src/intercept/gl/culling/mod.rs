//! Leaves out draws from the views that cannot show them.
//!
//! Only where that is proven: vertices whose places are known, and matrices that are known, be it the
//! fixed-function pipeline's or those of a shader whose text says what it does with them ([`proof`]). Everything else
//! goes to every view. Views that got nothing are not corrected either ([`blank`]).

pub mod arrays;
pub mod blank;
pub mod bounds;
pub mod layout;
pub mod position;
pub mod proof;
pub mod ranges;
pub mod widths;

use super::context::Context;
use super::draw::{Changes, Place};
use crate::correct::Texels;
use bounds::{Bounds, extent, outside};

/// The views that a draw goes to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Views {
    /// One bit each.
    seen: u64,
    /// `Context::areas` says where in each of them.
    bounded: bool,
}

impl Views {
    /// Every view.
    pub const ALL: Self = Self { seen: u64::MAX, bounded: false };

    /// Whether the draw goes to this view.
    pub fn contain(self, index: usize) -> bool {
        index >= 64 || self.seen >> index & 1 != 0
    }

    /// Whether it is known where in each view the draw comes to be.
    pub fn bounded(self) -> bool {
        self.bounded
    }

    /// The last of `count` views that the draw goes to.
    pub fn last(self, count: usize) -> Option<usize> {
        (0..count).rev().find(|index| self.contain(*index))
    }
}

/// Whether draws may be left out at all.
pub fn enabled() -> bool {
    crate::intercept::settings::settings().is_some_and(|s| s.cull)
}

/// The views that can show a draw at `place` of vertices within `bounds`, which are asked for where they may matter.
///
/// A draw that no view shows still goes to the last one where it `changes` state, or where more than its
/// picture counts (transform feedback).
pub fn views(ctx: &mut Context, place: Place, bounds: impl FnOnce(&mut Context) -> Bounds, changes: Changes) -> Views {
    let margin = ctx.widest.margin();
    // Where a picture is curved, a box is not what is around its corners.
    let curved = ctx.target.as_ref().is_some_and(|target| !target.lenses.is_empty());
    if !enabled() || !margin.is_finite() || curved {
        return Views::ALL;
    }
    let Some(model) = position::transform(ctx, place) else { return Views::ALL };
    let Some((low, high)) = bounds(ctx).known() else { return Views::ALL };
    ctx.counts.bounded_draws += 1;
    let mut areas = std::mem::take(&mut ctx.areas);
    areas.clear();
    let Some(target) = &ctx.target else { return Views::ALL };
    let mut seen = 0;
    let count = target.session.views().len().min(64);
    for index in 0..count {
        let (tile, own) = target.session.tile(index);
        let beside = [margin, margin * f64::from(tile[2]) / f64::from(tile[3].max(1))];
        let beside = beside.map(|pixels| 2.0 * pixels / f64::from(tile[2].max(1)));
        let transform = position::of_view(ctx, place, index).filter(|_| !own).map(|view| view.after(&model));
        let hidden = transform.as_ref().is_some_and(|transform| outside(transform, low, high, beside));
        seen |= u64::from(!hidden) << index;
        let part = transform.filter(|_| !hidden).and_then(|transform| extent(&transform, low, high));
        areas.push(match part {
            _ if hidden => blank::NOTHING,
            Some(part) => texels(part, tile, margin),
            None => texels([-1.0, -1.0, 1.0, 1.0], tile, margin),
        });
    }
    ctx.areas = areas;
    if seen == 0 && (changes != Changes::Nothing || ctx.feedback) {
        seen = 1 << (count.max(1) - 1);
    }
    Views { seen, bounded: true }
}

/// The texels of the atlas within `margin` of a part of a picture (left, bottom, right, top; −1…1), as far as they are the
/// tile's, or so near to it that a wide line may reach them.
fn texels([left, bottom, right, top]: [f64; 4], tile: [i32; 4], margin: f64) -> Texels {
    let along = |at: f64, axis: usize| {
        let length = f64::from(tile[axis + 2]);
        let inside = (0.5 * (1.0 + at) * length).clamp(0.0, length);
        f64::from(tile[axis]) + inside
    };
    [
        (along(left, 0) - margin).floor() as i32,
        (along(bottom, 1) - margin).floor() as i32,
        (along(right, 0) + margin).ceil() as i32,
        (along(top, 1) + margin).ceil() as i32,
    ]
}
