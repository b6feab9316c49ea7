//! Runs tests as `cargo test` does. A test counts as ignored if something that it needs is not
//! installed.
//!
//! A file lists its functions in [`tests!`]. A function that is in no list is dead code, which does
//! not compile. `CUPOLA_TEST_TIMES` names a file to which each test adds a line with its seconds
//! and its name.

use libtest_mimic::{Arguments, Completion, Failed, Trial};
use std::cell::RefCell;
use std::fmt::{Display, Write as _};
use std::io::Write as _;
use std::panic::{PanicHookInfo, catch_unwind};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Instant;

/// A test: its name in `cargo test`, and its function.
pub type Test = (&'static str, fn());

thread_local! {
    /// Reason why this thread's test cannot run.
    static MISSING: RefCell<Option<String>> = const { RefCell::new(None) };
    /// Lines that this thread's test printed, and its panic.
    static PRINTED: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Whether notes and panics are also printed at once, as the option `--nocapture` asks.
static PRINTS: AtomicBool = AtomicBool::new(false);

/// Defines `tests()`: this module's tests and those of the `modules` below it.
macro_rules! tests {
    ($($name:ident),* $(,)? $(; modules $($module:ident),* $(,)?)?) => {
        /// Tests of this module and of those below it.
        pub fn tests() -> Vec<crate::harness::Test> {
            #[allow(unused_mut, reason = "a module without others below it")]
            let mut tests: Vec<crate::harness::Test> =
                vec![$((concat!(module_path!(), "::", stringify!($name)), $name)),*];
            $($(tests.extend($module::tests());)*)?
            tests
        }
    };
}
pub(crate) use tests;

/// Counts this thread's test as ignored unless it fails. If `CUPOLA_REQUIRE_GL` is in the
/// environment, the test fails.
pub fn missing(what: impl Display) {
    assert!(std::env::var_os("CUPOLA_REQUIRE_GL").is_none(), "{what}");
    MISSING.with_borrow_mut(|missing| {
        missing.get_or_insert_with(|| what.to_string());
    });
}

/// Adds a line that is printed if this thread's test fails. With the option `--nocapture` the line
/// is printed at once.
#[allow(dead_code, reason = "not every user of this file has something to say")]
pub fn note(line: impl Display) {
    print(&line);
}

fn print(line: &dyn Display) {
    let kept = PRINTED.with_borrow_mut(|printed| match printed {
        Some(printed) => writeln!(printed, "{line}").is_ok(),
        None => false,
    });
    if !kept || PRINTS.load(Relaxed) {
        eprintln!("{line}");
    }
}

/// Runs a test on this thread.
pub fn outcome(test: fn()) -> Result<Completion, Failed> {
    MISSING.set(None);
    PRINTED.set(Some(String::new()));
    let result = catch_unwind(test);
    let printed = PRINTED.take().unwrap_or_default();
    match (result, MISSING.take()) {
        (Err(_), _) => Err(printed.into()),
        (Ok(()), Some(what)) => Ok(Completion::ignored_with(what)),
        (Ok(()), None) => Ok(Completion::Completed),
    }
}

/// Panic hook. The usual hook would also print the panics that negative controls expect.
fn keep_panic(info: &PanicHookInfo) {
    print(info);
}

/// Runs the tests that the command line selects.
pub fn run(tests: Vec<Test>) -> ExitCode {
    std::panic::set_hook(Box::new(keep_panic));
    let times = std::env::var_os("CUPOLA_TEST_TIMES").map(|file| {
        let opened = std::fs::OpenOptions::new().create(true).append(true).open(&file);
        &*Box::leak(Box::new(opened.unwrap_or_else(|error| panic!("{}: {error}", file.display()))))
    });
    let trial = |(path, test): Test| {
        // The name starts after that of the crate.
        let name = path.split_once("::").map_or(path, |(_, name)| name);
        Trial::ignorable_test(name, move || {
            let start = Instant::now();
            let outcome = outcome(test);
            if let Some(mut file) = times {
                // A single write, so that lines of several tests do not mix.
                let line = format!("{:.3} {name}\n", start.elapsed().as_secs_f64());
                file.write_all(line.as_bytes())?;
            }
            outcome
        })
    };
    // `scripts/test` gives this option to all test programs. This harness does not know it and
    // writes the times to a file instead.
    let mut arguments = Arguments::from_iter(std::env::args().filter(|argument| argument != "--report-time"));
    let threads = std::env::var("RUST_TEST_THREADS").ok().and_then(|number| number.parse().ok());
    arguments.test_threads = arguments.test_threads.or(threads);
    PRINTS.store(arguments.nocapture, Relaxed);
    libtest_mimic::run(&arguments, tests.into_iter().map(trial).collect()).exit_code()
}
