//! TODO-NOTE

pub mod device;
#[cfg(test)]
mod every_command;
pub mod features;
pub mod hooks;
pub mod instance;
pub mod negotiate;
pub mod pnext;
pub mod table;
