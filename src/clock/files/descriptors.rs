//! Descriptors of timers: reads from them, and their copies.

use super::timers::{self, Taken, Watched};
use super::{pointer, real_limit, wait_for_files};
use crate::caller::{interpose, is_served};
use crate::timeline;
use crate::{process, real};
use std::ffi::{c_int, c_void};

interpose! {
    3 read => read_for;
    4 __read_chk => read_checked;
    3 readv => readv_for;
    1 dup => dup_for;
    2 dup2 => dup2_for;
    3 dup3 => dup3_for;
    3 fcntl => fcntl_for;
    3 fcntl64 => fcntl_for;
}

// These functions serve each descriptor of the program, also in handlers of signals. Those that are
// no timers cost the look at a mark, and no lock.

pub unsafe extern "C-unwind" fn read_for(file: c_int, bytes: *mut c_void, length: usize, caller: usize) -> isize {
    if timers::may_be_timer(file) && length >= size_of::<u64>() && !bytes.is_null() && is_served(caller) {
        match read_timer(file) {
            // SAFETY: the program's bytes, which are enough.
            Some(Ok(count)) => unsafe {
                bytes.cast::<u64>().write_unaligned(count);
                return size_of::<u64>() as isize;
            },
            Some(Err(error)) => return real::fail(error) as isize,
            None => {}
        }
    }
    // SAFETY: the program's own call.
    unsafe { real::read(file, bytes, length) }
}

unsafe extern "C-unwind" fn read_checked(
    file: c_int,
    bytes: *mut c_void,
    length: usize,
    most: usize,
    caller: usize,
) -> isize {
    // SAFETY: the program's own call. libc ends the program if it is too long.
    unsafe {
        if length > most { real::__read_chk(file, bytes, length, most) } else { read_for(file, bytes, length, caller) }
    }
}

pub unsafe extern "C-unwind" fn readv_for(
    file: c_int,
    parts: *const libc::iovec,
    count: c_int,
    caller: usize,
) -> isize {
    if timers::may_be_timer(file) && count > 0 {
        // SAFETY: the program's list, or null. A timer writes one number, to the first part.
        if let Some(first) = unsafe { parts.as_ref() }
            && first.iov_len >= size_of::<u64>()
        {
            // SAFETY: the program's bytes.
            return unsafe { read_for(file, first.iov_base, first.iov_len, caller) };
        }
    }
    // SAFETY: the program's own call.
    unsafe { real::readv(file, parts, count) }
}

/// Number of expirations of a timer since it was last read, or the number of an error. If there was
/// none, a descriptor that blocks waits for one. `None` if this is no timer of the program.
fn read_timer(file: c_int) -> Option<Result<u64, c_int>> {
    let watched = Watched::of(std::iter::once(file));
    let mut has_looked = false;
    loop {
        watched.fire();
        match timers::take(file) {
            Taken::Count(count) => return Some(Ok(count)),
            Taken::Unknown => return None,
            Taken::None => {}
        }
        // SAFETY: a question about a descriptor.
        let flags = unsafe { real::fcntl(file, libc::F_GETFL, 0) };
        if flags & libc::O_NONBLOCK != 0 {
            if has_looked {
                return Some(Err(libc::EAGAIN));
            }
            has_looked = true;
            timeline::read();
            continue;
        }
        let mut asked = libc::pollfd { fd: file, events: libc::POLLIN, revents: 0 };
        let came = wait_for_files(None, &watched, std::ptr::null(), |limit, mask| {
            // SAFETY: a local structure.
            unsafe { real::ppoll(&mut asked, 1, pointer(&real_limit(limit)), mask) }
        });
        // SAFETY: the thread's own number.
        let error = if came < 0 { unsafe { *libc::__errno_location() } } else { 0 };
        if error != 0 && !(error == libc::EINTR && restarts()) {
            return Some(Err(error));
        }
    }
}

/// True if a read goes on after a signal: if the program has asked for that for each signal that it
/// handles. Which of them came is not known here.
fn restarts() -> bool {
    (1..=libc::SIGRTMAX()).all(|signal| {
        // SAFETY: a structure of numbers, which the system fills.
        let (action, is_known) = unsafe {
            let mut action: libc::sigaction = std::mem::zeroed();
            let answer = libc::sigaction(signal, std::ptr::null(), &mut action);
            (action, answer == 0)
        };
        let is_handled = is_known && action.sa_sigaction != libc::SIG_DFL && action.sa_sigaction != libc::SIG_IGN;
        !is_handled || action.sa_flags & libc::SA_RESTART != 0
    })
}

pub unsafe extern "C" fn dup_for(file: c_int, _caller: usize) -> c_int {
    // SAFETY: the program's own call.
    let new = unsafe { real::dup(file) };
    timers::copy(file, new);
    new
}

pub unsafe extern "C" fn dup2_for(file: c_int, new: c_int, _caller: usize) -> c_int {
    // SAFETY: the program's own call.
    let new = unsafe { real::dup2(file, new) };
    timers::copy(file, new);
    new
}

pub unsafe extern "C" fn dup3_for(file: c_int, new: c_int, flags: c_int, _caller: usize) -> c_int {
    // SAFETY: the program's own call.
    let new = unsafe { real::dup3(file, new, flags) };
    timers::copy(file, new);
    new
}

/// The third argument exists only for some commands. Both kinds of processors pass it in a register
/// in any case.
pub unsafe extern "C-unwind" fn fcntl_for(file: c_int, command: c_int, argument: usize, _caller: usize) -> c_int {
    // SAFETY: the program's own call.
    let answer = unsafe { process::fcntl(file, command, argument) };
    if matches!(command, libc::F_DUPFD | libc::F_DUPFD_CLOEXEC) {
        timers::copy(file, answer);
    }
    answer
}
