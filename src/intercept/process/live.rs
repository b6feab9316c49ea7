//! The rig while the program runs. It is read again when its file changes.
//!
//! The file's time and length are queried up to a hundred times a second, between two frames. On a
//! slow file system they are queried less often, so that the queries take at most a hundredth of
//! the time. Frames without a query only read the clock. If the file has a mistake, nothing
//! changes, and the log reports the mistake once.

use super::file_stamp::{FileStamp, text_sum_of};
use super::log;
use super::settings::Settings;
use crate::intercept::process::settings;
use crate::lock::Lock;
use crate::rig::Rig;
use std::collections::VecDeque;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, OnceLock};
use std::time::{Duration, Instant};

/// Least interval at which the file is checked.
const INTERVAL: Duration = Duration::from_millis(10);
/// Least ratio of the pause after a check of the file to the time of the check.
const PAUSE: u32 = 100;

/// Time after the last change of a rig that somebody is editing, after which it is planned. That
/// takes up to a second, in which further changes would have to wait.
pub const REST: Duration = Duration::from_millis(1500);

/// Number of versions whose checksums are known: a window shows one of the last ones.
const SUMS: usize = 32;

/// The current rig.
#[derive(Clone)]
pub struct Live {
    /// The rig.
    pub rig: Arc<Rig>,
    /// Grows with every change.
    pub version: u64,
}

struct Watch {
    live: Live,
    /// Checksums of the texts of the last versions, newest first, with their versions.
    sums: VecDeque<(u64, u64)>,
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
        let sums = VecDeque::from([(0, settings.rig_sum)]);
        Mutex::new(Watch { live, sums, looked: Instant::now(), pause: INTERVAL, seen: settings.rig_stamp })
    })
}

/// Returns the current rig; `None` if the settings are wrong.
pub fn rig() -> Option<Live> {
    let settings = settings::settings()?;
    Some(watch(settings).locked().live.clone())
}

/// Returns the rig's version at the last check of its file. May be called anywhere, at any time.
pub fn known_version() -> u64 {
    VERSION.load(Ordering::Acquire)
}

/// Returns the checksum of the text of a version of the rig's file, for readers of published
/// frames; 0: not known.
pub fn text_sum(version: u64) -> u64 {
    let Some(settings) = settings::settings() else { return 0 };
    let watch = watch(settings).locked();
    watch.sums.iter().find(|(known, _)| *known == version).map_or(0, |(_, sum)| *sum)
}

/// Returns the rig's version, after a check of its file if the last check is long enough ago.
/// Called at the end of a frame.
pub fn version() -> u64 {
    if let Some((settings, path)) = settings::settings().and_then(|s| Some((s, s.rig_file.as_deref()?))) {
        // A frame does not wait for the check of another window.
        if let Ok(mut watch) = watch(settings).try_lock()
            && watch.looked.elapsed() >= watch.pause
        {
            look(&mut watch, settings, path);
        }
    }
    known_version()
}

impl Watch {
    /// Notes that the present version has a text with this checksum.
    fn note_text(&mut self, sum: u64) {
        self.sums.retain(|(version, _)| *version != self.live.version);
        self.sums.push_front((self.live.version, sum));
        self.sums.truncate(SUMS);
    }
}

fn look(watch: &mut Watch, settings: &Settings, path: &Path) {
    watch.looked = Instant::now();
    let found = FileStamp::of(path);
    watch.pause = INTERVAL.max(watch.looked.elapsed() * PAUSE);
    // A file that is missing for a moment is being replaced.
    if found.is_none() || found == watch.seen {
        return;
    }
    watch.seen = found;
    // The text is read before the rig: a rig never has the checksum of a later text.
    let sum = text_sum_of(path);
    match settings.load() {
        Ok(rig) if rig.passthrough != watch.live.rig.passthrough => {
            log::once("the new `passthrough` of the rig takes effect at the next start of the program");
        }
        Ok(rig) if rig == *watch.live.rig => watch.note_text(sum),
        Ok(mut rig) => {
            if rig.views.duplicate != watch.live.rig.views.duplicate {
                log::once("the new `views.duplicate` of the rig takes effect at the next start of the program");
                rig.views.duplicate = watch.live.rig.views.duplicate;
            }
            watch.live = Live { rig: Arc::new(rig), version: watch.live.version + 1 };
            watch.note_text(sum);
            VERSION.store(watch.live.version, Ordering::Release);
            log::once(&format!("the rig's file has changed, and windows follow it ({})", watch.live.version));
        }
        Err(error) => log::once(&format!("the rig stays as it was: {error}")),
    }
}
