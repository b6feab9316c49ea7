//! The virtual clock: a program's time follows its frames.
//!
//! `libcupola_clock.so` is preloaded by `cupola run --clock FPS` and by nothing else. It answers
//! the functions of libc that read clocks, wait and give random numbers; `docs/clock.md` has the
//! rules. It is a library of its own because it exports names of libc: in `libcupola.so` they would
//! affect every program that links it.
//!
//! [`timeline`] has the time, [`settings`] the requests of the environment. By a [`page`] other
//! processes hold the time. [`caller`] decides who gets real time; [`real`] has the functions of
//! libc. [`reads`], [`sleeps`], [`files`], [`threads`], [`process`] and [`random`] answer the program,
//! [`syscalls`] what it asks of the system without libc.

#![deny(unsafe_op_in_unsafe_fn)]
// The address of a caller is known only on these machines; on others the library does nothing.
#![cfg(any(target_arch = "x86_64", target_arch = "aarch64"))]

mod caller;
mod files;
mod page;
mod process;
mod random;
mod reads;
mod real;
mod settings;
mod sleeps;
mod syscalls;
mod threads;
mod timeline;

use std::ffi::{c_int, c_ulong};

/// The dynamic linker calls it when it has loaded this library.
#[used]
#[unsafe(link_section = ".init_array")]
static BEGIN: extern "C" fn() = {
    extern "C" fn begin() {
        real::prepare();
        if settings::settings().is_some() {
            process::begin();
        }
    }
    begin
};

/// Announces that a frame of the window with this handle is complete. Cupola calls it before each
/// swap. Returns 1 if the time has advanced, 0 if the frames of another window count.
#[unsafe(no_mangle)]
pub extern "C" fn cupola_clock_frame(window: c_ulong) -> c_int {
    timeline::frame(window).into()
}

/// Advances the program's monotonic clock to this time in nanoseconds, unless it is later already.
#[unsafe(no_mangle)]
pub extern "C" fn cupola_clock_advance(time: u64) {
    timeline::advance(time);
}

/// Returns the program's monotonic clock, in nanoseconds.
#[unsafe(no_mangle)]
pub extern "C" fn cupola_clock_time() -> u64 {
    timeline::monotonic()
}
