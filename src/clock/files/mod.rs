//! Waits for files and connections, with limits in the program's time.
//!
//! [`timers`] has those of them that are timers; [`descriptors`] follows their copies. [`signals`]
//! end a wait also if they come between its calls of the system.

pub mod descriptors;
pub mod signals;
pub mod timers;

use super::caller::{interpose, is_served};
use super::real;
use super::timeline::{self, after, is_held_before, nanoseconds, timespec, wait_again};
use signals::Kept;
use std::cell::Cell;
use std::ffi::c_int;
use std::time::Duration;
use timers::Watched;

interpose! {
    3 poll => poll_for;
    4 __poll_chk => poll_checked;
    4 ppoll => ppoll_for;
    5 __ppoll_chk => ppoll_checked;
    5 select => select_for;
    6 pselect => pselect_for;
    4 epoll_wait => epoll_wait_for;
    5 epoll_pwait => epoll_pwait_for;
    5 epoll_pwait2 => epoll_pwait2_for;
}

/// Longest real time for which the drawing thread waits for input from outside. Then its time
/// advances to the limit.
const PATIENCE: Duration = Duration::from_millis(250);

/// A mask of signals; null: that of the thread.
type Mask = *const libc::sigset_t;

/// Waits until `attempt` returns a number other than 0, or until `deadline`. Timers among the
/// watched files end the wait, too, also those that another thread sets meanwhile. `attempt` is one
/// call of the system, with the mask that it gets.
fn wait_for_files(
    deadline: Option<u64>,
    watched: &Watched,
    mask: Mask,
    mut attempt: impl FnMut(Option<Duration>, Mask) -> c_int,
) -> c_int {
    let kept = Kept::begin();
    let mut attempt = |limit| Some(attempt(limit, kept.mask(mask))).filter(|count| *count != 0);
    let reached = Cell::new(None);
    let target = || {
        // While the time is held, timers are not due.
        let timer = watched.next().filter(|timer| !is_held_before(*timer));
        reached.set([deadline, timer].into_iter().flatten().min());
        reached.get()
    };
    loop {
        let came = wait_again(target, watched.again(), PATIENCE, &mut attempt).or_else(|| {
            watched.fire();
            attempt(Some(Duration::ZERO))
        });
        match came {
            Some(count) => return count,
            // Also if the time is held: then the limit has lasted its real time.
            None if deadline.is_some() && reached.get() == deadline => return 0,
            None => {}
        }
    }
}

/// Looks at files without waiting. If a timer is among them, this counts as a read of a clock:
/// the program may do nothing else until the timer expires.
fn look(watched: &Watched, mut attempt: impl FnMut() -> c_int) -> c_int {
    let count = attempt();
    if count != 0 || !watched.has_timers() {
        return count;
    }
    timeline::read();
    watched.fire();
    attempt()
}

/// Waits for as long as the program asked: `None`: without a limit; 0: not at all.
fn wait_or_look(
    length: Option<u64>,
    watched: &Watched,
    mask: Mask,
    mut attempt: impl FnMut(Option<Duration>, Mask) -> c_int,
) -> c_int {
    match length {
        Some(0) => look(watched, || attempt(Some(Duration::ZERO), mask)),
        _ => wait_for_files(length.map(after), watched, mask, attempt),
    }
}

/// A limit in milliseconds, converted to nanoseconds; `None` if it is negative: without a limit.
fn milliseconds(limit: c_int) -> Option<u64> {
    u64::try_from(limit).ok().map(|limit| limit * 1_000_000)
}

/// Length of a served wait with this limit, as of [`wait_or_look`]. `None`: the system waits, because
/// the caller has real time, or the limit is none.
///
/// # Safety
/// The limit must be null or one of the program.
unsafe fn served_length(limit: *const libc::timespec, caller: usize) -> Option<Option<u64>> {
    // SAFETY: as promised.
    let length = unsafe { limit.as_ref() }.map(nanoseconds);
    (length != Some(None) && is_served(caller)).then(|| length.flatten())
}

