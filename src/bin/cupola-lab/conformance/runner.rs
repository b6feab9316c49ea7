//! Runs tests with and without Cupola, each job on an X server of its own.

use super::outcome::{End, Outcome};
use super::profile::Test;
use super::results::{PLAIN, Results};
use crate::display;
use crate::environment::Environment;
use crate::failure::Failure;
use cupola::lock::Lock;
use cupola::system::process;
use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{self, RecvTimeoutError};
use std::time::{Duration, Instant};

/// Size of the screen of a job's X server.
const SCREEN: (u32, u32) = (1280, 1024);
/// Least time limit of a run.
const PATIENCE: Duration = Duration::from_secs(30);
/// Time that a test gets to end after it has printed its result.
const FAREWELL: Duration = Duration::from_secs(10);
/// Interval of the reports of progress.
const REPORT: Duration = Duration::from_secs(30);

/// A rig with the environment of its programs.
pub struct Rig {
    pub name: String,
    pub environment: Environment,
}

/// Tests to run, and parameters.
pub struct Runner {
    pub piglit: PathBuf,
    /// Folder for files that tests write.
    pub scratch: PathBuf,
    pub rigs: Vec<Rig>,
    /// Library that the tests load first.
    pub preload: Option<PathBuf>,
    /// Tests that take longer without Cupola are not run with it.
    pub longest: Duration,
}

impl Runner {
    /// Runs the tests that `results` lacks, with `jobs` tests at a time.
    pub fn run(&self, tests: &[Test], jobs: usize, results: &Mutex<Results>) -> Result<(), Failure> {
        let work = self.work_folder()?;
        let next = AtomicUsize::new(0);
        let job = || -> Result<(), Failure> {
            let folder = self.scratch.join(format!("job-{}", next_job()));
            std::fs::create_dir_all(&folder).map_err(|error| Failure::new(error.to_string()))?;
            let server = display::Server::start(SCREEN, &folder)?;
            while let Some(test) = tests.get(next.fetch_add(1, Ordering::Relaxed)) {
                self.compare(test, &work, &server, results)?;
            }
            Ok(())
        };
        std::thread::scope(|scope| {
            let running: Vec<_> = (0..jobs).map(|_| scope.spawn(job)).collect();
            let (start, mut reported) = (Instant::now(), Instant::now());
            while !running.iter().all(std::thread::ScopedJoinHandle::is_finished) {
                std::thread::sleep(Duration::from_millis(20));
                if reported.elapsed() >= REPORT {
                    reported = Instant::now();
                    report(next.load(Ordering::Relaxed), tests.len(), start.elapsed());
                }
            }
            let ended = running.into_iter().map(|job| job.join().unwrap_or_else(|_| Err(Failure::new("a job ended"))));
            ended.collect()
        })
    }

    /// Folder in which the paths of piglit's files are valid, and where tests can write.
    fn work_folder(&self) -> Result<PathBuf, Failure> {
        let work = self.scratch.join("work");
        let failure = |error: std::io::Error| Failure::new(format!("{}: {error}", work.display()));
        std::fs::create_dir_all(&work).map_err(failure)?;
        for name in ["tests", "generated_tests", "templates"] {
            if !work.join(name).exists() {
                std::os::unix::fs::symlink(self.piglit.join(name), work.join(name)).map_err(failure)?;
            }
        }
        Ok(work)
    }

    /// Runs a test without Cupola and, if it has a result, with each rig. Runs that differ are
    /// repeated, those with the rig twice.
    fn compare(
        &self,
        test: &Test,
        work: &Path,
        server: &display::Server,
        results: &Mutex<Results>,
    ) -> Result<(), Failure> {
        let limit = |plain: Option<&Outcome>| {
            plain.map_or(PATIENCE, |plain| PATIENCE.max(Duration::from_secs_f64(plain.seconds * 12.0)))
        };
        let run = |rig: Option<&Rig>, limit: Duration| execute(self.command(test, rig, work, server), limit);
        let known = results.locked().get(&test.name, PLAIN).cloned();
        let mut plain = match known {
            Some(plain) => plain,
            None => {
                let plain = run(None, limit(None))?;
                results.locked().add(&test.name, PLAIN, plain.clone())?;
                plain
            }
        };
        if !self.is_compared(&plain) {
            return Ok(());
        }
        for rig in &self.rigs {
            if results.locked().get(&test.name, &rig.name).is_some() {
                continue;
            }
            let mut ours = run(Some(rig), limit(Some(&plain)))?;
            // Some tests do not pass each time, with or without Cupola.
            for repeats in 1..=2 {
                if Outcome::difference(&plain, &ours).is_some() {
                    ours = Outcome { repeats, ..run(Some(rig), limit(Some(&plain)))? };
                }
            }
            if Outcome::difference(&plain, &ours).is_some() {
                let again = Outcome { repeats: 1, ..run(None, limit(None))? };
                if Outcome::difference(&again, &ours).is_none() {
                    results.locked().add(&test.name, PLAIN, again.clone())?;
                    plain = again;
                }
            }
            results.locked().add(&test.name, &rig.name, ours)?;
        }
        Ok(())
    }

