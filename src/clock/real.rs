//! The functions of libc behind the names that this library exports.

use std::ffi::{CStr, c_char, c_int, c_long, c_uint, c_ulong, c_void};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Address of the next function of this name; 0 if there is none.
fn next(address: &AtomicUsize, name: &CStr) -> usize {
    let known = address.load(Ordering::Relaxed);
    if known != 0 {
        return known;
    }
    // SAFETY: asks the dynamic linker for names. Conditions have an older form of the same names,
    // which an unversioned question may find.
    let found = unsafe {
        let newer = match name.to_bytes().starts_with(b"pthread_cond_") {
            true => libc::dlvsym(libc::RTLD_NEXT, name.as_ptr(), c"GLIBC_2.3.2".as_ptr()),
            false => std::ptr::null_mut(),
        };
        if newer.is_null() { libc::dlsym(libc::RTLD_NEXT, name.as_ptr()) } else { newer }
    } as usize;
    address.store(found, Ordering::Relaxed);
    found
}

/// Sets `errno` and returns -1.
pub fn fail(error: c_int) -> c_int {
    // SAFETY: the thread's own number.
    unsafe { *libc::__errno_location() = error };
    -1
}

/// A system call for a function that older versions of libc lack.
fn by_number(number: c_long, [a, b, c, d]: [usize; 4]) -> c_int {
    // SAFETY: the program's own call, with its arguments.
    unsafe { syscall(number, a, b, c, d, 0, 0) as c_int }
}

macro_rules! functions {
    ($($name:ident($($argument:ident: $kind:ty),*) -> $result:ty = $missing:expr;)*) => {$(
        /// As in libc.
        ///
        /// # Safety
        /// As in libc.
        #[allow(clippy::unused_unit, reason = "one function returns nothing")]
        pub unsafe fn $name($($argument: $kind),*) -> $result {
            static ADDRESS: AtomicUsize = AtomicUsize::new(0);
            let name = concat!(stringify!($name), "\0");
            let Ok(name) = CStr::from_bytes_with_nul(name.as_bytes()) else { return $missing };
            match next(&ADDRESS, name) {
                0 => $missing,
                // SAFETY: libc's function has this type; the caller promises the rest.
                address => unsafe {
                    let function: unsafe extern "C-unwind" fn($($kind),*) -> $result = std::mem::transmute(address);
                    function($($argument),*)
                },
            }
        }
    )*};
}