/// Pointer to a limit, as system calls take it.
fn pointer(limit: &Option<libc::timespec>) -> *const libc::timespec {
    limit.as_ref().map_or(std::ptr::null(), std::ptr::from_ref)
}

/// Converts a real limit for libc.
fn real_limit(limit: Option<Duration>) -> Option<libc::timespec> {
    limit.map(|limit| timespec(u64::try_from(limit.as_nanos()).unwrap_or(u64::MAX)))
}

pub unsafe extern "C-unwind" fn poll_for(
    files: *mut libc::pollfd,
    count: libc::nfds_t,
    limit: c_int,
    caller: usize,
) -> c_int {
    // SAFETY: the program's own call, with its limit in another form.
    unsafe {
        if !is_served(caller) {
            return real::poll(files, count, limit);
        }
        polled(files, count, milliseconds(limit), std::ptr::null())
    }
}

unsafe extern "C-unwind" fn poll_checked(
    files: *mut libc::pollfd,
    count: libc::nfds_t,
    limit: c_int,
    _length: usize,
    caller: usize,
) -> c_int {
    // SAFETY: the program's own call.
    unsafe { poll_for(files, count, limit, caller) }
}

pub unsafe extern "C-unwind" fn ppoll_for(
    files: *mut libc::pollfd,
    count: libc::nfds_t,
    limit: *const libc::timespec,
    mask: Mask,
    caller: usize,
) -> c_int {
    // SAFETY: the program's own call, with its limit in another form.
    unsafe {
        match served_length(limit, caller) {
            Some(length) => polled(files, count, length, mask),
            None => real::ppoll(files, count, limit, mask),
        }
    }
}

unsafe fn polled(files: *mut libc::pollfd, count: libc::nfds_t, length: Option<u64>, mask: Mask) -> c_int {
    let listed = match usize::try_from(count) {
        // SAFETY: the program's list. No process has more descriptors than a `c_int` can tell.
        Ok(count) if !files.is_null() && c_int::try_from(count).is_ok() => unsafe {
            std::slice::from_raw_parts(files, count)
        },
        _ => &[],
    };
    let is_read = |file: &&libc::pollfd| file.events & (libc::POLLIN | libc::POLLRDNORM) != 0;
    let watched = Watched::of(listed.iter().filter(is_read).map(|file| file.fd));
    // SAFETY: the program's own call, with its limit in another form.
    let attempt = |limit, mask| unsafe { real::ppoll(files, count, pointer(&real_limit(limit)), mask) };
    wait_or_look(length, &watched, mask, attempt)
}

unsafe extern "C-unwind" fn ppoll_checked(
    files: *mut libc::pollfd,
    count: libc::nfds_t,
    limit: *const libc::timespec,
    mask: Mask,
    _length: usize,
    caller: usize,
) -> c_int {
    // SAFETY: the program's own call.
    unsafe { ppoll_for(files, count, limit, mask, caller) }
}

/// Sets of `select`, which each attempt changes.
struct Sets {
    at: [*mut libc::fd_set; 3],
    before: [Option<libc::fd_set>; 3],
}

impl Sets {
    /// Copies the sets of the program. `None` if they are longer than libc's type.
    unsafe fn new(count: c_int, at: [*mut libc::fd_set; 3]) -> Option<Self> {
        // SAFETY: the program's sets, or null.
        let before = at.map(|set| unsafe { set.as_ref().copied() });
        usize::try_from(count).is_ok_and(|count| count <= libc::FD_SETSIZE).then_some(Self { at, before })
    }

    /// Writes the sets back as they were.
    unsafe fn restore(&self) {
        for (at, before) in self.at.iter().zip(&self.before) {
            if let Some(before) = before {
                // SAFETY: the program's set.
                unsafe { at.write(*before) };
            }
        }
    }
}

