//! Waits for files and connections, with limits in the program's time, and timers that are files.

use super::caller::{interpose, is_served};
use super::real;
use super::timeline::{after, is_held_before, moment, nanoseconds, now, start_of, timespec, wait};
use std::ffi::{c_int, c_long};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

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
    2 timerfd_create => timerfd_create_for;
    4 timerfd_settime => timerfd_settime_for;
    2 timerfd_gettime => timerfd_gettime_for;
}

/// Longest real time for which the drawing thread waits for input from outside. Then its time
/// advances to the limit.
const PATIENCE: Duration = Duration::from_millis(250);

/// Waits until `attempt` returns a number other than 0, or until `deadline`.
fn wait_for_files(deadline: Option<u64>, mut attempt: impl FnMut(Option<Duration>) -> c_int) -> c_int {
    let mut attempt = |limit| Some(attempt(limit)).filter(|count| *count != 0);
    loop {
        let timer = next_timer();
        let target = [deadline, timer].into_iter().flatten().min();
        let came = wait(target, PATIENCE, &mut attempt);
        if let Some(count) = came {
            return count;
        }
        let Some(target) = target else { continue };
        if is_held_before(target) {
            // The time is held: timers are not due, and a limit has lasted its real time.
            if deadline.is_some() {
                return 0;
            }
            continue;
        }
        fire(target);
        if deadline == Some(target) || timer == Some(target) {
            if let Some(count) = attempt(Some(Duration::ZERO)) {
                return count;
            }
            if deadline == Some(target) {
                return 0;
            }
        }
    }
}

/// A limit in milliseconds, converted to nanoseconds; `None` if it is negative: without a limit.
fn milliseconds(limit: c_int) -> Option<u64> {
    u64::try_from(limit).ok().map(|limit| limit * 1_000_000)
}

/// Pointer to a limit, as system calls take it.
fn pointer(limit: &Option<libc::timespec>) -> *const libc::timespec {
    limit.as_ref().map_or(std::ptr::null(), std::ptr::from_ref)
}

/// Converts a real limit for libc.
fn real_limit(limit: Option<Duration>) -> Option<libc::timespec> {
    limit.map(|limit| timespec(u64::try_from(limit.as_nanos()).unwrap_or(u64::MAX)))
}