    /// True if a test with this outcome without Cupola is run with Cupola.
    pub fn is_compared(&self, plain: &Outcome) -> bool {
        plain.result != "skip" && plain.end != End::Hung && plain.seconds <= self.longest.as_secs_f64()
    }

    fn command(&self, test: &Test, rig: Option<&Rig>, work: &Path, server: &display::Server) -> Command {
        let mut command = Command::new(self.piglit.join("bin").join(&test.command[0]));
        command.args(&test.command[1..]).current_dir(work);
        command.env("PIGLIT_SOURCE_DIR", &self.piglit).env("MESA_DEBUG", "silent");
        let mut set = |name: &str, value: Option<&std::ffi::OsStr>| {
            match value {
                Some(value) => command.env(name, value),
                None => command.env_remove(name),
            };
        };
        set("LD_PRELOAD", self.preload.as_deref().map(AsRef::as_ref));
        for (name, value) in rig.iter().flat_map(|rig| &rig.environment) {
            set(name, value.as_deref().map(AsRef::as_ref));
        }
        for (name, value) in server.environment() {
            set(name, value.as_deref());
        }
        command
    }
}

fn next_job() -> usize {
    static NEXT: AtomicUsize = AtomicUsize::new(0);
    NEXT.fetch_add(1, Ordering::Relaxed)
}

fn report(begun: usize, all: usize, elapsed: Duration) {
    let done = begun.min(all);
    let left = elapsed.as_secs_f64() / done.max(1) as f64 * (all - done) as f64;
    eprintln!("{done} of {all} tests, {} min left", (left / 60.0).ceil());
}

/// Runs a test and collects its output.
fn execute(mut command: Command, limit: Duration) -> Result<Outcome, Failure> {
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null()).process_group(0);
    let start = Instant::now();
    let mut child = process::end_with_parent(&mut command)
        .spawn()
        .map_err(|error| Failure::new(format!("{}: {error}", command.get_program().display())))?;
    let mut outcome =
        Outcome { result: String::new(), subtests: BTreeMap::new(), end: End::Hung, seconds: 0.0, repeats: 0 };
    let (sender, lines) = mpsc::channel();
    if let Some(output) = child.stdout.take() {
        std::thread::spawn(move || {
            for line in BufReader::new(output).split(b'\n').map_while(Result::ok) {
                if sender.send(String::from_utf8_lossy(&line).into_owned()).is_err() {
                    break;
                }
            }
        });
    }
    let mut deadline = start + limit;
    loop {
        match lines.recv_timeout(deadline.saturating_duration_since(Instant::now())) {
            Ok(line) => {
                let had_result = !outcome.result.is_empty();
                outcome.hear(&line);
                if !had_result && !outcome.result.is_empty() {
                    deadline = deadline.min(Instant::now() + FAREWELL);
                }
            }
            Err(RecvTimeoutError::Timeout) => break,
            Err(RecvTimeoutError::Disconnected) => {
                outcome.end = wait(&mut child, deadline)?;
                break;
            }
        }
    }
    outcome.seconds = start.elapsed().as_secs_f64();
    if outcome.end == End::Hung {
        // The process may have ended since.
        let _ = process::kill_group(&child);
        child.wait().map_err(|error| Failure::new(error.to_string()))?;
    }
    Ok(outcome)
}

/// Waits for a process that has closed its output.
fn wait(child: &mut Child, deadline: Instant) -> Result<End, Failure> {
    while Instant::now() < deadline {
        if let Some(status) = child.try_wait().map_err(|error| Failure::new(error.to_string()))? {
            return Ok(match (status.code(), status.signal()) {
                (Some(code), _) => End::Exit(code),
                (None, signal) => End::Signal(signal.unwrap_or_default()),
            });
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    Ok(End::Hung)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shell(script: &str, limit: Duration) -> Outcome {
        let mut command = Command::new("sh");
        command.args(["-c", script]);
        let Ok(outcome) = execute(command, limit) else { panic!("sh cannot be started") };
        outcome
    }

    #[test]
    fn the_end_of_a_process_is_part_of_the_outcome() {
        const SAYS: &str = r#"echo 'PIGLIT: {"result": "pass" }'"#;
        // A busy machine may take a second for a process.
        let ends = |script: &str| shell(script, Duration::from_secs(60)).words();
        assert_eq!(ends(&format!("{SAYS}; exit 0")), "pass");
        assert_eq!(ends(&format!("{SAYS}; kill -SEGV $$")), "pass, killed at exit");
        assert_eq!(ends("kill -ABRT $$"), "crash");
        assert_eq!(shell(&format!("{SAYS}; sleep 60"), Duration::from_secs(3)).words(), "pass, hangs at exit");
        assert_eq!(shell("sleep 60", Duration::from_millis(100)).words(), "timeout");
    }
}
