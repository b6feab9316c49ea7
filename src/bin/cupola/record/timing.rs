//! Times of the pictures of a recording.

use crate::launch::clock::Rate;

/// Places pictures on the frames of the recording by the program's time.
///
/// A program may draw fewer pictures than the recording has frames: it limits its rate, or sleeps.
/// Each picture is shown until the next one comes, as on a display of this rate.
#[derive(Clone, Debug)]
pub struct Timing {
    rate: Rate,
    /// Time of the first picture, nanoseconds.
    first: Option<u64>,
    /// Frame of the last picture, from 1; 0 before the first one.
    last: u64,
}

impl Timing {
    pub fn new(rate: Rate) -> Self {
        Self { rate, first: None, last: 0 }
    }

    /// Frame of the last picture, from 1; 0 before the first one.
    pub fn last(&self) -> u64 {
        self.last
    }

    /// Nanoseconds from frame 1 to the beginning of this frame.
    pub fn begin_of(&self, frame: u64) -> u64 {
        let scaled = u128::from(frame.saturating_sub(1)) * u128::from(self.rate.seconds) * 1_000_000_000;
        u64::try_from(scaled / u128::from(self.rate.frames.max(1))).unwrap_or(u64::MAX)
    }

    /// Frame that first shows the next picture, which the program presented at this time: the
    /// nearest one, but a later one than that of the picture before.
    pub fn frame(&mut self, time: u64) -> u64 {
        let passed = u128::from(time.saturating_sub(*self.first.get_or_insert(time)));
        let length = u128::from(self.rate.seconds) * 1_000_000_000;
        let nearest = (passed * u128::from(self.rate.frames) + length / 2) / length.max(1);
        self.last = u64::try_from(nearest).unwrap_or(u64::MAX).saturating_add(1).max(self.last + 1);
        self.last
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Frames that show pictures of these times, milliseconds.
    fn frames(times: &[u64]) -> Vec<u64> {
        let mut timing = Timing::new(Rate { frames: 50, seconds: 1 });
        times.iter().map(|time| timing.frame(5_000_000_000 + 1_000_000 * time)).collect()
    }

    #[test]
    fn pictures_are_shown_at_their_times() {
        assert_eq!(frames(&[0, 20, 40, 60]), [1, 2, 3, 4]);
        // The first picture came a bit after a frame's beginning.
        assert_eq!(frames(&[9, 20, 40, 60]), [1, 2, 3, 4]);
        // 25 pictures in a second, and 40.
        assert_eq!(frames(&[0, 40, 80, 120]), [1, 3, 5, 7]);
        assert_eq!(frames(&[0, 25, 50, 75, 100]), [1, 2, 4, 5, 6]);
        assert_eq!(frames(&[0, 0, 0]), [1, 2, 3]);
        let television = Timing::new(Rate { frames: 60_000, seconds: 1001 });
        assert_eq!((television.begin_of(1), television.begin_of(60_001)), (0, 1_001_000_000_000));
    }
}
