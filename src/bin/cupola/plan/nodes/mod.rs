//! `cupola plan --nodes`: costs of a rig on one machine and on many.
//!
//! `shares` computes from the plan of the rig what each node draws and sends. `estimate` turns it
//! into times, with the help of `simulation`, which runs the decisions of `cupola node` in
//! simulated time.

mod estimate;
mod shares;
mod simulation;

use crate::failure::Failure;
use crate::planning::window_request;
use cupola::correct;
use cupola::rig::Rig;
use serde_json::{Value, json};
use shares::Shares;
use simulation::{Failed, Show};
use std::time::Duration;

/// Numbers of nodes, if none is given.
const USUAL: [u32; 10] = [1, 2, 3, 4, 6, 8, 12, 16, 32, 64];

/// Options of `--nodes`.
#[derive(clap::Args)]
#[group(skip)]
pub struct Options {
    /// Estimate what N nodes draw, send and need [default N: several from 1 to 64]
    #[arg(long, value_name = "N", num_args = 0..=1, require_equals = true, default_missing_value = "0",
        value_parser = clap::value_parser!(u32).range(0..=64))]
    nodes: Option<u32>,
    /// With --nodes: milliseconds of the program's computation for a frame
    #[arg(long, value_name = "MS", default_value_t = 4.0, value_parser = amount, requires = "nodes")]
    program: f64,
    /// With --nodes: milliseconds in which the graphics card draws a million texels
    #[arg(long, value_name = "MS", default_value_t = 0.5, value_parser = amount, requires = "nodes")]
    texels: f64,
    /// With --nodes: milliseconds in which a million pixels are read back or copied
    #[arg(long, value_name = "MS", default_value_t = 1.0, value_parser = amount, requires = "nodes")]
    copy: f64,
    /// With --nodes: milliseconds that frames take longer by chance, on average
    #[arg(long, value_name = "MS", default_value_t = 0.5, value_parser = amount, requires = "nodes")]
    jitter: f64,
    /// With --nodes: gigabits per second that a node can send
    #[arg(long, value_name = "GBIT", default_value_t = 1.0, value_parser = amount, requires = "nodes")]
    link: f64,
    /// With --nodes: microseconds that a message takes from one node to another
    #[arg(long, value_name = "US", default_value_t = 50.0, value_parser = amount, requires = "nodes")]
    latency: f64,
    /// With --nodes: wanted frames per second
    #[arg(long, value_name = "FPS", default_value_t = 60.0, value_parser = amount, requires = "nodes")]
    rate: f64,
    /// With --nodes: all nodes are on one machine with N processors, as with cupola node --local
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1024), requires = "nodes")]
    cores: Option<u32>,
    /// With --nodes: number of frames that are simulated
    #[arg(long, value_name = "N", default_value_t = 2000, value_parser = clap::value_parser!(u32).range(20..=1_000_000),
        requires = "nodes")]
    simulated: u32,
    /// With --nodes: this node stops at a frame for some seconds, or for ever, for example
    /// 2,100,1.5 or 2,100,inf
    #[arg(long, value_name = "NODE,FRAME,SECONDS", value_parser = failed, requires = "nodes")]
    fail: Option<Failed>,
    /// With --nodes: time-out of cupola node in milliseconds
    #[arg(long, value_name = "MS", default_value_t = 100.0, value_parser = amount, requires = "nodes")]
    time_out: f64,
}

/// Parses a number of at least 0.
fn amount(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|value: &f64| value.is_finite() && (0.0..=1e6).contains(value))
        .ok_or_else(|| "expected a number from 0 to 1000000".to_owned())
}

/// Parses `NODE,FRAME,SECONDS`.
fn failed(text: &str) -> Result<Failed, String> {
    let parts: Vec<&str> = text.split(',').collect();
    let parsed = || {
        let [node, frame, seconds] = parts[..] else { return None };
        let seconds: f64 = seconds.parse().ok().filter(|seconds| *seconds > 0.0)?;
        let stopped = (seconds.is_finite()).then(|| Duration::try_from_secs_f64(seconds).ok());
        Some(Failed {
            node: node.parse().ok().filter(|node| *node > 0)?,
            frame: frame.parse().ok()?,
            stopped: stopped.unwrap_or(None),
        })
    };
    parsed()
        .ok_or_else(|| "expected a node from 1 on, a frame and seconds, for example 2,100,1.5 or 2,100,inf".to_owned())
}

impl Options {
    /// Numbers of nodes that were requested.
    fn counts(&self) -> Option<Vec<u32>> {
        self.nodes.map(|nodes| if nodes == 0 { USUAL.to_vec() } else { vec![nodes] })
    }

    /// A show of nodes that draw for these times, in milliseconds.
    fn show(&self, draws: &[f64], paced: bool) -> Show {
        let duration = |milliseconds: f64| Duration::from_secs_f64(milliseconds * 1e-3);
        Show {
            work: draws.iter().map(|draw| duration(self.program + draw)).collect(),
            jitter: duration(self.jitter),
            latency: duration(self.latency * 1e-3),
            cores: self.cores.map(|cores| cores as usize),
            length: duration(1e3 / self.rate.max(1e-3)),
            is_paced: paced,
            time_out: duration(self.time_out.max(2.0)),
            frames: self.simulated.into(),
            failed: self.fail,
        }
    }
}

/// Prints the table for a rig. Returns `None` if it was not requested.
pub fn run(options: &Options, rig: &Rig, size: Option<(u32, u32)>, as_json: bool) -> Result<Option<()>, Failure> {
    let Some(counts) = options.counts() else { return Ok(None) };
    if options.fail.is_some_and(|failed| counts.iter().any(|count| failed.node >= *count as usize)) {
        return Err(Failure::usage("--fail: there is no such node; give --nodes=N with a larger N"));
    }
    let request = window_request(rig, size);
    let plan = correct::build(rig, &request)?;
    let mut shares = Shares::new(rig, plan, &request.output_sizes);
    let mut rows = Vec::new();
    for count in counts {
        rows.push(estimate::of(options, &shares.of(count)?));
    }
    if as_json {
        let rows: Vec<Value> = rows.iter().map(estimate::Estimate::json).collect();
        println!("{:#}", json!({ "rig": rig.name, "nodes": rows }));
    } else {
        print!("{}", estimate::table(options, rig, &rows));
    }
    Ok(Some(()))
}
