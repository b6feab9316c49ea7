//! Signals during a wait that several calls of the system make.

use std::ffi::c_int;
use std::mem::MaybeUninit;

/// Faults of the code that runs: they cannot wait.
const FAULTS: [c_int; 6] = [libc::SIGSEGV, libc::SIGBUS, libc::SIGFPE, libc::SIGILL, libc::SIGTRAP, libc::SIGSYS];

/// Keeps signals from this thread. Those that come between two calls of one wait are delivered in
/// the next call, which gets the mask of the program and which they end, as they would have ended
/// the one call of the program. Other threads still take signals that are sent to the process.
pub struct Kept {
    before: libc::sigset_t,
}

impl Kept {
    pub fn begin() -> Self {
        let mut all = MaybeUninit::uninit();
        let mut before = MaybeUninit::zeroed();
        // SAFETY: fills local sets. That of before is a valid one even if it stays zero.
        unsafe {
            libc::sigfillset(all.as_mut_ptr());
            FAULTS.iter().for_each(|fault| {
                libc::sigdelset(all.as_mut_ptr(), *fault);
            });
            libc::pthread_sigmask(libc::SIG_BLOCK, all.as_ptr(), before.as_mut_ptr());
            Self { before: before.assume_init() }
        }
    }

    /// Mask for a call of the system: that which the program gives, or that of its thread.
    pub fn mask(&self, given: *const libc::sigset_t) -> *const libc::sigset_t {
        if given.is_null() { &self.before } else { given }
    }
}

impl Drop for Kept {
    /// Handlers of signals that came since the last call run here.
    fn drop(&mut self) {
        // SAFETY: a local set; the thread's own error number, which the answer of the wait may need.
        unsafe {
            let error = *libc::__errno_location();
            libc::pthread_sigmask(libc::SIG_SETMASK, &self.before, std::ptr::null_mut());
            *libc::__errno_location() = error;
        }
    }
}
