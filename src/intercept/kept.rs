//! What is kept of the latest frame, and written when the program ends.

use super::{log, settings};
use crate::lock::Lock;
use crate::runtime::report::{self, Picture, Statistics};
use std::sync::{Mutex, Once};

/// What is written when the program ends.
pub struct Kept {
    /// For `CUPOLA_STATS`.
    pub statistics: Option<Statistics>,
    /// The outputs, for `CUPOLA_CAPTURE`.
    pub pictures: Vec<Picture>,
    /// The views, for `CUPOLA_CAPTURE_VIEWS`.
    pub views: Vec<Picture>,
}

/// The latest frame, and the how manieth it is that was kept.
static KEPT: Mutex<(Option<Kept>, u64)> = Mutex::new((None, 0));

/// Keeps the latest frame in place of the one before, until the program ends. Its number is for [`amend`].
pub fn keep(kept: Kept) -> u64 {
    static AT_EXIT: Once = Once::new();
    AT_EXIT.call_once(|| {
        // SAFETY: registers a function of a library that is never unloaded.
        unsafe { libc::atexit(at_exit) };
    });
    let mut latest = KEPT.locked();
    *latest = (Some(kept), latest.1 + 1);
    latest.1
}

/// Changes the statistics of the frame with this number, if they are those that are kept.
pub fn amend(number: u64, change: impl FnOnce(&mut Statistics)) {
    let mut latest = KEPT.locked();
    let same = latest.1 == number;
    let statistics = latest.0.as_mut().and_then(|kept| kept.statistics.as_mut());
    if let Some(statistics) = statistics.filter(|_| same) {
        change(statistics);
    }
}

/// Writes what was kept and ends the program with exit code 0.
pub fn end_program() {
    write();
    // SAFETY: flushes the program's own output; `_exit` runs none of its handlers, which may
    // wait for a window system that is in the middle of this call.
    unsafe {
        libc::fflush(std::ptr::null_mut());
        libc::_exit(0);
    }
}

extern "C" fn at_exit() {
    // A panic while the process ends has nobody left to tell.
    let _ = crate::fence::guard(write);
}

fn write() {
    let Some(settings) = settings::settings() else { return };
    let Some(kept) = KEPT.locked().0.take() else { return };
    let say = |result: crate::Result<()>| {
        if let Err(error) = result {
            log::once(&error.message);
        }
    };
    if let (Some(path), Some(statistics)) = (&settings.stats, &kept.statistics) {
        say(report::write_statistics(path, statistics));
    }
    if let Some(path) = &settings.capture {
        let several = kept.pictures.len() > 1;
        // Of an output outside of the window there is nothing to write.
        for picture in kept.pictures.iter().filter(|picture| picture.width > 0 && picture.height > 0) {
            say(report::write_picture(&report::capture_path(path, &picture.name, several), picture));
        }
    }
    if let Some(directory) = &settings.capture_views {
        if let Err(error) = std::fs::create_dir_all(directory) {
            log::once(&format!("{}: {error}", directory.display()));
        }
        for picture in &kept.views {
            say(report::write_picture(&directory.join(format!("{}.png", picture.name)), picture));
        }
    }
}
