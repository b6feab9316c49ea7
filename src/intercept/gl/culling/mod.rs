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
use bounds::{Bounds, outside};

/// The views that a draw goes to, one bit each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Views(u64);

impl Views {
    /// Every view.
    pub const ALL: Self = Self(u64::MAX);

    /// Whether the draw goes to this view.
    pub fn contain(self, index: usize) -> bool {
        index >= 64 || self.0 >> index & 1 != 0
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
    if !enabled() || !margin.is_finite() {
        return Views::ALL;
    }
    let Some(model) = position::transform(ctx, place) else { return Views::ALL };
    let Some((low, high)) = bounds(ctx).known() else { return Views::ALL };
    ctx.counts.bounded_draws += 1;
    let Some(target) = &ctx.target else { return Views::ALL };
    let mut seen = 0;
    let count = target.session.views().len().min(64);
    for index in 0..count {
        let (tile, own) = target.session.tile(index);
        let beside = [margin, margin * f64::from(tile[2]) / f64::from(tile[3].max(1))];
        let beside = beside.map(|pixels| 2.0 * pixels / f64::from(tile[2].max(1)));
        let hidden = !own
            && position::of_view(ctx, place, index).is_some_and(|view| outside(&view.after(&model), low, high, beside));
        seen |= u64::from(!hidden) << index;
    }
    if seen == 0 && (changes != Changes::Nothing || ctx.feedback) {
        seen = 1 << (count.max(1) - 1);
    }
    Views(seen)
}
