//! The program's time.
//!
//! It is the time of a program whose work takes no time, on a display that shows `rate` frames in a
//! second. It advances when a frame ends and when the thread that draws the frames waits, and
//! stands still otherwise.

use super::page::{NEVER, Page};
use super::settings::{page, settings};
use super::{files::timers, real, threads};
use std::cell::Cell;
use std::sync::atomic::{AtomicBool, AtomicI32, AtomicU32, AtomicU64, Ordering};
use std::time::Duration;

/// Nanoseconds in a second.
const SECOND: u64 = 1_000_000_000;
/// The monotonic clock at the program's start.
const MONOTONIC_START: u64 = 1000 * SECOND;
/// Number of reads of a clock in one frame, without a wait between them, after which each read
/// advances the time.
const READS: u32 = 1000;
/// Nanoseconds by which such a read advances it.
const CREEP: u64 = 1000;
/// Interval at which another thread checks whether the time that it waits for has come.
pub const SLICE: Duration = Duration::from_millis(5);
/// Nanoseconds without a frame and without a wait of the drawing thread, after which other threads
/// wait in real time.
const STALLED: u64 = 5 * SECOND;
/// Number of swaps of other windows, without one of the leading window, after which another window
/// leads.
const GONE: u32 = 30;
/// Longest real time of a wait of the drawing thread while the time is held.
const HELD_WAIT: Duration = Duration::from_millis(250);
/// Longest real time between two frames of a program whose time is held.
const HELD_FRAME: Duration = Duration::from_millis(100);
/// Real time that a program gets to wait for whose held time it asks again and again.
const HELD_READ: Duration = Duration::from_millis(1);

/// Nanoseconds since the start.
static NOW: AtomicU64 = AtomicU64::new(0);
/// Number of the display's frame: time × rate at the beginning of the frame.
static FRAME: AtomicU64 = AtomicU64::new(0);
/// Number of the drawing thread. 0 before the first frame: then the process's first thread counts.
static THREAD: AtomicI32 = AtomicI32::new(0);
/// Real time at which that thread began to wait for others without a limit; 0 if it does not.
static BLOCKED: AtomicU64 = AtomicU64::new(0);
/// Real time at which the program's time last advanced.
static GROWN: AtomicU64 = AtomicU64::new(0);
/// Number of reads since then.
static READ: AtomicU32 = AtomicU32::new(0);
/// Handle of the leading window, whose swaps count.
static WINDOW: AtomicU64 = AtomicU64::new(0);
/// Number of swaps of other windows since its last one.
static OTHERS: AtomicU32 = AtomicU32::new(0);
/// True from the first frame on of a process whose time another process may hold.
static IS_HELD: AtomicBool = AtomicBool::new(false);

thread_local! {
    /// Number of this thread.
    static ID: Cell<libc::pid_t> = const { Cell::new(0) };
    /// Last time that this thread read: its time never goes back.
    static LAST: Cell<u64> = const { Cell::new(0) };
}

/// Number of this thread.
pub fn thread() -> libc::pid_t {
    ID.with(|id| {
        if id.get() == 0 {
            // SAFETY: returns a number.
            id.set(unsafe { libc::gettid() });
        }
        id.get()
    })
}

/// Makes this process, a copy that `fork` has made, one with a clock of its own: it has only this
/// thread, and nobody holds its time.
pub fn begin_copy() {
    ID.set(0);
    THREAD.store(0, Ordering::Release);
    BLOCKED.store(0, Ordering::Release);
    IS_HELD.store(false, Ordering::Release);
}

/// True if this thread draws the frames.
pub fn draws() -> bool {
    match THREAD.load(Ordering::Relaxed) {
        // SAFETY: returns a number.
        0 => thread() == unsafe { real::getpid() },
        drawing => drawing == thread(),
    }
}

/// Nanoseconds since the start, without counting a read.
pub fn now() -> u64 {
    NOW.load(Ordering::Acquire)
}

/// The monotonic clock.
pub fn monotonic() -> u64 {
    MONOTONIC_START + now()
}

/// Time as this thread sees it.
pub fn seen() -> u64 {
    if draws() {
        return now();
    }
    let real = real::now();
    if stands() {
        // The marks move along: time that was held does not count later.
        GROWN.store(real, Ordering::Release);
        // The drawing thread may end its wait at this moment; then there is nothing to update.
        let _ = BLOCKED.fetch_update(Ordering::AcqRel, Ordering::Acquire, |begin| (begin != 0).then_some(real));
    }
    let extra = match (is_blocked(), GROWN.load(Ordering::Acquire)) {
        (true, _) => blocked_for(real),
        (false, 0) => 0,
        (false, grown) => real.saturating_sub(grown).saturating_sub(STALLED),
    };
    LAST.with(|last| {
        last.set(last.get().max(now() + extra));
        last.get()
    })
}

