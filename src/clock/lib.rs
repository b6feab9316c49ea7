//! The virtual clock: a program's time is that of its frames.
//!
//! `libcupola_clock.so` is preloaded by `cupola run --clock FPS` and by nothing else. It answers
//! the functions of libc that read clocks, wait and give random numbers; `docs/clock.md` has the
//! rules. It is an artefact of its own, since it exports names of libc: in `libcupola.so` they
//! would reach every program that links it.
//!
//! [`timeline`] holds the time, [`settings`] what the environment asks for, [`caller`] decides who
//! gets real time, [`real`] has the functions of libc; [`reads`], [`sleeps`], [`poll_and_timerfd`],
//! [`threads`] and [`random`] answer the program.

#![deny(unsafe_op_in_unsafe_fn)]
// The addresses of callers are known for these machines alone; on others the library does nothing.
#![cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]

mod caller;
mod poll_and_timerfd;
mod random;
mod reads;
mod real;
mod settings;
mod sleeps;
mod threads;
mod timeline;

use std::ffi::{c_int, c_ulong};

/// A frame of the window with this handle is complete. Cupola calls it before each swap. 1: the
/// time has gone on; 0: the frames of another window lead.
#[unsafe(no_mangle)]
pub extern "C" fn cupola_clock_frame(window: c_ulong) -> c_int {
    timeline::frame(window).into()
}

/// The program's monotonic clock goes on to this time in nanoseconds, unless it is later already.
#[unsafe(no_mangle)]
pub extern "C" fn cupola_clock_advance(time: u64) {
    timeline::advance(time);
}

/// The program's monotonic clock, in nanoseconds.
#[unsafe(no_mangle)]
pub extern "C" fn cupola_clock_time() -> u64 {
    timeline::monotonic()
}
