//! The number of the program's process, and waits for processes.
//!
//! The program reads a number that is the same in each run, because programs make seeds of it. It
//! stands for the real one where the program hands it to the system. [`copies`] begins those of the
//! process.

pub mod copies;

use super::caller::{gets_number, interpose};
use super::real;
use super::threads::without_limit;
use std::ffi::{c_int, c_long, c_uint, c_ulong, c_void};
use std::sync::atomic::{AtomicI32, Ordering};

interpose! {
    0 getpid => getpid_for;
    0 getppid => getppid_for;
    2 kill => kill_for;
    2 killpg => killpg_for;
    3 tgkill => tgkill_for;
    3 sigqueue => sigqueue_for;
    0 getpgrp => getpgrp_for;
    1 getpgid => getpgid_for;
    2 setpgid => setpgid_for;
    1 getsid => getsid_for;
    0 setsid => setsid_for;
    1 tcgetpgrp => tcgetpgrp_for;
    2 tcsetpgrp => tcsetpgrp_for;
    1 tcgetsid => tcgetsid_for;
    3 ioctl => ioctl_for;
    3 sched_setaffinity => sched_setaffinity_for;
    3 sched_getaffinity => sched_getaffinity_for;
    3 sched_setscheduler => sched_setscheduler_for;
    1 sched_getscheduler => sched_getscheduler_for;
    2 sched_setparam => sched_setparam_for;
    2 sched_getparam => sched_getparam_for;
    3 sched_setattr => sched_setattr_for;
    4 sched_getattr => sched_getattr_for;
    2 sched_rr_get_interval => sched_rr_get_interval_for;
    3 setpriority => setpriority_for;
    2 getpriority => getpriority_for;
    2 pidfd_open => pidfd_open_for;
    4 prlimit => prlimit_for;
    4 prlimit64 => prlimit_for;
    6 process_vm_readv => process_vm_readv_for;
    6 process_vm_writev => process_vm_writev_for;
    1 wait => wait_for;
    3 waitpid => waitpid_for;
    3 wait3 => wait3_for;
    4 wait4 => wait4_for;
    4 waitid => waitid_for;
}

/// Number that the program reads. No process has this number.
const PROCESS: libc::pid_t = (1 << 22) + 1;

/// Command of `fcntl`, which the crate `libc` lacks for some systems.
const F_SETOWN_EX: c_int = 15;

/// Real number of the process in which the program began. Copies that `fork` makes know it, too.
static FIRST: AtomicI32 = AtomicI32::new(0);

/// Notes the number of this process, and prepares for copies of it.
pub fn begin() {
    // SAFETY: returns a number.
    FIRST.store(unsafe { real::getpid() }, Ordering::Relaxed);
    copies::begin();
}

/// The number that a caller reads for this real one.
fn read(process: libc::pid_t, caller: usize) -> libc::pid_t {
    if process == FIRST.load(Ordering::Relaxed) && gets_number(caller) { PROCESS } else { process }
}

/// The real number that the program means. A negative one means a group of processes.
fn real_number(process: libc::pid_t) -> libc::pid_t {
    match (process, FIRST.load(Ordering::Relaxed)) {
        (PROCESS, first) if first != 0 => first,
        (process, first) if process == -PROCESS && first != 0 => -first,
        (process, _) => process,
    }
}

pub unsafe extern "C" fn getpid_for(caller: usize) -> libc::pid_t {
    // SAFETY: returns a number.
    read(unsafe { real::getpid() }, caller)
}

pub unsafe extern "C" fn getppid_for(caller: usize) -> libc::pid_t {
    // SAFETY: returns a number.
    read(unsafe { real::getppid() }, caller)
}

/// Defines functions whose first argument is the number of a process.
macro_rules! with_number {
    ($($name:ident($($argument:ident: $kind:ty),*) -> $result:ty => $real:ident;)*) => {$(
        unsafe extern "C" fn $name(process: libc::pid_t, $($argument: $kind,)* _caller: usize) -> $result {
            // SAFETY: the program's own call.
            unsafe { real::$real(real_number(process), $($argument),*) }
        }
    )*};
}

