//! The end of the process. From then on nothing is corrected, because parts of the driver may be
//! gone already.
//!
//! Handlers of `atexit` and destructors of libraries run in the reverse order of their
//! registration. Drivers register some when they are loaded and others when they first compile a
//! shader. A handler of the program may therefore run while the driver can no longer compile. The
//! program's calls there (making no context current, for example) work without Cupola and have to
//! work with it.
//!
//! Two signs show that the process ends. Destructors of thread-local values run before all
//! handlers, on the thread that calls `exit`. On the first thread they run only then. Cupola's
//! `atexit` handler runs later; it is for the other threads.

use std::cell::Cell;
use std::sync::Once;
use std::sync::atomic::{AtomicBool, Ordering};

/// True if the process ends.
static PROCESS: AtomicBool = AtomicBool::new(false);

thread_local! {
    /// True if this thread ends, or calls `exit`.
    static THREAD: Cell<bool> = const { Cell::new(false) };
    /// Its destructor shows that the thread ends.
    static LAST_ACT: LastAct = const { LastAct(Cell::new(None)) };
}

/// Function that runs when the thread ends, while the driver still works.
struct LastAct(Cell<Option<fn()>>);

impl Drop for LastAct {
    fn drop(&mut self) {
        if let Some(act) = self.0.take() {
            act();
        }
        THREAD.set(true);
        // SAFETY: both calls only return a number.
        if unsafe { libc::gettid() == libc::getpid() } {
            PROCESS.store(true, Ordering::Release);
        }
    }
}

extern "C" fn at_exit() {
    PROCESS.store(true, Ordering::Release);
}

/// Watches for the end of the process and of this thread, and calls `act` when this thread ends.
/// Call it once the driver is loaded.
pub fn watch(act: Option<fn()>) {
    static AT_EXIT: Once = Once::new();
    AT_EXIT.call_once(|| {
        // SAFETY: registers a function of a library that is never unloaded.
        unsafe { libc::atexit(at_exit) };
    });
    // A thread whose values are destroyed has ended already.
    let _ = LAST_ACT.try_with(|last| last.0.set(act.or(last.0.get())));
}

/// True if the process ends.
#[inline]
pub fn of_process() -> bool {
    PROCESS.load(Ordering::Relaxed)
}

/// True if the process or this thread ends.
pub fn has_begun() -> bool {
    of_process() || THREAD.get()
}

#[cfg(test)]
mod tests {
    use super::{has_begun, of_process, watch};
    use std::cell::Cell;
    use std::sync::atomic::{AtomicU32, Ordering};

    static SEEN: AtomicU32 = AtomicU32::new(0);

    /// Does what a program may do at the end of a thread, after thread-local values are destroyed.
    struct Late;

    thread_local! {
        static LATE: Cell<Option<Late>> = const { Cell::new(None) };
    }

    impl Drop for Late {
        fn drop(&mut self) {
            SEEN.fetch_add(if has_begun() { 10 } else { 100 }, Ordering::Relaxed);
        }
    }

    /// Values are destroyed in the reverse order of their first use. The end of one thread is not
    /// the end of the process.
    #[test]
    fn the_end_of_a_thread_is_seen_on_it_alone() {
        let thread = std::thread::spawn(|| {
            LATE.set(Some(Late));
            watch(Some(|| {
                SEEN.fetch_add(if has_begun() { 1000 } else { 1 }, Ordering::Relaxed);
            }));
            assert!(!has_begun());
        });
        assert!(thread.join().is_ok());
        assert_eq!(SEEN.load(Ordering::Relaxed), 11, "first the act, then the sign");
        assert!(!has_begun() && !of_process());
    }
}
