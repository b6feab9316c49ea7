//! The end of a frame.
//!
//! Answers the swaps of GLX and EGL, `glFlush` and `glFinish`. [`present`] corrects the views into
//! the window and begins the next frame, [`front_buffer`] does so for programs that draw to the
//! front, [`capture`] reads outputs at their own resolution, [`frame_number`] counts frames of each
//! window. Lower rooms are told here that a frame ended; none of them calls this room.

pub mod capture;
pub mod frame_number;
pub mod front_buffer;
pub mod present;
