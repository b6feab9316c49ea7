//! The program's side: its wait at the end of each frame.

use super::page::{Arrival, Page};
use crate::system::monotonic;
use std::time::Duration;

/// Longest wait at each of the first frames: nodes need different times to load and to compile
/// shaders.
const START: Duration = Duration::from_secs(60);
/// Number of frames with that longer wait.
pub const FIRST_FRAMES: u64 = 10;
/// Interval at which a waiting program checks whether its command is still alive.
const LOOK: Duration = Duration::from_millis(20);

/// Point at which a program waits at the end of each of its frames.
pub struct Gate {
    page: Page,
    frame: u64,
    went: u64,
    state: State,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// The program waits for the others.
    InStep,
    /// The program goes on by itself, since this newest frame was released.
    Alone { released: u64 },
    /// The command of the program has ended.
    Left,
}

/// Change of the program's state at a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Said {
    /// The command has not answered in time: the program goes on without the others.
    Alone,
    /// The command answers again.
    InStep,
    /// The command beside the program has ended.
    Left,
}

/// Result of passing the end of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Passed {
    /// Number of the frame, from 1.
    pub frame: u64,
    /// Time of the program from here on, if the command has set one.
    pub time: Option<u64>,
    /// True if the others are ahead: the frame is not to be shown.
    pub is_late: bool,
    /// Change of state, if there was one.
    pub said: Option<Said>,
}

impl Gate {
    /// The gate of a page.
    pub fn new(page: Page) -> Self {
        page.take();
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
        Passed { frame, time: self.page.time_after(frame), is_late: self.page.newest() > frame, said }
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

    /// Waits for as long as a frame is shown: without the others, a program keeps their rate.
    fn keep_pace(&mut self) {
        let since = Duration::from_nanos(monotonic().saturating_sub(self.went));
        std::thread::sleep(self.page.length().saturating_sub(since));
        if self.state != State::Left && !self.page.has_command() {
            self.state = State::Left;
        }
    }
}
