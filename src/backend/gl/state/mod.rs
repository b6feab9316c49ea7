//! The state of the program's context that the correction changes: read, set, restored.
//!
//! `saved` is the state that drawing changes, `upload` the state that uploading changes. Values in
//! `known_state`, which the caller follows, are not queried. `current_program` is the program in
//! use with its subroutines, which `glUseProgram` resets.

mod capabilities;
pub mod current_program;
pub mod known_state;
mod saved;
mod upload;

pub(in crate::backend::gl) use capabilities::Capabilities;
pub(in crate::backend::gl) use saved::{
    UNITS, can_draw, clear, restore, save_and_set, set_color_writes, set_viewport, within,
};
pub(in crate::backend::gl) use upload::while_uploading;
