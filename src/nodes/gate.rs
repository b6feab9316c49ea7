//! The side of the program: its wait at the end of each frame.

use super::page::{Arrival, Page};
use crate::system::monotonic;
use std::time::Duration;

/// The longest wait at each of the first frames: programs load, and drivers compile, for different
/// times.
const START: Duration = Duration::from_secs(60);
/// So many are the first frames.
pub const FIRST_FRAMES: u64 = 10;
/// So often a waiting program looks whether its command still lives.
const LOOK: Duration = Duration::from_millis(20);

/// Where a program waits at the end of each of its frames.
pub struct Gate {
    page: Page,
    frame: u64,
    went: u64,
    state: State,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// With the others.
    InStep,
    /// On its own, since so many frames were let go.
    Alone { released: u64 },
    /// Its command has ended.
    Left,
}

/// What has changed for the program at a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Said {
    /// No word has come in the time: the program goes on without the others.
    Alone,
    /// The others are there again.
    InStep,
    /// The command beside the program has ended.
    Left,
}

/// How a program has passed the end of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Passed {
    /// Number of the frame, from 1.
    pub frame: u64,
    /// The program's time from here on, where the command says one.
    pub time: Option<u64>,
    /// The others are ahead: the frame is not to be shown.
    pub is_late: bool,
    /// What has changed.
    pub said: Option<Said>,
}

impl Gate {
    /// The gate of a page.
    pub fn new(page: Page) -> Self {
        Self { page, frame: 0, went: 0, state: State::InStep }
    }

    /// Waits until the frame that ends here may be shown. `digest`, `time`, `size`: as in
    /// [`Arrival`].
    pub fn pass(&mut self, digest: u64, time: u64, size: (u32, u32)) -> Passed {
        self.frame += 1;
        let frame = self.frame;
        self.page.arrive(&Arrival { frame, digest, time, went: self.went, size });
        let before = self.state;
        if let State::Alone { released } = before
            && self.page.released() != released
        {
            self.state = State::InStep;
        }
        match self.state {
            State::InStep => self.wait(),
            State::Alone { .. } | State::Left => self.keep_pace(),
        }
        self.went = monotonic();
        let said = match (before, self.state) {
            (State::InStep, State::Alone { .. }) => Some(Said::Alone),
            (State::Alone { .. }, State::InStep) => Some(Said::InStep),
            (State::InStep | State::Alone { .. }, State::Left) => Some(Said::Left),
            _ => None,
        };
        Passed { frame, time: self.page.time_after(frame), is_late: self.page.released() > frame, said }
    }

    /// Waits for the command, and goes on without it after the limit.
    fn wait(&mut self) {
        let limit = if self.frame <= FIRST_FRAMES { START.max(self.page.limit()) } else { self.page.limit() };
        let begin = monotonic();
        loop {
            let released = self.page.released();
            if released >= self.frame {
                return;
            }
            let waited = Duration::from_nanos(monotonic().saturating_sub(begin));
            let left = limit.saturating_sub(waited);
            if left.is_zero() {
                self.state = State::Alone { released };
                return;
            }
            if waited >= LOOK && !self.page.has_command() {
                self.state = State::Left;
                return;
            }
            self.page.wait_for_more(released, left.min(LOOK));
        }
    }

    /// Waits for as long as a frame is shown: alone, a program keeps the rate that all had.
    fn keep_pace(&mut self) {
        let since = Duration::from_nanos(monotonic().saturating_sub(self.went));
        std::thread::sleep(self.page.length().saturating_sub(since));
        if self.state != State::Left && !self.page.has_command() {
            self.state = State::Left;
        }
    }
}