unsafe extern "C-unwind" fn poll_for(
    files: *mut libc::pollfd,
    count: libc::nfds_t,
    limit: c_int,
    caller: usize,
) -> c_int {
    // SAFETY: the program's own call, with its limit in another form.
    unsafe {
        if limit == 0 || !is_served(caller) {
            return real::poll(files, count, limit);
        }
        let attempt = |limit| real::ppoll(files, count, pointer(&real_limit(limit)), std::ptr::null());
        wait_for_files(milliseconds(limit).map(after), attempt)
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

unsafe extern "C-unwind" fn ppoll_for(
    files: *mut libc::pollfd,
    count: libc::nfds_t,
    limit: *const libc::timespec,
    mask: *const libc::sigset_t,
    caller: usize,
) -> c_int {
    // SAFETY: the program's own call, with its limit in another form.
    unsafe {
        let length = limit.as_ref().map(nanoseconds);
        if length == Some(None) || length == Some(Some(0)) || !is_served(caller) {
            return real::ppoll(files, count, limit, mask);
        }
        let attempt = |limit| real::ppoll(files, count, pointer(&real_limit(limit)), mask);
        wait_for_files(length.flatten().map(after), attempt)
    }
}

unsafe extern "C-unwind" fn ppoll_checked(
    files: *mut libc::pollfd,
    count: libc::nfds_t,
    limit: *const libc::timespec,
    mask: *const libc::sigset_t,
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

unsafe extern "C-unwind" fn select_for(
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
        let Some(sets) = sets.filter(|_| length != Some(None) && length != Some(Some(0))) else {
            return real::select(count, read, write, other, limit);
        };
        selected(count, &sets, length.flatten(), std::ptr::null())
    }
}

unsafe extern "C-unwind" fn pselect_for(
    count: c_int,
    read: *mut libc::fd_set,
    write: *mut libc::fd_set,
    other: *mut libc::fd_set,
    limit: *const libc::timespec,
    mask: *const libc::sigset_t,
    caller: usize,
) -> c_int {
    // SAFETY: the program's own call, with its limit in another form.
    unsafe {
        let length = limit.as_ref().map(nanoseconds);
        let sets = Sets::new(count, [read, write, other]).filter(|_| is_served(caller));
        let Some(sets) = sets.filter(|_| length != Some(None) && length != Some(Some(0))) else {
            return real::pselect(count, read, write, other, limit, mask);
        };
        selected(count, &sets, length.flatten(), mask)
    }
}

unsafe fn selected(count: c_int, sets: &Sets, length: Option<u64>, mask: *const libc::sigset_t) -> c_int {
    let [read, write, other] = sets.at;
    wait_for_files(length.map(after), |limit| {
        // SAFETY: the program's own call.
        unsafe {
            sets.restore();
            real::pselect(count, read, write, other, pointer(&real_limit(limit)), mask)
        }
    })
}

unsafe extern "C-unwind" fn epoll_wait_for(
    file: c_int,
    events: *mut libc::epoll_event,
    count: c_int,
    limit: c_int,
    caller: usize,
) -> c_int {
    // SAFETY: the program's own call.
    unsafe { epoll_pwait_for(file, events, count, limit, std::ptr::null(), caller) }
}

unsafe extern "C-unwind" fn epoll_pwait_for(
    file: c_int,
    events: *mut libc::epoll_event,
    count: c_int,
    limit: c_int,
    mask: *const libc::sigset_t,
    caller: usize,
) -> c_int {
    if limit == 0 || !is_served(caller) {
        // SAFETY: the program's own call.
        return unsafe { real::epoll_pwait(file, events, count, limit, mask) };
    }
    // SAFETY: as above.
    unsafe { epolled(file, events, count, milliseconds(limit), mask) }
}

unsafe extern "C-unwind" fn epoll_pwait2_for(
    file: c_int,
    events: *mut libc::epoll_event,
    count: c_int,
    limit: *const libc::timespec,
    mask: *const libc::sigset_t,
    caller: usize,
) -> c_int {
    // SAFETY: the program's own call, with its limit in another form.
    unsafe {
        let length = limit.as_ref().map(nanoseconds);
        if length == Some(None) || length == Some(Some(0)) || !is_served(caller) {
            return real::epoll_pwait2(file, events, count, limit, mask);
        }
        epolled(file, events, count, length.flatten(), mask)
    }
}

unsafe fn epolled(
    file: c_int,
    events: *mut libc::epoll_event,
    count: c_int,
    length: Option<u64>,
    mask: *const libc::sigset_t,
) -> c_int {
    wait_for_files(length.map(after), |limit| {
        let limit =
            limit.map_or(-1, |limit| c_int::try_from(limit.as_nanos().div_ceil(1_000_000)).unwrap_or(c_int::MAX));
        // SAFETY: the program's own call.
        unsafe { real::epoll_pwait(file, events, count, limit, mask) }
    })
}

/// A timer of the program that is a file.
#[derive(Clone, Copy)]
struct Timer {
    file: c_int,
    /// Next time at which it fires, in nanoseconds since the start; 0: it is not set.
    deadline: u64,
    /// Time between later firings; 0: it fires once.
    interval: u64,
}

static TIMERS: Mutex<Vec<Timer>> = Mutex::new(Vec::new());

fn timers() -> MutexGuard<'static, Vec<Timer>> {
    TIMERS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Time at which the next timer fires.
fn next_timer() -> Option<u64> {
    timers().iter().map(|timer| timer.deadline).filter(|deadline| *deadline > 0).min()
}

/// Makes timers readable whose time has come at `time`.
pub fn fire(time: u64) {
    for timer in timers().iter_mut().filter(|timer| timer.deadline > 0 && timer.deadline <= time) {
        let late = time - timer.deadline;
        timer.deadline = match timer.interval {
            0 => 0,
            interval => timer.deadline + interval * (late / interval + 1),
        };
        set(timer.file, 1);
    }
}

/// Makes the system's timer fire once after this number of nanoseconds; 0: never.
fn set(file: c_int, after: c_long) {
    let zero = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    let new = libc::itimerspec { it_interval: zero, it_value: libc::timespec { tv_sec: 0, tv_nsec: after } };
    // SAFETY: valid structures; the system refuses a file that is no longer a timer.
    unsafe { real::timerfd_settime(file, 0, &new, std::ptr::null_mut()) };
}

unsafe extern "C" fn timerfd_create_for(clock: c_int, flags: c_int, caller: usize) -> c_int {
    // SAFETY: the program's own call.
    let file = unsafe { real::timerfd_create(clock, flags) };
    let mut timers = timers();
    timers.retain(|timer| timer.file != file);
    if file >= 0 && start_of(clock).is_some() && is_served(caller) {
        timers.push(Timer { file, deadline: 0, interval: 0 });
    }
    file
}

unsafe extern "C" fn timerfd_settime_for(
    file: c_int,
    flags: c_int,
    new: *const libc::itimerspec,
    old: *mut libc::itimerspec,
    _caller: usize,
) -> c_int {
    let mut timers = timers();
    // SAFETY: the program's structure, or null.
    let times =
        unsafe { new.as_ref() }.and_then(|new| Some((nanoseconds(&new.it_value)?, nanoseconds(&new.it_interval)?)));
    let timer = timers.iter_mut().find(|timer| timer.file == file);
    let (Some(timer), Some((value, interval))) = (timer, times) else {
        drop(timers);
        // SAFETY: the program's own call.
        return unsafe { real::timerfd_settime(file, flags, new, old) };
    };
    // SAFETY: the program's structure, or null.
    if let Some(old) = unsafe { old.as_mut() } {
        *old = timer.left();
    }
    let is_absolute = flags & libc::TFD_TIMER_ABSTIME != 0;
    timer.interval = interval;
    timer.deadline = match value {
        0 => 0,
        value if is_absolute => moment(value).max(1),
        value => after(value),
    };
    // An earlier firing that was not read is forgotten.
    set(file, 0);
    drop(timers);
    fire(now());
    0
}

unsafe extern "C" fn timerfd_gettime_for(file: c_int, time: *mut libc::itimerspec, _caller: usize) -> c_int {
    let left = timers().iter().find(|timer| timer.file == file).map(Timer::left);
    match left.filter(|_| !time.is_null()) {
        // SAFETY: the program's structure.
        Some(left) => unsafe {
            time.write(left);
            0
        },
        // SAFETY: the program's own call.
        None => unsafe { real::timerfd_gettime(file, time) },
    }
}

impl Timer {
    fn left(&self) -> libc::itimerspec {
        libc::itimerspec {
            it_interval: timespec(self.interval),
            it_value: timespec(self.deadline.saturating_sub(now())),
        }
    }
}
