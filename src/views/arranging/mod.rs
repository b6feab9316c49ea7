//! Third step of the planner: the choice of the views.
//!
//! `choose` compares the families of views: dedicated views for each output (`dedicated`), views
//! that several outputs share as cells of the direction sphere (`partition`), or a mixture. Outputs
//! whose vertices are projected directly to their pixels have a dedicated view (`projected`). A rig
//! with content has one view for all outputs (`content`). `cost` is the cost of a view beside its
//! texels. The result is an arrangement of planned views (`planned_view`), which have no tile yet.
//! `cached` stores it for the next start. `cells` computes the cost of any cells, for searches of
//! the laboratory. `unseen` makes views for pixels that the samples missed.

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
