//! From rig and views to passes.
//!
//! `builder` runs the planner of the views and makes a pass for each output. `examiner` cuts an
//! output into squares and finds what each needs (views, neighbours, a test for pixels that show
//! nothing), and pixels for which no view answers: `builder` has views widened by these. `blocks`
//! makes batches of the squares. `rectangles` merges those that share a shader; `cover` finds what
//! they leave black. From a finished plan, `unsampled` finds the parts of views that no pixel
//! samples, and `footprints` the pixels that sample a part of a view. Results of both kinds are
//! cached.

pub mod blocks;
pub mod builder;
pub mod cover;
pub mod examiner;
pub mod footprints;
pub mod needs;
pub mod picture;
pub mod rectangles;
pub mod unsampled;
pub mod unsampled_cached;
