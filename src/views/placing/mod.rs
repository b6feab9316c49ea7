//! Fourth step of the planner: where views lie in the atlas.
//!
//! `layout` gives each planned view its size in texels, with the guard that filters need, and
//! scales all views down where the atlas is too small. `atlas` packs the tiles. `idle` finds views
//! that answer for no pixel's centre; the planner removes those and places the others again.

pub mod atlas;
pub mod idle;
pub mod layout;