/// Time for a program that reads a clock.
pub fn read() -> u64 {
    if draws() && READ.fetch_add(1, Ordering::Relaxed) >= READS {
        if now() + CREEP <= limit() {
            NOW.fetch_add(CREEP, Ordering::AcqRel);
        } else {
            nap(HELD_READ);
        }
    }
    seen()
}

/// Waits in real time.
fn nap(time: Duration) {
    let time = timespec(u64::try_from(time.as_nanos()).unwrap_or(0));
    // SAFETY: a local structure. A signal may end the wait.
    unsafe { real::nanosleep(&time, std::ptr::null_mut()) };
}

/// The page of another process that may hold the time, from the first frame on.
fn holder() -> Option<Page<'static>> {
    if IS_HELD.load(Ordering::Acquire) { page() } else { None }
}

/// Nanoseconds since the start beyond which the time does not go now.
fn limit() -> u64 {
    match holder().map(Page::until) {
        None | Some(NEVER) => u64::MAX,
        Some(until) => begin_of(until.max(FRAME.load(Ordering::Relaxed))),
    }
}

/// True if the time is held and does not reach this moment.
pub fn is_held_before(moment: u64) -> bool {
    moment > limit().max(now())
}

/// True if the time is held and stands.
pub fn stands() -> bool {
    now() >= limit()
}

/// Time at the beginning of a frame of the display.
fn begin_of(frame: u64) -> u64 {
    let (frames, seconds) = settings().map_or((1, 1), |settings| settings.rate);
    let length = u128::from(seconds) * u128::from(SECOND);
    u64::try_from(u128::from(frame) * length / u128::from(frames)).unwrap_or(u64::MAX)
}

/// Value of a clock at the program's start; `None` for clocks that are not virtual.
pub fn start_of(clock: libc::clockid_t) -> Option<u64> {
    match clock {
        libc::CLOCK_REALTIME | libc::CLOCK_REALTIME_COARSE | libc::CLOCK_TAI => Some(settings()?.start),
        libc::CLOCK_MONOTONIC | libc::CLOCK_MONOTONIC_RAW | libc::CLOCK_MONOTONIC_COARSE | libc::CLOCK_BOOTTIME => {
            Some(MONOTONIC_START)
        }
        libc::CLOCK_PROCESS_CPUTIME_ID | libc::CLOCK_THREAD_CPUTIME_ID => Some(0),
        _ => None,
    }
}

/// Converts a moment of either kind of clock to nanoseconds since the start. The number tells the
/// kind: no monotonic clock runs for decades before 1986.
pub fn moment(time: u64) -> u64 {
    let is_date = time > 500_000_000 * SECOND;
    time.saturating_sub(if is_date { settings().map_or(0, |settings| settings.start) } else { MONOTONIC_START })
}

/// Converts a time to nanoseconds; `None` for one that libc refuses.
pub fn nanoseconds(time: &libc::timespec) -> Option<u64> {
    let (seconds, rest) = (u64::try_from(time.tv_sec).ok()?, u64::try_from(time.tv_nsec).ok()?);
    (rest < SECOND).then(|| seconds.saturating_mul(SECOND).saturating_add(rest))
}

/// Converts nanoseconds to a time for libc.
pub fn timespec(time: u64) -> libc::timespec {
    libc::timespec { tv_sec: (time / SECOND) as libc::time_t, tv_nsec: (time % SECOND) as libc::c_long }
}

/// Advances the time to `time`, or as far as it goes while it is held.
fn grow(time: u64) {
    let time = time.min(limit());
    NOW.fetch_max(time, Ordering::AcqRel);
    READ.store(0, Ordering::Relaxed);
    GROWN.store(real::now(), Ordering::Release);
    timers::fire(time);
    threads::wake(time);
}

/// Advances the monotonic clock to `time`, unless it is later already.
pub fn advance(time: u64) {
    let time = time.saturating_sub(MONOTONIC_START);
    if time > now() {
        grow(time);
    }
}

/// Announces that a frame of this window is complete, and advances the time to the next one, unless
/// it is held. Returns false if another window leads.
pub fn frame(window: u64) -> bool {
    let Some(settings) = settings() else { return false };
    if !leads(window) {
        return false;
    }
    THREAD.store(thread(), Ordering::Relaxed);
    let (frames, seconds) = settings.rate;
    let (length, frames) = (u128::from(seconds) * u128::from(SECOND), u128::from(frames));
    // If a program waited longer than a frame lasts, frames of the display have passed: the nearest
    // frame is the next.
    let nearest = (u128::from(now()) * frames + length / 2) / length;
    let nearest = u64::try_from(nearest).unwrap_or(u64::MAX);
    // Before the first frame the time is not held, and may be that of a later frame.
    let is_first = holder().is_none();
    let current = if is_first { nearest } else { FRAME.load(Ordering::Relaxed) };
    let holder = page().filter(|page| page.claim(process(), is_gone));
    let until = holder.map_or(NEVER, Page::until);
    let wanted = nearest.max(FRAME.load(Ordering::Relaxed) + 1);
    let next = wanted.min(until.max(current));
    FRAME.store(next, Ordering::Relaxed);
    if let Some(page) = holder {
        page.pass(current, next);
    }
    IS_HELD.store(holder.is_some(), Ordering::Release);
    grow(begin_of(next));
    // If `advance` has brought the time here already, it is not held: a node that is behind the
    // others must not wait.
    if next == current && next < wanted {
        nap(Duration::from_nanos(begin_of(1)).min(HELD_FRAME));
    }
    true
}

