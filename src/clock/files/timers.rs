//! Timers of the program that are files (`timerfd`). The system's own timer is made readable when
//! the program's time has come, so that it wakes who waits for it in whatever way.

use crate::caller::{interpose, is_served};
use crate::process::copies::Shared;
use crate::real;
use crate::timeline::{SLICE, after, draws, moment, nanoseconds, now, seen, start_of, thread, timespec};
use std::ffi::{c_int, c_long};
use std::sync::MutexGuard;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

interpose! {
    2 timerfd_create => timerfd_create_for;
    4 timerfd_settime => timerfd_settime_for;
    2 timerfd_gettime => timerfd_gettime_for;
}

/// Longest real time that the system needs to make a timer readable.
const SOON: Duration = Duration::from_millis(10);
/// Interval at which a wait for unknown files looks whether the program has made a timer.
const RARE: Duration = Duration::from_millis(100);

struct Timer {
    /// Its descriptors: the first, and copies.
    files: Vec<c_int>,
    /// Next time at which it expires, in nanoseconds since the start; 0: it is not set.
    deadline: u64,
    /// Time between later expirations; 0: it expires once.
    interval: u64,
    /// Number of expirations that nobody has read. The system's timer knows of one.
    expired: u64,
    /// The thread that set it last.
    thread: libc::pid_t,
}

impl Timer {
    fn left(&self) -> libc::itimerspec {
        libc::itimerspec {
            it_interval: timespec(self.interval),
            it_value: timespec(self.deadline.saturating_sub(seen())),
        }
    }

    /// Makes the timer readable, whose time has come at `time`.
    fn expire(&mut self, file: c_int, time: u64) {
        let late = time.saturating_sub(self.deadline);
        let (next, count) = match self.interval {
            0 => (0, 1),
            interval => (time.saturating_add(interval - late % interval), late / interval + 1),
        };
        self.deadline = next;
        // Reads that are not seen here take all expirations.
        if !is_readable(file, Duration::ZERO) {
            self.expired = 0;
        }
        // Also if it is readable already: edge-triggered waits are told of each expiration.
        set(file, 1);
        is_readable(file, SOON);
        self.expired += count;
    }
}

/// The timers of the program.
#[derive(Default)]
pub struct Table(Vec<Timer>);

pub static TIMERS: Shared<Table> = Shared::new(Table(Vec::new()));

/// Which remainders the descriptors of timers have, one bit for each.
static MARKS: [AtomicU64; 16] = [const { AtomicU64::new(0) }; 16];

/// Number of a descriptor's mark.
fn slot(file: c_int) -> usize {
    file.cast_unsigned() as usize % (64 * MARKS.len())
}

/// Word and bit of a descriptor's mark.
fn mark(file: c_int) -> (&'static AtomicU64, u64) {
    (&MARKS[slot(file) / 64], 1 << (slot(file) % 64))
}

fn set_mark(file: c_int) {
    let (word, bit) = mark(file);
    word.fetch_or(bit, Ordering::AcqRel);
}

/// False if this is no timer. Handlers of signals may ask: it takes no lock.
pub fn may_be_timer(file: c_int) -> bool {
    let (word, bit) = mark(file);
    word.load(Ordering::Acquire) & bit != 0
}

/// Makes no descriptor one of a timer.
pub fn forget_marks() {
    MARKS.iter().for_each(|word| word.store(0, Ordering::Release));
}

/// The timers.
fn timers() -> MutexGuard<'static, Table> {
    TIMERS.lock()
}

impl Table {
    /// The timer with this descriptor. `None` if the program has closed it: `close` and its kin are
    /// not seen, so the system is asked whether it is a timer still.
    fn find(&mut self, file: c_int) -> Option<&mut Timer> {
        let index = self.0.iter().position(|timer| timer.files.contains(&file))?;
        if is_timer(file) {
            return self.0.get_mut(index);
        }
        self.forget(file);
        None
    }

    /// Forgets a descriptor, and its timer if that has no other.
    fn forget(&mut self, file: c_int) {
        self.0.iter_mut().for_each(|timer| timer.files.retain(|own| *own != file));
        self.0.retain(|timer| !timer.files.is_empty());
        if !self.0.iter().flat_map(|timer| &timer.files).any(|other| slot(*other) == slot(file)) {
            let (word, bit) = mark(file);
            word.fetch_and(!bit, Ordering::AcqRel);
        }
    }

