//! Locks that stay usable after a panic.
//!
//! The standard library marks a lock whose holder panicked. Cupola catches panics before they reach
//! the program and goes on, so the mark is of no use. It is ignored here, in one place.
//!
//! The locks themselves are those of the standard library: a word and a futex. They allocate
//! nothing. In a forked child process, a lock is free unless another thread of the parent held it.
//! `parking_lot` has a table of waiting threads for the whole process. It allocates when a thread
//! waits, and a child that is forked while another thread changes the table waits for ever.
//! Programs with Cupola do fork. No lock of either kind may be taken in a signal handler.

use std::sync::{Mutex, MutexGuard, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

/// Locking of a [`Mutex`] that ignores panics.
pub trait Lock<T: ?Sized> {
    /// Waits for the lock and holds it.
    fn locked(&self) -> MutexGuard<'_, T>;

    /// Returns the value of a lock that no other thread can hold.
    fn unlocked_mut(&mut self) -> &mut T;
}

impl<T: ?Sized> Lock<T> for Mutex<T> {
    fn locked(&self) -> MutexGuard<'_, T> {
        self.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn unlocked_mut(&mut self) -> &mut T {
        self.get_mut().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Locking of an [`RwLock`] that ignores panics.
pub trait SharedLock<T: ?Sized> {
    /// Waits until no thread writes, and locks for reading.
    fn reading(&self) -> RwLockReadGuard<'_, T>;

    /// Waits until no other thread reads or writes, and locks for writing.
    fn writing(&self) -> RwLockWriteGuard<'_, T>;
}

impl<T: ?Sized> SharedLock<T> for RwLock<T> {
    fn reading(&self) -> RwLockReadGuard<'_, T> {
        self.read().unwrap_or_else(PoisonError::into_inner)
    }

    fn writing(&self) -> RwLockWriteGuard<'_, T> {
        self.write().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_panic_left_is_used_further() {
        let (one, shared) = (Mutex::new(1), RwLock::new(2));
        let panicked = std::thread::scope(|scope| {
            let broken = scope.spawn(|| {
                let _held = (one.locked(), shared.writing());
                std::panic::resume_unwind(Box::new("while both are held"));
            });
            broken.join().is_err()
        });
        assert!(panicked && one.is_poisoned() && shared.is_poisoned());
        *one.locked() += 1;
        *shared.writing() += 1;
        assert_eq!((*one.locked(), *shared.reading()), (2, 3));
        let mut one = one;
        assert_eq!(*one.unlocked_mut(), 2);
    }
}
