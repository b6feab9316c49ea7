//! Leaves out draws from the views that cannot show them.
//!
//! Only where that is proven: the fixed-function pipeline, whose matrices are known, and vertices whose
//! places are known. Everything else goes to every view. Views that got nothing are not corrected either ([`blank`]).

pub mod arrays;
pub mod blank;
pub mod bounds;
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

/// The views that can show a draw at `place` of vertices within `bounds`.
///
/// A draw that no view shows still goes to the last one where it `changes` state, or where more than its
/// picture counts (transform feedback).
pub fn views(ctx: &mut Context, place: Place, bounds: &Bounds, changes: Changes) -> Views {
    let enabled = crate::intercept::settings::settings().is_some_and(|s| s.cull);
    let margin = ctx.widest.margin();
    if !enabled || place != Place::FixedScene || ctx.assembly || !margin.is_finite() {
        return Views::ALL;
    }
    let Some((low, high)) = bounds.known() else { return Views::ALL };
    let model_view = super::matrices::model_view(ctx);
    let Some(target) = &ctx.target else { return Views::ALL };
    let mut seen = 0;
    let count = target.session.views().len().min(64);
    for index in 0..count {
        let (tile, own) = target.session.tile(index);
        let beside = [margin, margin * f64::from(tile[2]) / f64::from(tile[3].max(1))];
        let beside = beside.map(|pixels| 2.0 * pixels / f64::from(tile[2].max(1)));
        let hidden = ctx.projection.per_view.get(index).is_some_and(|m| outside(m, &model_view, low, high, beside));
        seen |= u64::from(own || !hidden) << index;
    }
    if seen == 0 && (changes != Changes::Nothing || ctx.feedback) {
        seen = 1 << (count.max(1) - 1);
    }
    Views(seen)
}
