//! Decisions of node 0: release of frames, and nodes that are late, gone or different.
//!
//! This is a state machine: its input are arrivals and the time, its output are messages to send
//! and to show.

use super::sums::Sums;
use cupola::nodes::{Arrival, FIRST_FRAMES};
use std::time::Duration;

/// Longest wait for each of the first frames, shorter than that of the programs.
const START: Duration = Duration::from_secs(55);

/// An action that follows from a decision.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Action {
    /// All nodes may show frames up to this number. `time` is the program's time after it; 0 leaves
    /// it open.
    Release { frame: u64, time: u64 },
    /// A message for the user.
    Say(String),
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
        let size = self.nodes[0].arrived.size;
        if arrival.frame == 1 && self.nodes[0].arrived.frame > 0 && arrival.size != size {
            actions.push(Action::Say(format!(
                "the window of node {number} has {}x{} pixels, that of node 0 {}x{}: programs draw differently in \
                 windows of different sizes (--size sets the size)",
                arrival.size.0, arrival.size.1, size.0, size.1
            )));
        }
        actions.extend(self.sums.add(number, &arrival).map(Action::Say));
        self.look(now, &mut actions);
        actions
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
        actions
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
            self.first_came = None;
            let in_step = |node: &Node| node.state == State::InStep;
            let members: Vec<usize> = (0..self.nodes.len()).filter(|number| in_step(&self.nodes[*number])).collect();
            actions.extend(self.sums.settle(newest, &members).map(Action::Say));
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
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    fn head(count: usize) -> Head {
        Head::new(count, Duration::from_millis(50), None)
    }

    fn at(frame: u64) -> Arrival {
        Arrival { frame, digest: frame, time: frame * 16 * MS, went: 0, size: (640, 480) }
    }

    fn released(actions: &[Action]) -> Option<u64> {
        actions.iter().rev().find_map(|action| match action {
            Action::Release { frame, .. } => Some(*frame),
            Action::Say(_) => None,
        })
    }

    fn said(actions: &[Action]) -> String {
        let words = actions.iter().filter_map(|action| match action {
            Action::Say(words) => Some(words.as_str()),
            Action::Release { .. } => None,
        });
        words.collect::<Vec<_>>().join("\n")
    }

    #[test]
    fn a_frame_is_released_when_all_have_come() {
        let mut head = head(3);
        for frame in 1..5 {
            assert_eq!(released(&head.arrived(2, at(frame), 0)), None);
            assert_eq!(released(&head.arrived(0, at(frame), 10)), None);
            assert_eq!(released(&head.tick(49 * MS)), None);
            assert_eq!(head.arrived(1, at(frame), 20), [Action::Release { frame, time: 0 }]);
        }
    }

    #[test]
    fn others_go_on_without_one_that_is_late_and_it_comes_back() {
        let mut head = head(3);
        for frame in 1..20 {
            (0..3).for_each(|node| drop(head.arrived(node, at(frame), 0)));
        }
        head.arrived(0, at(20), 0);
        head.arrived(1, at(20), 5 * MS);
        assert_eq!(released(&head.tick(49 * MS)), None);
        let actions = head.tick(51 * MS);
        assert_eq!(released(&actions), Some(20));
        assert!(said(&actions).contains("node 2 has not reached frame 20"), "{actions:?}");
        for frame in 21..100 {
            head.arrived(0, at(frame), 60 * MS);
            assert_eq!(head.arrived(1, at(frame), 60 * MS), [Action::Release { frame, time: 0 }]);
            // The node draws the frames that it has missed, and no node waits for it.
            assert_eq!(head.arrived(2, at(frame - 1), 60 * MS), []);
        }
        head.arrived(0, at(100), 70 * MS);
        assert!(said(&head.arrived(2, at(100), 71 * MS)).contains("node 2 is in step again at frame 100"));
        // The others wait for it again. No message is repeated.
        assert_eq!(released(&head.tick(90 * MS)), None);
        assert_eq!(released(&head.arrived(1, at(100), 91 * MS)), Some(100));
        head.arrived(0, at(101), 100 * MS);
        head.arrived(1, at(101), 100 * MS);
        assert_eq!(head.tick(160 * MS), [Action::Release { frame: 101, time: 0 }]);
    }

    #[test]
    fn a_node_that_is_gone_is_not_waited_for() {
        let mut head = head(3);
        (0..2).for_each(|node| drop(head.arrived(node, at(1), 0)));
        assert_eq!(released(&head.gone(2, MS)), Some(1));
        assert_eq!((head.left(), released(&head.gone(2, MS))), (2, None));
        head.arrived(1, at(2), 0);
        assert_eq!(released(&head.gone(0, MS)), Some(2));
        assert_eq!(released(&head.arrived(1, at(3), 0)), Some(3));
    }

    /// Node 0 was stopped, and the others went on by themselves.
    #[test]
    fn all_meet_at_the_frame_of_the_one_that_is_ahead() {
        let mut head = head(3);
        (0..3).for_each(|node| drop(head.arrived(node, at(1), 0)));
        assert_eq!(released(&head.arrived(1, at(120), 0)), Some(119));
        assert_eq!(released(&head.arrived(2, at(117), 0)), None);
        assert_eq!(released(&head.arrived(2, at(120), 0)), None);
        assert_eq!(released(&head.arrived(0, at(120), 0)), Some(120));
    }

    #[test]
    fn frames_follow_the_real_time() {
        let mut head = Head::new(1, Duration::from_millis(50), Some(Duration::from_millis(16)));
        // The first frames take no time, and none is skipped.
        for frame in 1..10 {
            let time = frame * 16 * MS;
            assert_eq!(head.arrived(0, at(frame), frame * 7000 * MS), [Action::Release { frame, time }]);
        }
        let start = 90_000 * MS;
        assert_eq!(head.arrived(0, at(10), start), [Action::Release { frame: 10, time: 160 * MS }]);
        assert_eq!(head.arrived(0, at(11), start + MS), []);
        assert_eq!(head.tick(start + 15 * MS), []);
        assert_eq!(head.tick(start + 16 * MS), [Action::Release { frame: 11, time: 176 * MS }]);
        // The frame is too slow by two and a half frames.
        assert_eq!(head.arrived(0, at(12), start + 72 * MS), [Action::Release { frame: 12, time: 224 * MS }]);
    }

    #[test]
    fn the_one_that_draws_something_else_is_named() {
        let mut head = head(3);
        for frame in 1..30 {
            let other = |node: usize| u64::from(node == 1 && (4..8).contains(&frame));
            let actions: Vec<Action> = (0..3)
                .flat_map(|node| head.arrived(node, Arrival { digest: frame + 100 * other(node), ..at(frame) }, 0))
                .collect();
            let words = said(&actions);
            assert_eq!(words.contains("node 1 draws something else than the others in frame 4"), frame == 4, "{words}");
            assert_eq!(
                words.contains("node 1 draws the same as the others again since frame 8"),
                frame == 18,
                "{words}"
            );
            assert_eq!(words.is_empty(), frame != 4 && frame != 18, "{frame}: {words}");
        }
        assert!(head.summary(false).contains("node 1 differed in 4 frames from 4 to 7"), "{}", head.summary(false));
    }

    #[test]
    fn windows_of_different_sizes_are_told() {
        let mut head = head(2);
        head.arrived(0, at(1), 0);
        let words = said(&head.arrived(1, Arrival { size: (800, 600), ..at(1) }, 0));
        assert!(words.contains("800x600") && words.contains("640x480"), "{words}");
    }
}