with_number! {
    kill_for(signal: c_int) -> c_int => kill;
    killpg_for(signal: c_int) -> c_int => killpg;
    sigqueue_for(signal: c_int, value: usize) -> c_int => sigqueue;
    sched_setaffinity_for(size: usize, set: *const c_void) -> c_int => sched_setaffinity;
    sched_getaffinity_for(size: usize, set: *mut c_void) -> c_int => sched_getaffinity;
    sched_setscheduler_for(policy: c_int, value: *const c_void) -> c_int => sched_setscheduler;
    sched_getscheduler_for() -> c_int => sched_getscheduler;
    sched_setparam_for(value: *const c_void) -> c_int => sched_setparam;
    sched_getparam_for(value: *mut c_void) -> c_int => sched_getparam;
    sched_setattr_for(value: *const c_void, flags: c_uint) -> c_int => sched_setattr;
    sched_getattr_for(value: *mut c_void, size: c_uint, flags: c_uint) -> c_int => sched_getattr;
    sched_rr_get_interval_for(time: *mut libc::timespec) -> c_int => sched_rr_get_interval;
    pidfd_open_for(flags: c_uint) -> c_int => pidfd_open;
    prlimit_for(kind: c_int, new: *const c_void, old: *mut c_void) -> c_int => prlimit;
    process_vm_readv_for(own: *const libc::iovec, own_count: c_ulong, other: *const libc::iovec, count: c_ulong,
        flags: c_ulong) -> isize => process_vm_readv;
    process_vm_writev_for(own: *const libc::iovec, own_count: c_ulong, other: *const libc::iovec, count: c_ulong,
        flags: c_ulong) -> isize => process_vm_writev;
}

unsafe extern "C" fn tgkill_for(process: libc::pid_t, thread: libc::pid_t, signal: c_int, _caller: usize) -> c_int {
    // SAFETY: the program's own call. The first thread has the number of the process.
    unsafe { real::tgkill(real_number(process), real_number(thread), signal) }
}

unsafe extern "C" fn setpgid_for(process: libc::pid_t, group: libc::pid_t, _caller: usize) -> c_int {
    // SAFETY: the program's own call.
    unsafe { real::setpgid(real_number(process), real_number(group)) }
}

// A group and a session have the number of the process that has begun them. Programs compare it with
// their own.

pub unsafe extern "C" fn getpgrp_for(caller: usize) -> libc::pid_t {
    // SAFETY: returns a number.
    unsafe { getpgid_for(0, caller) }
}

pub unsafe extern "C" fn getpgid_for(process: libc::pid_t, caller: usize) -> libc::pid_t {
    // SAFETY: returns a number.
    read(unsafe { real::getpgid(real_number(process)) }, caller)
}

pub unsafe extern "C" fn getsid_for(process: libc::pid_t, caller: usize) -> libc::pid_t {
    // SAFETY: returns a number.
    read(unsafe { real::getsid(real_number(process)) }, caller)
}

pub unsafe extern "C" fn setsid_for(caller: usize) -> libc::pid_t {
    // SAFETY: the program's own call.
    read(unsafe { real::setsid() }, caller)
}

unsafe extern "C" fn tcgetpgrp_for(terminal: c_int, caller: usize) -> libc::pid_t {
    // SAFETY: a question about a descriptor.
    read(unsafe { real::tcgetpgrp(terminal) }, caller)
}

unsafe extern "C" fn tcgetsid_for(terminal: c_int, caller: usize) -> libc::pid_t {
    // SAFETY: a question about a descriptor.
    read(unsafe { real::tcgetsid(terminal) }, caller)
}

unsafe extern "C" fn tcsetpgrp_for(terminal: c_int, group: libc::pid_t, _caller: usize) -> c_int {
    // SAFETY: the program's own call.
    unsafe { real::tcsetpgrp(terminal, real_number(group)) }
}

/// The third argument exists only for some requests. Both kinds of processors pass it in a register
/// in any case.
pub unsafe extern "C-unwind" fn ioctl_for(file: c_int, request: c_ulong, argument: usize, caller: usize) -> c_int {
    // The kernel's numbers have 32 bits.
    let is = |number: libc::Ioctl| request as u32 == number as u32;
    if is(libc::TIOCSPGRP) {
        // SAFETY: the program's number, or null, which the system refuses.
        let group = unsafe { (argument as *const libc::pid_t).as_ref() }.map(|group| real_number(*group));
        let group = group.as_ref().map_or(0, |group| std::ptr::from_ref(group) as usize);
        // SAFETY: the program's own call; the number is a local one.
        return unsafe { real::ioctl(file, request, group) };
    }
    // SAFETY: the program's own call.
    let answer = unsafe { real::ioctl(file, request, argument) };
    if answer == 0 && (is(libc::TIOCGPGRP) || is(libc::TIOCGSID)) {
        // SAFETY: the system has written a number there.
        unsafe { *(argument as *mut libc::pid_t) = read(*(argument as *const libc::pid_t), caller) };
    }
    answer
}

