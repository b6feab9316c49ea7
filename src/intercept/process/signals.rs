//! Signals that end the program. Captures and statistics are written first.
//!
//! A handler may neither allocate nor lock. It wakes a thread that writes. If the program
//! continues, its next frame is the last one. Signals that the program handles or ignores are left
//! alone. If there is nothing to write, all signals are.

use std::cell::UnsafeCell;
use std::mem::MaybeUninit;
use std::sync::Once;
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};
use std::time::Duration;

/// Signals that usually end a program.
const DEADLY: [libc::c_int; 10] = [
    libc::SIGHUP,
    libc::SIGINT,
    libc::SIGQUIT,
    libc::SIGILL,
    libc::SIGABRT,
    libc::SIGBUS,
    libc::SIGFPE,
    libc::SIGSEGV,
    libc::SIGPIPE,
    libc::SIGTERM,
];

/// Time in which the program may draw one more frame, if none is stored yet.
const FOR_A_FRAME: Duration = Duration::from_secs(5);

/// Longest time that the process waits until everything is written.
const FOR_WRITING: Duration = Duration::from_secs(5);

const STEP: Duration = Duration::from_millis(10);

/// The process that runs the thread. A child made by `fork` has no such thread.
static OWNER: AtomicI32 = AtomicI32::new(0);
/// The first signal; 0 = none.
static RECEIVED: AtomicI32 = AtomicI32::new(0);
/// True if the program continues to draw until it is ended.
static DRAWS_ON: AtomicBool = AtomicBool::new(true);
/// True if everything is written.
static WRITTEN: AtomicBool = AtomicBool::new(false);
static WAKE: Semaphore = Semaphore(UnsafeCell::new(MaybeUninit::uninit()));

struct Semaphore(UnsafeCell<MaybeUninit<libc::sem_t>>);

// SAFETY: `sem_t` is accessed only by `sem_init`, `sem_post` and `sem_wait`, which synchronise
// threads. It is never moved.
unsafe impl Sync for Semaphore {}

/// Handles the signals from now on. `write` writes the stored frame, and `is_kept` returns whether
/// there is one. Further calls do nothing.
pub fn watch(is_kept: fn() -> bool, write: fn()) {
    static WATCH: Once = Once::new();
    WATCH.call_once(|| {
        // SAFETY: the semaphore is static, and nothing uses it yet.
        let ready = unsafe { libc::sem_init(WAKE.0.get().cast(), 0, 0) } == 0;
        if ready && spawn_without_signals(move || write_on_demand(is_kept, write)) {
            OWNER.store(std::process::id() as i32, Ordering::Release);
            DEADLY.into_iter().for_each(take);
        }
    });
}

/// Returns the signal that ends the program after this frame.
pub fn received() -> Option<libc::c_int> {
    Some(RECEIVED.load(Ordering::Acquire)).filter(|signal| *signal != 0)
}

/// Ends this process by a signal that another process sent.
pub fn end_by(signal: libc::c_int) {
    // SAFETY: both calls only take numbers. The signal goes to the whole process, since this thread
    // may block it.
    unsafe {
        libc::signal(signal, libc::SIG_DFL);
        libc::kill(libc::getpid(), signal);
    }
    std::thread::sleep(FOR_WRITING);
}

/// Starts the thread that writes. It blocks all signals. Returns whether it runs.
fn spawn_without_signals(run: impl FnOnce() + Send + 'static) -> bool {
    let (mut all, mut before) = (MaybeUninit::uninit(), MaybeUninit::uninit());
    // SAFETY: both sets are filled before they are read; the mask of this thread is restored.
    unsafe {
        libc::sigfillset(all.as_mut_ptr());
        libc::pthread_sigmask(libc::SIG_SETMASK, all.as_ptr(), before.as_mut_ptr());
    }
    let thread = std::thread::Builder::new().name("cupola-signals".to_owned()).spawn(run);
    // SAFETY: as above.
    unsafe { libc::pthread_sigmask(libc::SIG_SETMASK, before.as_ptr(), std::ptr::null_mut()) };
    thread.is_ok()
}

/// Installs the handler for a signal, unless the program handles or ignores the signal itself.
fn take(signal: libc::c_int) {
    // SAFETY: all zeroes is a valid sigaction; both structures live during the calls, and the
    // handler has the three-argument form that the flags announce.
    unsafe {
        let mut known: libc::sigaction = std::mem::zeroed();
        if libc::sigaction(signal, std::ptr::null(), &mut known) != 0 || known.sa_sigaction != libc::SIG_DFL {
            return;
        }
        let mut action: libc::sigaction = std::mem::zeroed();
        action.sa_sigaction = handle as *const () as libc::sighandler_t;
        action.sa_flags = libc::SA_SIGINFO | libc::SA_RESTART | libc::SA_ONSTACK;
        libc::sigaction(signal, &action, std::ptr::null_mut());
    }
}

/// The handler. After a signal from another process the program can draw one more frame; after any
/// other signal it cannot.
extern "C" fn handle(signal: libc::c_int, info: *mut libc::siginfo_t, _context: *mut libc::c_void) {
    // SAFETY: every call here may be made in a handler; the kernel passes a valid `info`; errno is
    // the program's.
    unsafe {
        let errno = *libc::__errno_location();
        let own = libc::getpid();
        let from_outside = match (*info).si_code {
            libc::SI_USER | libc::SI_QUEUE => (*info).si_pid() != own,
            // A signal of the terminal.
            code => code == libc::SI_KERNEL && matches!(signal, libc::SIGINT | libc::SIGQUIT | libc::SIGHUP),
        };
        let is_fault =
            (*info).si_code > 0 && matches!(signal, libc::SIGSEGV | libc::SIGBUS | libc::SIGILL | libc::SIGFPE);
        // A child that shares this memory after `vfork` must change nothing here.
        let ours = OWNER.load(Ordering::Acquire) == own;
        if ours {
            if !from_outside {
                DRAWS_ON.store(false, Ordering::Release);
            }
            let _ = RECEIVED.compare_exchange(0, signal, Ordering::AcqRel, Ordering::Acquire);
            libc::sem_post(WAKE.0.get().cast());
        }
        if !ours || !from_outside {
            let step = libc::timespec { tv_sec: 0, tv_nsec: STEP.as_nanos() as libc::c_long };
            let mut left = if ours { FOR_WRITING.as_millis() / STEP.as_millis() } else { 0 };
            while left > 0 && !WRITTEN.load(Ordering::Acquire) {
                libc::nanosleep(&step, std::ptr::null_mut());
                left -= 1;
            }
            libc::signal(signal, libc::SIG_DFL);
            // A faulty instruction is executed again, and faults as without Cupola.
            if !is_fault {
                libc::raise(signal);
            }
        }
        *libc::__errno_location() = errno;
    }
}

/// Waits for a signal and writes the stored frame. Ends the process by the signal, unless the
/// handler does that.
fn write_on_demand(is_kept: fn() -> bool, write: fn()) {
    // SAFETY: the semaphore was initialised before this thread was started.
    while unsafe { libc::sem_wait(WAKE.0.get().cast()) } != 0 {}
    let mut waited = Duration::ZERO;
    while DRAWS_ON.load(Ordering::Acquire) && !is_kept() && waited < FOR_A_FRAME {
        std::thread::sleep(STEP);
        waited += STEP;
    }
    let _ = crate::fence::guard(write);
    WRITTEN.store(true, Ordering::Release);
    if DRAWS_ON.load(Ordering::Acquire) {
        end_by(RECEIVED.load(Ordering::Acquire));
    }
}
