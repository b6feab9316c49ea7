//! One window's Cupola: rig, plan and backend.

pub mod process;
