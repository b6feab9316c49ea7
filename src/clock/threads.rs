//! Waits of threads for each other, with limits in the program's time.
//!
//! A wait of the drawing thread without a limit counts too: until it ends, sleeps of other threads
//! last their real time, because it may wait for them.

use super::caller::{interpose, is_served};
use super::process::copies::Shared;
use super::real;
use super::timeline::{self, moment, nanoseconds, seen, timespec, wait};
use std::ffi::{c_int, c_void};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, MutexGuard};
use std::time::Duration;

interpose! {
    2 pthread_cond_wait => cond_wait_for;
    3 pthread_cond_timedwait => cond_timedwait_for;
    4 pthread_cond_clockwait => cond_clockwait_for;
    2 cnd_wait => cnd_wait_for;
    3 cnd_timedwait => cnd_timedwait_for;
    1 sem_wait => sem_wait_for;
    2 sem_timedwait => sem_timedwait_for;
    3 sem_clockwait => sem_clockwait_for;
    2 pthread_mutex_timedlock => mutex_timedlock_for;
    3 pthread_mutex_clocklock => mutex_clocklock_for;
    2 mtx_timedlock => mtx_timedlock_for;
    2 pthread_rwlock_timedrdlock => rwlock_timedrdlock_for;
    3 pthread_rwlock_clockrdlock => rwlock_clockrdlock_for;
    2 pthread_rwlock_timedwrlock => rwlock_timedwrlock_for;
    3 pthread_rwlock_clockwrlock => rwlock_clockwrlock_for;
    2 pthread_join => join_for;
    3 pthread_timedjoin_np => timedjoin_for;
    4 pthread_clockjoin_np => clockjoin_for;
    2 thrd_join => thrd_join_for;
    1 pthread_barrier_wait => barrier_for;
}

/// Longest real time for which the drawing thread waits for another thread. Then its time advances
/// to the limit.
pub const PATIENCE: Duration = Duration::from_millis(250);

type Time = *const libc::timespec;

/// Moment in the last argument of a call, if the call gets virtual time.
unsafe fn limit(time: Time, caller: usize) -> Option<u64> {
    // SAFETY: the program's structure, or null.
    unsafe { time.as_ref() }.and_then(nanoseconds).filter(|_| is_served(caller)).map(moment)
}

/// Moment of the real monotonic clock at which `limit` from now ends.
pub fn real_end(limit: Duration) -> libc::timespec {
    timespec(real::now().saturating_add(u64::try_from(limit.as_nanos()).unwrap_or(u64::MAX)))
}

/// Waits until `deadline`. `attempt` waits until a moment of the real clock; it returns ETIMEDOUT
/// if nothing came.
fn wait_for_thread(deadline: u64, attempt: impl Fn(Time) -> c_int) -> c_int {
    let attempt = |limit: Option<Duration>| {
        Some(attempt(&real_end(limit.unwrap_or(PATIENCE)))).filter(|answer| *answer != libc::ETIMEDOUT)
    };
    wait(Some(deadline), PATIENCE, attempt).unwrap_or(libc::ETIMEDOUT)
}

/// A thread that waits for a condition, until a moment.
pub struct Waiting {
    condition: usize,
    deadline: u64,
    is_late: Arc<AtomicBool>,
}

pub static WAITING: Shared<Vec<Waiting>> = Shared::new(Vec::new());

/// The threads that wait so.
fn waiting() -> MutexGuard<'static, Vec<Waiting>> {
    WAITING.lock()
}

/// Wakes threads that wait for a condition until `time` or earlier.
pub fn wake(time: u64) {
    for thread in waiting().iter() {
        if thread.deadline <= time {
            thread.is_late.store(true, Ordering::Release);
            // SAFETY: its thread waits for it until it is taken from the list.
            unsafe { libc::pthread_cond_broadcast(thread.condition as *mut libc::pthread_cond_t) };
        }
    }
}

