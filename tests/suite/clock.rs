//! The virtual clock: `cupola run --clock`.

use crate::compare::expect_identical_captures;
use crate::harness::{note, tests};
use crate::programs::{Finished, Run, built, preload, scratch};
use std::path::Path;
use std::process::Command;

tests! {
    waits_last_the_programs_time,
    timers_that_are_files_follow_the_programs_time,
    nothing_is_lost_at_the_worst_moment,
    the_system_understands_the_number_of_the_process,
    two_runs_are_equal,
    without_the_clock_two_runs_differ,
    another_seed_gives_other_numbers,
    a_wait_within_a_frame_moves_no_frame,
    limiters_keep_their_rate,
}

const FRAMES: usize = 6;

/// Runs the program that moves by time. It waits in each frame in the way of `mode`.
fn by_time(mode: &str, cupola: &[&str]) -> Option<Finished> {
    let extra = ["--answers", "answers.txt", "--mode", mode];
    Run { frames: FRAMES, cupola_frames: FRAMES, extra: &extra, cupola, ..Run::new("by_time") }.under("fisheye")
}

/// The values that the program read in its frames.
fn answers(run: &Finished) -> String {
    std::fs::read_to_string(run.directory.join("answers.txt")).expect("the program writes down what it reads")
}

/// The program's time in each frame, in seconds.
fn times(run: &Finished) -> Vec<f64> {
    let time = |line: &str| line.split(' ').nth(1).and_then(|time| time.parse().ok()).expect("a time");
    let times: Vec<f64> = answers(run).lines().map(time).collect();
    note(format_args!("{times:?}"));
    assert_eq!(times.len(), FRAMES);
    times
}

/// Runs a program that needs no display, with the library of the clock. It checks what it reads.
fn checks_itself(program: &str, arguments: &[&str]) {
    checks_itself_beside("", program, arguments);
}

/// As [`checks_itself`], with another library behind that of the clock.
fn checks_itself_beside(beside: &str, program: &str, arguments: &[&str]) {
    let library = Path::new(env!("CARGO_BIN_EXE_cupola")).with_file_name("libcupola_clock.so");
    assert!(library.exists(), "{}: build it by cargo build --package cupola_clock", library.display());
    let mut command = Command::new(built().join(program));
    command.args(arguments).env("LD_PRELOAD", format!("{}:{beside}", library.display())).env("CUPOLA_CLOCK", "60/1");
    Finished::run(command, program, "without a display").expect_success();
}

fn waits_last_the_programs_time() {
    checks_itself("clock_waits", &[]);
}

fn timers_that_are_files_follow_the_programs_time() {
    for part in [
        "unwatched",
        "copies",
        "set_meanwhile",
        "looks",
        "forked",
        "reads",
        "looks_by_reads",
        "reads_of_others",
        "of_others",
        "edges",
    ] {
        checks_itself("clock_timers", &[part]);
    }
}

/// A library behind the clock's does something between the calls of the system that make one wait,
/// and while the process is copied.
fn nothing_is_lost_at_the_worst_moment() {
    for part in ["interrupted", "locked", "copied"] {
        checks_itself_beside(&preload("beside"), "clock_beside", &[part]);
    }
}

/// Two copies of a library, with the name of GLib's for the bus of the session and with another.
fn the_system_understands_the_number_of_the_process() {
    let folder = scratch("number");
    let copies = ["libgio-2.0.so.0", "libother.so"].map(|name| {
        let copy = folder.join(name);
        std::fs::copy(preload("own_number"), &copy).expect("a library can be copied");
        copy.to_str().expect("a UTF-8 path").to_owned()
    });
    checks_itself("clock_process", &[&copies[0], &copies[1]]);
}

fn two_runs_are_equal() {
    let options = ["--clock", "60", "--seed", "7"];
    let (Some(one), Some(other)) = (by_time("draw", &options), by_time("draw", &options)) else { return };
    assert_eq!(answers(&one), answers(&other));
    expect_identical_captures(&one, &other, "two runs with a clock");
    for (frame, time) in times(&one).iter().enumerate() {
        assert!((time - frame as f64 / 60.0).abs() < 2e-9, "frame {frame} is at {time} s");
    }
}

/// Negative control of the test above.
fn without_the_clock_two_runs_differ() {
    let (Some(one), Some(other)) = (by_time("draw", &[]), by_time("draw", &[])) else { return };
    assert_ne!(answers(&one), answers(&other));
    let [one, other] = [one, other].map(|run| run.picture("capture.png"));
    assert!(one.difference(&other).0 > 0, "two pictures of different times are equal");
}

fn another_seed_gives_other_numbers() {
    let (Some(one), Some(other)) =
        (by_time("draw", &["--clock", "24"]), by_time("draw", &["--clock", "24", "--seed", "1"]))
    else {
        return;
    };
    assert_eq!(times(&one), times(&other));
    let numbers = |run: &Finished| {
        answers(run).lines().map(|line| line.split(' ').skip(6).collect::<String>()).collect::<Vec<_>>()
    };
    assert!(numbers(&one).iter().zip(numbers(&other)).all(|(one, other)| *one != other));
}

fn a_wait_within_a_frame_moves_no_frame() {
    let Some(run) = by_time("sleep", &["--clock", "60"]) else { return };
    for (frame, time) in times(&run).iter().enumerate() {
        assert!((time - frame as f64 / 60.0).abs() < 2e-9, "frame {frame} is at {time} s");
    }
}

/// A program that limits itself to 30 frames per second shows each frame for two frames of a
/// display of 60.
fn limiters_keep_their_rate() {
    for mode in ["limit", "spin"] {
        let Some(run) = by_time(mode, &["--clock", "60"]) else { return };
        for (frame, time) in times(&run).iter().enumerate() {
            // The program's shortest sleep is a millisecond.
            assert!((time - frame as f64 / 30.0).abs() < 1.1e-3, "{mode}: frame {frame} is at {time} s");
        }
    }
}
