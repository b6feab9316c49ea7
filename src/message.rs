//! Messages of the library, and their receiver.
//!
//! Modules write messages through the [`log`] crate, under targets that begin with `cupola`. A Rust
//! program receives them with a logger of its own. C programs, and programs into which Cupola is
//! injected, have the logger of this module. It passes each message to the receiver that is set,
//! otherwise to the default one, which only the interception has.

use crate::error::{Error, ErrorKind, Result};
use crate::lock::SharedLock;
use log::{Level, LevelFilter, Log, Metadata, Record};
use std::cell::Cell;
use std::sync::{OnceLock, RwLock};

/// Receives messages, from any thread.
pub type Receiver = Box<dyn Fn(Level, &str) + Send + Sync>;

static RECEIVER: RwLock<Option<Receiver>> = RwLock::new(None);
static DEFAULT: OnceLock<fn(&str)> = OnceLock::new();

/// Target of the messages that the default receiver gets.
pub const INTERCEPT: &str = "cupola::intercept";

thread_local! {
    static RECEIVING: Cell<bool> = const { Cell::new(false) };
}

/// Sets or removes the receiver of messages. When this returns, the earlier receiver is not running
/// and will not be called again.
///
/// # Errors
/// [`ErrorKind::InvalidState`] if a receiver calls this, or if the process has another logger.
pub fn set_receiver(receiver: Option<Receiver>) -> Result<()> {
    if RECEIVING.try_with(Cell::get).unwrap_or(true) {
        return Err(Error::new(ErrorKind::InvalidState, "the callback for messages cannot be changed while it runs"));
    }
    if !is_installed() {
        let message = "this process has a logger of its own for the `log` crate; it receives the messages";
        return Err(Error::new(ErrorKind::InvalidState, message));
    }
    let level = if receiver.is_some() { LevelFilter::Debug } else { LevelFilter::Warn };
    // Messages are passed on under the lock, so that this waits for messages that are being
    // received.
    let before = std::mem::replace(&mut *RECEIVER.writing(), receiver);
    log::set_max_level(level);
    drop(before);
    Ok(())
}

/// Sets the function that gets warnings of the interception while no receiver is set.
pub fn set_default(write: fn(&str)) {
    let _ = DEFAULT.set(write);
    if is_installed() && log::max_level() < LevelFilter::Warn {
        log::set_max_level(LevelFilter::Warn);
    }
}

/// True if the process has the logger of this module; installs it if there is none.
fn is_installed() -> bool {
    static INSTALLED: OnceLock<bool> = OnceLock::new();
    *INSTALLED.get_or_init(|| log::set_logger(&Logger).is_ok())
}

struct Logger;

impl Log for Logger {
    fn enabled(&self, metadata: &Metadata) -> bool {
        metadata.target().split("::").next() == Some("cupola")
    }

    fn log(&self, record: &Record) {
        // A message from within a receiver would never end. The thread may be ending, too.
        if !self.enabled(record.metadata()) || RECEIVING.try_with(Cell::get).unwrap_or(true) {
            return;
        }
        let text = record.args().to_string();
        let receiver = RECEIVER.reading();
        if let Some(receiver) = &*receiver {
            RECEIVING.set(true);
            receiver(record.level(), &text);
            RECEIVING.set(false);
        } else if let Some(write) = DEFAULT.get().filter(|_| record.target() == INTERCEPT) {
            write(&text);
        }
    }

    fn flush(&self) {}
}

#[cfg(test)]
mod tests;