/// Structure of `F_SETOWN_EX`: whether a thread, a process or a group is meant, and its number.
type Owner = [c_int; 2];

/// `fcntl`, with real numbers of processes.
///
/// # Safety
/// As `fcntl`.
pub unsafe fn fcntl(file: c_int, command: c_int, argument: usize) -> c_int {
    // SAFETY: the program's own call, with its structure or null, which the system refuses.
    unsafe {
        match command {
            libc::F_SETOWN => real::fcntl(file, command, real_argument(argument)),
            F_SETOWN_EX => match (argument as *const Owner).as_ref() {
                Some([kind, owner]) => {
                    let owner: Owner = [*kind, real_number(*owner)];
                    real::fcntl(file, command, std::ptr::from_ref(&owner) as usize)
                }
                None => real::fcntl(file, command, argument),
            },
            _ => real::fcntl(file, command, argument),
        }
    }
}

/// The number of the user in the second argument of `getpriority` is none of a process.
fn real_holder(kind: c_uint, holder: c_uint) -> c_uint {
    if kind == libc::PRIO_USER as c_uint { holder } else { real_number(holder.cast_signed()).cast_unsigned() }
}

unsafe extern "C" fn setpriority_for(kind: c_uint, holder: c_uint, priority: c_int, _caller: usize) -> c_int {
    // SAFETY: the program's own call.
    unsafe { real::setpriority(kind, real_holder(kind, holder), priority) }
}

unsafe extern "C" fn getpriority_for(kind: c_uint, holder: c_uint, _caller: usize) -> c_int {
    // SAFETY: the program's own call.
    unsafe { real::getpriority(kind, real_holder(kind, holder)) }
}

/// An argument of a system call that is the number of a process. The system looks at its lower half.
fn real_argument(process: usize) -> usize {
    real_number(process as libc::pid_t) as usize
}

/// Arguments of a system call with real numbers of processes.
pub fn real_arguments(number: c_long, mut arguments: [usize; 6]) -> [usize; 6] {
    let places: &[usize] = match number {
        libc::SYS_tgkill | libc::SYS_rt_tgsigqueueinfo | libc::SYS_setpgid => &[0, 1],
        libc::SYS_kill
        | libc::SYS_tkill
        | libc::SYS_rt_sigqueueinfo
        | libc::SYS_getpgid
        | libc::SYS_getsid
        | libc::SYS_sched_setaffinity
        | libc::SYS_sched_getaffinity
        | libc::SYS_sched_setscheduler
        | libc::SYS_sched_getscheduler
        | libc::SYS_sched_setparam
        | libc::SYS_sched_getparam
        | libc::SYS_sched_setattr
        | libc::SYS_sched_getattr
        | libc::SYS_sched_rr_get_interval
        | libc::SYS_pidfd_open
        | libc::SYS_prlimit64
        | libc::SYS_process_vm_readv
        | libc::SYS_process_vm_writev => &[0],
        libc::SYS_setpriority | libc::SYS_getpriority if arguments[0] != libc::PRIO_USER as usize => &[1],
        _ => &[],
    };
    for place in places {
        arguments[*place] = real_argument(arguments[*place]);
    }
    arguments
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
    wait_for_process(options, caller, || unsafe { real::waitpid(real_number(process), status, options) })
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
    wait_for_process(options, caller, || unsafe { real::wait4(real_number(process), status, options, usage) })
}

pub unsafe extern "C-unwind" fn waitid_for(
    kind: c_int,
    process: libc::id_t,
    answer: *mut c_void,
    options: c_int,
    caller: usize,
) -> c_int {
    let process = real_number(process.cast_signed()).cast_unsigned();
    // SAFETY: the program's own call.
    wait_for_process(options, caller, || unsafe { real::waitid(kind, process, answer, options) })
}
