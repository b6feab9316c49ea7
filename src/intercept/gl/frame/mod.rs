//! The end of a frame.
//!
//! Hooks of the swaps of GLX and EGL, `glFlush` and `glFinish` come here. [`present`] corrects the
//! views into the window and begins the next frame; [`front_buffer`] does so for programs that draw
//! to the front buffer. [`frame_statistics`] stores statistics and captures, [`capture`] reads
//! outputs at their own resolution, [`publish`] reads pictures for other processes.
//! [`frame_number`] counts the frames of each window. [`in_turn`] collects views that are drawn in
//! turn. [`leaving`] stores frames of windows that a program leaves without a swap. This folder
//! calls the lower folders when a frame ends; they never call it.

pub mod capture;
pub mod frame_number;
pub mod frame_statistics;
pub mod front_buffer;
pub mod in_turn;
pub mod leaving;
pub mod present;
pub mod publish;
