//! The program on the dome: start, stop, messages, and memory.

use crate::launch::held::{self, Request};
use cupola::lock::Lock;
use cupola::system::process;
use serde_json::Value;
use std::collections::VecDeque;
use std::ffi::OsString;
use std::io::{BufRead, BufReader, Read};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, Sender};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// Greatest number of lines of the program's messages that are shown.
const LINES: usize = 60;
/// Longest such line, bytes.
const LONGEST_LINE: u64 = 2000;
/// Time that a program gets to end by itself.
const GRACE: Duration = Duration::from_secs(5);
/// A message of the library that reports no problem.
const FOLLOWS: &str = "the rig's file has changed, and windows follow it";

/// Number of frames that the library publishes per second. Reading back every frame would slow fast
/// programs down; twice as many as the page uses keep the delay small.
const RATE: &str = "30";

/// Options and files with which programs are started.
#[derive(Clone)]
pub struct Launch {
    /// Options of `cupola run`.
    pub options: Vec<OsString>,
    /// The file that the library follows.
    pub working_file: PathBuf,
    /// File in which the library publishes its pictures.
    pub ring: PathBuf,
    /// File to which the library writes statistics.
    pub statistics: PathBuf,
    /// File by which the program's time is held, if it has a virtual clock.
    pub clock: PathBuf,
}

impl Launch {
    /// Executes a request for the program's time.
    ///
    /// # Errors
    /// The program has no virtual clock.
    pub fn hold(&self, request: Request) -> Result<(), String> {
        held::apply(&self.clock, request).map(drop).map_err(|_| {
            "no program with a virtual clock runs: its time can be held if the server was started with --clock FPS"
                .to_owned()
        })
    }

    /// State of the program's time; `None` without a virtual clock.
    pub fn time(&self) -> Option<Value> {
        held::state(&self.clock).ok()
    }
}

/// State of the program.
#[derive(Clone, Debug, Default, serde::Serialize)]
pub struct Status {
    /// Name of the running program, or of the last one.
    pub name: Option<String>,
    /// True if it runs.
    pub runs: bool,
    /// Process number of `cupola run`.
    pub process: Option<u32>,
    /// Description of how the last program ended, if it failed.
    pub ended: Option<String>,
    /// Last lines that it and Cupola printed.
    pub lines: VecDeque<String>,
}

/// Orders to the thread that owns the program.
enum Order {
    Start(String, Vec<OsString>),
    Stop,
    Leave,
}

/// Handle of the program, for any thread.
#[derive(Clone)]
pub struct Program {
    orders: Sender<Order>,
    status: Arc<Mutex<Status>>,
}

impl Program {
    /// Starts without a program. Returns also the part for [`supervise`].
    pub fn new() -> (Self, Supervised) {
        let (orders, received) = std::sync::mpsc::channel();
        let program = Self { orders, status: Arc::default() };
        (program.clone(), Supervised { orders: received, status: program.status })
    }

    /// Stops the running program, and starts another one.
    pub fn start(&self, name: &str, command: Vec<OsString>) {
        // The receiver lives as long as the process.
        let _ = self.orders.send(Order::Start(name.to_owned(), command));
    }

    /// Stops the program.
    pub fn stop(&self) {
        let _ = self.orders.send(Order::Stop);
    }

    /// Stops the program and ends the server.
    pub fn leave(&self) {
        let _ = self.orders.send(Order::Leave);
    }

    /// State of the program.
    pub fn status(&self) -> Status {
        self.status.locked().clone()
    }

    /// Memory of the program and of the processes that it started, bytes.
    pub fn memory(&self) -> u64 {
        self.status().process.map_or(0, |process| family(process).into_iter().map(resident).sum())
    }
}

/// The part for the thread that owns the program.
pub struct Supervised {
    orders: Receiver<Order>,
    status: Arc<Mutex<Status>>,
}

