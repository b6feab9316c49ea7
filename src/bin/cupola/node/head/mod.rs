//! Decisions of node 0: release of frames, and nodes that are late, gone or different.
//!
//! This is a state machine: its input are arrivals and the time, its output are messages to send
//! and to show.

use super::input::{Event, Line, Queue};
use super::link::Message;
use super::sums::Sums;
use cupola::nodes::{Arrival, FIRST_FRAMES};
use std::time::Duration;

/// Longest wait for each of the first frames, shorter than that of the programs.
const START: Duration = Duration::from_secs(55);

/// Time without a frame after which programs count as idle: they draw only when something happens.
/// Keyboard and mouse then reach them without waiting for the end of a frame. A slow program is
/// drawing then, and has read its events long before.
const IDLE: Duration = Duration::from_millis(100);

/// An action that follows from a decision.
#[derive(Clone, Debug, PartialEq)]
pub enum Action {
    /// This event reaches the programs of all nodes at the end of this frame, which is released
    /// next, or at once, if it is released and the programs are idle.
    Input { frame: u64, event: Event },
    /// All nodes may show frames up to this number. `time` is the program's time after it; 0 leaves
    /// it open.
    Release { frame: u64, time: u64 },
    /// A message for the user.
    Say(String),
}

impl Action {
    /// What is to be sent to the other nodes.
    pub fn message(&self) -> Option<Message> {
        match *self {
            Self::Input { frame, event } => Some(Message::Input { frame, event }),
            Self::Release { frame, time } => Some(Message::Release { frame, time }),
            Self::Say(_) => None,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    InStep,
    /// The others have gone on without this node.
    Late,
    /// The node's program has ended, or its connection is lost.
    Gone,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    arrived: Arrival,
    state: State,
    /// True if the user knows that this node is late.
    told: bool,
}

/// Start of the programs' time in real time.
#[derive(Clone, Copy, Debug)]
struct Start {
    /// Time of the machine.
    real: u64,
    /// Time of the program at that moment.
    program: u64,
}

/// State of node 0. Times are nanoseconds of its monotonic clock.
pub struct Head {
    nodes: Vec<Node>,
    released: u64,
    /// Time at which the first node arrived at the frame that is not released yet.
    first_came: Option<u64>,
    patience: Duration,
    /// Length of a frame, if the programs' time follows real time.
    length: Option<u64>,
    start: Option<Start>,
    /// Time from which a frame may be shown at which all nodes have arrived.
    early: Option<u64>,
    sums: Sums,
    input: Queue,
    /// Time of the last release, or of the last events for idle programs.
    acted: u64,
}

impl Head {
    /// Starts with `count` nodes. The others wait for a late node no longer than `patience`.
    /// `length`: length of a frame, if frames are released in real time; `None`: frames are
    /// released as soon as all nodes have arrived.
    pub fn new(count: usize, patience: Duration, length: Option<Duration>) -> Self {
        let node = Node { arrived: Arrival::default(), state: State::InStep, told: false };
        let length = length.map(|length| nanoseconds(length).max(1));
        Self {
            nodes: vec![node; count],
            released: 0,
            first_came: None,
            patience,
            length,
            start: None,
            early: None,
            sums: Sums::default(),
            input: Queue::default(),
            acted: 0,
        }
    }

    /// Handles the arrival of a node's program at the end of a frame.
    pub fn arrived(&mut self, number: usize, arrival: Arrival, now: u64) -> Vec<Action> {
        let mut actions = Vec::new();
        let Some(node) = self.nodes.get_mut(number).filter(|node| node.arrived.frame < arrival.frame) else {
            return actions;
        };
        if node.state == State::Gone {
            // The connection to this node is lost for good.
            return actions;
        }
        node.arrived = arrival;
        if arrival.frame == 1 {
            actions.extend(self.other_sizes(number).map(Action::Say));
        }
        actions.extend(self.sums.add(number, &arrival).map(Action::Say));
        self.look(now, &mut actions);
        actions
    }

    /// Messages for windows of another size than that of node 0, when node `arrived` has drawn its
    /// first frame: its own, or, if it is node 0, those of the nodes that were here before.
    fn other_sizes(&self, arrived: usize) -> impl Iterator<Item = String> {
        let first = &self.nodes[0].arrived;
        let is_new = move |number: usize| number == arrived || arrived == 0;
        let is_unlike = move |node: &Node| first.frame > 0 && node.arrived.frame > 0 && node.arrived.size != first.size;
        let nodes = self.nodes.iter().enumerate().filter(move |(number, node)| is_new(*number) && is_unlike(node));
        nodes.map(|(number, node)| {
            format!(
                "the window of node {number} has {}x{} pixels, that of node 0 {}x{}: programs draw differently in \
                 windows of different sizes (--size sets the size)",
                node.arrived.size.0, node.arrived.size.1, first.size.0, first.size.1
            )
        })
    }

    /// True if no line should be added before some have reached the programs.
    pub fn is_input_full(&self) -> bool {
        self.input.is_full()
    }

    /// Adds a line of keyboard or mouse.
    pub fn add_input(&mut self, line: Line) {
        self.input.add(line);
    }

    /// Handles the end of a node's program, or of the connection to it.
    pub fn gone(&mut self, number: usize, now: u64) -> Vec<Action> {
        let mut actions = Vec::new();
        if let Some(node) = self.nodes.get_mut(number).filter(|node| node.state != State::Gone) {
            node.state = State::Gone;
            self.look(now, &mut actions);
        }
        actions
    }

    /// Handles the passage of time.
    pub fn tick(&mut self, now: u64) -> Vec<Action> {
        let mut actions = Vec::new();
        self.look(now, &mut actions);
        if self.are_idle(now) {
            let (frame, events) = (self.released, self.input.take(self.released));
            if !events.is_empty() {
                self.acted = now;
            }
            actions.extend(events.into_iter().map(|event| Action::Input { frame, event }));
        }
        actions
    }

    /// True if all programs have waited for something to happen for a while.
    fn are_idle(&self, now: u64) -> bool {
        let mut here = self.nodes.iter().filter(|node| node.state != State::Gone);
        let is_idle = |node: &Node| node.state == State::InStep && node.arrived.frame == self.released;
        self.released > 0 && now.saturating_sub(self.acted) > nanoseconds(IDLE) && here.all(is_idle)
    }

    /// Number of nodes that are not gone.
    pub fn left(&self) -> usize {
        self.nodes.iter().filter(|node| node.state != State::Gone).count()
    }

    /// Time at which [`Head::tick`] has something to do, unless another node arrives before.
    pub fn due(&self) -> Option<u64> {
        let patience = self.patience();
        self.early.or(self.first_came.map(|came| came.saturating_add(nanoseconds(patience))))
    }

    /// Summary at the end; `times`: includes the differences in time.
    pub fn summary(&self, times: bool) -> String {
        format!("{} frames on {} nodes{}", self.released, self.nodes.len(), self.sums.summary(times))
    }

    /// The summary as JSON.
    pub fn json(&self, times: bool) -> serde_json::Value {
        let mut json = serde_json::json!({
            "frames": self.released,
            "nodes": self.nodes.len(),
            "different": self.sums.different(),
        });
        if times {
            json["frames_by_microseconds_apart_up_to"] = serde_json::json!(self.sums.histogram());
        }
        json
    }

    /// True if a node is not gone.
    pub fn is_there(&self, number: usize) -> bool {
        self.nodes.get(number).is_some_and(|node| node.state != State::Gone)
    }

    /// Longest wait for a late node at the next frame.
    fn patience(&self) -> Duration {
        if self.released < FIRST_FRAMES { START.max(self.patience) } else { self.patience }
    }

    /// Releases the frame at which the nodes have arrived, if it is time.
    fn look(&mut self, now: u64, actions: &mut Vec<Action>) {
        let here = self.nodes.iter().filter(|node| node.state != State::Gone);
        let Some(newest) = here.map(|node| node.arrived.frame).max().filter(|newest| *newest > self.released) else {
            return;
        };
        if newest > self.released + 1 {
            // A program that went on by itself is ahead: it has shown the frames before.
            self.released = newest - 1;
            self.first_came = None;
            actions.push(Action::Release { frame: self.released, time: 0 });
        }
        let came = *self.first_came.get_or_insert(now);
        let patience = self.patience();
        let is_over = now.saturating_sub(came) >= nanoseconds(patience);
        for (number, node) in self.nodes.iter_mut().enumerate() {
            let is_there = node.arrived.frame == newest;
            match node.state {
                State::Late if is_there => {
                    node.state = State::InStep;
                    if !std::mem::replace(&mut node.told, true) {
                        actions.push(Action::Say(format!("node {number} is in step again at frame {newest}")));
                    }
                }
                State::InStep if is_over && !is_there => {
                    node.state = State::Late;
                    if !node.told {
                        actions.push(Action::Say(format!(
                            "node {number} has not reached frame {newest} in time: the others go on without it, and it \
                             leaves out frames until it is there again"
                        )));
                    }
                }
                _ => {}
            }
        }
        let is_waited_for = |node: &Node| node.state == State::InStep && node.arrived.frame < newest;
        if self.nodes.iter().any(is_waited_for) {
            return;
        }
        if let Some(time) = self.time(newest, now) {
            self.released = newest;
            self.acted = now;
            self.first_came = None;
            let in_step = |node: &Node| node.state == State::InStep;
            let members: Vec<usize> = (0..self.nodes.len()).filter(|number| in_step(&self.nodes[*number])).collect();
            actions.extend(self.sums.settle(newest, &members).map(Action::Say));
            actions.extend(self.input.take(newest).into_iter().map(|event| Action::Input { frame: newest, event }));
            actions.push(Action::Release { frame: newest, time });
        }
    }

    /// Time of the program after a frame at which all have arrived; `None` if it is too early.
    fn time(&mut self, frame: u64, now: u64) -> Option<u64> {
        let Some(length) = self.length else { return Some(0) };
        let there = self.nodes.iter().filter(|node| node.state != State::Gone && node.arrived.frame == frame);
        let program = there.map(|node| node.arrived.time).max().unwrap_or(0);
        if frame < FIRST_FRAMES {
            // While a program loads at its start, its time stands still.
            return Some(program);
        }
        let start = *self.start.get_or_insert(Start { real: now, program });
        let real = now.saturating_sub(start.real);
        let due = start.real.saturating_add(program.saturating_sub(start.program));
        self.early = (now < due).then_some(due);
        if now < due {
            return None;
        }
        // Frames that were drawn too slowly are skipped: the time advances by whole frames.
        Some(program.max(start.program + real / length * length))
    }
}

/// Converts a length to nanoseconds.
fn nanoseconds(length: Duration) -> u64 {
    u64::try_from(length.as_nanos()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests;
