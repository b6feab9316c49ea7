//! Loader interface: `vkNegotiateLoaderLayerInterfaceVersion`, `vk…ProcAddr`, `vkCreateInstance`,
//! `vkCreateDevice` and their counterparts.
//!
//! [`negotiate`] gives the loader Cupola's `Get…ProcAddr`, which answer from [`table`]. If Cupola
//! has nothing to do on a device, the loader gets the next layer's own addresses. [`device`] builds
//! a `Device` from its parts and destroys them in order; [`features`] enables what the rig needs.
//! The module has no state of its own: instances and devices are in `state`.
//!
//! ```text
//! loader ─ negotiate ─ table ─┬─ device, instance: made and destroyed
//!                             └─ HOOKS of each module ─ next layer
//! ```

mod chain_links;
pub mod device;
mod device_structures;
#[cfg(test)]
mod every_command;
pub mod features;
pub mod instance;
pub mod negotiate;
mod present_barrier;
pub mod table;
