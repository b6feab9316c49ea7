//! Random OpenGL calls of all entry points: OpenGL answers as without Cupola. `cupola-lab calls` plays and compares them.

use crate::display;
use crate::harness::{note, tests};
use crate::programs::{player, scratch, vendor};
use std::path::{Path, PathBuf};

tests! {
    random_calls_have_the_same_answers,
    what_was_found_before_has_the_same_answers,
    a_call_that_is_lost_is_found,
}

/// Compares with a rig. The laboratory's exit code and words; `None` where there is no display.
fn compare(arguments: &[&str]) -> Option<(bool, String)> {
    display::get()?;
    let folder = scratch("calls");
    let mut command = player();
    command.arg("--folder").arg(folder).args(arguments);
    let output = command.output().expect("the laboratory can be started");
    let words = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    Some((output.status.success(), words))
}

fn expect_same(arguments: &[&str]) {
    let Some((same, words)) = compare(arguments) else { return };
    assert!(same, "{words}");
    let calls = words.lines().find_map(|line| line.split_once(" calls in ")?.0.parse::<usize>().ok());
    note(format_args!("{} calls", calls.unwrap_or(0)));
    assert!(calls.is_some_and(|calls| calls > 0), "{words}");
}

fn random_calls_have_the_same_answers() {
    expect_same(&["--rig", "identity", "--keep", "--episodes", "8", "--calls", "300"]);
}

fn lists() -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/calls");
    let files = std::fs::read_dir(folder).expect("the lists of calls").filter_map(|entry| Some(entry.ok()?.path()));
    let mut files: Vec<_> = files.filter(|path| path.extension().is_some_and(|end| end == "calls")).collect();
    files.sort();
    files
}

fn what_was_found_before_has_the_same_answers() {
    let files = lists();
    assert!(!files.is_empty());
    let mut arguments = vec!["--keep", "--replay"];
    arguments.extend(files.iter().map(|path| path.to_str().expect("a UTF-8 path")));
    expect_same(&arguments);
}

/// The control: calls that put state back after a swap are lost between Cupola and the driver, one in each run.
fn a_call_that_is_lost_is_found() {
    let Some(folder) = vendor() else { return };
    let list = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/calls/control/swap.calls");
    let folder = format!("LD_LIBRARY_PATH={folder}");
    let arguments =
        ["--keep", "--set", "CUPOLA_GLX_REAL=calls", "--set", &folder, "--replay", list.to_str().expect("UTF-8")];
    let Some((same, words)) = compare(&arguments) else { return };
    assert!(same, "without a fault: {words}");
    for call in CONTROLS {
        let fault = format!("CALLS_FAULT=lost {call}");
        let Some((same, words)) = compare(&[&arguments[..], &["--set", &fault]].concat()) else { return };
        assert!(!same, "{call}: {words}");
    }
}

/// Functions, each with the first and the last of its calls that are lost.
const CONTROLS: [&str; 3] = ["glBindTexture 5 5", "glUseProgram 3 3", "glBindVertexArray 3 3"];