/// Number of this process.
fn process() -> u64 {
    // SAFETY: returns a number.
    u64::from(unsafe { real::getpid() }.unsigned_abs())
}

/// True if the process of this number has ended.
fn is_gone(process: u64) -> bool {
    // SAFETY: signal 0 is sent to nobody.
    unsafe {
        real::syscall(libc::SYS_kill, process as usize, 0, 0, 0, 0, 0) != 0 && *libc::__errno_location() == libc::ESRCH
    }
}

/// True if the swaps of this window count. The first window leads until only others are swapped.
fn leads(window: u64) -> bool {
    let leading = WINDOW.load(Ordering::Relaxed);
    if leading != window && leading != 0 && OTHERS.fetch_add(1, Ordering::Relaxed) < GONE {
        return false;
    }
    WINDOW.store(window, Ordering::Relaxed);
    OTHERS.store(0, Ordering::Relaxed);
    true
}

/// Wait of the drawing thread for others without a limit. They may need the time to advance before
/// they end its wait.
struct Blocked;

impl Blocked {
    fn begin() -> Self {
        BLOCKED.store(real::now(), Ordering::Release);
        Self
    }
}

/// True if the drawing thread waits for others without a limit.
pub fn is_blocked() -> bool {
    BLOCKED.load(Ordering::Acquire) != 0
}

/// Nanoseconds for which it has waited so, at this real time.
fn blocked_for(real: u64) -> u64 {
    match BLOCKED.load(Ordering::Acquire) {
        0 => 0,
        blocked => real.saturating_sub(blocked),
    }
}

impl Drop for Blocked {
    fn drop(&mut self) {
        BLOCKED.store(0, Ordering::Release);
    }
}

/// Waits until the time is `deadline` (`None`: without a limit), or until something comes.
/// `attempt` waits in real time, for no longer than its argument, and returns `None` if nothing
/// came. The drawing thread makes one attempt, no longer than `patience`, and then advances the
/// time. Other threads do not advance it. While the time is held, a wait ends after the real time
/// that was asked for, of the drawing thread after [`HELD_WAIT`] at the latest.
pub fn wait<R>(
    deadline: Option<u64>,
    patience: Duration,
    attempt: impl FnMut(Option<Duration>) -> Option<R>,
) -> Option<R> {
    wait_again(|| deadline, None, patience, attempt)
}

/// As [`wait`], for a deadline that another thread may move: after `again` of real time at the
/// latest it is asked for again.
pub fn wait_again<R>(
    deadline: impl Fn() -> Option<u64>,
    again: Option<Duration>,
    patience: Duration,
    mut attempt: impl FnMut(Option<Duration>) -> Option<R>,
) -> Option<R> {
    let draws = draws();
    let mut blocked = None;
    // The deadline, the real time at which the wait for it began, and how long it was to last then.
    let mut known = None;
    loop {
        let Some(deadline) = deadline() else {
            if draws && blocked.is_none() {
                blocked = Some(Blocked::begin());
            }
            let came = attempt(again);
            if came.is_some() || again.is_none() {
                return came;
            }
            continue;
        };
        let real = real::now();
        // After a wait without a limit the time is later for other threads, who may have set the deadline.
        let blocked_for = if blocked.is_some() { blocked_for(real) } else { 0 };
        let left = deadline.saturating_sub(seen().saturating_add(blocked_for));
        let (begin, length) = match known {
            Some((before, begin, length)) if before == deadline => (begin, length),
            _ => (real, left),
        };
        known = Some((deadline, begin, length));
        let (part, is_last) = if draws {
            let patience = if is_held_before(deadline) { HELD_WAIT } else { patience };
            let rest = Duration::from_nanos(length)
                .min(patience)
                .saturating_sub(Duration::from_nanos(real.saturating_sub(begin)));
            (again.map_or(rest, |again| again.min(rest)), again.is_none_or(|again| rest <= again))
        } else {
            (Duration::from_nanos(left).min(SLICE), left == 0)
        };
        let came = attempt(Some(part));
        let is_last = is_last || (!draws && stands() && real::now().saturating_sub(begin) >= length);
        if draws && is_last && came.is_none() {
            grow(deadline);
        }
        if came.is_some() || is_last {
            return came;
        }
    }
}

/// Moment `time` nanoseconds from now.
pub fn after(time: u64) -> u64 {
    seen().saturating_add(time)
}
