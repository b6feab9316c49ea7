//! The planner: which directions the outputs sample, and the fewest, tightest views that show them.
//!
//! `sight` maps the pixels of each output to directions, `samples` gathers them along lines, `fit` and `density`
//! find the opening and the resolution that a view with given axes needs (four samples at a time: `lanes`), `axes` and
//! `partition` choose axes, `alone` plans views that serve one output, `choose` compares the families of views by what `cost` says, `layout` and `atlas` size and place them,
//! `curved` gives outputs whose vertices are projected straight to their pixels a picture of their own,
//! `kept` has a cache remember what was chosen,
//! `cells` says what given cells cost, `idle` finds those that would be drawn for nothing, `survey` and `report` look at the result.
//!
//! Resolution at quality 1: a projector or a perspective output gets at least one texel per pixel
//! in every direction, everywhere; a domemaster gets its nominal resolution (diameter over aperture)
//! in every direction, everywhere, or that of its own pixels (`[views] resolution = "full"`).

pub mod arranging;
pub mod fitting;
pub mod placing;
pub mod planner;
pub mod reporting;
pub mod sampling;
pub mod view_plan;

pub use crate::views::arranging::cells::{CellCosts, with_cell_costs};
pub use crate::views::arranging::cost::cost;
pub use crate::views::planner::{plan, plan_with_reach};
pub use crate::views::reporting::report::{OutputShare, Report, ViewReport, report};
pub use crate::views::reporting::survey::{Surveyed, Surveyor, survey};
pub use crate::views::view_plan::{Request, Tile, View, ViewPlan};

#[cfg(test)]
pub(crate) mod tests;
