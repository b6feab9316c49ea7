//! Waits for processes.

use super::caller::interpose;
use super::real;
use super::threads::without_limit;
use std::ffi::{c_int, c_void};

interpose! {
    1 wait => wait_for;
    3 waitpid => waitpid_for;
    3 wait3 => wait3_for;
    4 wait4 => wait4_for;
    4 waitid => waitid_for;
}

/// Waits for a process: as [`without_limit`], unless the options are to return at once.
fn wait_for_process(options: c_int, caller: usize, attempt: impl Fn() -> c_int) -> c_int {
    if options & libc::WNOHANG == 0 { without_limit(caller, attempt) } else { attempt() }
}

unsafe extern "C-unwind" fn wait_for(status: *mut c_int, caller: usize) -> libc::pid_t {
    // SAFETY: the program's own call.
    unsafe { waitpid_for(-1, status, 0, caller) }
}

unsafe extern "C-unwind" fn waitpid_for(
    process: libc::pid_t,
    status: *mut c_int,
    options: c_int,
    caller: usize,
) -> libc::pid_t {
    // SAFETY: the program's own call.
    wait_for_process(options, caller, || unsafe { real::waitpid(process, status, options) })
}

unsafe extern "C-unwind" fn wait3_for(
    status: *mut c_int,
    options: c_int,
    usage: *mut libc::rusage,
    caller: usize,
) -> libc::pid_t {
    // SAFETY: the program's own call.
    unsafe { wait4_for(-1, status, options, usage, caller) }
}

pub unsafe extern "C-unwind" fn wait4_for(
    process: libc::pid_t,
    status: *mut c_int,
    options: c_int,
    usage: *mut libc::rusage,
    caller: usize,
) -> libc::pid_t {
    // SAFETY: the program's own call.
    wait_for_process(options, caller, || unsafe { real::wait4(process, status, options, usage) })
}

unsafe extern "C-unwind" fn waitid_for(
    kind: c_int,
    process: libc::id_t,
    answer: *mut c_void,
    options: c_int,
    caller: usize,
) -> c_int {
    // SAFETY: the program's own call.
    wait_for_process(options, caller, || unsafe { real::waitid(kind, process, answer, options) })
}
