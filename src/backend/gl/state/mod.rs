//! The state of the program's context that correcting touches: read, set, put back.
//!
//! `saved` is what drawing touches, `upload` what uploading does. What is known of the state
//! (`known_state`, followed by the caller) is not asked for. `current_program` is the program in
//! use with its subroutines, which OpenGL forgets.

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