/// Waits for a condition until `deadline`. Several short waits would miss signals between them.
/// Threads other than the drawing one therefore wait once, and the drawing thread wakes them. If it
/// takes long, they return by themselves, as after a spurious wake-up, which the standard permits.
unsafe fn wait_for_condition(
    condition: *mut libc::pthread_cond_t,
    mutex: *mut libc::pthread_mutex_t,
    deadline: u64,
) -> c_int {
    // SAFETY: the program's own call, with its limit on another clock.
    let attempt = |end: Time| unsafe { real::pthread_cond_clockwait(condition, mutex, libc::CLOCK_MONOTONIC, end) };
    if timeline::draws() {
        return wait_for_thread(deadline, attempt);
    }
    let left = Duration::from_nanos(deadline.saturating_sub(seen()));
    let patience = if left.is_zero() || timeline::is_blocked() { Duration::ZERO } else { PATIENCE };
    let is_late = Arc::new(AtomicBool::new(false));
    waiting().push(Waiting { condition: condition as usize, deadline, is_late: is_late.clone() });
    let answer = attempt(&real_end(left.saturating_add(patience)));
    waiting().retain(|thread| !Arc::ptr_eq(&thread.is_late, &is_late));
    match answer {
        0 if is_late.load(Ordering::Acquire) => libc::ETIMEDOUT,
        libc::ETIMEDOUT if seen() < deadline && !timeline::stands() => 0,
        answer => answer,
    }
}

type Condition = *mut libc::pthread_cond_t;
type Lock = *mut libc::pthread_mutex_t;

unsafe extern "C-unwind" fn cond_wait_for(condition: Condition, mutex: Lock, caller: usize) -> c_int {
    // SAFETY: the program's own call.
    let attempt = || unsafe { real::pthread_cond_wait(condition, mutex) };
    without_limit(caller, attempt)
}

/// A wait without a limit.
pub fn without_limit(caller: usize, attempt: impl Fn() -> c_int) -> c_int {
    if is_served(caller) { wait(None, PATIENCE, |_| Some(attempt())).unwrap_or(0) } else { attempt() }
}

unsafe extern "C-unwind" fn cond_timedwait_for(condition: Condition, mutex: Lock, time: Time, caller: usize) -> c_int {
    // SAFETY: the program's own call.
    unsafe {
        match limit(time, caller) {
            Some(deadline) => wait_for_condition(condition, mutex, deadline),
            None => real::pthread_cond_timedwait(condition, mutex, time),
        }
    }
}

unsafe extern "C-unwind" fn cond_clockwait_for(
    condition: Condition,
    mutex: Lock,
    clock: c_int,
    time: Time,
    caller: usize,
) -> c_int {
    // SAFETY: the program's own call.
    unsafe {
        match limit(time, caller) {
            Some(deadline) => wait_for_condition(condition, mutex, deadline),
            None => real::pthread_cond_clockwait(condition, mutex, clock, time),
        }
    }
}

/// Converts an answer of POSIX's threads to one of C11's.
fn of_c11(answer: c_int) -> c_int {
    match answer {
        0 => 0,
        libc::ETIMEDOUT => 4,
        _ => 2,
    }
}

unsafe extern "C-unwind" fn cnd_wait_for(condition: Condition, mutex: Lock, caller: usize) -> c_int {
    // SAFETY: the program's own call; glibc's types are those of POSIX's threads.
    of_c11(unsafe { cond_wait_for(condition, mutex, caller) })
}

unsafe extern "C-unwind" fn cnd_timedwait_for(condition: Condition, mutex: Lock, time: Time, caller: usize) -> c_int {
    // SAFETY: as above.
    of_c11(unsafe { cond_timedwait_for(condition, mutex, time, caller) })
}

unsafe extern "C-unwind" fn mtx_timedlock_for(mutex: Lock, time: Time, caller: usize) -> c_int {
    // SAFETY: as above.
    of_c11(unsafe { mutex_timedlock_for(mutex, time, caller) })
}

/// Error number of a call that sets `errno`; 0 if it succeeded.
fn errno(answer: c_int) -> c_int {
    // SAFETY: the thread's own number.
    if answer == 0 { 0 } else { unsafe { *libc::__errno_location() } }
}