functions! {
    clock_gettime(clock: libc::clockid_t, time: *mut libc::timespec) -> c_int = fail(libc::ENOSYS);
    gettimeofday(time: *mut libc::timeval, zone: *mut c_void) -> c_int = fail(libc::ENOSYS);
    time(time: *mut libc::time_t) -> libc::time_t = -1;
    timespec_get(time: *mut libc::timespec, base: c_int) -> c_int = 0;
    clock() -> libc::clock_t = -1;
    times(times: *mut libc::tms) -> libc::clock_t = -1;
    getpid() -> libc::pid_t = -1;
    getppid() -> libc::pid_t = -1;
    kill(process: libc::pid_t, signal: c_int) -> c_int = fail(libc::ENOSYS);
    killpg(group: libc::pid_t, signal: c_int) -> c_int = fail(libc::ENOSYS);
    tgkill(process: libc::pid_t, thread: libc::pid_t, signal: c_int) -> c_int = fail(libc::ENOSYS);
    sigqueue(process: libc::pid_t, signal: c_int, value: usize) -> c_int = fail(libc::ENOSYS);
    getpgid(process: libc::pid_t) -> libc::pid_t = fail(libc::ENOSYS);
    setpgid(process: libc::pid_t, group: libc::pid_t) -> c_int = fail(libc::ENOSYS);
    getsid(process: libc::pid_t) -> libc::pid_t = fail(libc::ENOSYS);
    setsid() -> libc::pid_t = fail(libc::ENOSYS);
    tcgetpgrp(terminal: c_int) -> libc::pid_t = fail(libc::ENOSYS);
    tcgetsid(terminal: c_int) -> libc::pid_t = fail(libc::ENOSYS);
    tcsetpgrp(terminal: c_int, group: libc::pid_t) -> c_int = fail(libc::ENOSYS);
    sched_setattr(process: libc::pid_t, value: *const c_void, flags: c_uint) -> c_int
        = by_number(libc::SYS_sched_setattr, [process as usize, value as usize, flags as usize, 0]);
    sched_getattr(process: libc::pid_t, value: *mut c_void, size: c_uint, flags: c_uint) -> c_int
        = by_number(libc::SYS_sched_getattr, [process as usize, value as usize, size as usize, flags as usize]);
    sched_setaffinity(process: libc::pid_t, size: usize, set: *const c_void) -> c_int = fail(libc::ENOSYS);
    sched_getaffinity(process: libc::pid_t, size: usize, set: *mut c_void) -> c_int = fail(libc::ENOSYS);
    sched_setscheduler(process: libc::pid_t, policy: c_int, value: *const c_void) -> c_int = fail(libc::ENOSYS);
    sched_getscheduler(process: libc::pid_t) -> c_int = fail(libc::ENOSYS);
    sched_setparam(process: libc::pid_t, value: *const c_void) -> c_int = fail(libc::ENOSYS);
    sched_getparam(process: libc::pid_t, value: *mut c_void) -> c_int = fail(libc::ENOSYS);
    sched_rr_get_interval(process: libc::pid_t, time: *mut libc::timespec) -> c_int = fail(libc::ENOSYS);
    setpriority(kind: c_uint, holder: c_uint, priority: c_int) -> c_int = fail(libc::ENOSYS);
    getpriority(kind: c_uint, holder: c_uint) -> c_int = fail(libc::ENOSYS);
    pidfd_open(process: libc::pid_t, flags: c_uint) -> c_int = fail(libc::ENOSYS);
    prlimit(process: libc::pid_t, kind: c_int, new: *const c_void, old: *mut c_void) -> c_int = fail(libc::ENOSYS);
    process_vm_readv(process: libc::pid_t, own: *const libc::iovec, own_count: c_ulong, other: *const libc::iovec,
        count: c_ulong, flags: c_ulong) -> isize = fail(libc::ENOSYS) as isize;
    process_vm_writev(process: libc::pid_t, own: *const libc::iovec, own_count: c_ulong, other: *const libc::iovec,
        count: c_ulong, flags: c_ulong) -> isize = fail(libc::ENOSYS) as isize;
    nanosleep(time: *const libc::timespec, left: *mut libc::timespec) -> c_int = fail(libc::ENOSYS);
    clock_nanosleep(clock: libc::clockid_t, flags: c_int, time: *const libc::timespec, left: *mut libc::timespec)
        -> c_int = libc::ENOSYS;
    usleep(time: c_uint) -> c_int = fail(libc::ENOSYS);
    sleep(time: c_uint) -> c_uint = time;
    ppoll(files: *mut libc::pollfd, count: libc::nfds_t, limit: *const libc::timespec, mask: *const libc::sigset_t)
        -> c_int = fail(libc::ENOSYS);
    poll(files: *mut libc::pollfd, count: libc::nfds_t, limit: c_int) -> c_int = fail(libc::ENOSYS);
    pselect(count: c_int, read: *mut libc::fd_set, write: *mut libc::fd_set, other: *mut libc::fd_set,
        limit: *const libc::timespec, mask: *const libc::sigset_t) -> c_int = fail(libc::ENOSYS);
    select(count: c_int, read: *mut libc::fd_set, write: *mut libc::fd_set, other: *mut libc::fd_set,
        limit: *mut libc::timeval) -> c_int = fail(libc::ENOSYS);
    epoll_pwait(file: c_int, events: *mut libc::epoll_event, count: c_int, limit: c_int, mask: *const libc::sigset_t)
        -> c_int = fail(libc::ENOSYS);
    epoll_pwait2(file: c_int, events: *mut libc::epoll_event, count: c_int, limit: *const libc::timespec,
        mask: *const libc::sigset_t) -> c_int = fail(libc::ENOSYS);
    getrandom(bytes: *mut c_void, length: usize, flags: c_uint) -> isize = fail(libc::ENOSYS) as isize;
    getentropy(bytes: *mut c_void, length: usize) -> c_int = fail(libc::ENOSYS);
    arc4random() -> u32 = 0;
    arc4random_buf(bytes: *mut c_void, length: usize) -> () = ();
    arc4random_uniform(bound: u32) -> u32 = 0;
    open(path: *const c_char, flags: c_int, mode: c_uint) -> c_int = fail(libc::ENOSYS);
    openat(folder: c_int, path: *const c_char, flags: c_int, mode: c_uint) -> c_int = fail(libc::ENOSYS);
    fopen(path: *const c_char, mode: *const c_char) -> *mut libc::FILE = std::ptr::null_mut();
    timerfd_create(clock: c_int, flags: c_int) -> c_int = fail(libc::ENOSYS);
    timerfd_settime(file: c_int, flags: c_int, new: *const libc::itimerspec, old: *mut libc::itimerspec)
        -> c_int = fail(libc::ENOSYS);
    pthread_cond_wait(condition: *mut libc::pthread_cond_t, mutex: *mut libc::pthread_mutex_t) -> c_int = libc::ENOSYS;
    pthread_cond_timedwait(condition: *mut libc::pthread_cond_t, mutex: *mut libc::pthread_mutex_t,
        time: *const libc::timespec) -> c_int = libc::ENOSYS;
    pthread_cond_clockwait(condition: *mut libc::pthread_cond_t, mutex: *mut libc::pthread_mutex_t, clock: c_int,
        time: *const libc::timespec) -> c_int = libc::ENOSYS;
    sem_wait(semaphore: *mut libc::sem_t) -> c_int = fail(libc::ENOSYS);
    sem_clockwait(semaphore: *mut libc::sem_t, clock: c_int, time: *const libc::timespec) -> c_int = fail(libc::ENOSYS);
    pthread_mutex_clocklock(mutex: *mut libc::pthread_mutex_t, clock: c_int, time: *const libc::timespec)
        -> c_int = libc::ENOSYS;
    pthread_rwlock_clockrdlock(lock: *mut libc::pthread_rwlock_t, clock: c_int, time: *const libc::timespec)
        -> c_int = libc::ENOSYS;
    pthread_rwlock_clockwrlock(lock: *mut libc::pthread_rwlock_t, clock: c_int, time: *const libc::timespec)
        -> c_int = libc::ENOSYS;
    pthread_join(thread: libc::pthread_t, answer: *mut *mut c_void) -> c_int = libc::ENOSYS;
    thrd_join(thread: libc::pthread_t, answer: *mut c_int) -> c_int = 2;
    pthread_barrier_wait(barrier: *mut libc::pthread_barrier_t) -> c_int = libc::ENOSYS;
    pthread_clockjoin_np(thread: libc::pthread_t, answer: *mut *mut c_void, clock: c_int, time: *const libc::timespec)
        -> c_int = libc::ENOSYS;
    waitpid(process: libc::pid_t, status: *mut c_int, options: c_int) -> libc::pid_t = fail(libc::ENOSYS);
    wait4(process: libc::pid_t, status: *mut c_int, options: c_int, usage: *mut libc::rusage)
        -> libc::pid_t = fail(libc::ENOSYS);
    waitid(kind: c_int, process: libc::id_t, answer: *mut c_void, options: c_int) -> c_int = fail(libc::ENOSYS);
    syscall(number: c_long, a: usize, b: usize, c: usize, d: usize, e: usize, f: usize) -> c_long
        = c_long::from(fail(libc::ENOSYS));
    __read_chk(file: c_int, bytes: *mut c_void, length: usize, most: usize) -> isize = fail(libc::EFAULT) as isize;
    timerfd_gettime(file: c_int, time: *mut libc::itimerspec) -> c_int = fail(libc::ENOSYS);
}

