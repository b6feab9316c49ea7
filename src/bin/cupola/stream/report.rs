//! Numbers of sent and lost frames, and delays.

use cupola::ring::Frame;
use cupola::system;
use serde_json::{Value, json};
use std::fmt;

/// Greatest number of frames whose times are stored; those of later frames are not.
const KEPT: usize = 1 << 20;

/// Numbers of a stream.
#[derive(Default)]
pub struct Report {
    /// Number of frames that the receiver has received.
    pub sent: u64,
    /// Number of frames that were lost because it was too slow: before this command had read them.
    lost_before: u64,
    /// The same, afterwards.
    lost_here: u64,
    /// Number of frames for which there was no receiver.
    unseen: u64,
    /// Number of frames that were skipped to keep the rate.
    left_out: u64,
    read: u64,
    /// Number of the program's frames that were not published.
    missing: u64,
    index: u64,
    /// Delays from the program's swap until the receiver had received the picture, microseconds.
    delays: Vec<u32>,
    /// True if the first loss was reported.
    is_told: bool,
}

impl Report {
    /// Counts a frame that was read; `lost` frames were lost so far.
    pub fn read(&mut self, frame: &Frame, lost: u64) {
        if self.index > 0 {
            self.missing += frame.index.saturating_sub(self.index + 1);
        }
        (self.index, self.read) = (frame.index, self.read + 1);
        self.left_out = self.read - self.sent - self.lost_here - self.unseen - 1;
        self.lost_before(lost);
    }

    /// Notes how many frames were lost because the receiver kept this command from reading them.
    pub fn lost_before(&mut self, lost: u64) {
        self.lost_before = lost;
        if self.lost() > 0 && !std::mem::replace(&mut self.is_told, true) {
            eprintln!("cupola: the receiver is slower than the program: it loses frames");
        }
    }

    /// Counts a frame that was read, but for which the receiver is too slow.
    pub fn lost_here(&mut self) {
        self.lost_here += 1;
        self.lost_before(self.lost_before);
    }

    /// Counts a frame for which there is no receiver.
    pub fn unseen(&mut self) {
        self.unseen += 1;
        if self.unseen == 1 {
            eprintln!("cupola: no receiver takes the pictures yet");
        }
    }

    /// Number of frames that were lost because the receiver was too slow.
    fn lost(&self) -> u64 {
        self.lost_before + self.lost_here
    }

    /// Counts a frame that was received. `time`: of its swap; a virtual clock gives no delays.
    pub fn sent(&mut self, time: u64) {
        self.sent += 1;
        let delay = system::monotonic().checked_sub(time).and_then(|delay| u32::try_from(delay / 1000).ok());
        if let Some(delay) = delay.filter(|delay| *delay < 60_000_000 && self.delays.len() < KEPT) {
            self.delays.push(delay);
        }
    }

    /// Median and 99th percentile of the delays, microseconds.
    fn delays(&self) -> Option<(u32, u32)> {
        let mut sorted = self.delays.clone();
        sorted.sort_unstable();
        let at = |part: usize| sorted.get(sorted.len() * part / 100).copied();
        Some((at(50)?, at(99)?))
    }

    /// The numbers as JSON.
    pub fn json(&self) -> Value {
        let mut json = json!({
            "sent": self.sent,
            "lost": self.lost(),
            "left_out": self.left_out,
            "not_published": self.missing.saturating_sub(self.lost_before),
        });
        if self.unseen > 0 {
            json["without_receiver"] = self.unseen.into();
        }
        if let Some((median, most)) = self.delays() {
            json["microseconds_from_swap"] = json!({ "median": median, "99_of_100": most });
        }
        json
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} frames sent, {} lost", self.sent, self.lost())?;
        if self.unseen > 0 {
            write!(f, ", {} without a receiver", self.unseen)?;
        }
        if self.left_out > 0 {
            write!(f, ", {} left out to keep the rate", self.left_out)?;
        }
        Ok(())
    }
}
