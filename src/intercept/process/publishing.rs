//! Finished pictures of this process for others, in a [`ring`](crate::ring). Both APIs bring their
//! frames here.
//!
//! Only one window is published: the first one. Another window replaces it after a while in which
//! only that other window was presented.

use super::{clock, live, log, settings};
use crate::lock::Lock;
use crate::ring::{Pictures, Shape, Stamp, Writer};
use crate::runtime::run_results::Published;
use std::sync::{Mutex, Once};

/// Number of frames in the ring: a reader that is slower by more than this loses frames.
const SLOTS: usize = 4;

/// Number of frames of other windows, without one of the published window, after which that window
/// counts as gone.
const GONE: u32 = 30;

/// Least time between frames that nobody reads, in nanoseconds: so a later reader finds a recent frame, and they cost
/// little.
const UNREAD: u64 = 100_000_000;

struct Publishing {
    writer: Option<Writer>,
    /// True if nothing is published any more.
    is_over: bool,
    window: Option<u64>,
    /// Frames of other windows since the last frame of the published one.
    of_others: u32,
    left_out: u64,
    /// Time of the first frame that was presented, nanoseconds.
    first: Option<u64>,
    pace: Pace,
}

/// Time of the last published frame. It decides which frame is next, if not all are published.
#[derive(Debug, Default)]
struct Pace {
    /// Time of the last published frame in nanoseconds, and the version of its rig.
    last: Option<(u64, u64)>,
}

impl Pace {
    /// True if a frame of this time is published. `least`: least time between frames, in
    /// nanoseconds. `awaited`: a reader has read all that was published. The first frame with
    /// another `version` of the rig is always published, because somebody waits for it.
    fn takes(&mut self, now: u64, least: u64, version: u64, awaited: bool) -> bool {
        if self.last.is_some_and(|(last, shown)| (now < last + least || !awaited) && shown == version) {
            return false;
        }
        self.last = Some((now, version));
        true
    }
}

static PUBLISHING: Mutex<Publishing> = Mutex::new(Publishing {
    writer: None,
    is_over: false,
    window: None,
    of_others: 0,
    left_out: 0,
    first: None,
    pace: Pace { last: None },
});

/// Returns the numbers of the frame that is presented now. `version`: that of the rig that it
/// shows.
pub fn stamp(index: u64, version: u64) -> Stamp {
    Stamp { index, time: time(), rig: live::text_sum(version) }
}

/// The program's time, or real time without a virtual clock, nanoseconds.
fn time() -> u64 {
    clock::time().unwrap_or_else(crate::system::monotonic)
}

/// True if this frame of a window is published. `version`: that of the rig that the frame shows.
/// Call it once for each frame.
pub fn wants(window: u64, version: u64) -> bool {
    let Some(settings) = settings::settings().filter(|settings| settings.publish.is_some()) else { return false };
    let mut publishing = PUBLISHING.locked();
    if publishing.is_over {
        return false;
    }
    if publishing.window != Some(window) && publishing.window.is_some() && publishing.of_others < GONE {
        publishing.of_others += 1;
        if publishing.of_others < GONE {
            return false;
        }
    }
    (publishing.window, publishing.of_others) = (Some(window), 0);
    if settings.publish_from > 0 {
        let time = time();
        let first = *publishing.first.get_or_insert(time);
        if time > first && time < first + settings.publish_from {
            return false;
        }
    }
    let (now, least) = (crate::system::monotonic(), settings.publish_interval);
    // The last frame before a program's time is held is published, whoever has read the others.
    let is_held = clock::time().is_some();
    let awaited = is_held || publishing.writer.as_ref().is_none_or(Writer::is_awaited);
    if least > 0 {
        return publishing.pace.takes(now, least, version, awaited);
    }
    let all = is_held || settings.publish_waits || publishing.writer.as_ref().is_some_and(Writer::has_readers);
    publishing.pace.takes(now, if all { 0 } else { UNREAD }, version, true)
}

/// True if the program waits for the readers of its frames.
pub fn waits() -> bool {
    settings::settings().is_some_and(|settings| settings.publish_waits)
}

/// True if the published pictures have 16 bits for each colour.
pub fn is_deep() -> bool {
    settings::settings().is_some_and(|settings| settings.publish_deep)
}

/// Publishes a frame with pictures of these names and sizes. `fill` writes the pictures.
pub fn publish(shapes: &[Shape], stamp: Stamp, fill: impl FnOnce(&mut Pictures<'_>)) {
    let mut publishing = PUBLISHING.locked();
    if publishing.is_over {
        return;
    }
    if let Err(error) = publishing.prepare(shapes) {
        log::once(&format!("frames are not published any more: {error}"));
        publishing.end();
    }
    if let Some(writer) = &mut publishing.writer {
        writer.publish(stamp, fill);
    }
}

/// Counts a frame that could not be read back in time.
pub fn left_out() {
    PUBLISHING.locked().left_out += 1;
}

/// Returns the numbers of published frames, for the statistics.
pub fn statistics() -> Option<Published> {
    let publishing = PUBLISHING.locked();
    let writer = publishing.writer.as_ref()?;
    let (readers, lost) = writer.readers();
    Some(Published { frames: writer.published(), readers, lost, left_out: publishing.left_out })
}

/// Ends publishing, because the program ends.
pub fn end() {
    PUBLISHING.locked().end();
}

impl Publishing {
    /// Makes the file fit the pictures.
    fn prepare(&mut self, shapes: &[Shape]) -> crate::Result<()> {
        match &mut self.writer {
            Some(writer) if writer.shapes() == shapes => Ok(()),
            Some(writer) => writer.reshape(shapes),
            None => {
                let Some(settings) = settings::settings() else { return Ok(()) };
                let Some(path) = &settings.publish else { return Ok(()) };
                let writer = Writer::create(path, shapes, SLOTS, settings.publish_waits)?;
                if settings.publish_waits && !writer.wait_for_a_reader() {
                    log::once("nobody reads the published frames; the program continues without waiting for readers");
                }
                self.writer = Some(writer);
                static AT_EXIT: Once = Once::new();
                AT_EXIT.call_once(|| {
                    // SAFETY: registers a function of a library that is never unloaded.
                    unsafe { libc::atexit(at_exit) };
                });
                Ok(())
            }
        }
    }

    fn end(&mut self) {
        self.is_over = true;
        if let Some(writer) = self.writer.take() {
            writer.end();
        }
    }
}

extern "C" fn at_exit() {
    // A panic while the process ends can be reported to nobody.
    let _ = crate::fence::guard(end);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_between_two_published_ones_are_left_out() {
        let mut pace = Pace::default();
        let taken: Vec<u64> = (0..100).map(|frame| frame * 7).filter(|now| pace.takes(*now, 30, 0, true)).collect();
        assert_eq!(taken[..4], [0, 35, 70, 105]);
        // The first frame of a changed rig does not wait, and those after it do.
        let taken: Vec<bool> =
            [(700, 0), (701, 1), (702, 1), (731, 1)].map(|(now, v)| pace.takes(now, 30, v, true)).into();
        assert_eq!(taken, [true, true, false, true]);
        // What nobody has read yet is not replaced, except by a changed rig.
        let taken = [(800, 1, false), (900, 1, false), (901, 2, false), (990, 2, true)];
        assert_eq!(taken.map(|(now, v, awaited)| pace.takes(now, 30, v, awaited)), [false, false, true, true]);
        // A program that is slower than the pace publishes each frame.
        let mut pace = Pace::default();
        assert!((0..10).all(|frame| pace.takes(frame * 40, 30, 0, true)));
    }
}
