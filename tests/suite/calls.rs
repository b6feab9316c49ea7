//! Random OpenGL calls of all entry points: OpenGL answers as without Cupola. `cupola-lab calls`
//! makes and compares the calls.

use crate::display;
use crate::harness::{note, tests};
use crate::programs::{player, scratch, vendor};
use std::path::{Path, PathBuf};

tests! {
    random_calls_have_the_same_answers,
    what_was_found_before_has_the_same_answers,
    draws_to_several_views_have_the_same_answers,
    a_call_that_is_lost_is_found,
}

/// Compares the answers without Cupola and with a rig. Returns whether the laboratory succeeded,
/// and its output. `None` if there is no display.
fn compare(arguments: &[&str]) -> Option<(bool, String)> {
    compare_with(arguments, &[])
}

/// As [`compare`], with variables in the environment of both players.
fn compare_with(arguments: &[&str], environment: &[(&str, &str)]) -> Option<(bool, String)> {
    display::get()?;
    let folder = scratch("calls");
    let mut command = player();
    command.envs(environment.iter().copied()).arg("--folder").arg(folder).args(arguments);
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

/// Returns the lists of calls of a folder of `tests`.
fn lists(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests").join(folder);
    let files = std::fs::read_dir(folder).expect("the lists of calls").filter_map(|entry| Some(entry.ok()?.path()));
    let mut files: Vec<_> = files.filter(|path| path.extension().is_some_and(|end| end == "calls")).collect();
    files.sort();
    files
}

/// Plays the lists of a folder with a rig, and without Cupola.
fn replay(folder: &str, rig: &str) {
    let files = lists(folder);
    assert!(!files.is_empty());
    let mut arguments = vec!["--rig", rig, "--keep", "--replay"];
    arguments.extend(files.iter().map(|path| path.to_str().expect("a UTF-8 path")));
    expect_same(&arguments);
}

fn what_was_found_before_has_the_same_answers() {
    replay("calls", "identity-captured");
}

/// Draws that are issued once per view count once in atomic counters.
fn draws_to_several_views_have_the_same_answers() {
    replay("calls/views", "fisheye");
}

/// Negative control: one call between Cupola and the driver is lost in each run. The test must find
/// more lost calls than the list itself contains, so that some of them are Cupola's own calls,
/// which restore state after a swap.
fn a_call_that_is_lost_is_found() {
    let Some(folder) = vendor() else { return };
    let list = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/calls/control/swap.calls");
    let text = std::fs::read_to_string(&list).expect("the list of the control");
    let file = list.to_str().expect("a UTF-8 path");
    let arguments = ["--keep", "--kinds", "compatibility", "--set", "CUPOLA_GLX_REAL=calls", "--replay", file];
    // `cupola` puts a folder of its own in front of this list.
    let environment = [("LD_LIBRARY_PATH", folder)];
    let Some((same, words)) = compare_with(&arguments, &environment) else { return };
    assert!(same, "without a fault: {words}");
    let fault = |function: &str, call: usize| format!("CALLS_FAULT=lost {function} {call} {call}");
    let faults = CONTROLS.iter().flat_map(|function| (1..=MOST_CALLS).map(move |call| fault(function, call)));
    let in_turn: Vec<String> = faults.flat_map(|fault| ["--in-turn".to_owned(), fault]).collect();
    let in_turn: Vec<&str> = in_turn.iter().map(String::as_str).collect();
    let Some((_, words)) = compare_with(&[&arguments[..], &in_turn].concat(), &environment) else { return };
    for function in CONTROLS {
        let own = text.lines().filter(|line| line.split(' ').nth(1) == Some(function)).count();
        let is_found =
            |call: &usize| words.lines().any(|line| line == format!("different with {}", fault(function, *call)));
        let found: Vec<_> = (1..=MOST_CALLS).filter(is_found).collect();
        note(format_args!("{function}: lost calls {found:?} found"));
        assert!(
            found.len() > own,
            "{function}: of {MOST_CALLS} calls that are lost only {found:?} change an answer:\n{words}"
        );
    }
}

/// Functions of which a call is lost.
const CONTROLS: [&str; 3] = ["glBindTexture", "glUseProgram", "glBindVertexArray"];

/// Number of calls of each function of which one is lost in turn.
const MOST_CALLS: usize = 8;
