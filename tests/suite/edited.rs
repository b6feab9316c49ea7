//! A rig that is edited while somebody watches the published pictures.

use crate::harness::{note, tests};
use crate::picture::Picture;
use crate::programs::{Finished, Run, scratch};
use cupola::ring::{Frame, Next, Reader, text_sum};
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::{Duration, Instant};

tests! {
    an_edited_rig_is_shown_at_once_and_exactly_when_it_rests,
    an_edited_rig_is_shown_at_once_and_exactly_when_it_rests_on_vulkan,
}

const LIMIT: Duration = Duration::from_secs(20);
/// Difference of a colour that counts, of 255.
const FAR: u8 = 40;

/// Pictures of the first projector: before the change, the first one of the changed rig, and the
/// last one.
struct Watched {
    before: Picture,
    first: Picture,
    last: Picture,
}

fn picture(frame: &Frame) -> Picture {
    let found = &frame.pictures[0];
    let width = found.size.0 as usize;
    Picture::from_fn(width, found.size.1 as usize, |x, y| {
        let at = 4 * (y * width + x);
        [found.rgba[at], found.rgba[at + 1], found.rgba[at + 2]]
    })
}

/// Part of the pixels that are far from those of another picture.
fn far(found: &Picture, expected: &Picture) -> f64 {
    let pairs = found.pixels.iter().zip(&expected.pixels);
    let far = pairs.filter(|(a, b)| (0..3).any(|channel| a[channel].abs_diff(b[channel]) > FAR)).count();
    far as f64 / expected.pixels.len() as f64
}

/// A program that is watched, and how its pictures are told from rough ones.
struct Case<'a> {
    program: &'a str,
    vulkan: bool,
    name: &'a str,
    /// True for an exact picture, up to roundings.
    is_exact: fn(&Picture, &Picture) -> bool,
}

impl Case<'_> {
    fn run(&self, run: Run, rig: &str) -> Option<Finished> {
        if self.vulkan { run.vulkan_under(rig) } else { run.under(rig) }
    }
}

/// Changes the rig, and watches until the picture is `exact`. `None`: the program has ended before.
fn watch(
    ring: &Path,
    file: &Path,
    edited: &str,
    is_exact: impl Fn(&Picture) -> bool,
    has_ended: &AtomicBool,
) -> Option<Watched> {
    let mut frame = Frame::default();
    let mut reader = loop {
        match Reader::open(ring) {
            Ok(reader) => break reader,
            Err(_) if has_ended.load(Relaxed) => return None,
            Err(_) => std::thread::sleep(Duration::from_millis(5)),
        }
    };
    let mut next = |frame: &mut Frame| reader.next(LIMIT, frame).expect("frames") == Next::Frame;
    // The views are planned once more for the program's number of draws.
    for _ in 0..20 {
        next(&mut frame).then_some(())?;
    }
    let before = picture(&frame);
    let started = Instant::now();
    std::fs::write(file.with_extension("next"), edited).expect("written");
    std::fs::rename(file.with_extension("next"), file).expect("renamed");
    while frame.rig != text_sum(edited.as_bytes()) {
        next(&mut frame).then_some(())?;
    }
    let first = picture(&frame);
    note(format_args!("the first picture of the changed rig comes after {:?}", started.elapsed()));
    while !is_exact(&picture(&frame)) && started.elapsed() < LIMIT {
        next(&mut frame).then_some(())?;
    }
    note(format_args!("the exact one after {:?}", started.elapsed()));
    Some(Watched { before, first, last: picture(&frame) })
}

fn an_edited_rig_is_shown_at_once_and_exactly_when_it_rests() {
    let is_exact = |found: &Picture, exact: &Picture| found.difference(exact).0 * 1000 <= exact.pixels.len();
    Case { program: "core330_mvp", vulkan: false, name: "edited", is_exact }.is_shown_at_once();
}

/// The window keeps its views, so even its exact picture has texels of other views.
fn an_edited_rig_is_shown_at_once_and_exactly_when_it_rests_on_vulkan() {
    let is_exact = |found: &Picture, exact: &Picture| found.difference(exact).1 <= 8;
    Case { program: "vk_cube", vulkan: true, name: "edited-vulkan", is_exact }.is_shown_at_once();
}

impl Case<'_> {
    fn is_shown_at_once(&self) {
        let directory = scratch(self.name);
        let (file, ring) = (directory.join("rig.toml"), directory.join("ring"));
        let preset = cupola::rig::presets().iter().find(|preset| preset.name == "planetarium-2").expect("a preset");
        let edited = preset.text.replace("pitch = 35.00", "pitch = 38.00");
        let run = Run { size: (512, 160), frames: 20, cupola_frames: 0, ..Run::new(self.program) };
        std::fs::write(&file, &edited).expect("a rig");
        let rig = file.to_string_lossy();
        let Some(exact) = self.run(run.clone(), &rig) else { return };
        let exact = exact.expect_success().picture("capture-front.png");
        std::fs::write(&file, preset.text).expect("a rig");
        let publish = format!("--publish={}", ring.display());
        let environment = [("APP_WAIT", "."), ("CUPOLA_PUBLISH_RATE", "1000")];
        let run = Run { cupola: &[&publish], environment: &environment, directory: Some(&directory), ..run };
        let has_ended = AtomicBool::new(false);
        let (finished, watched) = std::thread::scope(|scope| {
            let watcher = scope.spawn(|| {
                let watched = watch(&ring, &file, &edited, |found| (self.is_exact)(found, &exact), &has_ended);
                std::fs::write(directory.join("end"), "").expect("a file that ends the program");
                watched
            });
            let finished = self.run(run, &rig);
            has_ended.store(true, Relaxed);
            (finished, watcher.join().expect("a watcher"))
        });
        let Some(finished) = finished else { return };
        finished.expect_success().expect_no_gl_errors();
        let Watched { before, first, last } = watched.expect("pictures of the changed rig");
        let [changed, rough] = [&before, &first].map(|picture| far(picture, &exact));
        note(format_args!("far from the exact picture: {changed:.4} before the change, {rough:.4} after it"));
        let [rough_differs, last_differs] = [&first, &last].map(|picture| picture.difference(&exact));
        note(format_args!(
            "pixels that differ: {rough_differs:?} in the first picture, {last_differs:?} in the last one"
        ));
        assert!((self.is_exact)(&last, &exact), "the exact picture does not come");
        // Parts that no view showed are black. Negative control: the picture before the change.
        assert!(rough < 0.01 && changed > 0.03, "{changed} {rough}");
        assert!(!(self.is_exact)(&first, &exact), "the first picture is not a rough one");
    }
}
