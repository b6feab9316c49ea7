//! The planner finds the directions that the outputs sample, and the fewest, tightest views that
//! show them.
//!
//! There is one folder for each step. `sampling` finds the directions that outputs show. `fitting`
//! finds the opening and the resolution of a view with given axes. `arranging` chooses the views.
//! `placing` puts them into the atlas. `planner` runs the steps. `view_plan` holds the request and
//! the result; `reporting` reports on the result. Each folder uses only folders before it.
//!
//! Resolution at quality 1: a projector or a perspective output gets at least one texel per pixel
//! in every direction, everywhere; a domemaster gets its nominal resolution (diameter over
//! aperture) in every direction, everywhere, or that of its own pixels (`[views] resolution =
//! "full"`).

pub mod arranging;
pub mod fitting;
pub mod placing;
pub mod planner;
pub mod reporting;
pub mod sampling;
pub mod view_plan;

pub use crate::views::arranging::cells::{CellCosts, with_cell_costs};
pub use crate::views::arranging::cost::cost;
pub use crate::views::planner::plan;
pub use crate::views::reporting::plan_report::{OutputShare, Report, ViewReport, report};
pub use crate::views::reporting::survey::{Surveyed, Surveyor, survey};
pub use crate::views::view_plan::{Request, Tile, View, ViewPlan};

#[cfg(test)]
pub(crate) mod tests;
