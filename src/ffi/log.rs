//! Messages of the library, for the program's own log.

use super::status::{call, cupola_status};
use crate::message::{self, Receiver};
use log::Level;
use std::ffi::{CString, c_char, c_void};

/// Importance of a message. Numbers never change, and later versions may add some.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub enum cupola_log_level {
    /// A defect of the library.
    CUPOLA_LOG_ERROR = 1,
    /// The picture may be wrong or worse than expected.
    CUPOLA_LOG_WARNING = 2,
    /// Actions of the library, at creation and when sizes change.
    CUPOLA_LOG_INFO = 3,
    /// Details for developers.
    CUPOLA_LOG_DEBUG = 4,
}

/// Receives a message of the library (see `cupola_set_log_callback`).
///
/// `message` is UTF-8 without a newline at its end, NUL-terminated, valid during the call. `user`
/// is the pointer that was passed to `cupola_set_log_callback`.
///
/// The callback may be called from any thread, and from several at the same time. It returns
/// normally: a `longjmp` or a C++ exception out of it is undefined behaviour. It may call functions
/// of the library, except `cupola_set_log_callback` and those with a handle that is in use by the
/// call from which the message comes; messages of these calls are discarded.
pub type cupola_log_callback =
    Option<unsafe extern "C" fn(level: cupola_log_level, message: *const c_char, user: *mut c_void)>;

/// Pointer of the program, which the library passes on and does not use.
struct User(*mut c_void);

// SAFETY: the caller of `cupola_set_log_callback` promises that the callback may be called from any
// thread with it.
unsafe impl Send for User {}
// SAFETY: as above.
unsafe impl Sync for User {}

impl User {
    fn pointer(&self) -> *mut c_void {
        self.0
    }
}

/// Sets the function that receives the messages of the library, or removes it. There is one for the
/// whole process.
///
/// Without a callback, warnings of an injected library (`cupola run`) go to standard error and to
/// the file that `CUPOLA_LOG` names; other messages are discarded. With a callback, it receives all
/// of them instead.
///
/// # Parameters
/// - `callback`: the function, or null to remove the current one.
/// - `user`: passed to the callback; may be null.
///
/// # Returns
/// - `CUPOLA_INVALID_STATE`: called from the callback, or the program is written in Rust and has a
///   logger of its own.
///
/// # Ownership
/// `user` belongs to the program. It has to live until this function has returned from setting
/// another callback or from the removal: from then on the earlier callback is not running and will
/// not be called again.
///
/// # Threads
/// Any thread. The function waits until calls of the earlier callback have returned; so the caller
/// must not hold a lock that this callback needs.
///
/// # Safety
/// `callback` can be called from any thread with `user`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_set_log_callback(callback: cupola_log_callback, user: *mut c_void) -> cupola_status {
    call(|| {
        let user = User(user);
        let receiver = callback.map(|callback| -> Receiver {
            Box::new(move |level, text| {
                let text = CString::new(text.replace('\0', "")).unwrap_or_default();
                // SAFETY: the program's own function; the text lives during the call.
                unsafe { callback(level_of(level), text.as_ptr(), user.pointer()) };
            })
        });
        message::set_receiver(receiver)
    })
}

fn level_of(level: Level) -> cupola_log_level {
    match level {
        Level::Error => cupola_log_level::CUPOLA_LOG_ERROR,
        Level::Warn => cupola_log_level::CUPOLA_LOG_WARNING,
        Level::Info => cupola_log_level::CUPOLA_LOG_INFO,
        Level::Debug | Level::Trace => cupola_log_level::CUPOLA_LOG_DEBUG,
    }
}
