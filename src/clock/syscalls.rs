//! System calls by `syscall`, with which libraries of other languages make calls that libc also
//! offers.

use super::caller::{interpose, is_served};
use super::files::{self, descriptors, timers};
use super::threads::{PATIENCE, real_end};
use super::timeline::{self, moment, nanoseconds, timespec, wait};
use super::{process, random, reads, real, sleeps};
use std::ffi::{c_int, c_long};

interpose! {
    7 syscall => syscall_for;
}

#[allow(clippy::too_many_arguments)]
unsafe extern "C-unwind" fn syscall_for(
    number: c_long,
    a: usize,
    b: usize,
    c: usize,
    d: usize,
    e: usize,
    f: usize,
    caller: usize,
) -> c_long {
    // SAFETY: the program's own call.
    unsafe {
        if !is_served(caller) {
            return real::syscall(number, a, b, c, d, e, f);
        }
        match number {
            libc::SYS_clock_gettime => reads::clock_gettime_for(a as libc::clockid_t, b as *mut _, caller).into(),
            libc::SYS_gettimeofday => reads::gettimeofday_for(a as *mut _, b as *mut _, caller).into(),
            #[cfg(target_arch = "x86_64")]
            libc::SYS_time => reads::time_for(a as *mut _, caller),
            libc::SYS_getpid => process::getpid_for(caller).into(),
            libc::SYS_getppid => process::getppid_for(caller).into(),
            #[cfg(target_arch = "x86_64")]
            libc::SYS_getpgrp => process::getpgrp_for(caller).into(),
            libc::SYS_getpgid => process::getpgid_for(a as libc::pid_t, caller).into(),
            libc::SYS_getsid => process::getsid_for(a as libc::pid_t, caller).into(),
            libc::SYS_setsid => process::setsid_for(caller).into(),
            libc::SYS_ioctl => process::ioctl_for(a as c_int, b as _, c, caller).into(),
            libc::SYS_getrandom => random::getrandom_for(a as *mut _, b, c as _, caller) as c_long,
            libc::SYS_nanosleep => sleeps::nanosleep_for(a as *const _, b as *mut _, caller).into(),
            libc::SYS_clock_nanosleep => {
                match sleeps::clock_nanosleep_for(a as libc::clockid_t, b as c_int, c as *const _, d as *mut _, caller)
                {
                    0 => 0,
                    error => real::fail(error).into(),
                }
            }
            libc::SYS_wait4 => {
                process::wait4_for(a as libc::pid_t, b as *mut _, c as c_int, d as *mut _, caller).into()
            }
            // The last argument, which libc lacks, asks for the usage of resources.
            libc::SYS_waitid if e == 0 => {
                process::waitid_for(a as c_int, b as libc::id_t, c as *mut _, d as c_int, caller).into()
            }
            libc::SYS_futex => futex(a, b, c, d, e, f).unwrap_or_else(|| real::syscall(number, a, b, c, d, e, f)),
            _ => files(number, [a, b, c, d, e, f], caller),
        }
    }
}

/// System calls that wait for files, and those for timers that are files.
///
/// # Safety
/// As the system call.
unsafe fn files(number: c_long, arguments: [usize; 6], caller: usize) -> c_long {
    let [a, b, c, d, e, f] = arguments;
    let file = a as c_int;
    // SAFETY: the program's own call, whose arguments have these types.
    unsafe {
        match number {
            #[cfg(target_arch = "x86_64")]
            libc::SYS_poll => files::poll_for(a as *mut _, b as _, c as c_int, caller).into(),
            libc::SYS_ppoll => files::ppoll_for(a as *mut _, b as _, c as *const _, d as *const _, caller).into(),
            #[cfg(target_arch = "x86_64")]
            libc::SYS_select => {
                files::select_for(file, b as *mut _, c as *mut _, d as *mut _, e as *mut _, caller).into()
            }
            libc::SYS_pselect6 => {
                // The last argument is the address of the mask's address and size.
                let mask = (f as *const *const libc::sigset_t).as_ref().map_or(std::ptr::null(), |mask| *mask);
                files::pselect_for(file, b as *mut _, c as *mut _, d as *mut _, e as *const _, mask, caller).into()
            }
            #[cfg(target_arch = "x86_64")]
            libc::SYS_epoll_wait => files::epoll_wait_for(file, b as *mut _, c as c_int, d as c_int, caller).into(),
            libc::SYS_epoll_pwait => {
                files::epoll_pwait_for(file, b as *mut _, c as c_int, d as c_int, e as *const _, caller).into()
            }
            libc::SYS_epoll_pwait2 => {
                files::epoll_pwait2_for(file, b as *mut _, c as c_int, d as *const _, e as *const _, caller).into()
            }
            libc::SYS_timerfd_create => timers::timerfd_create_for(a as c_int, b as c_int, caller).into(),
            libc::SYS_timerfd_settime => {
                timers::timerfd_settime_for(file, b as c_int, c as *const _, d as *mut _, caller).into()
            }
            libc::SYS_timerfd_gettime => timers::timerfd_gettime_for(file, b as *mut _, caller).into(),
            libc::SYS_read => descriptors::read_for(file, b as *mut _, c, caller) as c_long,
            libc::SYS_readv => descriptors::readv_for(file, b as *const _, c as c_int, caller) as c_long,
            #[cfg(target_arch = "x86_64")]
            libc::SYS_dup2 => descriptors::dup2_for(file, b as c_int, caller).into(),
            libc::SYS_dup => descriptors::dup_for(file, caller).into(),
            libc::SYS_dup3 => descriptors::dup3_for(file, b as c_int, c as c_int, caller).into(),
            libc::SYS_fcntl => descriptors::fcntl_for(file, b as c_int, c, caller).into(),
            _ => {
                let [a, b, c, d, e, f] = process::real_arguments(number, arguments);
                real::syscall(number, a, b, c, d, e, f)
            }
        }
    }
}

/// Waits for a futex; `None` for its other uses.
unsafe fn futex(word: usize, flags: usize, value: usize, time: usize, other: usize, bits: usize) -> Option<c_long> {
    let real_time = libc::FUTEX_CLOCK_REALTIME as usize;
    let is_absolute = match (flags & !real_time) as c_int & libc::FUTEX_CMD_MASK {
        libc::FUTEX_WAIT => false,
        libc::FUTEX_WAIT_BITSET => true,
        _ => return None,
    };
    // SAFETY: the program's structure, or null.
    let length = match unsafe { (time as *const libc::timespec).as_ref() } {
        None => None,
        Some(time) => Some(nanoseconds(time)?),
    };
    let deadline = length.map(|length| if is_absolute { moment(length) } else { timeline::after(length) });
    let came = wait(deadline, PATIENCE, |limit| {
        let end = limit.map(|limit| match is_absolute {
            true => real_end(limit),
            false => timespec(u64::try_from(limit.as_nanos()).unwrap_or(u64::MAX)),
        });
        let end = end.as_ref().map_or(std::ptr::null(), std::ptr::from_ref::<libc::timespec>) as usize;
        // SAFETY: the program's own call, with its limit on the real monotonic clock.
        let answer = unsafe { real::syscall(libc::SYS_futex, word, flags & !real_time, value, end, other, bits) };
        // SAFETY: the thread's own number.
        (answer == 0 || limit.is_none() || unsafe { *libc::__errno_location() } != libc::ETIMEDOUT).then_some(answer)
    });
    Some(came.unwrap_or_else(|| real::fail(libc::ETIMEDOUT).into()))
}
