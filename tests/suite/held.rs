//! A program whose time is held: `cupola run --pause`, `cupola ctl pause`, `resume` and `step`, with
//! a server and without.

use crate::display::{self, Place};
use crate::harness::tests;
use crate::nodes::until;
use crate::programs::{Run, built, library, scratch};
use cupola::ring::{Frame, Next, Reader};
use std::net::UdpSocket;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

tests! {
    single_frames_are_those_of_a_run_that_is_not_held,
    a_program_that_waits_for_its_next_frame_gets_it_by_steps,
    a_server_holds_its_program,
    what_cannot_be_held_is_refused,
}

/// Nanoseconds of the program's clock at its start.
const START: u64 = 1_000_000_000_000;

/// A running command of Cupola, whose program publishes its frames.
struct Running {
    child: Child,
    directory: PathBuf,
    _place: Place,
}

impl Running {
    fn start(command: &str, options: &[&str], mode: &str) -> Option<Self> {
        Self::start_in(&[], command, options, mode)
    }

    fn start_in(environment: &[(&str, &str)], command: &str, options: &[&str], mode: &str) -> Option<Self> {
        let display = display::get()?;
        let directory = scratch("held");
        let run = Run { frames: 0, size: (96, 96), extra: &["--mode", mode], ..Run::new("by_time") };
        let place = display::place();
        let mut cupola = Command::new(env!("CARGO_BIN_EXE_cupola"));
        cupola.args([command, "--rig", "fisheye", "--clock", "60"]).args(options).arg("--");
        cupola.arg(built().join(run.program)).args(run.arguments(&place));
        cupola.env("CUPOLA_LIBRARY", library()).env("DISPLAY", &display.name).env("LIBGL_ALWAYS_SOFTWARE", "1");
        cupola.env("CUPOLA_CACHE", Path::new(env!("CARGO_TARGET_TMPDIR")).join("results")).current_dir(&directory);
        cupola.env("XDG_RUNTIME_DIR", &directory).envs(environment.iter().copied());
        let log = std::fs::File::create(directory.join("log")).expect("a file");
        let child = cupola.stderr(log).stdin(Stdio::null()).stdout(Stdio::null()).spawn().expect("cupola starts");
        Some(Self { child, directory, _place: place })
    }

    fn run(options: &[&str], mode: &str) -> Option<Self> {
        Self::start("run", &[options, &["--publish=ring"]].concat(), mode)
    }

    fn log(&self) -> String {
        std::fs::read_to_string(self.directory.join("log")).unwrap_or_default()
    }

    fn reader(&self, file: &Path) -> Reader {
        until("the program publishes frames", || Reader::open(&self.directory.join(file)).ok())
    }

    /// Runs `cupola ctl` and returns what it prints.
    fn control(&self, arguments: &[&str]) -> Result<String, String> {
        let mut control = Command::new(env!("CARGO_BIN_EXE_cupola"));
        control.env("XDG_RUNTIME_DIR", &self.directory).arg("ctl").args(arguments);
        let output = control.output().expect("cupola starts");
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().to_owned();
        if output.status.success() { Ok(text(&output.stdout)) } else { Err(text(&output.stderr)) }
    }

    /// As [`Self::control`], for the program without a server.
    fn own(&self, arguments: &[&str]) -> String {
        let number = self.child.id().to_string();
        let printed = self.control(&[&["--run", &number], arguments].concat());
        printed.unwrap_or_else(|error| panic!("{error}\n{}", self.log()))
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // The command ends its program when a signal asks it to end.
        crate::nodes::kill("TERM", self.child.id());
        let _ = self.child.wait();
    }
}

/// The next frame: its number on the display, and its picture.
fn next(reader: &mut Reader) -> (u64, Vec<u8>) {
    let mut frame = Frame::default();
    let came = reader.next(Duration::from_secs(40), &mut frame).expect("frames");
    assert_eq!(came, Next::Frame);
    (((frame.time - START) * 60 + 500_000_000) / 1_000_000_000, std::mem::take(&mut frame.pictures[0].rgba))
}

/// The next frames until `count` of the frame with this number have come; earlier ones are counted.
fn reach(reader: &mut Reader, number: u64, count: usize) -> (Vec<u64>, Vec<Vec<u8>>) {
    let (mut earlier, mut pictures) = (Vec::new(), Vec::new());
    while pictures.len() < count {
        let (found, picture) = next(reader);
        assert!(found <= number, "frame {found} after {number}");
        if found == number {
            pictures.push(picture);
        } else if earlier.last() != Some(&found) {
            earlier.push(found);
        }
    }
    (earlier, pictures)
}

fn all_equal(pictures: &[Vec<u8>], expected: &[u8]) -> bool {
    pictures.iter().all(|picture| picture == expected)
}

