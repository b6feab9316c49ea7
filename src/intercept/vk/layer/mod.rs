//! Loader interface: `vkNegotiateLoaderLayerInterfaceVersion`, `vk…ProcAddr`, `vkCreateInstance`,
//! `vkCreateDevice` and their counterparts.
//!
//! [`negotiate`] gives the loader our `Get…ProcAddr`, which answer from [`table`]. Where Cupola has
//! nothing to do on a device, the loader gets the next layer's own addresses. [`device`] builds a
//! `Device` of its parts and takes them down in order; [`features`] enables what the rig needs. The
//! room has no state of its own: instances and devices are in `state`.
//!
//! ```text
//! loader ─ negotiate ─ table ─┬─ device, instance: made and destroyed
//!                             └─ HOOKS of each room ─ next layer
//! ```

mod chain_links;
pub mod device;
mod device_structures;
#[cfg(test)]
mod every_command;
pub mod features;
pub mod instance;
pub mod negotiate;
pub mod table;