pub unsafe extern "C-unwind" fn select_for(
    count: c_int,
    read: *mut libc::fd_set,
    write: *mut libc::fd_set,
    other: *mut libc::fd_set,
    limit: *mut libc::timeval,
    caller: usize,
) -> c_int {
    // SAFETY: the program's own call, with its limit in another form.
    unsafe {
        let limited =
            limit.as_ref().map(|limit| libc::timespec { tv_sec: limit.tv_sec, tv_nsec: limit.tv_usec * 1000 });
        let length = limited.as_ref().map(nanoseconds);
        let sets = Sets::new(count, [read, write, other]).filter(|_| is_served(caller));
        let Some(sets) = sets.filter(|_| length != Some(None)) else {
            return real::select(count, read, write, other, limit);
        };
        selected(count, &sets, length.flatten(), std::ptr::null())
    }
}

pub unsafe extern "C-unwind" fn pselect_for(
    count: c_int,
    read: *mut libc::fd_set,
    write: *mut libc::fd_set,
    other: *mut libc::fd_set,
    limit: *const libc::timespec,
    mask: Mask,
    caller: usize,
) -> c_int {
    // SAFETY: the program's own call, with its limit in another form.
    unsafe {
        let length = limit.as_ref().map(nanoseconds);
        let sets = Sets::new(count, [read, write, other]).filter(|_| is_served(caller));
        let Some(sets) = sets.filter(|_| length != Some(None)) else {
            return real::pselect(count, read, write, other, limit, mask);
        };
        selected(count, &sets, length.flatten(), mask)
    }
}

unsafe fn selected(count: c_int, sets: &Sets, length: Option<u64>, mask: Mask) -> c_int {
    let [read, write, other] = sets.at;
    let is_read = |file: &c_int| match &sets.before[0] {
        // SAFETY: a copy of the program's set, which has place for all files below `count`.
        Some(set) => unsafe { libc::FD_ISSET(*file, set) },
        None => false,
    };
    wait_or_look(length, &Watched::of((0..count).filter(is_read)), mask, |limit, mask| {
        // SAFETY: the program's own call.
        unsafe {
            sets.restore();
            real::pselect(count, read, write, other, pointer(&real_limit(limit)), mask)
        }
    })
}

pub unsafe extern "C-unwind" fn epoll_wait_for(
    file: c_int,
    events: *mut libc::epoll_event,
    count: c_int,
    limit: c_int,
    caller: usize,
) -> c_int {
    // SAFETY: the program's own call.
    unsafe { epoll_pwait_for(file, events, count, limit, std::ptr::null(), caller) }
}

pub unsafe extern "C-unwind" fn epoll_pwait_for(
    file: c_int,
    events: *mut libc::epoll_event,
    count: c_int,
    limit: c_int,
    mask: Mask,
    caller: usize,
) -> c_int {
    if !is_served(caller) {
        // SAFETY: the program's own call.
        return unsafe { real::epoll_pwait(file, events, count, limit, mask) };
    }
    // SAFETY: as above.
    unsafe { epolled(file, events, count, milliseconds(limit), mask) }
}

pub unsafe extern "C-unwind" fn epoll_pwait2_for(
    file: c_int,
    events: *mut libc::epoll_event,
    count: c_int,
    limit: *const libc::timespec,
    mask: Mask,
    caller: usize,
) -> c_int {
    // SAFETY: the program's own call, with its limit in another form.
    unsafe {
        match served_length(limit, caller) {
            Some(length) => epolled(file, events, count, length, mask),
            None => real::epoll_pwait2(file, events, count, limit, mask),
        }
    }
}

unsafe fn epolled(file: c_int, events: *mut libc::epoll_event, count: c_int, length: Option<u64>, mask: Mask) -> c_int {
    wait_or_look(length, &Watched::Epoll(file), mask, |limit, mask| {
        let limit =
            limit.map_or(-1, |limit| c_int::try_from(limit.as_nanos().div_ceil(1_000_000)).unwrap_or(c_int::MAX));
        // SAFETY: the program's own call.
        unsafe { real::epoll_pwait(file, events, count, limit, mask) }
    })
}