/// Functions that programs call from handlers of signals, and before this library is prepared. The
/// dynamic linker may be asked in neither place. Until [`prepare`], they are system calls.
macro_rules! early {
    ($($name:ident($($argument:ident: $kind:ty),*) -> $result:ty = $number:ident;)*) => {
        #[allow(non_camel_case_types)]
        #[derive(Clone, Copy)]
        enum Early { $($name),* }

        static EARLY: [AtomicUsize; [$(Early::$name),*].len()] = [$({ let _ = Early::$name; AtomicUsize::new(0) }),*];

        /// Asks the dynamic linker for these functions.
        pub fn prepare() {
            $(
                if let Ok(name) = CStr::from_bytes_with_nul(concat!(stringify!($name), "\0").as_bytes()) {
                    next(&EARLY[Early::$name as usize], name);
                }
            )*
        }

        $(
            /// As in libc.
            ///
            /// # Safety
            /// As in libc.
            pub unsafe fn $name($($argument: $kind),*) -> $result {
                match EARLY[Early::$name as usize].load(Ordering::Relaxed) {
                    // SAFETY: the system's call has these arguments; the caller promises the rest.
                    0 => unsafe { direct(libc::$number, &[$($argument as usize),*]) as $result },
                    // SAFETY: libc's function has this type; the caller promises the rest.
                    address => unsafe {
                        let function: unsafe extern "C-unwind" fn($($kind),*) -> $result = std::mem::transmute(address);
                        function($($argument),*)
                    },
                }
            }
        )*
    };
}