fn single_frames_are_those_of_a_run_that_is_not_held() {
    let options = ["--publish=ring", "--frames", "12"];
    let Some(free) = Running::start_in(&[("CUPOLA_PUBLISH_WAIT", "1")], "run", &options, "steady") else { return };
    let mut reader = free.reader(Path::new("ring"));
    let expected: std::collections::BTreeMap<u64, Vec<u8>> = (0..8).map(|_| next(&mut reader)).collect();
    drop((reader, free));
    let Some(held) = Running::run(&["--pause"], "steady") else { return };
    let mut reader = held.reader(Path::new("ring"));
    let first = reach(&mut reader, 0, 6).1;
    assert!(all_equal(&first, &first[0]), "the picture moves although its time stands");
    assert_eq!(held.own(&["step", "3"]), "time stands at frame 3, 0.0500 s");
    let (earlier, third) = reach(&mut reader, 3, 6);
    assert!(earlier.starts_with(&[0]) && earlier.is_sorted(), "{earlier:?}");
    assert!(all_equal(&third, &third[0]) && third[0] != first[0]);
    assert_eq!(held.own(&["step"]), "time stands at frame 4, 0.0667 s");
    let fourth = reach(&mut reader, 4, 2).1;
    for (number, picture) in [(0, &first[0]), (3, &third[0]), (4, &fourth[0])] {
        assert!(*picture == expected[&number], "frame {number} differs from that of a run that is not held");
    }
    assert!(expected.values().zip(expected.values().skip(1)).all(|(one, other)| one != other));
    // Control: time that goes on changes the picture.
    assert!(held.own(&["resume"]).starts_with("time goes on at frame"));
    until("time goes on", || (next(&mut reader).0 > 20).then_some(()));
    let words = held.own(&["pause"]);
    let number: u64 = words
        .strip_prefix("time stands at frame ")
        .and_then(|rest| rest.split(',').next()?.parse().ok())
        .unwrap_or_else(|| panic!("{words}"));
    let pictures = reach(&mut reader, number, 4).1;
    assert!(all_equal(&pictures, &pictures[0]));
}

/// Programs that wait for a moment of their own: by sleeping until it comes, by asking again and
/// again, and by a sleep in each frame. The first two wait after they have drawn, so that a picture
/// is complete when the time of the next one has come.
fn a_program_that_waits_for_its_next_frame_gets_it_by_steps() {
    for (mode, first, steps, then, stands) in
        [("limit", 2, "4", 4, false), ("spin", 2, "4", 4, false), ("sleep", 1, "3", 4, true)]
    {
        let Some(held) = Running::run(&["--pause"], mode) else { return };
        let number = held.child.id().to_string();
        let ask = |request: &[&str]| {
            let printed = held.control(&[&["--run", &number, "--json"], request].concat()).ok()?;
            serde_json::from_str::<serde_json::Value>(&printed).ok()
        };
        let drawn = || ask(&["pause"]).filter(|state| state["frame"].is_u64());
        let state = until("the first frame is complete", drawn);
        assert!(state["frame"] == first && state["held"] == true, "{mode}: {state}");
        let state = ask(&["step", steps]).expect("a state");
        assert!(state["frame"] == then && state["stands"] == stands, "{mode}: {state}");
    }
}

/// A message of OSC with a whole number.
fn message(address: &str, number: i32) -> Vec<u8> {
    let mut bytes = address.as_bytes().to_vec();
    bytes.resize((bytes.len() / 4 + 1) * 4, 0);
    bytes.extend(b",i\0\0");
    bytes.extend(number.to_be_bytes());
    bytes
}

fn a_server_holds_its_program() {
    let options = ["--pause", "--port", "0", "--osc", "0"];
    let Some(server) = Running::start("serve", &options, "steady") else { return };
    let frame = |words: &str| until(words, || server.control(&["stats"]).ok().filter(|text| text.contains(words)));
    frame("time stands at frame 0,");
    assert_eq!(server.control(&["step", "2"]), Ok("time stands at frame 2, 0.0333 s".into()));
    let log = server.log();
    let port = log.lines().find_map(|line| line.strip_prefix("cupola: OSC at ")).expect("an address");
    let socket = UdpSocket::bind("127.0.0.1:0").expect("a socket");
    socket.send_to(&message("/cupola/step", 5), port).expect("sent");
    frame("time stands at frame 7,");
    socket.send_to(b"/cupola/resume\0\0,\0\0\0", port).expect("sent");
    until("time goes on", || {
        let state = server.control(&["--json", "stats"]).ok()?;
        let state: serde_json::Value = serde_json::from_str(&state).ok()?;
        (state["clock"]["held"] == false && state["clock"]["frame"].as_u64() > Some(20)).then_some(())
    });
    assert!(server.control(&["pause"]).expect("held").starts_with("time stands at frame"));
    let state = server.control(&["--json", "pause"]).expect("held");
    let state: serde_json::Value = serde_json::from_str(&state).expect("JSON");
    assert!(state["held"] == true && state["frame"].as_u64() > Some(20), "{state}");
}

fn what_cannot_be_held_is_refused() {
    let cupola = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_cupola"));
        let output =
            command.env("XDG_RUNTIME_DIR", scratch("nothing")).args(arguments).output().expect("cupola starts");
        assert!(!output.status.success(), "{arguments:?}");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    assert!(cupola(&["run", "--pause", "true"]).contains("--clock"));
    assert!(cupola(&["record", "--pause", "--frames", "2", "--out", "x", "true"]).contains("--clock"));
    assert!(
        cupola(&["node", "--local", "2", "--clock", "60", "--pause", "true"]).contains("--pause: the time of several")
    );
    assert!(cupola(&["ctl", "--run", "1", "step"]).contains("--run 1: no cupola run"));
}
