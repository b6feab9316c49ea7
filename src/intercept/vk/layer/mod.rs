//! TODO-NOTE

mod chain_links;
pub mod device;
mod device_structures;
#[cfg(test)]
mod every_command;
pub mod features;
pub mod instance;
pub mod negotiate;
pub mod table;