unsafe extern "C-unwind" fn sem_wait_for(semaphore: *mut libc::sem_t, caller: usize) -> c_int {
    // SAFETY: the program's own call.
    without_limit(caller, || unsafe { real::sem_wait(semaphore) })
}

unsafe extern "C-unwind" fn sem_timedwait_for(semaphore: *mut libc::sem_t, time: Time, caller: usize) -> c_int {
    // SAFETY: the program's own call.
    unsafe { sem_clockwait_for(semaphore, libc::CLOCK_REALTIME, time, caller) }
}

unsafe extern "C-unwind" fn sem_clockwait_for(
    semaphore: *mut libc::sem_t,
    clock: c_int,
    time: Time,
    caller: usize,
) -> c_int {
    // SAFETY: the program's own call.
    unsafe {
        let Some(deadline) = limit(time, caller) else { return real::sem_clockwait(semaphore, clock, time) };
        match wait_for_thread(deadline, |end| errno(real::sem_clockwait(semaphore, libc::CLOCK_MONOTONIC, end))) {
            0 => 0,
            error => real::fail(error),
        }
    }
}

/// Defines locks with a limit: the function's name without and with a clock, and libc's with one.
macro_rules! locks {
    ($($kind:ty: $timed:ident, $clocked:ident => $real:ident;)*) => {$(
        unsafe extern "C-unwind" fn $timed(lock: *mut $kind, time: Time, caller: usize) -> c_int {
            // SAFETY: the program's own call.
            unsafe { $clocked(lock, libc::CLOCK_REALTIME, time, caller) }
        }

        unsafe extern "C-unwind" fn $clocked(lock: *mut $kind, clock: c_int, time: Time, caller: usize) -> c_int {
            // SAFETY: the program's own call.
            unsafe {
                match limit(time, caller) {
                    Some(deadline) => wait_for_thread(deadline, |end| real::$real(lock, libc::CLOCK_MONOTONIC, end)),
                    None => real::$real(lock, clock, time),
                }
            }
        }
    )*};
}

locks! {
    libc::pthread_mutex_t: mutex_timedlock_for, mutex_clocklock_for => pthread_mutex_clocklock;
    libc::pthread_rwlock_t: rwlock_timedrdlock_for, rwlock_clockrdlock_for => pthread_rwlock_clockrdlock;
    libc::pthread_rwlock_t: rwlock_timedwrlock_for, rwlock_clockwrlock_for => pthread_rwlock_clockwrlock;
}

unsafe extern "C-unwind" fn join_for(thread: libc::pthread_t, answer: *mut *mut c_void, caller: usize) -> c_int {
    // SAFETY: the program's own call.
    without_limit(caller, || unsafe { real::pthread_join(thread, answer) })
}

unsafe extern "C-unwind" fn thrd_join_for(thread: libc::pthread_t, answer: *mut c_int, caller: usize) -> c_int {
    // SAFETY: the program's own call.
    without_limit(caller, || unsafe { real::thrd_join(thread, answer) })
}

unsafe extern "C-unwind" fn barrier_for(barrier: *mut libc::pthread_barrier_t, caller: usize) -> c_int {
    // SAFETY: the program's own call.
    without_limit(caller, || unsafe { real::pthread_barrier_wait(barrier) })
}

unsafe extern "C-unwind" fn timedjoin_for(
    thread: libc::pthread_t,
    answer: *mut *mut c_void,
    time: Time,
    caller: usize,
) -> c_int {
    // SAFETY: the program's own call.
    unsafe { clockjoin_for(thread, answer, libc::CLOCK_REALTIME, time, caller) }
}

unsafe extern "C-unwind" fn clockjoin_for(
    thread: libc::pthread_t,
    answer: *mut *mut c_void,
    clock: c_int,
    time: Time,
    caller: usize,
) -> c_int {
    // SAFETY: the program's own call.
    unsafe {
        let Some(deadline) = limit(time, caller) else {
            return real::pthread_clockjoin_np(thread, answer, clock, time);
        };
        wait_for_thread(deadline, |end| real::pthread_clockjoin_np(thread, answer, libc::CLOCK_MONOTONIC, end))
    }
}
