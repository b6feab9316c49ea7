//! From rig and views to passes.
//!
//! `builder` runs the planner of the views and makes a pass for each output. `examiner` divides an
//! output into blocks and finds the needs of each: views, neighbours, and a test for pixels that
//! show nothing. It also finds pixels that no view serves; `builder` then widens views. `blocks`
//! makes batches of the blocks, and `by_method` changes them for tables and meshes. `rectangles`
//! merges blocks that share a shader; `cover` finds the pixels that stay black. From a finished
//! plan, `unsampled` finds the parts of views that no pixel samples, and `footprints` the pixels
//! that sample a part of a view. Needs and unsampled areas are cached.

pub mod blocks;
pub mod builder;
pub mod by_method;
pub mod cover;
pub mod examiner;
pub mod footprints;
pub mod needs;
pub mod picture;
pub mod rectangles;
pub mod unsampled;
pub mod unsampled_cached;
