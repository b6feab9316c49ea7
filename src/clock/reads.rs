//! Clocks that the program reads.

use super::caller::{interpose, is_served};
use super::real;
use super::timeline::{read, start_of, timespec};
use std::ffi::{c_int, c_ushort, c_void};

interpose! {
    2 clock_gettime => clock_gettime_for;
    2 __clock_gettime => clock_gettime_for;
    2 gettimeofday => gettimeofday_for;
    1 time => time_for;
    1 ftime => ftime_for;
    2 timespec_get => timespec_get_for;
    0 clock => clock_for;
    1 times => times_for;
}

/// Time of a clock for a program that reads it; `None` if libc answers.
fn time_of(clock: libc::clockid_t, caller: usize) -> Option<libc::timespec> {
    let start = start_of(clock).filter(|_| is_served(caller))?;
    Some(timespec(start + read()))
}

pub unsafe extern "C" fn clock_gettime_for(clock: libc::clockid_t, time: *mut libc::timespec, caller: usize) -> c_int {
    match time_of(clock, caller).filter(|_| !time.is_null()) {
        // SAFETY: the program's structure.
        Some(now) => unsafe {
            time.write(now);
            0
        },
        // SAFETY: the program's own call.
        None => unsafe { real::clock_gettime(clock, time) },
    }
}

pub unsafe extern "C" fn gettimeofday_for(time: *mut libc::timeval, zone: *mut c_void, caller: usize) -> c_int {
    match time_of(libc::CLOCK_REALTIME, caller).filter(|_| !time.is_null()) {
        // SAFETY: the program's structure.
        Some(now) => unsafe {
            time.write(libc::timeval { tv_sec: now.tv_sec, tv_usec: now.tv_nsec / 1000 });
            0
        },
        // SAFETY: the program's own call.
        None => unsafe { real::gettimeofday(time, zone) },
    }
}

pub unsafe extern "C" fn time_for(time: *mut libc::time_t, caller: usize) -> libc::time_t {
    let Some(now) = time_of(libc::CLOCK_REALTIME, caller) else {
        // SAFETY: the program's own call.
        return unsafe { real::time(time) };
    };
    if !time.is_null() {
        // SAFETY: the program's number.
        unsafe { time.write(now.tv_sec) };
    }
    now.tv_sec
}

/// `struct timeb`, which the crate `libc` lacks.
#[repr(C)]
pub struct TimeB {
    time: libc::time_t,
    milliseconds: c_ushort,
    zone: i16,
    summer: i16,
}

unsafe extern "C" fn ftime_for(time: *mut TimeB, caller: usize) -> c_int {
    let mut now = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: a local structure.
    unsafe { clock_gettime_for(libc::CLOCK_REALTIME, &mut now, caller) };
    let milliseconds = (now.tv_nsec / 1_000_000) as c_ushort;
    // SAFETY: the program's structure.
    unsafe { time.write(TimeB { time: now.tv_sec, milliseconds, zone: 0, summer: 0 }) };
    0
}

unsafe extern "C" fn timespec_get_for(time: *mut libc::timespec, base: c_int, caller: usize) -> c_int {
    const TIME_UTC: c_int = 1;
    match time_of(libc::CLOCK_REALTIME, caller).filter(|_| base == TIME_UTC && !time.is_null()) {
        // SAFETY: the program's structure.
        Some(now) => unsafe {
            time.write(now);
            base
        },
        // SAFETY: the program's own call.
        None => unsafe { real::timespec_get(time, base) },
    }
}

unsafe extern "C" fn clock_for(caller: usize) -> libc::clock_t {
    match time_of(libc::CLOCK_PROCESS_CPUTIME_ID, caller) {
        Some(now) => now.tv_sec * 1_000_000 + now.tv_nsec / 1000,
        // SAFETY: returns a number.
        None => unsafe { real::clock() },
    }
}

unsafe extern "C" fn times_for(times: *mut libc::tms, caller: usize) -> libc::clock_t {
    let Some(now) = time_of(libc::CLOCK_PROCESS_CPUTIME_ID, caller) else {
        // SAFETY: the program's own call.
        return unsafe { real::times(times) };
    };
    // Ticks of a hundredth of a second, as Linux has them for programs.
    let ticks = now.tv_sec * 100 + now.tv_nsec / 10_000_000;
    if !times.is_null() {
        // SAFETY: the program's structure.
        unsafe { times.write(libc::tms { tms_utime: ticks, tms_stime: 0, tms_cutime: 0, tms_cstime: 0 }) };
    }
    ticks
}
