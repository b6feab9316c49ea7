//! Copies of the process, which `fork` makes.

use crate::{files::timers, threads, timeline};
use std::ptr::null_mut;
use std::sync::atomic::{AtomicPtr, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError, TryLockError};

/// A list that all threads use, with its lock.
///
/// When the process is copied, its threads may have the lock, which the copy then never gets. To
/// take it before is no way out: other libraries take theirs at the same time, in any order. So the
/// copy begins with another list.
pub struct Shared<T: 'static> {
    first: Mutex<T>,
    /// The list of a copy; null: the first one.
    fresh: AtomicPtr<Mutex<T>>,
}

impl<T: Default> Shared<T> {
    pub const fn new(list: T) -> Self {
        Self { first: Mutex::new(list), fresh: AtomicPtr::new(null_mut()) }
    }

    fn list(&self) -> &Mutex<T> {
        // SAFETY: null, or memory that [`Self::renew`] has filled and that nobody gives back.
        unsafe { self.fresh.load(Ordering::Acquire).as_ref() }.unwrap_or(&self.first)
    }

    pub fn lock(&self) -> MutexGuard<'_, T> {
        self.list().lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Makes the list an empty one, in a copy of the process. Nothing of the old list is given back
    /// to the allocator, which may not be ready here.
    fn renew(&self) {
        match self.list().try_lock() {
            Ok(mut list) => std::mem::forget(std::mem::take(&mut *list)),
            Err(TryLockError::Poisoned(list)) => std::mem::forget(std::mem::take(&mut *list.into_inner())),
            // A thread that the copy lacks has it. (If it is this one, in a handler of a signal, it
            // gives back the old one.)
            Err(TryLockError::WouldBlock) => {
                let (size, access) = (size_of::<Mutex<T>>(), libc::PROT_READ | libc::PROT_WRITE);
                let kind = libc::MAP_PRIVATE | libc::MAP_ANONYMOUS;
                // SAFETY: maps new pages; nothing else lies there.
                let fresh = unsafe { libc::mmap(null_mut(), size, access, kind, -1, 0) };
                // Without memory the copy may hang when it uses the list.
                if fresh != libc::MAP_FAILED {
                    let fresh = fresh.cast::<Mutex<T>>();
                    // SAFETY: the pages have this size, and begin at a multiple of each alignment.
                    unsafe { fresh.write(Mutex::new(T::default())) };
                    self.fresh.store(fresh, Ordering::Release);
                }
            }
        }
    }
}

/// Has the lists renewed in each copy of this process.
pub fn begin() {
    // SAFETY: a function that stays. If there is no memory for it, copies of this process may hang.
    unsafe { libc::pthread_atfork(None, None, Some(in_copy)) };
}

/// The copy has a clock of its own. It shares the timers that are files with the first process: to
/// fire them is up to that one.
extern "C" fn in_copy() {
    timers::TIMERS.renew();
    timers::forget_marks();
    threads::WAITING.renew();
    timeline::begin_copy();
}
