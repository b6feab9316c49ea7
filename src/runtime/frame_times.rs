//! Times of frames, for the statistics.

use crate::system::thread_time;
use serde::Serialize;
use std::time::{Duration, Instant};

/// Number of the last values that are stored for the median.
const KEPT: usize = 1024;

/// Statistics of frames, in milliseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Milliseconds {
    /// Number of frames that were measured.
    pub frames: u64,
    /// Mean of all of them.
    pub mean: f64,
    /// Median of the last 1024.
    pub median: f64,
    /// Percentile: 95 % of the last 1024 frames took no longer.
    pub percentile_95: f64,
}

/// Durations that were measured. Adding one allocates nothing.
#[derive(Clone, Debug)]
pub struct Durations {
    count: u64,
    sum: f64,
    last: Vec<f32>,
}

impl Default for Durations {
    fn default() -> Self {
        Self { count: 0, sum: 0.0, last: Vec::with_capacity(KEPT) }
    }
}

impl Durations {
    /// Adds one.
    pub fn add(&mut self, duration: Duration) {
        let milliseconds = duration.as_secs_f64() * 1e3;
        let place = (self.count % KEPT as u64) as usize;
        match self.last.get_mut(place) {
            Some(old) => *old = milliseconds as f32,
            None => self.last.push(milliseconds as f32),
        }
        self.count += 1;
        self.sum += milliseconds;
    }

    /// Returns the mean and the percentiles; `None` if nothing was measured.
    pub fn summary(&self) -> Option<Milliseconds> {
        let mut last = self.last.clone();
        let mut at = |part: f64| {
            let place = (part * (last.len() as f64 - 1.0)).round() as usize;
            (!last.is_empty()).then(|| f64::from(*last.select_nth_unstable_by(place, f32::total_cmp).1))
        };
        let (median, percentile_95) = (at(0.5)?, at(0.95)?);
        Some(Milliseconds { frames: self.count, mean: self.sum / self.count as f64, median, percentile_95 })
    }
}

/// Times of a window's frames.
#[derive(Debug, Default)]
pub struct FrameTimes {
    /// End of the last frame, and the processor time of its thread at that moment.
    last: Option<(Instant, Duration)>,
    /// Time from one frame to the next.
    pub frame: Durations,
    /// Processor time of the thread in a frame, program and driver included.
    pub processor: Durations,
    /// Processor time of the thread that records the correction.
    pub correction: Durations,
    /// Time of the device from the beginning of a frame to the correction.
    pub device_drawing: Durations,
    /// Time of the device for the correction.
    pub device_correction: Durations,
}

impl FrameTimes {
    /// Counts the end of a frame.
    pub fn end_frame(&mut self) {
        let now = (Instant::now(), thread_time());
        if let Some((instant, processor)) = self.last.replace(now) {
            self.frame.add(now.0 - instant);
            // Another thread may present the next frame.
            if let Some(time) = now.1.checked_sub(processor) {
                self.processor.add(time);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Durations, FrameTimes, KEPT};
    use std::time::Duration;

    #[test]
    fn the_summary_is_that_of_the_numbers() {
        let mut durations = Durations::default();
        assert_eq!(durations.summary(), None);
        (1..=101).rev().for_each(|n| durations.add(Duration::from_millis(n)));
        let summary = durations.summary().expect("101 numbers");
        assert_eq!((summary.frames, summary.mean, summary.median, summary.percentile_95), (101, 51.0, 51.0, 96.0));
    }

    #[test]
    fn the_median_is_that_of_the_last_ones() {
        let mut durations = Durations::default();
        (0..KEPT).for_each(|_| durations.add(Duration::from_millis(1000)));
        (0..KEPT).for_each(|_| durations.add(Duration::from_millis(2)));
        let summary = durations.summary().expect("numbers");
        assert_eq!((summary.frames, summary.mean, summary.median), (2 * KEPT as u64, 501.0, 2.0));
    }

    #[test]
    fn a_frame_that_sleeps_costs_no_processor_time() {
        let mut times = FrameTimes::default();
        times.end_frame();
        assert_eq!(times.frame.summary(), None, "it takes two ends to make a frame");
        std::thread::sleep(Duration::from_millis(30));
        times.end_frame();
        let (frame, processor) = (times.frame.summary().expect("one"), times.processor.summary().expect("one"));
        assert!(frame.mean >= 30.0 && processor.mean < frame.mean / 2.0, "{frame:?} {processor:?}");
    }
}
