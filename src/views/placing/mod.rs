//! Fourth step of the planner: the tiles of the views in the atlas.
//!
//! `layout` gives each planned view its size in texels, with the guard that filters need, and
//! scales all views down if the atlas is too small. `atlas` packs the tiles. `idle` finds views
//! that serve no pixel's centre; the planner removes these and places the others again.

pub mod atlas;
pub mod idle;
pub mod layout;