    /// A descriptor of a timer whose time has come, and that time.
    fn due(&self, time: impl Fn(&Timer) -> u64) -> Option<(c_int, u64)> {
        let due = |timer: &Timer| timer.deadline > 0 && timer.deadline <= time(timer);
        let timer = self.0.iter().find(|timer| due(timer))?;
        Some((*timer.files.first()?, time(timer)))
    }

    /// Makes timers readable whose time has come.
    fn fire(&mut self, time: impl Fn(&Timer) -> u64) {
        // Each turn moves a deadline beyond its time, or forgets a descriptor.
        while let Some((file, time)) = self.due(&time) {
            if let Some(timer) = self.find(file) {
                timer.expire(file, time);
            }
        }
    }
}

/// Files of a wait.
pub enum Watched {
    /// Those of these that may be timers.
    Files(Vec<c_int>),
    /// Those that an `epoll` with this descriptor watches.
    Epoll(c_int),
}

impl Watched {
    pub fn of(files: impl Iterator<Item = c_int>) -> Self {
        Self::Files(files.filter(|file| may_be_timer(*file)).collect())
    }

    /// False if there is no timer among the files.
    pub fn has_timers(&self) -> bool {
        match self {
            Self::Files(files) => !files.is_empty(),
            Self::Epoll(_) => !timers().0.is_empty(),
        }
    }

    /// Descriptors of the timers that count for this thread. For the drawing thread an `epoll`
    /// watches all. Another thread may see a later time, at which it must not fire those of others:
    /// for it, an `epoll` watches those that the system names, and those that the thread has set.
    fn files(&self, table: &Table) -> Vec<c_int> {
        match self {
            Self::Files(files) => files.clone(),
            Self::Epoll(_) if table.0.is_empty() => Vec::new(),
            Self::Epoll(file) => {
                let (all, own) = (draws(), thread());
                let named = if all { Vec::new() } else { named(*file) };
                let counts =
                    |timer: &&Timer| all || timer.thread == own || timer.files.iter().any(|file| named.contains(file));
                table.0.iter().filter(counts).flat_map(|timer| &timer.files).copied().collect()
            }
        }
    }

    /// Time at which the next of the timers expires.
    pub fn next(&self) -> Option<u64> {
        let mut table = timers();
        let files = self.files(&table);
        files.into_iter().filter_map(|file| Some(table.find(file)?.deadline)).filter(|deadline| *deadline > 0).min()
    }

    /// Interval at which a wait asks for [`Self::next`] again, because another thread may set a
    /// timer; `None`: never.
    pub fn again(&self) -> Option<Duration> {
        match self {
            _ if self.has_timers() => Some(SLICE),
            Self::Files(_) => None,
            Self::Epoll(_) => Some(RARE),
        }
    }

    /// Makes timers readable whose time has come: these as this thread sees the time, which may be
    /// ahead of the program's, and all others by the program's time.
    pub fn fire(&self) {
        let (now, seen) = (now(), seen());
        let mut table = timers();
        let files = if seen > now { self.files(&table) } else { Vec::new() };
        table.fire(|timer| if timer.files.iter().any(|file| files.contains(file)) { seen } else { now });
    }
}

/// Descriptors that an `epoll` watches, as the system names them: with the numbers at which the
/// program added them. None if the system does not tell.
fn named(epoll: c_int) -> Vec<c_int> {
    let text = content(&format!("/proc/self/fdinfo/{epoll}\0"));
    let lines = text.split(|byte| *byte == b'\n').filter_map(|line| std::str::from_utf8(line).ok());
    lines.filter_map(|line| line.strip_prefix("tfd:")?.split_whitespace().next()?.parse().ok()).collect()
}

/// Content of a file whose path ends with 0; empty if it cannot be read. By system calls: a thread
/// that reads with a lock cannot be cancelled here.
fn content(path: &str) -> Vec<u8> {
    let (folder, flags) = (libc::AT_FDCWD as usize, (libc::O_RDONLY | libc::O_CLOEXEC) as usize);
    // SAFETY: the path ends with 0.
    let file = unsafe { real::syscall(libc::SYS_openat, folder, path.as_ptr() as usize, flags, 0, 0, 0) };
    let Ok(file) = usize::try_from(file) else { return Vec::new() };
    let (mut content, mut part) = (Vec::new(), [0_u8; 1024]);
    loop {
        let bytes = part.as_mut_ptr() as usize;
        // SAFETY: local bytes, as many as the call gets to know.
        let count = unsafe { real::syscall(libc::SYS_read, file, bytes, part.len(), 0, 0, 0) };
        match usize::try_from(count).ok().and_then(|count| part.get(..count)) {
            Some(read) if !read.is_empty() => content.extend_from_slice(read),
            _ => break,
        }
    }
    // SAFETY: a descriptor that nobody else knows.
    unsafe { real::syscall(libc::SYS_close, file, 0, 0, 0, 0, 0) };
    content
}

