//! Simulation of a show of several nodes: programs draw for a while, messages take a while, and the
//! decisions are those of `cupola node` itself.

use crate::node::head::{Action, Head};
use cupola::nodes::{Arrival, FIRST_FRAMES};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::time::Duration;

/// Time in which node 0 receives or sends a message, nanoseconds.
const HANDLING: u64 = 5_000;
/// Longest simulated time, nanoseconds.
const LONGEST: u64 = 3_600_000_000_000;

/// A node that fails.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Failed {
    pub node: usize,
    /// Frame in which it stops.
    pub frame: u64,
    /// Time for which it stops; `None`: for ever.
    pub stopped: Option<Duration>,
}

/// Parameters of a simulation.
#[derive(Clone, Debug)]
pub struct Show {
    /// Time that each node's program and graphics card take for a frame.
    pub work: Vec<Duration>,
    /// Mean of the additional, exponentially distributed time of a frame.
    pub jitter: Duration,
    /// Time that a message takes.
    pub latency: Duration,
    /// Processors that all nodes share; `None`: each node has its own.
    pub cores: Option<usize>,
    /// Time from frame to frame.
    pub length: Duration,
    /// True if frames are shown at that rate and no faster.
    pub is_paced: bool,
    pub time_out: Duration,
    pub frames: u64,
    pub failed: Option<Failed>,
}

/// Results of a simulation.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Seen {
    /// Mean time from frame to frame on node 0, milliseconds.
    pub interval: f64,
    /// Time between the first and the last node that show a frame, milliseconds: median, and 99th
    /// percentile.
    pub apart: (f64, f64),
    /// Longest time without a new picture on the nodes that did not fail, milliseconds.
    pub longest: f64,
    /// Number of frames that the failed node did not show.
    pub left_out: u64,
    /// Time from the failed node's stop until it showed a frame with the others, milliseconds;
    /// `None`: it did not.
    pub back: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Event {
    /// A program has drawn a frame.
    Drawn {
        node: usize,
        epoch: u64,
    },
    /// Node 0 receives a message.
    Arrived {
        node: usize,
        frame: u64,
    },
    /// A node receives the release of frames up to this number.
    Released {
        node: usize,
        frame: u64,
    },
    /// A program has waited up to its limit.
    Over {
        node: usize,
        frame: u64,
    },
    /// A program that goes on by itself shows its next frame.
    Paced {
        node: usize,
        frame: u64,
    },
    Tick,
    GoesOn {
        node: usize,
    },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Draws { until: u64 },
    Waits,
    Alone { released: u64 },
    Stopped { left: u64 },
    Dead,
}

#[derive(Clone, Debug)]
struct Node {
    state: State,
    /// Number of the frame that it draws, or whose end it has reached.
    frame: u64,
    released: u64,
    /// Newest released frame since which it goes on by itself.
    alone: Option<u64>,
    epoch: u64,
    went: u64,
    time: u64,
    /// Time at which it showed each frame.
    shown: BTreeMap<u64, u64>,
}

struct Run<'a> {
    show: &'a Show,
    head: Head,
    events: BinaryHeap<Reverse<(u64, u64, Event)>>,
    count: u64,
    nodes: Vec<Node>,
    /// Time at which each processor is free.
    cores: Option<Vec<u64>>,
    /// Time at which node 0 has finished its work.
    busy: u64,
    /// Times of the programs after each frame.
    times: BTreeMap<u64, u64>,
    arrivals: BTreeMap<(usize, u64), Arrival>,
    random: u64,
    tick: Option<u64>,
}

