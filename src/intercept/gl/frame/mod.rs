//! The end of a frame.
//!
//! Answers the swaps of GLX and EGL, `glFlush` and `glFinish`. [`present`] corrects the views into
//! the window and begins the next frame, [`front_buffer`] does so for programs that draw to the
//! front, [`frame_statistics`] keeps statistics and pictures, [`capture`] reads outputs at their
//! own resolution, [`publish`] reads pictures for other processes, [`frame_number`] counts frames
//! of each window, [`in_turn`] collects views that are drawn in turn, [`leaving`] keeps frames of
//! windows that are left without a swap. This room tells the lower rooms that a frame ended. They
//! never call it.

pub mod capture;
pub mod frame_number;
pub mod frame_statistics;
pub mod front_buffer;
pub mod in_turn;
pub mod leaving;
pub mod present;
pub mod publish;