/// Makes all timers readable whose time has come at `time`.
pub fn fire(time: u64) {
    timers().fire(|_| time);
}

/// What a read of a timer takes.
pub enum Taken {
    /// Number of expirations.
    Count(u64),
    /// It has not expired.
    None,
    /// This is no timer of the program, or the system has an error to tell.
    Unknown,
}

/// Takes the expirations of a timer.
pub fn take(file: c_int) -> Taken {
    let mut table = timers();
    let Some(timer) = table.find(file) else { return Taken::Unknown };
    let mut count = 0_u64;
    let bytes = &raw mut count;
    // SAFETY: a local number. It is a system call, so that the thread cannot be cancelled here.
    match is_readable(file, Duration::ZERO)
        .then(|| unsafe { real::syscall(libc::SYS_read, file as usize, bytes as usize, size_of::<u64>(), 0, 0, 0) })
    {
        None => Taken::None,
        Some(8) => Taken::Count(std::mem::take(&mut timer.expired).max(count)),
        Some(_) => Taken::Unknown,
    }
}

/// Notes that the program has made the descriptor `new` a copy of `old`.
pub fn copy(old: c_int, new: c_int) {
    if new < 0 || new == old || !(may_be_timer(old) || may_be_timer(new)) {
        return;
    }
    let mut table = timers();
    table.forget(new);
    if let Some(timer) = table.find(old) {
        timer.files.push(new);
        set_mark(new);
    }
}

/// Makes the system's timer fire once after this number of nanoseconds; 0: never.
fn set(file: c_int, after: c_long) {
    let zero = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    let new = libc::itimerspec { it_interval: zero, it_value: libc::timespec { tv_sec: 0, tv_nsec: after } };
    // SAFETY: valid structures; the system refuses a file that is no longer a timer.
    unsafe { real::timerfd_settime(file, 0, &new, std::ptr::null_mut()) };
}

/// True if the descriptor is that of a timer.
fn is_timer(file: c_int) -> bool {
    let zero = libc::timespec { tv_sec: 0, tv_nsec: 0 };
    let mut time = libc::itimerspec { it_interval: zero, it_value: zero };
    // SAFETY: writes a local structure; the system refuses other files.
    unsafe { real::timerfd_gettime(file, &mut time) == 0 }
}

/// Waits until a file can be read, for no longer than `limit` of real time. By the system call: a
/// thread that waits here with a lock cannot be cancelled.
fn is_readable(file: c_int, limit: Duration) -> bool {
    let mut asked = libc::pollfd { fd: file, events: libc::POLLIN, revents: 0 };
    let mut limit = libc::timespec { tv_sec: 0, tv_nsec: limit.subsec_nanos().into() };
    let (asked, limit) = (&raw mut asked, &raw mut limit);
    // SAFETY: local structures.
    unsafe { real::syscall(libc::SYS_ppoll, asked as usize, 1, limit as usize, 0, 0, 0) == 1 }
}

pub unsafe extern "C" fn timerfd_create_for(clock: c_int, flags: c_int, caller: usize) -> c_int {
    // SAFETY: the program's own call.
    let file = unsafe { real::timerfd_create(clock, flags) };
    if file >= 0 {
        let mut timers = timers();
        timers.forget(file);
        if start_of(clock).is_some() && is_served(caller) {
            timers.0.push(Timer { files: vec![file], deadline: 0, interval: 0, expired: 0, thread: thread() });
            set_mark(file);
        }
    }
    file
}

pub unsafe extern "C" fn timerfd_settime_for(
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
    let (Some(timer), Some((value, interval))) = (timers.find(file), times) else {
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
    timer.thread = thread();
    timer.deadline = match value {
        0 => 0,
        value if is_absolute => moment(value).max(1),
        value => after(value),
    };
    // An earlier expiration that was not read is forgotten.
    timer.expired = 0;
    set(file, 0);
    drop(timers);
    Watched::Files(vec![file]).fire();
    0
}

pub unsafe extern "C" fn timerfd_gettime_for(file: c_int, time: *mut libc::itimerspec, _caller: usize) -> c_int {
    let left = timers().find(file).map(|timer| timer.left());
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
