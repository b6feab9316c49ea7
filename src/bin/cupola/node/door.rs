//! Release of a node's program, after it has received the events of keyboard and mouse.
//!
//! Events belong to the end of a frame, where the program waits. A program that is late is stopped
//! there, too, and receives them in the same frame as all others.

use super::input::Event;
use super::input::screen::Screen;
use cupola::lock::Lock;
use cupola::nodes::{Arrival, Page};
use std::collections::VecDeque;
use std::path::Path;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, Once, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Interval at which the end of the program is checked.
const LOOK: Duration = Duration::from_millis(10);
/// Longest wait for an X server when the program has ended.
const LAST: Duration = Duration::from_secs(1);

#[derive(Default)]
struct Held {
    /// Number of the newest frame that all may show.
    newest: u64,
    /// Events with the frames at whose end they reach the program.
    events: VecDeque<(u64, Event)>,
    /// Frame whose events are being sent to the program.
    busy: Option<u64>,
    has_ended: bool,
}

impl Held {
    /// Number of the first frame that the program may not pass yet.
    fn held_at(&self) -> Option<u64> {
        self.busy.or(self.events.front().map(|(frame, _)| *frame))
    }
}

/// Page of a program, and the events that it receives before it is released.
pub struct Door {
    page: Page,
    /// Number of this node.
    node: u32,
    held: Mutex<Held>,
    changed: Condvar,
    once: Once,
    thread: Mutex<Option<JoinHandle<()>>>,
    say: fn(&str),
}

impl Door {
    /// Makes the door of a node's program.
    pub fn new(page: Page, node: u32, say: fn(&str)) -> Arc<Self> {
        let (held, changed) = (Mutex::default(), Condvar::new());
        Arc::new(Self { page, node, held, changed, once: Once::new(), thread: Mutex::default(), say })
    }

    fn held(&self) -> MutexGuard<'_, Held> {
        self.held.locked()
    }

    /// Longest wait of the program.
    pub fn limit(&self) -> Duration {
        self.page.limit()
    }

    /// Sets the length of a frame: [`Page::set_length`].
    pub fn set_length(&self, length: Duration) {
        self.page.set_length(length);
    }

    /// Newest arrival of the program: [`Page::arrival`].
    pub fn arrival(&self, known: u64, limit: Duration) -> Option<Arrival> {
        self.page.arrival(known, limit)
    }

    /// Releases the program for good: [`Page::leave`].
    pub fn leave(&self) {
        self.page.leave();
    }

    /// Lets all show frames up to this number; `time` is the program's time after the last of them.
    pub fn open(&self, frame: u64, time: u64) {
        let mut held = self.held();
        held.newest = held.newest.max(frame);
        self.page.announce(frame, time);
        self.release(&held);
        if held.held_at().is_some() {
            self.changed.notify_all();
        }
    }

    /// Releases the program as far as its events allow.
    fn release(&self, held: &Held) {
        self.page.release(held.held_at().map_or(held.newest, |frame| held.newest.min(frame.saturating_sub(1))));
    }

    /// Adds an event that reaches the program at the end of this frame. The events of a frame are
    /// added before the frame is opened.
    pub fn add(self: &Arc<Self>, frame: u64, event: Event) {
        self.expect_events();
        self.held().events.push_back((frame, event));
        self.changed.notify_all();
    }

    /// Starts the thread that sends events, once.
    pub fn expect_events(self: &Arc<Self>) {
        self.once.call_once(|| {
            let door = Arc::clone(self);
            let thread = std::thread::spawn(move || door.give_events());
            *self.thread.locked() = Some(thread);
        });
    }

    /// Handles the end of the program.
    pub fn close(&self) {
        self.held().has_ended = true;
        self.changed.notify_all();
        let thread = self.thread.locked().take();
        let begin = Instant::now();
        // The thread restores the keyboard's repetition, unless the X server hangs.
        while thread.as_ref().is_some_and(|thread| !thread.is_finished()) && begin.elapsed() < LAST {
            std::thread::sleep(LOOK);
        }
    }

    /// False while the program ends; events that it does not receive then are not reported.
    fn is_running(&self) -> bool {
        !self.held().has_ended && Path::new(&format!("/proc/{}", self.page.process())).exists()
    }

    fn say(&self, words: &str) {
        (self.say)(&format!("node {}: {words}", self.node));
    }

    /// Waits until the program has reached the end of a frame. `false`: it has ended.
    fn wait_for(&self, frame: u64) -> bool {
        while self.page.arrived() < frame && !self.held().has_ended {
            self.page.arrival(self.page.arrived(), LOOK);
        }
        !self.held().has_ended
    }

    /// Sends events to the program as long as it runs.
    fn give_events(&self) {
        if !self.wait_for(1) {
            return;
        }
        let mut screen = Screen::open(self.page.process());
        if let Err(message) = &screen {
            self.say(&format!("keyboard and mouse do not reach the program: {message}"));
        }
        let mut has_missed = false;
        let mut told = Vec::new();
        while let Some(frame) = self.next_frame() {
            if !self.wait_for(frame) {
                return;
            }
            let late = self.page.arrived() - frame;
            let events = self.events_of(frame);
            // An idle program may draw its next frame at this moment.
            if late > 1 && !std::mem::replace(&mut has_missed, true) {
                self.say(&format!(
                    "the program was on its own, and gets what keyboard and mouse had for it after frame {frame} {late} \
                     frames later than the others"
                ));
            }
            match screen.as_mut().map(|screen| screen.give(&events)) {
                Ok(Ok(words)) => {
                    let new = |words: &String| !told.contains(words) && self.is_running();
                    let new: Vec<String> = words.into_iter().filter(new).collect();
                    new.iter().for_each(|words| self.say(words));
                    told.extend(new);
                }
                Ok(Err(message)) => {
                    if self.is_running() {
                        self.say(&format!("keyboard and mouse do not reach the program any more: {message}"));
                    }
                    screen = Err(message);
                }
                Err(_) => {}
            }
            let mut held = self.held();
            held.busy = None;
            self.release(&held);
        }
    }

    /// Waits for the next frame that has events. `None`: the program has ended.
    fn next_frame(&self) -> Option<u64> {
        let mut held = self.held();
        loop {
            if held.has_ended {
                return None;
            }
            match held.events.front().map(|(frame, _)| *frame) {
                // All events of a frame were added before it was opened.
                Some(frame) if frame <= held.newest => {
                    held.busy = Some(frame);
                    return Some(frame);
                }
                _ => held = self.changed.wait(held).unwrap_or_else(PoisonError::into_inner),
            }
        }
    }

    fn events_of(&self, frame: u64) -> Vec<Event> {
        let mut held = self.held();
        let count = held.events.iter().take_while(|(of, _)| *of <= frame).count();
        held.events.drain(..count).map(|(_, event)| event).collect()
    }
}
