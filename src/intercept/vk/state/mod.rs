//! State of a device: the data of each feature, below the code that works on it.
//!
//! There is a folder or file for each part of a device, with the part's struct in its `mod.rs`:
//! types, look-ups, and methods that keep the data valid. No file here calls another module. The
//! modules above add the behaviour, as functions that take the parts that they need. [`device`]
//! combines the parts; [`hooks`] defines hooks.
//!
//! ```text
//! device ─ recording ─ queries, pipelines
//!        ─ swapchains, images, descriptors
//!        ─ views
//!        ─ driver, flatness, host_memory
//! ```

pub mod descriptors;
pub mod device;
pub mod driver;
pub mod flatness;
pub mod hooks;
pub mod host_memory;
pub mod images;
pub mod pipelines;
pub mod queries;
pub mod recording;
pub mod swapchains;
pub mod views;
