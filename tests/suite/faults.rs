//! Faults of the driver: whatever the driver refuses or lacks, the program keeps running and shows
//! its own picture.
//!
//! `tests/apps/preload/calls.c` is between Cupola and the driver and has one fault in each run. The
//! rig does not change the picture. So the window must show the same as without Cupola, whether
//! Cupola gives up because of the fault or not. `CUPOLA_ALL_FAULTS=1` tries each fault instead of a
//! sample.

use crate::harness::{note, tests};
use crate::picture::Picture;
use crate::programs::{Run, vendor};
use std::collections::BTreeMap;

tests! {
    calls_that_are_refused,
    functions_that_are_missing,
    answers_that_are_absurd,
    a_fault_of_the_program_s_own_calls_is_seen,
}

const RIG: &str = "identity-captured";

/// Results of a run of the program.
struct Outcome {
    succeeded: bool,
    window: Picture,
    /// Number of calls of each function.
    calls: BTreeMap<String, u64>,
    /// The text on stderr.
    words: String,
}

/// Whether a window shows the program's own picture. Cupola rounds colours between vertices in
/// another order.
fn is_own(window: &Picture, right: &Picture) -> bool {
    let (_, worst) = window.difference(right);
    worst <= 1
}

/// Runs the program with a rig and a driver that has the fault. `None` if that is not possible.
fn run(rig: &str, fault: &str) -> Option<Outcome> {
    let folder = vendor()?;
    let environment = [
        ("LD_LIBRARY_PATH", folder),
        ("CUPOLA_GLX_REAL", "calls"),
        ("CALLS_REPORT", "calls.txt"),
        ("CALLS_FAULT", fault),
    ];
    // Four frames: the first two may be lost if the driver refuses each correction.
    let extra = ["--shot", "window.ppm"];
    let run = Run { frames: 4, cupola_frames: 1000, extra: &extra, environment: &environment, ..Run::new("immediate") };
    let finished = Run { size: (96, 96), ..run }.under(rig)?;
    let line = |line: &str| {
        let (name, number) = line.split_once(' ').expect("a name and a number");
        (name.to_owned(), number.parse().expect("a number"))
    };
    Some(Outcome {
        succeeded: finished.succeeded(),
        window: finished.picture("window.ppm"),
        calls: finished.text("calls.txt").lines().map(line).collect(),
        words: finished.words().into_owned(),
    })
}

/// Functions that Cupola calls and the program does not call, each with the number of its calls,
/// and the right picture.
fn calls_of_cupola() -> Option<(BTreeMap<String, u64>, Picture)> {
    let (plain, ours) = (run("identity", "")?, run(RIG, "")?);
    assert!(plain.succeeded && ours.succeeded, "{}", ours.words);
    assert!(is_own(&ours.window, &plain.window), "without a fault");
    let own: BTreeMap<_, _> = ours.calls.into_iter().filter(|(name, _)| !plain.calls.contains_key(name)).collect();
    assert!(own.len() > 30, "{own:?}");
    Some((own, plain.window))
}

/// Tries all faults or a sample of them, and panics with a list of those after which something is
/// wrong.
fn expect_the_own_picture(faults: &[String], sample: usize, right: &Picture) {
    let step = if std::env::var_os("CUPOLA_ALL_FAULTS").is_some() { 1 } else { faults.len().div_ceil(sample) };
    let mut wrong = Vec::new();
    let mut tried = 0;
    for fault in faults.iter().step_by(step.max(1)) {
        let Some(outcome) = run(RIG, fault) else { return };
        tried += 1;
        if !outcome.succeeded || !is_own(&outcome.window, right) {
            wrong.push(format!("{fault}: succeeded: {}; {}", outcome.succeeded, outcome.words.trim()));
        }
    }
    note(format_args!("{tried} of {} faults were tried", faults.len()));
    assert!(wrong.is_empty(), "{} of {tried} faults:\n{}", wrong.len(), wrong.join("\n"));
}

/// Whether a driver may refuse the function because it has no memory.
fn may_be_refused(function: &str) -> bool {
    const MAKES: [&str; 17] = [
        "glGen",
        "glCreate",
        "glTexStorage",
        "glTexImage",
        "glTextureView",
        "glRenderbufferStorage",
        "glBufferData",
        "glBufferStorage",
        "glMap",
        "glCompileShader",
        "glLinkProgram",
        "glCheckFramebufferStatus",
        "glDraw",
        "glBlit",
        "glGetProgramBinary",
        "glFramebuffer",
        "glFenceSync",
    ];
    MAKES.iter().any(|start| function.starts_with(start))
}

fn calls_that_are_refused() {
    let Some((own, right)) = calls_of_cupola() else { return };
    let mut faults = Vec::new();
    for (name, calls) in own.iter().filter(|(name, _)| may_be_refused(name)) {
        faults.extend((1..=*calls).map(|call| format!("call {name} {call} {call}")));
        faults.push(format!("call {name} 1 {}", u32::MAX));
    }
    expect_the_own_picture(&faults, 16, &right);
}

fn functions_that_are_missing() {
    let Some((own, right)) = calls_of_cupola() else { return };
    // Cupola repeats the program's vertices with other functions of OpenGL 1.0 than the program
    // used.
    let repeats =
        |name: &str| name.starts_with("glColor") || name.starts_with("glVertex3") || name.starts_with("glVertex4");
    let faults: Vec<_> = own.keys().filter(|name| !repeats(name)).map(|name| format!("missing {name}")).collect();
    expect_the_own_picture(&faults, 12, &right);
}

fn answers_that_are_absurd() {
    let Some((_, right)) = calls_of_cupola() else { return };
    let mut faults = Vec::new();
    // GL_MAX_TEXTURE_SIZE, _RENDERBUFFER_SIZE, _VIEWPORT_DIMS, _SAMPLES, _TEXTURE_IMAGE_UNITS,
    // _COMBINED_TEXTURE_IMAGE_UNITS, _COLOR_ATTACHMENTS, _DRAW_BUFFERS, _VERTEX_ATTRIBS;
    // GL_NUM_EXTENSIONS, _MAJOR_VERSION, _MINOR_VERSION.
    for number in [0x0D33, 0x84E8, 0x0D3A, 0x8D57, 0x8872, 0x8B4D, 0x8CDF, 0x8824, 0x8869, 0x821D, 0x821B, 0x821C] {
        faults.extend([0, 1, 64, -1, i32::MAX].map(|value| format!("number {number:#x} {value}")));
    }
    // GL_VERSION, _RENDERER, _VENDOR, _SHADING_LANGUAGE_VERSION, _EXTENSIONS.
    for string in [0x1F02, 0x1F01, 0x1F00, 0x8B8C, 0x1F03] {
        faults.extend(["0", "nonsense", "99.9 of a liar", "1.0"].map(|text| format!("string {string:#x} {text}")));
    }
    // GL_COMPILE_STATUS, GL_LINK_STATUS, GL_INFO_LOG_LENGTH.
    for status in [0x8B81, 0x8B82, 0x8B84] {
        faults.extend([0, -1].map(|value| format!("status {status:#x} {value}")));
    }
    expect_the_own_picture(&faults, 12, &right);
}

/// Negative control: calls with which the program itself draws are refused. The test must notice
/// it.
fn a_fault_of_the_program_s_own_calls_is_seen() {
    let Some(right) = run("identity", "") else { return };
    let Some(refused) = run("identity", "call glBegin 1 1000") else { return };
    assert!(!refused.succeeded || !is_own(&refused.window, &right.window));
}
