//! Times, bandwidth and memory of three ways to show a rig: replicas, mirrors, windows.

use super::Options;
use super::shares::Share;
use super::simulation::Seen;
use cupola::rig::Rig;
use serde_json::{Value, json};

/// Number of bytes of a message of `cupola node` on the wire: six numbers, and the headers of TCP,
/// IP and Ethernet.
const MESSAGE: f64 = 48.0 + 78.0;
/// Number of bytes of a pixel that is sent from node to node.
const PIXEL: f64 = 4.0;
/// Number of stored pictures that a reader may be behind.
const SLOTS: f64 = 4.0;

/// One way to show a rig.
pub struct Way {
    /// Time from frame to frame, milliseconds.
    interval: f64,
    /// Megabits per second that node 0 sends.
    megabits: f64,
    /// Delay of a picture, compared with one program in one window, milliseconds.
    delay: f64,
    /// Memory of the node that needs most, megabytes.
    megabytes: f64,
}

/// The three ways with a number of nodes.
pub struct Estimate {
    shares: Vec<Share>,
    /// Simulated replicas at the wanted rate.
    paced: Seen,
    /// Simulated replicas without a rate limit.
    free: Seen,
    replicas: Way,
    mirrors: Way,
    windows: Way,
}

/// Estimates the ways for nodes with these shares.
pub fn of(options: &Options, shares: &[Share]) -> Estimate {
    let draw = |texels: u64| options.texels * texels as f64 * 1e-6;
    let all = |part: fn(&Share) -> u64| shares.iter().map(part).sum::<u64>();
    let most = |part: fn(&Share) -> u64| shares.iter().map(part).max().unwrap_or(0);
    let draws: Vec<f64> = shares.iter().map(|share| draw(share.texels)).collect();
    let paced = options.show(&draws, true).run();
    let free = options.show(&draws, false).run();
    let others = shares.len() as f64 - 1.0;
    let whole = options.program + draw(all(|share| share.texels)) + options.jitter;
    let wanted = 1e3 / options.rate.max(1e-3);
    // Each picture is read back or copied once on its way out, and once where it is shown.
    let elsewhere = shares.iter().skip(1).map(|share| share.pixels).sum::<u64>() as f64 * 1e-6;
    let farthest = shares.iter().skip(1).map(|share| share.pixels).max().unwrap_or(0) as f64 * 1e-6;
    let sent = if options.link > 0.0 { elsewhere * PIXEL * 8.0 / options.link } else { f64::INFINITY };
    let sent = if elsewhere > 0.0 { sent } else { 0.0 };
    let copied = options.copy * elsewhere;
    let mirrored = wanted.max(whole + copied).max(sent);
    let windowed = wanted.max(whole + copied);
    let kept = SLOTS * PIXEL * elsewhere;
    let megabytes = |bytes: u64| bytes as f64 * 1e-6;
    let everything = megabytes(all(|share| share.bytes));
    Estimate {
        replicas: Way {
            interval: wanted.max(free.interval),
            megabits: others * MESSAGE * 8.0e-6 * 1e3 / wanted.max(free.interval),
            delay: if others > 0.0 { 2.0 * options.latency * 1e-3 } else { 0.0 },
            megabytes: megabytes(most(|share| share.bytes)),
        },
        mirrors: Way {
            interval: mirrored,
            megabits: elsewhere * PIXEL * 8.0 * 1e3 / mirrored,
            delay: if elsewhere > 0.0 { copied + sent + options.latency * 1e-3 + options.copy * farthest } else { 0.0 },
            megabytes: everything + kept,
        },
        windows: Way {
            interval: windowed,
            megabits: 0.0,
            delay: if elsewhere > 0.0 { copied + options.copy * farthest } else { 0.0 },
            megabytes: everything + kept,
        },
        paced,
        free,
        shares: shares.to_vec(),
    }
}

impl Estimate {
    /// As JSON.
    pub fn json(&self) -> Value {
        let way = |way: &Way| {
            json!({
                "milliseconds": way.interval,
                "megabits": way.megabits,
                "delay_milliseconds": way.delay,
                "megabytes": way.megabytes,
            })
        };
        let seen = |seen: &Seen| {
            json!({
                "milliseconds": seen.interval,
                "apart_milliseconds": { "median": seen.apart.0, "99_of_100": seen.apart.1 },
                "longest_milliseconds": seen.longest,
                "left_out": seen.left_out,
                "back_after_milliseconds": seen.back,
            })
        };
        let shares: Vec<Value> = self
            .shares
            .iter()
            .map(|share| json!({ "outputs": share.outputs, "views": share.views, "texels": share.texels, "pixels": share.pixels }))
            .collect();
        json!({
            "nodes": self.shares.len(),
            "shares": shares,
            "replicas": way(&self.replicas),
            "mirrors": way(&self.mirrors),
            "windows": way(&self.windows),
            "simulated": { "at_the_rate": seen(&self.paced), "as_fast_as_they_can": seen(&self.free) },
        })
    }
}

/// Formats the table for people.
pub fn table(options: &Options, rig: &Rig, rows: &[Estimate]) -> String {
    let mut text = format!("{}, {} frames in a second wanted\n", rig.name, options.rate);
    let mut line = |words: String| text.extend([words.as_str(), "\n"]);
    line("replicas: each node runs the program and draws what its outputs show".to_owned());
    line(
        "  nodes  outputs  views  Mtexels    ms  frames/s    Mbit/s  delay ms  apart ms      MB   the most of a node"
            .to_owned(),
    );
    for row in rows {
        let most = |part: fn(&Share) -> u64| row.shares.iter().map(part).max().unwrap_or(0);
        line(
            format!(
                "  {:5}  {:7}  {:5}  {:7.2} {}  {:8.3}",
                row.shares.len(),
                most(|share| share.outputs as u64),
                most(|share| share.views as u64),
                most(|share| share.texels) as f64 * 1e-6,
                way(&row.replicas),
                row.paced.apart.1,
            ) + &format!("  {:6.0}", row.replicas.megabytes),
        );
    }
    if options.fail.is_some() {
        line("with the failure".to_owned());
        for row in rows {
            let back = row.paced.back.map_or_else(
                || "it does not come back".to_owned(),
                |back| format!("it shows frames with the others {back:.0} ms after it goes on"),
            );
            line(format!(
                "  {:5}  the others show no new picture for {:.0} ms; the node leaves out {} frames; {back}",
                row.shares.len(),
                row.paced.longest,
                row.paced.left_out
            ));
        }
    }
    type Part = fn(&Estimate) -> &Way;
    let others: [(&str, Part); 2] = [
        ("mirrors: node 0 draws everything and sends the others their pictures, 4 bytes for each pixel", |row| {
            &row.mirrors
        }),
        ("windows: one machine draws everything, and copies the pictures to windows of other screens", |row| {
            &row.windows
        }),
    ];
    for (title, part) in others {
        line(title.to_owned());
        line("  nodes                             ms  frames/s    Mbit/s  delay ms                MB".to_owned());
        for row in rows {
            line(format!(
                "  {:5}                          {}            {:6.0}",
                row.shares.len(),
                way(part(row)),
                part(row).megabytes
            ));
        }
    }
    text
}

fn way(way: &Way) -> String {
    format!("{:5.1}  {:8.1}  {:8.2}  {:8.2}", way.interval, 1e3 / way.interval.max(1e-6), way.megabits, way.delay)
}
