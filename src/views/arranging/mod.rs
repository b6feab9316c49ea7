//! Third step of the planner: which views there are.
//!
//! `choose` compares the families of views: a dedicated view for each output (`dedicated`), views
//! that several outputs share as cells of the direction sphere (`partition`), or a mixture. Outputs
//! whose vertices are projected straight to their pixels have a view of their own (`projected`). A
//! rig with content has one view for all of them (`content`). `cost` says what a view costs beside
//! its texels. The result is an arrangement of planned views (`planned_view`), which have no place
//! yet. `cached` keeps it for the next start, and `cells` gives searches of the laboratory the cost
//! of any cells. `unseen` makes views for pixels that the samples missed.

pub mod cached;
pub mod cells;
pub mod choose;
pub mod content;
pub mod cost;
pub mod dedicated;
pub mod partition;
pub mod planned_view;
pub mod projected;
pub mod unseen;
