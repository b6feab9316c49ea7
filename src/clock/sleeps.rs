//! Sleeps of the program.

use super::caller::{interpose, is_served};
use super::files::signals::Kept;
use super::real;
use super::timeline::{after, moment, nanoseconds, start_of, timespec, wait};
use std::ffi::{c_int, c_uint};
use std::time::Duration;

interpose! {
    2 nanosleep => nanosleep_for;
    4 clock_nanosleep => clock_nanosleep_for;
    1 usleep => usleep_for;
    1 sleep => sleep_for;
    2 thrd_sleep => nanosleep_for;
}

/// Longest real time that a sleep of the drawing thread takes. Other threads can work meanwhile.
const NAP: Duration = Duration::from_millis(1);

/// Sleeps until the program's time is `moment`. Returns whether a signal ended the sleep.
unsafe fn sleep_until(moment: u64) -> bool {
    let kept = Kept::begin();
    let nap = |limit: Option<Duration>| {
        let time = timespec(limit.map_or(0, |limit| u64::try_from(limit.as_nanos()).unwrap_or(0)));
        // SAFETY: local structures, and no files.
        (unsafe { real::ppoll(std::ptr::null_mut(), 0, &time, kept.mask(std::ptr::null())) } != 0).then_some(())
    };
    wait(Some(moment), NAP, nap).is_some()
}

pub unsafe extern "C-unwind" fn nanosleep_for(
    time: *const libc::timespec,
    left: *mut libc::timespec,
    caller: usize,
) -> c_int {
    // SAFETY: the program's structure, or null.
    let length = unsafe { time.as_ref() }.and_then(nanoseconds);
    let Some(length) = length.filter(|_| is_served(caller)) else {
        // SAFETY: the program's own call.
        return unsafe { real::nanosleep(time, left) };
    };
    let end = after(length);
    // SAFETY: no condition.
    if !unsafe { sleep_until(end) } {
        return 0;
    }
    // SAFETY: the program's structure, or null.
    if let Some(left) = unsafe { left.as_mut() } {
        *left = timespec(end.saturating_sub(after(0)));
    }
    real::fail(libc::EINTR)
}

pub unsafe extern "C-unwind" fn clock_nanosleep_for(
    clock: libc::clockid_t,
    flags: c_int,
    time: *const libc::timespec,
    left: *mut libc::timespec,
    caller: usize,
) -> c_int {
    // SAFETY: the program's structure, or null.
    let length = unsafe { time.as_ref() }.and_then(nanoseconds);
    let Some(length) = length.filter(|_| start_of(clock).is_some() && is_served(caller)) else {
        // SAFETY: the program's own call.
        return unsafe { real::clock_nanosleep(clock, flags, time, left) };
    };
    if flags & libc::TIMER_ABSTIME == 0 {
        // SAFETY: the program's structures.
        return if unsafe { nanosleep_for(time, left, caller) } == 0 { 0 } else { libc::EINTR };
    }
    // SAFETY: no condition.
    if unsafe { sleep_until(moment(length)) } { libc::EINTR } else { 0 }
}

unsafe extern "C-unwind" fn usleep_for(microseconds: c_uint, caller: usize) -> c_int {
    if !is_served(caller) {
        // SAFETY: the program's own call.
        return unsafe { real::usleep(microseconds) };
    }
    // SAFETY: no condition.
    if unsafe { sleep_until(after(u64::from(microseconds) * 1000)) } { real::fail(libc::EINTR) } else { 0 }
}

unsafe extern "C-unwind" fn sleep_for(seconds: c_uint, caller: usize) -> c_uint {
    if !is_served(caller) {
        // SAFETY: the program's own call.
        return unsafe { real::sleep(seconds) };
    }
    let end = after(u64::from(seconds) * 1_000_000_000);
    // SAFETY: no condition.
    if !unsafe { sleep_until(end) } {
        return 0;
    }
    c_uint::try_from(end.saturating_sub(after(0)).div_ceil(1_000_000_000)).unwrap_or(seconds)
}
