//! The most recent frame's statistics and pictures, which are written when the program ends.

use crate::intercept::inspection;
use crate::intercept::inspection::page::{self, Page};
use crate::intercept::process::settings::{self, Settings};
use crate::intercept::process::{log, publishing, signals};
use crate::lock::Lock;
use crate::runtime::frame_times::FrameTimes;
use crate::runtime::run_results::{self, Picture, Statistics};
use std::sync::{Arc, Mutex, Once};
use std::time::Instant;

/// Statistics and pictures of a frame.
pub struct LastFrame {
    /// For `CUPOLA_STATS`.
    pub statistics: Option<Statistics>,
    /// Times of the frames so far, for the statistics.
    pub times: Option<Arc<Mutex<FrameTimes>>>,
    /// The outputs, for `CUPOLA_CAPTURE`.
    pub pictures: Vec<Picture>,
    /// The views, for `CUPOLA_CAPTURE_VIEWS`.
    pub views: Vec<Picture>,
}

/// Most recent frame, with its state.
struct Latest {
    frame: Option<LastFrame>,
    /// The frame's sequence number.
    number: u64,
    /// True if the draws of the frame were described.
    is_described: bool,
    /// True if everything is written. Later frames are not stored.
    is_written: bool,
}

static LAST_FRAME: Mutex<Latest> =
    Mutex::new(Latest { frame: None, number: 0, is_described: false, is_written: false });

/// True if the program ends after the frame with this number: because it is the requested number,
/// the requested time is over, or a signal ends the program.
pub fn is_last(settings: &Settings, number: u64) -> bool {
    if settings.has_report() {
        signals::watch(is_kept, write);
    }
    // A frame can be described only if it was known at its start to be the last.
    settings.frames == Some(number) || (is_over(settings) && (settings.inspect.is_none() || inspection::is_recording()))
}

/// True if the requested time is over or a signal ends the program.
fn is_over(settings: &Settings) -> bool {
    settings.is_time_over() || signals::received().is_some()
}

/// Begins the frame with this number.
pub fn begin(settings: &Settings, number: u64) {
    inspection::begin_frame(settings, settings.frames == Some(number) || is_over(settings));
}

/// True if pictures of the outputs have to be stored with this frame.
pub fn wants_outputs(settings: &Settings) -> bool {
    settings.capture.is_some() || inspection::is_recording()
}

/// True if pictures of the views have to be stored with this frame.
pub fn wants_views(settings: &Settings) -> bool {
    settings.capture_views.is_some() || inspection::is_recording()
}

/// True if a frame is stored, with a description of its draws if one was requested.
fn is_kept() -> bool {
    let latest = LAST_FRAME.locked();
    let wants_description = settings::settings().is_some_and(|settings| settings.inspect.is_some());
    latest.frame.is_some() && (latest.is_described || !wants_description)
}

/// Stores a frame in place of the one before, unless everything is written. Returns its sequence
/// number, for [`amend`].
pub fn store(frame: LastFrame) -> u64 {
    static AT_EXIT: Once = Once::new();
    AT_EXIT.call_once(|| {
        // SAFETY: registers a function of a library that is never unloaded.
        unsafe { libc::atexit(at_exit) };
    });
    let mut latest = LAST_FRAME.locked();
    if !latest.is_written {
        latest.frame = Some(frame);
        latest.is_described = inspection::is_recording();
        latest.number += 1;
    }
    write_now_and_then(&mut latest);
    latest.number
}

/// Writes the statistics of the stored frame, if that was requested and the interval is over.
fn write_now_and_then(latest: &mut Latest) {
    static WRITTEN: Mutex<Option<Instant>> = Mutex::new(None);
    let Some((settings, every)) = settings::settings().and_then(|settings| Some((settings, settings.stats_every?)))
    else {
        return;
    };
    let mut written = WRITTEN.locked();
    if written.is_some_and(|written| written.elapsed() < every) {
        return;
    }
    *written = Some(Instant::now());
    let Some(LastFrame { statistics: Some(statistics), times, .. }) = &mut latest.frame else { return };
    if let Some(times) = times {
        statistics.milliseconds = (&*times.locked()).into();
    }
    if let Some(path) = &settings.stats
        && let Err(error) = run_results::replace_statistics(path, statistics)
    {
        log::once(&error.message);
    }
}

/// Changes the statistics of the frame with this number, if it is still the stored one.
pub fn amend(number: u64, change: impl FnOnce(&mut Statistics)) {
    let mut latest = LAST_FRAME.locked();
    let same = latest.number == number;
    let statistics = latest.frame.as_mut().and_then(|frame| frame.statistics.as_mut());
    if let Some(statistics) = statistics.filter(|_| same) {
        change(statistics);
    }
}

/// Writes the stored frame and ends the program: with exit code 0, or by the signal that it
/// received.
pub fn end_program() {
    write();
    publishing::end();
    if let Some(signal) = signals::received() {
        signals::end_by(signal);
    }
    // SAFETY: flushes the program's own output; `_exit` runs none of its handlers, which may
    // wait for a window system that is in the middle of this call.
    unsafe {
        libc::fflush(std::ptr::null_mut());
        libc::_exit(0);
    }
}

extern "C" fn at_exit() {
    // A panic while the process ends can be reported to nobody.
    let _ = crate::fence::guard(write);
}

/// Writes the stored frame, if there is one. Another thread that calls this waits until everything
/// is written.
fn write() {
    let Some(settings) = settings::settings() else { return };
    let mut latest = LAST_FRAME.locked();
    if std::mem::replace(&mut latest.is_written, true) {
        return;
    }
    let Some(mut frame) = latest.frame.take() else { return };
    if let (Some(statistics), Some(times)) = (&mut frame.statistics, &frame.times) {
        statistics.milliseconds = (&*times.locked()).into();
    }
    let say = |result: crate::Result<()>| {
        if let Err(error) = result {
            log::once(&error.message);
        }
    };
    if let (Some(path), Some(statistics)) = (&settings.stats, &frame.statistics) {
        say(run_results::write_statistics(path, statistics));
    }
    if let Some(path) = &settings.inspect {
        let arguments: Vec<String> = std::env::args_os().map(|text| text.to_string_lossy().into_owned()).collect();
        let page = Page {
            command: arguments.join(" "),
            passes: &inspection::take(),
            statistics: frame.statistics.as_ref(),
            outputs: &frame.pictures,
            views: &frame.views,
        };
        say(run_results::write_text(path, &page::html(&page)));
    }
    if let Some(path) = &settings.capture {
        // With several nodes, each writes the pictures of its own outputs.
        let several = frame.pictures.len() > 1 || settings.node_page.is_some();
        // An output outside of the window has no picture.
        for picture in frame.pictures.iter().filter(|picture| picture.width > 0 && picture.height > 0) {
            say(run_results::write_picture(&run_results::capture_path(path, &picture.name, several), picture));
        }
    }
    if let Some(directory) = &settings.capture_views {
        if let Err(error) = std::fs::create_dir_all(directory) {
            log::once(&format!("{}: {error}", directory.display()));
        }
        for picture in &frame.views {
            say(run_results::write_picture(&directory.join(format!("{}.png", picture.name)), picture));
        }
    }
}
