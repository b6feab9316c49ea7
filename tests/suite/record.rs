//! `cupola record`: two recordings are equal, and an interrupted recording can be continued.

use crate::display;
use crate::harness::tests;
use crate::programs::{Finished, Run, built, library, scratch};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

tests! {
    two_recordings_are_equal,
    an_interrupted_recording_goes_on,
    several_outputs_have_a_folder_each,
}

const FRAMES: usize = 6;

/// Records a program that moves by time and random numbers. The program itself draws `drawn`
/// frames.
fn record(out: &Path, drawn: usize, options: &[&str]) -> Option<Finished> {
    let run = Run { frames: drawn, size: (96, 96), ..Run::new("by_time") };
    let mut command = Command::new(env!("CARGO_BIN_EXE_cupola"));
    command.env("CUPOLA_LIBRARY", library()).arg("record").args(options);
    command.args(["--frames", &FRAMES.to_string(), "--out"]).arg(out).arg("--");
    let place = display::place();
    command.arg(built().join(run.program)).args(run.arguments(&place));
    Finished::of(command, run.program, "record")
}

/// Names and contents of the files of a recording.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let name = |path: &Path| path.file_name().expect("a name").to_string_lossy().into_owned();
    entries.map(|path| (name(&path), std::fs::read(&path).expect("a file"))).collect()
}

fn two_recordings_are_equal() {
    let folder = scratch("record");
    let (one, other, third) = (folder.join("one"), folder.join("other"), folder.join("third"));
    let seed = ["--name", "Show", "--capture", "capture.png", "--seed", "7"];
    let Some(finished) = record(&one, FRAMES, &seed) else { return };
    let finished = finished.expect_success();
    let Some(again) = record(&other, FRAMES, &seed) else { return };
    again.expect_success();
    let (one, other) = (files(&one), files(&other));
    let names: Vec<String> = (1..=FRAMES).map(|number| format!("Show_{number:06}.png")).collect();
    assert_eq!(one.keys().collect::<Vec<_>>(), names.iter().collect::<Vec<_>>());
    assert!(one == other, "two recordings differ");
    let last = image::load_from_memory(&one[&names[FRAMES - 1]]).expect("a picture").into_rgb8();
    let captured = image::open(finished.directory.join("capture.png")).expect("a picture").into_rgb8();
    assert!(last == captured, "the last frame is not the captured one");
    // Controls: the pictures change. They differ for another date, from which the random numbers
    // start.
    assert!(one[&names[0]] != one[&names[1]] && one[&names[1]] != one[&names[2]]);
    let Some(another) = record(&third, FRAMES, &["--name", "Show", "--clock-start", "2010-01-01"]) else { return };
    another.expect_success();
    assert!(one != files(&third));
}

fn an_interrupted_recording_goes_on() {
    let folder = scratch("resume");
    let (whole, parts) = (folder.join("whole"), folder.join("parts"));
    let Some(finished) = record(&whole, FRAMES, &[]) else { return };
    finished.expect_success();
    let Some(finished) = record(&parts, 3, &[]) else { return };
    assert!(!finished.succeeded() && finished.words().contains("after 3 of 6 frames"), "{}", finished.words());
    let Some(finished) = record(&parts, FRAMES, &[]) else { return };
    let finished = finished.expect_success();
    assert!(finished.words().contains("goes on with frame 4"), "{}", finished.words());
    let all = files(&whole);
    assert!(all == files(&parts), "the recording in two parts differs");
    // The folder of another recording stays unchanged.
    std::fs::remove_file(parts.join(all.keys().next_back().expect("a file"))).expect("removed");
    let before = files(&parts);
    let Some(finished) = record(&parts, FRAMES, &["--clock-start", "2010-01-01"]) else { return };
    assert!(!finished.succeeded() && finished.words().contains("shows another picture"), "{}", finished.words());
    assert!(before == files(&parts));
}

fn several_outputs_have_a_folder_each() {
    let folder = scratch("outputs");
    let Some(finished) = record(&folder, FRAMES, &["--rig", "planetarium-2"]) else { return };
    finished.expect_success();
    let rig = cupola::rig::load("planetarium-2").expect("a preset");
    assert_eq!(rig.outputs.len(), 2);
    for output in &rig.outputs {
        assert_eq!(files(&folder.join(&output.name)).len(), FRAMES, "{}", output.name);
    }
    let beside = scratch("domemaster");
    let Some(finished) = record(&beside, FRAMES, &["--rig", "planetarium-2", "--domemaster", "64"]) else { return };
    finished.expect_success();
    let first = image::open(beside.join("domemaster_000001.png")).expect("a picture");
    assert_eq!((first.width(), first.height(), files(&beside).len()), (64, 64, FRAMES));
}