/// Starts and stops programs until an order or a signal ends this process. `is_once`: it also ends
/// with the program. On Linux a program ends with the thread that started it, so this has to be the
/// thread that lives longest.
pub fn supervise(supervised: &Supervised, launch: &Launch, is_once: bool) {
    let mut child: Option<Child> = None;
    loop {
        let order = supervised.orders.recv_timeout(Duration::from_millis(50)).ok();
        if let Some(running) = &mut child
            && let Ok(Some(status)) = running.try_wait()
        {
            let failed = status.signal().map(|signal| format!("ended by signal {signal}"));
            let failed =
                failed.or_else(|| status.code().filter(|code| *code != 0).map(|code| format!("exit code {code}")));
            supervised.ended(failed);
            child = None;
            if is_once && order.is_none() {
                return;
            }
        }
        if process::end_was_asked_for() {
            stop(&mut child);
            return;
        }
        match order {
            None => {}
            Some(Order::Stop) => {
                stop(&mut child);
                supervised.ended(None);
            }
            Some(Order::Leave) => {
                stop(&mut child);
                // Leaves time for the answer to the request.
                std::thread::sleep(Duration::from_millis(100));
                return;
            }
            Some(Order::Start(name, command)) => {
                stop(&mut child);
                child = supervised.start(name, &command, launch);
            }
        }
    }
}

impl Supervised {
    fn start(&self, name: String, command: &[OsString], launch: &Launch) -> Option<Child> {
        for file in [&launch.statistics, &launch.ring, &launch.clock] {
            // An earlier program may have left the file behind.
            let _ = std::fs::remove_file(file);
        }
        let mut run = Command::new(std::env::current_exe().unwrap_or_else(|_| "cupola".into()));
        run.arg("run").args(&launch.options).arg("--rig").arg(&launch.working_file);
        run.arg("--clock-page").arg(&launch.clock).arg("--").args(command);
        run.env("CUPOLA_PUBLISH", &launch.ring)
            .env("CUPOLA_PUBLISH_RATE", RATE)
            .env("CUPOLA_STATS", &launch.statistics)
            .env("CUPOLA_STATS_EVERY", "1")
            .stdin(Stdio::null())
            .stdout(Stdio::inherit())
            .stderr(Stdio::piped())
            // Ctrl-C reaches the server, which then stops the program.
            .process_group(0);
        let started = process::end_with_parent(&mut run).spawn();
        let mut status = self.status.locked();
        *status = Status { name: Some(name), ..Status::default() };
        match started {
            Ok(mut child) => {
                status.runs = true;
                status.process = Some(child.id());
                if let Some(words) = child.stderr.take() {
                    let kept = self.status.clone();
                    std::thread::spawn(move || keep_lines(words, &kept));
                }
                Some(child)
            }
            Err(error) => {
                status.ended = Some(error.to_string());
                None
            }
        }
    }

    fn ended(&self, failed: Option<String>) {
        let mut status = self.status.locked();
        (status.runs, status.process, status.ended) = (false, None, failed);
    }
}

/// Prints the program's output, and stores its last lines.
fn keep_lines(words: impl Read, status: &Mutex<Status>) {
    let mut words = BufReader::new(words);
    loop {
        let mut line = Vec::new();
        match words.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut line) {
            Ok(0) | Err(_) => return,
            Ok(_) => {}
        }
        let line = String::from_utf8_lossy(&line);
        let line = line.trim_end();
        if line.contains(FOLLOWS) {
            continue;
        }
        eprintln!("{line}");
        let mut status = status.locked();
        status.lines.push_back(line.to_owned());
        if status.lines.len() > LINES {
            status.lines.pop_front();
        }
    }
}

/// Ends the program; asks it first.
fn stop(child: &mut Option<Child>) {
    let Some(mut running) = child.take() else { return };
    // It may have ended by itself.
    let _ = process::terminate(&running);
    let asked = Instant::now();
    while asked.elapsed() < GRACE {
        if !matches!(running.try_wait(), Ok(None)) {
            return;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    let _ = process::kill_group(&running);
    let _ = running.wait();
}

/// A process, and the processes that it started.
fn family(process: u32) -> Vec<u32> {
    let children = std::fs::read_to_string(format!("/proc/{process}/task/{process}/children")).unwrap_or_default();
    let children = children.split_whitespace().filter_map(|id| id.parse().ok());
    std::iter::once(process).chain(children.flat_map(family)).collect()
}

/// Memory of a process, bytes.
fn resident(process: u32) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    let kilobytes: Option<u64> = line.and_then(|line| line.trim().trim_end_matches(" kB").parse().ok());
    kilobytes.unwrap_or(0) << 10
}

/// Memory of this process, bytes.
pub fn own_memory() -> u64 {
    resident(std::process::id())
}
