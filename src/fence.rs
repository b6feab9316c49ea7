//! The barrier that keeps panics from crossing into C.

use std::panic::{AssertUnwindSafe, catch_unwind};

/// Runs `body`; returns `None` if it panicked. The panic's message goes to standard error and to
/// the logger.
pub fn guard<T>(body: impl FnOnce() -> T) -> Option<T> {
    let caught = catch_unwind(AssertUnwindSafe(body)).inspect_err(|payload| {
        let text = payload.downcast_ref::<&str>().copied().or_else(|| payload.downcast_ref::<String>().map(|s| &**s));
        log::error!("a defect of Cupola: {}", text.unwrap_or("a panic without a message"));
    });
    caught.ok()
}