early! {
    read(file: c_int, bytes: *mut c_void, length: usize) -> isize = SYS_read;
    readv(file: c_int, parts: *const libc::iovec, count: c_int) -> isize = SYS_readv;
    dup(file: c_int) -> c_int = SYS_dup;
    dup2(file: c_int, new: c_int) -> c_int = SYS_dup3;
    dup3(file: c_int, new: c_int, flags: c_int) -> c_int = SYS_dup3;
    fcntl(file: c_int, command: c_int, argument: usize) -> c_int = SYS_fcntl;
    ioctl(file: c_int, request: c_ulong, argument: usize) -> c_int = SYS_ioctl;
}

/// A system call, without libc. Arguments that are not given are 0.
///
/// # Safety
/// As the system call.
unsafe fn direct(number: c_long, arguments: &[usize]) -> isize {
    let [a, b, c] = [0, 1, 2].map(|index| arguments.get(index).copied().unwrap_or(0));
    let answer: isize;
    // SAFETY: as promised.
    unsafe {
        #[cfg(target_arch = "x86_64")]
        std::arch::asm!("syscall", inlateout("rax") number as isize => answer, in("rdi") a, in("rsi") b, in("rdx") c,
            lateout("rcx") _, lateout("r11") _, options(nostack));
        #[cfg(target_arch = "aarch64")]
        std::arch::asm!("svc 0", in("x8") number, inlateout("x0") a => answer, in("x1") b, in("x2") c, options(nostack));
    }
    match answer {
        -4095..0 => fail(-answer as c_int) as isize,
        answer => answer,
    }
}

/// A time of the real monotonic clock, in nanoseconds.
pub fn now() -> u64 {
    let mut time = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    // SAFETY: writes one structure.
    unsafe { clock_gettime(libc::CLOCK_MONOTONIC, &mut time) };
    super::timeline::nanoseconds(&time).unwrap_or(0)
}
