//! Tells the user that something takes longer than usual.

use crate::terminal::spinner;
use std::sync::mpsc;
use std::time::Duration;

/// Time after which the user is told that something is still being computed.
const PATIENCE: Duration = Duration::from_secs(2);

/// Does `work`. If it takes longer than two seconds, a spinner with `message` is shown meanwhile.
pub fn patiently<R>(message: &str, work: impl FnOnce() -> R) -> R {
    after(PATIENCE, || spinner(message), work)
}

/// Does `work`. What `shown` returns lives from the end of `delay` to the end of the work, unless
/// the work ends earlier.
fn after<S, R>(delay: Duration, shown: impl FnOnce() -> S + Send, work: impl FnOnce() -> R) -> R {
    let (done, ends) = mpsc::channel::<()>();
    std::thread::scope(|scope| {
        scope.spawn(move || {
            if ends.recv_timeout(delay) == Err(mpsc::RecvTimeoutError::Timeout) {
                let _shown = shown();
                let _ = ends.recv();
            }
        });
        let result = work();
        drop(done);
        result
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicU32, Ordering};

    #[test]
    fn only_long_work_is_shown_and_only_while_it_lasts() {
        struct Shown<'a>(&'a AtomicU32);
        impl Drop for Shown<'_> {
            fn drop(&mut self) {
                self.0.fetch_add(10, Ordering::SeqCst);
            }
        }
        let count = AtomicU32::new(0);
        let shown = || {
            count.fetch_add(1, Ordering::SeqCst);
            Shown(&count)
        };
        assert_eq!(after(Duration::from_secs(60), shown, || 5), 5);
        assert_eq!(count.load(Ordering::SeqCst), 0);
        let slow = || {
            // The work ends only when it is shown.
            while count.load(Ordering::SeqCst) == 0 {
                std::thread::yield_now();
            }
            count.load(Ordering::SeqCst)
        };
        assert_eq!(after(Duration::from_millis(1), shown, slow), 1);
        assert_eq!(count.load(Ordering::SeqCst), 11);
    }
}
