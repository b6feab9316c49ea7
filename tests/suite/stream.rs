//! Pictures for other programs: `cupola stream` and `cupola record --pipe`.

use crate::display;
use crate::harness::tests;
use crate::programs::{Finished, Run, built, library, scratch};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

tests! {
    a_slow_receiver_loses_frames_that_are_counted,
    a_recording_to_a_command_has_each_frame,
    without_the_feature_it_is_said_how_to_get_pipewire,
}

const SIDE: usize = 96;

/// Command that writes the numbers that are painted into pictures to `file`.
fn reader(slow: usize, file: &Path) -> String {
    format!("{} {SIDE} {SIDE} {slow} > {}", built().join("index_reader").display(), file.display())
}

/// Numbers that the command has written.
fn numbers(file: &Path) -> Vec<u64> {
    let text = std::fs::read_to_string(file).unwrap_or_default();
    text.lines().filter_map(|line| line.split(' ').next()?.parse().ok()).collect()
}

/// A program that paints the number of each frame into the picture.
fn painting(frames: usize, rate: &'static str) -> Run<'static> {
    Run {
        size: (SIDE, SIDE),
        frames,
        extra: if rate == "200" { &["--mode", "200"] } else { &[] },
        ..Run::new("frame_index")
    }
}

/// Runs the program and streams its frames to a reader that takes `slow` milliseconds per frame.
/// Returns the numbers that the reader got, and the statistics of the stream.
fn streamed(slow: usize) -> Option<(Vec<u64>, serde_json::Value)> {
    let folder = scratch("stream");
    let (ring, file, stats) = (folder.join("ring"), folder.join("numbers"), folder.join("stats.json"));
    let mut stream = Command::new(env!("CARGO_BIN_EXE_cupola"));
    stream
        .args(["stream", "--format", "raw", "--fps", "1000", "--pipe", &reader(slow, &file), "--published"])
        .arg(&ring);
    let mut stream = stream.arg("--stats").arg(&stats).stderr(Stdio::null()).spawn().expect("cupola starts");
    let publish = format!("--publish={}", ring.display());
    let run = Run { cupola: &[publish.as_str()], cupola_frames: 0, ..painting(200, "200") };
    let Some(finished) = run.under("identity") else {
        stream.kill().and_then(|()| stream.wait()).expect("it ends");
        return None;
    };
    // The program has drawn all its frames, so it did not wait for the reader.
    finished.expect_success();
    assert!(stream.wait().expect("it ends").success());
    let stats = std::fs::read(stats).expect("statistics");
    Some((numbers(&file), serde_json::from_slice(&stats).expect("JSON")))
}

/// Number of frames that were lost. `None` if the numbers are not in order.
fn lost(numbers: &[u64]) -> Option<u64> {
    let is_in_order = numbers.windows(2).all(|pair| pair[0] < pair[1]);
    is_in_order
        .then(|| numbers.last().zip(numbers.first()).map_or(0, |(last, first)| last - first + 1) - numbers.len() as u64)
}

fn a_slow_receiver_loses_frames_that_are_counted() {
    let Some((slow, counted)) = streamed(40) else { return };
    let number = |key: &str| counted[key].as_u64().unwrap_or_else(|| panic!("{key}: {counted}"));
    let expected = |numbers: &[u64]| lost(numbers).map(|lost| (numbers.len() as u64, lost));
    // A frame may also be lost before the first one that was read.
    let sent = (number("sent"), number("lost") + number("not_published"));
    assert!(
        expected(&slow).is_some_and(|(read, lost)| read == sent.0 && lost <= sent.1 && lost + 4 > sent.1),
        "{counted}: {slow:?}"
    );
    assert!(number("lost") > 20 && slow.last() > Some(&150), "{counted}: {slow:?}");
    // Negative control: numbers in another order. Control: a fast reader gets more frames.
    let mut wrong = slow.clone();
    wrong.swap(3, 4);
    assert_eq!(expected(&wrong), None);
    let Some((fast, counted)) = streamed(0) else { return };
    assert!(fast.len() > 2 * slow.len(), "{counted}: {fast:?}");
}

fn a_recording_to_a_command_has_each_frame() {
    const FRAMES: usize = 5;
    let folder = scratch("pipe");
    let record = |format: &str, command: &str| {
        let run = painting(0, "");
        let mut record = Command::new(env!("CARGO_BIN_EXE_cupola"));
        record
            .env("CUPOLA_LIBRARY", library())
            .args(["record", "--rig", "identity", "--format", format, "--pipe", command]);
        record.args(["--frames", &FRAMES.to_string(), "--out"]).arg(&folder).arg("--");
        let place = display::place();
        record.arg(built().join(run.program)).args(run.arguments(&place));
        Finished::of(record, run.program, "record")
    };
    let file = |name: &str| -> PathBuf { folder.join(name) };
    let Some(read) = record("raw", &reader(0, &file("numbers"))) else { return };
    read.expect_success();
    assert_eq!(numbers(&file("numbers")), (1..=FRAMES as u64).collect::<Vec<_>>());
    for format in ["raw", "nut", "y4m"] {
        let command = format!("test $CUPOLA_WIDTH = {SIDE} && test $CUPOLA_FPS = 60/1 && cat > all.{format}");
        let Some(finished) = record(format, &command) else { return };
        finished.expect_success();
    }
    let bytes = |format: &str| std::fs::read(file(&format!("all.{format}"))).expect("a file");
    let (raw, nut, y4m) = (bytes("raw"), bytes("nut"), bytes("y4m"));
    assert_eq!(raw.len(), FRAMES * SIDE * SIDE * 4);
    let last = &raw[(FRAMES - 1) * SIDE * SIDE * 4..];
    assert!(
        nut.starts_with(b"nut/multimedia container\0") && nut.ends_with(last) && !nut.ends_with(&raw[..last.len()])
    );
    let starts = nut.windows(8).filter(|bytes| *bytes == [b'N', b'K', 0xE4, 0xAD, 0xEE, 0xCA, 0x45, 0x69]).count();
    assert_eq!(starts, FRAMES);
    let head = format!("YUV4MPEG2 W{SIDE} H{SIDE} F60:1 ");
    assert!(y4m.starts_with(head.as_bytes()));
    let line = y4m.iter().position(|byte| *byte == b'\n').expect("a line") + 1;
    assert_eq!(y4m.len() - line, FRAMES * (6 + SIDE * SIDE * 3));
    // If the command fails, the recording fails.
    let Some(failed) = record("raw", "head -c 100 > /dev/null; exit 3") else { return };
    assert!(!failed.succeeded(), "{}", failed.words());
}

fn without_the_feature_it_is_said_how_to_get_pipewire() {
    if cfg!(feature = "pipewire") {
        return;
    }
    let mut stream = Command::new(env!("CARGO_BIN_EXE_cupola"));
    let output = stream.args(["stream", "pipewire:Dome"]).output().expect("cupola starts");
    let words = String::from_utf8_lossy(&output.stderr);
    assert!(words.contains("--features pipewire") && words.contains("libpipewire-0.3-dev"), "{words}");
    assert_eq!(output.status.code(), Some(1));
}
