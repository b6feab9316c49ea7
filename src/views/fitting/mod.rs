//! Second step of the planner: the opening and the resolution that a view with given axes needs.
//!
//! `fit` projects samples into a view and finds its opening. `density` finds the least resolutions
//! across and up that give every output pixel a texel. `axes` searches the direction and the roll
//! with which a view needs the fewest texels. `lanes` computes four samples at a time.

pub mod axes;
pub mod density;
pub mod fit;
pub mod lanes;
