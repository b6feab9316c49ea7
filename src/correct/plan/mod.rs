//! From rig and views to passes.
//!
//! `builder` runs the planner of the views and makes a pass for each output. `blocks` cuts an
//! output into squares and finds what each needs: views, neighbours, a test for pixels that show
//! nothing. `rectangles` merges blocks that share a shader; `cover` finds what they leave black.
//! From a finished plan, `unsampled` finds the parts of views that no pixel samples, and
//! `footprints` the pixels that sample a part of a view. Results of both kinds are cached.

pub mod blocks;
pub mod builder;
pub mod cover;
pub mod footprints;
pub mod needs;
pub mod rectangles;
pub mod unsampled;
pub mod unsampled_cached;