fn nanoseconds(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

impl Show {
    /// Runs the simulation.
    pub fn run(&self) -> Seen {
        let node = Node {
            state: State::Waits,
            frame: 0,
            released: 0,
            alone: None,
            epoch: 0,
            went: 0,
            time: 0,
            shown: BTreeMap::new(),
        };
        let mut run = Run {
            show: self,
            head: Head::new(self.work.len(), self.time_out / 2, self.is_paced.then_some(self.length)),
            events: BinaryHeap::new(),
            count: 0,
            nodes: vec![node; self.work.len()],
            cores: self.cores.map(|cores| vec![0; cores]),
            busy: 0,
            times: BTreeMap::new(),
            arrivals: BTreeMap::new(),
            random: 1,
            tick: None,
        };
        for node in 0..self.work.len() {
            run.begin(node, 0);
        }
        while let Some(Reverse((now, _, event))) = run.events.pop() {
            if now > LONGEST || run.nodes.iter().any(|node| node.frame > self.frames) {
                break;
            }
            run.take(event, now);
        }
        run.seen()
    }
}

impl Run<'_> {
    fn at(&mut self, time: u64, event: Event) {
        self.count += 1;
        self.events.push(Reverse((time, self.count, event)));
    }

    /// Random number of the exponential distribution with mean 1.
    fn chance(&mut self) -> f64 {
        // Marsaglia's xorshift64.
        self.random ^= self.random << 13;
        self.random ^= self.random >> 7;
        self.random ^= self.random << 17;
        -(((self.random >> 11) as f64 + 0.5) / (1u64 << 53) as f64).ln()
    }

    /// Begins the next frame of a program as soon as a processor is free. Returns that time.
    fn begin(&mut self, node: usize, now: u64) -> u64 {
        let extra = nanoseconds(self.show.jitter) as f64 * self.chance();
        let work = nanoseconds(self.show.work[node]) + extra as u64;
        let begin = match &mut self.cores {
            None => now,
            Some(cores) => {
                // Takes the processor that is free first.
                let first = cores.iter_mut().min();
                first.map_or(now, |free| {
                    let begin = now.max(*free);
                    *free = begin + work;
                    begin
                })
            }
        };
        let until = begin + work;
        let frame = &mut self.nodes[node];
        frame.frame += 1;
        frame.state = State::Draws { until };
        let (epoch, number) = (frame.epoch, frame.frame);
        self.at(until, Event::Drawn { node, epoch });
        if let Some(failed) = self.show.failed.filter(|failed| (failed.node, failed.frame) == (node, number)) {
            let frame = &mut self.nodes[node];
            frame.epoch += 1;
            match failed.stopped {
                Some(stopped) => {
                    frame.state = State::Stopped { left: work };
                    self.at(now + nanoseconds(stopped), Event::GoesOn { node });
                }
                None => {
                    frame.state = State::Dead;
                    // The connection is lost, and node 0 notices it.
                    let actions = self.head.gone(node, now);
                    self.act(actions, now);
                }
            }
        }
        begin
    }

    fn take(&mut self, event: Event, now: u64) {
        match event {
            Event::Drawn { node, epoch } if self.nodes[node].epoch == epoch => self.drawn(node, now),
            Event::Drawn { .. } => {}
            Event::Arrived { node, frame } => {
                if let Some(arrival) = self.arrivals.remove(&(node, frame)) {
                    let actions = self.head.arrived(node, arrival, now);
                    self.act(actions, now);
                }
            }
            Event::Released { node, frame } => {
                let one = &mut self.nodes[node];
                one.released = one.released.max(frame);
                if one.state == State::Waits && one.released >= one.frame {
                    self.pass(node, now);
                }
            }
            Event::Over { node, frame } => {
                let one = &mut self.nodes[node];
                if one.state == State::Waits && one.frame == frame {
                    one.alone = Some(one.released);
                    self.pass(node, now);
                }
            }
            Event::Paced { node, frame } => {
                let one = &self.nodes[node];
                if matches!(one.state, State::Alone { .. }) && one.frame == frame {
                    self.pass(node, now);
                }
            }
            Event::Tick => {
                self.tick = None;
                let actions = self.head.tick(now);
                self.act(actions, now);
            }
            Event::GoesOn { node } => {
                let one = &mut self.nodes[node];
                if let State::Stopped { left } = one.state {
                    one.state = State::Draws { until: now + left };
                    let epoch = one.epoch;
                    self.at(now + left, Event::Drawn { node, epoch });
                }
            }
        }
    }

    /// Handles a program at the end of a frame.
    fn drawn(&mut self, node: usize, now: u64) {
        let latency = if node == 0 { 0 } else { nanoseconds(self.show.latency) };
        let length = nanoseconds(self.show.length);
        let one = &mut self.nodes[node];
        one.time += length;
        let frame = one.frame;
        let arrival = Arrival { frame, digest: frame, time: one.time, went: one.went, size: (1, 1) };
        self.arrivals.insert((node, frame), arrival);
        self.busy = self.busy.max(now + latency) + HANDLING;
        self.at(self.busy, Event::Arrived { node, frame });
        let one = &mut self.nodes[node];
        if one.alone.is_some_and(|released| one.released != released) {
            one.alone = None;
        }
        match one.alone {
            Some(released) => {
                one.state = State::Alone { released };
                let due = now.max(one.went + length);
                self.at(due, Event::Paced { node, frame });
            }
            None if one.released >= frame => self.pass(node, now),
            None => {
                one.state = State::Waits;
                let limit = if frame <= FIRST_FRAMES { 60_000_000_000 } else { nanoseconds(self.show.time_out) };
                self.at(now + limit, Event::Over { node, frame });
            }
        }
    }

    /// Shows a program's frame, or skips it if the others are ahead.
    fn pass(&mut self, node: usize, now: u64) {
        let one = &mut self.nodes[node];
        if let Some(time) = self.times.get(&one.frame) {
            one.time = one.time.max(*time);
        }
        let (frame, is_late) = (one.frame, one.released > one.frame);
        let went = self.begin(node, now);
        let one = &mut self.nodes[node];
        one.went = went;
        if !is_late {
            one.shown.insert(frame, went);
        }
    }

    /// Executes the actions of node 0.
    fn act(&mut self, actions: Vec<Action>, now: u64) {
        let latency = nanoseconds(self.show.latency);
        for action in actions {
            let Action::Release { frame, time } = action else { continue };
            if time > 0 {
                self.times.insert(frame, time);
            }
            self.busy = self.busy.max(now);
            for node in 1..self.nodes.len() {
                self.busy += HANDLING;
                self.at(self.busy + latency, Event::Released { node, frame });
            }
            self.at(self.busy, Event::Released { node: 0, frame });
        }
        if let Some(due) =
            self.head.due().map(|due| due.max(now + 1)).filter(|due| self.tick.is_none_or(|tick| tick > *due))
        {
            self.tick = Some(due);
            self.at(due, Event::Tick);
        }
    }

    fn seen(&self) -> Seen {
        const MS: f64 = 1e-6;
        let failed = self.show.failed.map(|failed| failed.node);
        let others =
            || self.nodes.iter().enumerate().filter(|(number, _)| Some(*number) != failed).map(|(_, node)| node);
        let steps = |node: &Node| -> Vec<u64> {
            let times: Vec<u64> = node.shown.range(FIRST_FRAMES..).map(|(_, time)| *time).collect();
            times.windows(2).map(|pair| pair[1] - pair[0]).collect()
        };
        let leader = others().next().map(steps).unwrap_or_default();
        let mut apart: Vec<u64> = Vec::new();
        if let Some(first) = others().next() {
            for frame in first.shown.range(FIRST_FRAMES..).map(|(frame, _)| frame) {
                let times: Vec<u64> = others().filter_map(|node| node.shown.get(frame).copied()).collect();
                apart.extend(times.iter().max().zip(times.iter().min()).map(|(last, first)| last - first));
            }
        }
        apart.sort_unstable();
        let part = |part: usize| apart.get(apart.len() * part / 100).map_or(0.0, |time| *time as f64 * MS);
        let longest = others().flat_map(steps).max().unwrap_or(0);
        let (left_out, back) = self.show.failed.map_or((0, None), |failed| self.returned(failed));
        Seen {
            interval: leader.iter().sum::<u64>() as f64 * MS / leader.len().max(1) as f64,
            apart: (part(50), part(99)),
            longest: longest as f64 * MS,
            left_out,
            back,
        }
    }

    /// Number of frames that the failed node did not show, and the time from its stop until it was
    /// back.
    fn returned(&self, failed: Failed) -> (u64, Option<f64>) {
        let Some(node) = self.nodes.get(failed.node) else { return (0, None) };
        let left_out = (1..node.frame).filter(|frame| !node.shown.contains_key(frame)).count() as u64;
        let before = node.shown.range(..failed.frame).next_back().map_or(0, |(_, time)| *time);
        let after = node.shown.range(failed.frame..).next();
        let back = failed.stopped.zip(after).map(|(stopped, (_, time))| {
            (time.saturating_sub(before).saturating_sub(nanoseconds(stopped))) as f64 * 1e-6
        });
        (left_out, back)
    }
}

#[cfg(test)]
mod tests;
