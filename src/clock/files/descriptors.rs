//! Descriptors of timers: their copies.

use super::timers;
use crate::caller::interpose;
use crate::real;
use std::ffi::c_int;

interpose! {
    1 dup => dup_for;
    2 dup2 => dup2_for;
    3 dup3 => dup3_for;
    3 fcntl => fcntl_for;
    3 fcntl64 => fcntl_for;
}

// These functions serve each descriptor of the program, also in handlers of signals. Those that are
// no timers cost the look at a mark, and no lock.

unsafe extern "C" fn dup_for(file: c_int, _caller: usize) -> c_int {
    // SAFETY: the program's own call.
    let new = unsafe { real::dup(file) };
    timers::copy(file, new);
    new
}

unsafe extern "C" fn dup2_for(file: c_int, new: c_int, _caller: usize) -> c_int {
    // SAFETY: the program's own call.
    let new = unsafe { real::dup2(file, new) };
    timers::copy(file, new);
    new
}

unsafe extern "C" fn dup3_for(file: c_int, new: c_int, flags: c_int, _caller: usize) -> c_int {
    // SAFETY: the program's own call.
    let new = unsafe { real::dup3(file, new, flags) };
    timers::copy(file, new);
    new
}

/// The third argument exists only for some commands. Both kinds of processors pass it in a register
/// in any case.
unsafe extern "C-unwind" fn fcntl_for(file: c_int, command: c_int, argument: usize, _caller: usize) -> c_int {
    // SAFETY: the program's own call.
    let answer = unsafe { real::fcntl(file, command, argument) };
    if matches!(command, libc::F_DUPFD | libc::F_DUPFD_CLOEXEC) {
        timers::copy(file, answer);
    }
    answer
}
