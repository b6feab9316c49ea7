//! Warnings of the interception, each logged once. They go to the program's callback for messages
//! if it has one, else to standard error and to the file that `CUPOLA_LOG` names.

use crate::lock::Lock;
use crate::message;
use crate::system::variable;
use std::collections::HashSet;
use std::io::Write;
use std::sync::Mutex;

static SEEN: Mutex<Option<HashSet<String>>> = Mutex::new(None);

/// Greatest number of warnings that are remembered. A rig that is changed for hours makes more.
const MOST_REMEMBERED: usize = 10_000;

/// Logs a warning the first time; repetitions are left out.
pub fn once(text: &str) {
    let is_new = {
        let mut seen = SEEN.locked();
        let seen = seen.get_or_insert_with(HashSet::new);
        if seen.len() == MOST_REMEMBERED {
            seen.clear();
        }
        seen.insert(text.to_owned())
    };
    if is_new {
        message::set_default(write);
        ::log::warn!(target: message::INTERCEPT, "{text}");
    }
}

fn write(message: &str) {
    // A program whose standard error is closed must not notice the message.
    let _ = std::io::stderr().write_all(format!("cupola: {message}\n").as_bytes());
    if let Some(path) = variable("CUPOLA_LOG") {
        let file = std::fs::OpenOptions::new().create(true).append(true).open(path);
        if let Ok(mut file) = file {
            let _ = writeln!(file, "cupola[{}]: {message}", std::process::id());
        }
    }
}
