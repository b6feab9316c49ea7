//! Comparison of the programs on several nodes: sums of their calls in each frame.

use cupola::nodes::Arrival;
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Number of frames whose sum is stored for late nodes.
const KEPT: usize = 4096;
/// Number of equal frames after which a node counts as equal to the others again.
const ALIKE: u64 = 10;
/// Greatest number of stored differences in time between nodes.
const SKEWS: usize = 1 << 20;

/// Difference of a node.
#[derive(Clone, Copy)]
struct Difference {
    first: u64,
    last: u64,
    frames: u64,
    /// True if the user knows that the node is equal to the others again.
    is_told_alike: bool,
}

/// Sums of the newest frames, and results.
#[derive(Default)]
pub struct Sums {
    /// Frames at which not all nodes have arrived: node, sum, and time at which it showed the frame
    /// before.
    open: BTreeMap<u64, Vec<(usize, u64, u64)>>,
    /// Sum of most nodes, for each frame.
    settled: BTreeMap<u64, u64>,
    /// Nodes that differed.
    different: BTreeMap<usize, Difference>,
    /// Nanoseconds between the first and the last node in a frame.
    skews: Vec<u64>,
}

impl Sums {
    /// Adds the sum of a node. Returns a message for the user.
    pub fn add(&mut self, node: usize, arrival: &Arrival) -> Option<String> {
        match self.settled.get(&arrival.frame) {
            Some(sum) => self.compared(node, arrival.frame, *sum == arrival.digest),
            None => {
                self.open.entry(arrival.frame).or_default().push((node, arrival.digest, arrival.went));
                None
            }
        }
    }

    /// Compares a frame at which all nodes that are in step, `members`, have arrived. Returns a
    /// message for the user.
    pub fn settle(&mut self, frame: u64, members: &[usize]) -> Option<String> {
        let sums = self.open.remove(&frame).unwrap_or_default();
        self.open.retain(|open, _| *open > frame);
        let count = |sum: u64| sums.iter().filter(|(_, other, _)| *other == sum).count();
        // Of two equally frequent sums, that of the lowest node counts.
        let usual = sums.iter().rev().max_by_key(|(node, sum, _)| (count(*sum), std::cmp::Reverse(*node)))?.1;
        self.settled.insert(frame, usual);
        if self.settled.len() > KEPT {
            self.settled.pop_first();
        }
        let went: Vec<u64> = sums.iter().filter(|sum| members.contains(&sum.0)).map(|(_, _, went)| *went).collect();
        if let (Some(first), Some(last)) = (went.iter().min(), went.iter().max())
            && *first > 0
            && went.len() > 1
            && self.skews.len() < SKEWS
        {
            self.skews.push(last - first);
        }
        let words = sums.into_iter().filter_map(|(node, sum, _)| self.compared(node, frame, sum == usual));
        words.reduce(|all, next| format!("{all}\n{next}"))
    }

    /// Records whether a node's sum is that of the others. Returns a message for the user.
    fn compared(&mut self, node: usize, frame: u64, is_alike: bool) -> Option<String> {
        if is_alike {
            let known = self.different.get_mut(&node)?;
            let is_again = frame > known.last + ALIKE && !std::mem::replace(&mut known.is_told_alike, true);
            return is_again
                .then(|| format!("node {node} draws the same as the others again since frame {}", known.last + 1));
        }
        let known = self.different.get_mut(&node);
        if let Some(known) = known {
            (known.last, known.frames) = (known.last.max(frame), known.frames + 1);
            return None;
        }
        self.different.insert(node, Difference { first: frame, last: frame, frames: 1, is_told_alike: false });
        Some(format!(
            "node {node} draws something else than the others in frame {frame}: its program depends on something that \
             differs between the nodes"
        ))
    }

    /// Results, as the end of a sentence; `times`: includes the differences in time.
    pub fn summary(&self, times: bool) -> String {
        let mut text = if self.different.is_empty() { ", all alike".to_owned() } else { String::new() };
        for (node, Difference { first, last, frames, .. }) in &self.different {
            text.push_str(&format!(", node {node} differed in {frames} frames from {first} to {last}"));
        }
        let mut skews = self.skews.clone();
        skews.sort_unstable();
        let part = |part: usize| skews.get(skews.len() * part / 100).map(|time| *time as f64 * 1e-6);
        if let (Some(median), Some(most)) = (part(50), part(99))
            && times
        {
            let words = "between the first node and the last";
            text.push_str(&format!("; {words} {median:.3} ms, in 99 of 100 frames at most {most:.3} ms"));
        }
        text
    }

    /// Nodes that differed, as JSON.
    pub fn different(&self) -> Vec<Value> {
        let different = self.different.iter();
        let json = |(node, known): (&usize, &Difference)| json!({ "node": node, "first": known.first, "last": known.last, "frames": known.frames });
        different.map(json).collect()
    }

    /// Number of frames for each range of microseconds between the first node and the last: up to
    /// each power of two.
    pub fn histogram(&self) -> Vec<(u64, usize)> {
        let mut counts = BTreeMap::new();
        for skew in &self.skews {
            *counts.entry(skew.div_ceil(1000).next_power_of_two()).or_default() += 1;
        }
        counts.into_iter().collect()
    }
}
