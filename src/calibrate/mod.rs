//! Finds the real places, lenses and brightness of projectors from marks or photographs.
//!
//! `marks` solves each projector for itself, from places of its picture whose direction in the dome
//! is known. `joint` solves all projectors together with a camera that has seen them; `gray` has
//! the patterns for that. `light` finds the brightness of the projectors. `projector` and `camera`
//! define the free numbers. `least_squares` finds the values that fit best although some
//! observations are wrong; `matrix` solves its equations.

pub mod camera;
pub mod gray;
pub mod joint;
pub mod least_squares;
pub mod light;
pub mod marks;
mod matrix;
pub mod projector;

pub use camera::{Camera, CameraLens};
pub use joint::{Observed, Sighting};
pub use marks::{Mark, Quality, Solved};
pub use matrix::Symmetric;
pub use projector::{Part, Projector};
