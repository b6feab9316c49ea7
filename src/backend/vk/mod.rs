//! Vulkan.
//!
//! Only functions of Vulkan 1.0 are called and no feature or extension has to be enabled: the
//! device is the program's, which may have enabled little.

mod barrier;
mod binaries;
mod descriptors;
pub mod driver;
mod images;
mod map;
mod memory;
mod passes;
mod program;
mod surface;

pub use ash;
pub use barrier::{COLOR, Use, barrier};
pub use driver::api::{Api, missing_of_device, refused};
pub use driver::timers::Timing;
pub use images::{SourceImage, TargetImage};
pub use map::gpu_map;
pub use memory::Buffer;
pub use passes::{Recording, VkBackend};
pub use surface::Surface;

#[cfg(test)]
mod tests;
