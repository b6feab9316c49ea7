//! The rig while the program runs: read again when its file changes.
//!
//! The file's time and length are asked up to a hundred times a second, between two frames, but for
//! no more than a hundredth of the time where the file lies far away: other frames read the clock
//! and no more. A file with a mistake changes nothing, and the log says once what is
//! wrong with it.

use super::file_stamp::FileStamp;
use super::log;
use super::settings::Settings;
use crate::intercept::settings;
use crate::lock::Lock;
use crate::rig::Rig;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock};
use std::time::{Duration, Instant};

/// Least interval at which the file is checked.
const INTERVAL: Duration = Duration::from_millis(10);
/// Least ratio of the pause after a check of the file to the time of the check.
const PAUSE: u32 = 100;

/// The rig of the moment.
#[derive(Clone)]
pub struct Live {
    /// The rig.
    pub rig: Arc<Rig>,
    /// Grows with every change.
    pub version: u64,
}

struct Watch {
    live: Live,
    looked: Instant,
    /// Time from the last check to the next.
    pause: Duration,
    seen: Option<FileStamp>,
}

static VERSION: AtomicU64 = AtomicU64::new(0);

fn watch(settings: &Settings) -> &'static Mutex<Watch> {
    static WATCH: OnceLock<Mutex<Watch>> = OnceLock::new();
    WATCH.get_or_init(|| {
        let live = Live { rig: Arc::new(settings.rig.clone()), version: 0 };
        Mutex::new(Watch { live, looked: Instant::now(), pause: INTERVAL, seen: settings.rig_stamp })
    })
}

/// The rig of the moment; `None` where the settings are wrong.
pub fn rig() -> Option<Live> {
    let settings = settings::settings()?;
    Some(watch(settings).locked().live.clone())
}

/// The rig's version as it was found last. For any place and time.
pub fn known_version() -> u64 {
    VERSION.load(Ordering::Acquire)
}

/// The rig's version, after a look at its file if the last one was a while ago. For the end of a
/// frame.
pub fn version() -> u64 {
    if let Some((settings, path)) = settings::settings().and_then(|s| Some((s, s.rig_file.as_deref()?))) {
        // A frame does not wait for another window's look.
        if let Ok(mut watch) = watch(settings).try_lock()
            && watch.looked.elapsed() >= watch.pause
        {
            look(&mut watch, settings, path);
        }
    }
    known_version()
}

fn look(watch: &mut Watch, settings: &Settings, path: &Path) {
    watch.looked = Instant::now();
    let found = FileStamp::of(path);
    watch.pause = INTERVAL.max(watch.looked.elapsed() * PAUSE);
    // A file that is gone for a moment is being replaced.
    if found.is_none() || found == watch.seen {
        return;
    }
    watch.seen = found;
    match settings.load() {
        Ok(rig) if rig.passthrough != watch.live.rig.passthrough => {
            log::once("the rig file has changed its `passthrough`, which needs a new start; it stays as it was");
        }
        Ok(rig) if rig == *watch.live.rig => {}
        Ok(mut rig) => {
            if rig.views.duplicate != watch.live.rig.views.duplicate {
                log::once(
                    "the rig file has changed its `views.duplicate`, which needs a new start; it stays as it was",
                );
                rig.views.duplicate = watch.live.rig.views.duplicate;
            }
            watch.live = Live { rig: Arc::new(rig), version: watch.live.version + 1 };
            VERSION.store(watch.live.version, Ordering::Release);
            log::once(&format!("the rig's file has changed, and windows follow it ({})", watch.live.version));
        }
        Err(error) => log::once(&format!("the rig stays as it was: {error}")),
    }
}
