//! Nodes that show the pictures of node 0: `cupola node --mirror`.

use crate::display::{self, Display};
use crate::finished::Finished;
use crate::harness::{note, tests};
use crate::nodes::{are_equal, by_time, children, kill, rig, until};
use crate::programs::{Run, built, library, scratch};
use cupola::ring::{Frame, Next, Reader, Shape, Writer};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

tests! {
    mirrors_show_what_one_process_shows,
    a_mirror_that_is_stopped_loses_frames_and_delays_nothing,
    a_mirror_that_is_killed_leaves_the_others,
    a_mirror_leaves_the_pictures_of_others_alone,
}

fn mirrors_show_what_one_process_shows() {
    let rig = rig();
    let published = format!("--publish={}", scratch("mirrors").join("ring").display());
    let mut before = None;
    for frames in [20, 40] {
        let clock = ["--clock", "60", "--seed", "7"];
        let nodes = ["node", "--local", "3", "--mirror", "--headless", &published];
        let Some(nodes) = by_time(&rig, "draw", frames, &[&nodes[..], &clock].concat()) else { return };
        let Some(one) = by_time(&rig, "draw", frames, &[&["run"][..], &clock].concat()) else { return };
        let words = nodes.words();
        assert!(are_equal(&rig, &nodes, &one), "frame {frames}: {words}");
        assert!(words.contains("node 1 of 3") && words.contains("node 2 has received"), "{words}");
        // Control: the pictures move.
        assert!(before.is_none_or(|before| !are_equal(&rig, &before, &nodes)));
        before = Some(nodes);
    }
}

/// Two nodes on a screen of their own: the program `by_time`, which does not end, and a mirror.
struct Show {
    launcher: Child,
    other: Display,
    directory: PathBuf,
    /// Commands of node 0 and of node 1.
    nodes: Vec<u32>,
    program: u32,
}

impl Show {
    fn start() -> Option<Self> {
        let other = display::own(24)?;
        let run = Run { frames: 0, size: (96, 96), extra: &["--mode", "draw"], ..Run::new("by_time") };
        let directory = scratch("mirror");
        let mut command = Command::new(env!("CARGO_BIN_EXE_cupola"));
        command.args(["node", "--local", "2", "--mirror", "--publish=ring", "--rig"]).arg(rig()).arg("--");
        let place = display::place();
        command.arg(built().join(run.program)).args(run.arguments(&place));
        command.env("CUPOLA_LIBRARY", library()).env("DISPLAY", &other.name).env("LIBGL_ALWAYS_SOFTWARE", "1");
        command.env("CUPOLA_CACHE", Path::new(env!("CARGO_TARGET_TMPDIR")).join("results")).current_dir(&directory);
        let log = std::fs::File::create(directory.join("log")).expect("a file");
        command.stderr(log).stdin(Stdio::null()).stdout(Stdio::null());
        let launcher = command.spawn().expect("cupola starts");
        let nodes =
            until("the nodes start", || Some(children(launcher.id(), "cupola")).filter(|nodes| nodes.len() == 2));
        let mut show = Self { launcher, other, directory, nodes, program: 0 };
        show.program =
            until(&show.words(), || show.nodes.iter().find_map(|node| children(*node, "by_time").first().copied()));
        if children(show.nodes[0], "by_time").is_empty() {
            show.nodes.reverse();
        }
        Some(show)
    }

    fn words(&self) -> String {
        std::fs::read_to_string(self.directory.join("log")).expect("a log")
    }

    fn says(&self, words: &str) {
        until(&format!("{words}:\n{}", self.words()), || self.words().contains(words).then_some(()));
    }

    fn frames(&self, ring: &str) -> Frames {
        let reader = until(ring, || Reader::open_at_newest(&self.directory.join(ring)).ok());
        Frames { reader, frame: Frame::default() }
    }
}

impl Drop for Show {
    fn drop(&mut self) {
        for process in [self.launcher.id(), self.nodes[0], self.nodes[1], self.program] {
            let _ = Command::new("sh").args(["-c", &format!("kill -s KILL {process} 2>/dev/null")]).status();
        }
        let _ = self.launcher.wait();
    }
}

/// Published frames.
struct Frames {
    reader: Reader,
    frame: Frame,
}

impl Frames {
    /// Waits for the next frame that the reader has not lost.
    fn next(&mut self) -> &Frame {
        until("a frame is published", || {
            (self.reader.next(Duration::from_millis(50), &mut self.frame).expect("a ring") == Next::Frame).then_some(())
        });
        &self.frame
    }

    /// True if no frame comes for a while.
    fn has_nothing(&mut self) -> bool {
        self.reader.next(Duration::from_millis(200), &mut self.frame).expect("a ring") == Next::Nothing
    }

    /// Skips to the newest frame.
    fn newest(&mut self) -> &Frame {
        self.reader.skip_to_newest();
        self.next()
    }
}

