//! `cupola-lab conformance`: compares the results of piglit's tests with and without Cupola.

mod known;
mod outcome;
mod profile;
mod results;
mod runner;

use crate::environment::{self, beside_this};
use crate::failure::Failure;
use outcome::Outcome;
use profile::Test;
use results::{PLAIN, Results};
use runner::{Rig, Runner};
use serde_json::json;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// Profiles of piglit: programs, including those of GLX and EGL, and shader tests.
const PROFILES: [&str; 2] = ["quick_gl", "quick_shader"];

/// Compare the results of piglit's tests with and without Cupola
///
/// The tests draw to windows, never with -fbo. Skipped, hanging and slow tests are not run with
/// Cupola. The exit code is 1 if a test differs and is not among the known differences, or if a
/// known difference is not found.
#[derive(clap::Args)]
pub struct Arguments {
    /// Compare with this rig; can be repeated [default: identity, identity-captured, fisheye]
    #[arg(long = "rig", value_name = "FILE|PRESET")]
    rigs: Vec<String>,
    /// Run N tests, spread over all programs and folders
    #[arg(long, value_name = "N")]
    sample: Option<usize>,
    /// Run only tests whose name contains this text
    #[arg(long, value_name = "TEXT", default_value = "")]
    only: String,
    /// Number of tests at a time
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..))]
    jobs: u16,
    /// Leave out tests that need more seconds without Cupola
    #[arg(long, value_name = "S", default_value_t = 5.0)]
    seconds: f64,
    /// File of outcomes; an interrupted run continues there
    #[arg(long, value_name = "FILE", default_value = "out/conformance/results.jsonl")]
    results: PathBuf,
    /// File of known differences
    #[arg(long, value_name = "FILE", default_value = "tests/conformance/known.toml")]
    known: PathBuf,
    /// Folder of piglit
    #[arg(long, value_name = "DIR", default_value = concat!("/usr/lib/x86_64-linux-gnu", "/piglit"))]
    piglit: PathBuf,
    /// Set LD_PRELOAD to this library for each test, with and without Cupola
    #[arg(long, value_name = "FILE")]
    preload: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

/// Runs the subcommand.
pub fn run(arguments: &Arguments) -> Result<ExitCode, Failure> {
    let known = known::read(&arguments.known)?;
    let tests = tests(arguments)?;
    let folder = arguments.results.parent().filter(|folder| *folder != Path::new("")).unwrap_or(Path::new("."));
    let failure = |path: &Path, error: std::io::Error| Failure::usage(format!("{}: {error}", path.display()));
    std::fs::create_dir_all(folder).map_err(|error| failure(folder, error))?;
    let folder = folder.canonicalize().map_err(|error| failure(folder, error))?;
    let default = ["identity", "identity-captured", "fisheye"].map(str::to_owned);
    let names = if arguments.rigs.is_empty() { &default[..] } else { &arguments.rigs };
    let runner = Runner {
        piglit: arguments.piglit.clone(),
        rigs: names.iter().map(|name| rig(name, &folder)).collect::<Result<_, _>>()?,
        preload: arguments
            .preload
            .as_ref()
            .map(std::path::absolute)
            .transpose()
            .map_err(|error| Failure::usage(format!("--preload: {error}")))?,
        scratch: folder,
        longest: Duration::from_secs_f64(arguments.seconds),
    };
    let results = Mutex::new(Results::open(&arguments.results, library()?)?);
    runner.run(&tests, usize::from(arguments.jobs), &results)?;
    let results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
    let summary = Summary::new(&tests, &runner, &results);
    let wrong = known::judge(&summary.found, &known);
    if arguments.json {
        println!("{:#}", json!({ "outcomes": summary.counts, "unsteady": summary.unsteady, "wrong": wrong }));
    } else {
        summary.print(tests.len());
        wrong.iter().for_each(|line| println!("{line}"));
        println!("{} differ and should not, or should and do not", wrong.len());
    }
    Ok(if wrong.is_empty() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Selects the tests of the arguments.
fn tests(arguments: &Arguments) -> Result<Vec<Test>, Failure> {
    let mut tests = Vec::new();
    for name in PROFILES {
        tests.extend(profile::read(&arguments.piglit, name)?);
    }
    // Some distributions do not build all programs.
    let is_built = |test: &Test| arguments.piglit.join("bin").join(&test.command[0]).exists();
    tests.retain(|test| test.name.contains(&arguments.only) && is_built(test));
    if tests.is_empty() {
        return Err(Failure::usage(format!("no test has a name with {:?}", arguments.only)));
    }
    Ok(match arguments.sample {
        Some(count) => profile::sample(tests, count),
        None => tests,
    })
}

/// A rig with the environment of its programs.
fn rig(name: &str, folder: &Path) -> Result<Rig, Failure> {
    Ok(Rig { name: name.to_owned(), environment: environment::of_rig(name, folder)? })
}

/// Digest of the library.
fn library() -> Result<String, Failure> {
    let path = beside_this("libcupola.so")?;
    let bytes = std::fs::read(&path).map_err(|error| Failure::new(format!("{}: {error}", path.display())))?;
    Ok(format!("{:032x}", xxhash_rust::xxh3::xxh3_128(&bytes)))
}

/// Outcomes of the chosen tests.
struct Summary {
    /// Number of tests by rig and outcome.
    counts: BTreeMap<String, BTreeMap<String, usize>>,
    found: known::Found,
    /// Tests that differed at first but not when they were repeated, with their rig.
    unsteady: Vec<(String, String)>,
}

impl Summary {
    fn new(tests: &[Test], runner: &Runner, results: &Results) -> Self {
        let mut summary = Self { counts: BTreeMap::new(), found: known::Found::new(), unsteady: Vec::new() };
        for test in tests {
            let Some(plain) = results.get(&test.name, PLAIN) else { continue };
            summary.count(PLAIN, plain);
            if !runner.is_compared(plain) {
                continue;
            }
            for rig in &runner.rigs {
                let Some(ours) = results.get(&test.name, &rig.name) else { continue };
                summary.count(&rig.name, ours);
                let difference = Outcome::difference(plain, ours);
                let key = (test.name.clone(), rig.name.clone());
                if difference.is_none() && ours.repeats > 0 {
                    summary.unsteady.push(key.clone());
                }
                summary.found.insert(key, difference);
            }
        }
        summary
    }

    fn count(&mut self, rig: &str, outcome: &Outcome) {
        *self.counts.entry(rig.to_owned()).or_default().entry(outcome.words()).or_default() += 1;
    }

    fn print(&self, tests: usize) {
        println!("{tests} tests");
        for (rig, counts) in &self.counts {
            let words: Vec<String> = counts.iter().map(|(words, count)| format!("{words} {count}")).collect();
            let differ = self.found.iter().filter(|((_, of), difference)| of == rig && difference.is_some()).count();
            println!("{rig}: {}; {differ} differ from plain", words.join(", "));
        }
        for (test, rig) in &self.unsteady {
            println!("{test}, {rig}: not the same in each run");
        }
    }
}