fn a_mirror_that_is_stopped_loses_frames_and_delays_nothing() {
    let Some(show) = Show::start() else { return };
    let (mut of_program, mut of_mirror) = (show.frames("ring"), show.frames("ring-mirror-1"));
    // The same frame has the same pixels on both sides.
    let (mut drawn, mut mirrored) = (BTreeMap::new(), BTreeMap::new());
    until("five frames are read on both sides", || {
        for (reader, frames) in [(&mut of_program, &mut drawn), (&mut of_mirror, &mut mirrored)] {
            let frame = reader.next().clone();
            frames.insert(frame.index, frame.pictures);
            if frames.len() > 200 {
                frames.pop_first();
            }
        }
        (drawn.keys().filter(|index| mirrored.contains_key(index)).count() >= 5).then_some(())
    });
    for (index, pictures) in &mirrored {
        assert_eq!(pictures.len(), 3);
        let Some(drawn) = drawn.get(index) else { continue };
        assert!(pictures.iter().all(|picture| drawn.contains(picture)), "frame {index}");
    }
    // Control: the pictures move.
    let frames: Vec<_> = mirrored.values().collect();
    assert!(frames.windows(2).any(|pair| pair[0] != pair[1]));
    // The windows are on the screen, beside each other.
    let (width, height) = (96, 54);
    until("the windows show the mirror's pictures", || {
        let frame = of_mirror.newest().clone();
        let pixels = show.other.pixels((2 * width, 2 * height));
        let place = |number: usize| (number % 2 * width as usize, number / 2 * height as usize);
        let is_there = |(number, picture): (usize, &cupola::ring::Picture)| {
            let (left, top) = place(number);
            picture.rgba.as_chunks::<4>().0.iter().enumerate().all(|(index, rgba)| {
                let (x, y) = (left + index % width as usize, top + index / width as usize);
                pixels[y * 2 * width as usize + x][..] == rgba[..3]
            })
        };
        frame.pictures.iter().enumerate().all(is_there).then_some(())
    });
    // A mirror that is stopped: the program draws on.
    kill("STOP", show.nodes[1]);
    let stopped = of_program.newest().index;
    until("the program draws on", || (of_program.newest().index > stopped + 100).then_some(()));
    // What was on its way may have come.
    until("the mirror has stopped", || of_mirror.has_nothing().then_some(()));
    kill("CONT", show.nodes[1]);
    let now = of_program.newest().index;
    until("the mirror goes on", || (of_mirror.newest().index > now).then_some(()));
    // The end of the program is the end of the mirror.
    kill("TERM", show.program);
    show.says("node 1 has received");
    let words = show.words();
    note(format_args!("{words}"));
    let lost = words.split("and lost ").nth(1).and_then(|rest| rest.split_whitespace().next()?.parse::<u64>().ok());
    assert!(lost.is_some_and(|lost| lost > 50), "{words}");
    until("the mirror's file is removed", || (!show.directory.join("ring-mirror-1").exists()).then_some(()));
    assert!(!words.contains("unexpectedly") && !words.contains("cannot be reached"), "{words}");
}

fn a_mirror_that_is_killed_leaves_the_others() {
    let Some(show) = Show::start() else { return };
    let mut of_program = show.frames("ring");
    show.frames("ring-mirror-1").newest();
    kill("KILL", show.nodes[1]);
    show.says("node 1 has ended unexpectedly: the others go on without it");
    let killed = of_program.newest().index;
    until("the program draws on", || (of_program.newest().index > killed + 20).then_some(()));
    // Node 0 is killed: the mirror ends with an error.
    let Some(show) = Show::start() else { return };
    show.frames("ring-mirror-1").newest();
    kill("KILL", show.nodes[0]);
    show.says("node 1: node 0 cannot be reached any more");
    until("the mirror's file is removed", || (!show.directory.join("ring-mirror-1").exists()).then_some(()));
}

/// Another program publishes pictures in the mirror's file: the mirror ends, and says why.
fn a_mirror_leaves_the_pictures_of_others_alone() {
    let folder = scratch("taken");
    let taken = folder.join("ring-mirror-1");
    let shape = Shape { name: "other".into(), size: (4, 4), format: cupola::ring::Format::Rgba8 };
    let writer = Writer::create(&taken, &[shape], 3, false).expect("a ring");
    let published = format!("--publish={}", folder.join("ring").display());
    let nodes = ["node", "--local", "2", "--mirror", "--headless", &published];
    let rig = rig();
    let mut command = Command::new(env!("CARGO_BIN_EXE_cupola"));
    command.env("CUPOLA_LIBRARY", library()).args(nodes).arg("--rig").arg(&rig).args(["--frames", "30", "--"]);
    let run = Run { frames: 0, size: (96, 96), ..Run::new("by_time") };
    let place = display::place();
    command.arg(built().join(run.program)).args(run.arguments(&place));
    let Some(finished) = Finished::of(command, run.program, "node") else { return };
    let words = finished.words();
    assert!(!finished.succeeded() && words.contains("another program publishes its frames there"), "{words}");
    assert!(Reader::open(&taken).is_ok(), "the file of the other program is gone");
    writer.end();
}
