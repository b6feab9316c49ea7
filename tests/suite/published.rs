//! Published frames: a reader gets the picture that the window shows, and all frames that it waits
//! for.

use crate::compare::expect_similar;
use crate::harness::tests;
use crate::picture::Picture;
use crate::programs::{Finished, Run, scratch};
use cupola::ring::{Format, Frame, Next, Reader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::time::Duration;

tests! {
    a_reader_gets_what_the_window_shows,
    a_domemaster_beside_the_window_is_as_one_in_it,
    vulkan_publishes_the_same,
    a_reader_in_c_gets_the_same,
    frames_that_nobody_reads_are_left_out,
    a_reader_that_is_killed_does_not_hold_a_program_that_waits,
    pictures_of_16_bits_have_more_levels,
    vulkan_publishes_16_bits,
}

const LIMIT: Duration = Duration::from_secs(60);

/// Frames that a reader got from a program.
#[derive(Default)]
struct Seen {
    indices: Vec<u64>,
    last: Frame,
    lost: u64,
}

/// Reads from the file until the program ends. Returns nothing if the program ends before it
/// publishes a frame.
fn read(path: &Path, has_ended: &AtomicBool) -> Seen {
    let (mut seen, mut frame) = (Seen::default(), Frame::default());
    let mut reader = loop {
        match Reader::open(path) {
            Ok(reader) => break reader.taking_deep(),
            Err(_) if has_ended.load(Relaxed) => return seen,
            Err(_) => std::thread::sleep(Duration::from_millis(5)),
        }
    };
    while reader.next(LIMIT, &mut frame).expect("frames") == Next::Frame {
        seen.indices.push(frame.index);
        std::mem::swap(&mut seen.last, &mut frame);
    }
    seen.lost = reader.lost();
    seen
}

/// Runs a program that waits for the reader of this test.
fn recorded(run: &Run<'_>, start: impl Fn(&Run<'_>) -> Option<Finished>, options: &[&str]) -> Option<(Finished, Seen)> {
    let file: PathBuf = scratch("published").join("ring");
    let publish = format!("--publish={}", file.display());
    let options: Vec<&str> = options.iter().copied().chain([publish.as_str()]).collect();
    let environment = [run.environment, &[("CUPOLA_PUBLISH_WAIT", "1")]].concat();
    let run = Run { cupola: &options, environment: &environment, ..run.clone() };
    let has_ended = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let reading = scope.spawn(|| read(&file, &has_ended));
        let finished = start(&run);
        has_ended.store(true, Relaxed);
        let finished = finished?.expect_success();
        let seen = reading.join().expect("a reader");
        assert!(!file.exists(), "the file is removed");
        Some((finished, seen))
    })
}

/// A live program publishes ten frames a second for later readers, and each frame while there is one.
fn frames_that_nobody_reads_are_left_out() {
    const FRAMES: usize = 600;
    let file = scratch("unread").join("ring");
    let publish = format!("--publish={}", file.display());
    let options = [publish.as_str()];
    let run = Run { frames: FRAMES, cupola_frames: FRAMES, size: (96, 96), cupola: &options, ..Run::new("by_time") };
    let under = |run: &Run<'_>| run.under("identity");
    let under_vulkan = |run: &Run<'_>| run.vulkan_under("identity");
    let of_vulkan = [publish.as_str(), "--frames", "600"];
    let usual: &dyn Fn(&Run<'_>) -> Option<Finished> = &under;
    for (program, under, cupola) in [("by_time", usual, &options[..]), ("vk_cube", &under_vulkan, &of_vulkan)] {
        let started = std::time::Instant::now();
        let Some(finished) = under(&Run { program, cupola, ..run.clone() }) else { return };
        let published = finished.expect_success().statistics()["published"]["frames"].as_u64().expect("a number");
        let most = started.elapsed().as_millis() as u64 / 100 + 2;
        assert!((1..=most).contains(&published), "{program}: {published} of {FRAMES} frames, at most {most}");
    }
    let has_ended = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let reading = scope.spawn(|| {
            let mut reader = loop {
                match Reader::open(&file) {
                    Ok(reader) => break reader,
                    Err(_) if has_ended.load(Relaxed) => return Vec::new(),
                    Err(_) => std::thread::sleep(Duration::from_millis(1)),
                }
            };
            let (mut frame, mut seen) = (Frame::default(), Vec::new());
            while reader.next(LIMIT, &mut frame).expect("frames") == Next::Frame {
                seen.push((frame.number, frame.index));
            }
            seen
        });
        let finished = under(&run);
        has_ended.store(true, Relaxed);
        let seen = reading.join().expect("a reader");
        if finished.is_some() {
            assert!(seen.len() > 50, "{} frames", seen.len());
            let step = |pair: &[(u64, u64)]| pair[1].0 - pair[0].0 == pair[1].1 - pair[0].1;
            assert!(seen.windows(2).all(step), "frames are missing: {seen:?}");
        }
    });
}

/// Sends a signal to a process.
fn signal(name: &str, process: u32) {
    let sent = Command::new("sh").args(["-c", &format!("kill -s {name} {process}")]).status();
    assert!(sent.is_ok_and(|status| status.success()), "{name} to {process}");
}

fn a_reader_that_is_killed_does_not_hold_a_program_that_waits() {
    const FRAMES: usize = 200;
    let file = scratch("killed").join("ring");
    let publish = format!("--publish={}", file.display());
    let (options, environment) = ([publish.as_str()], [("CUPOLA_PUBLISH_WAIT", "1")]);
    let run = Run {
        frames: FRAMES,
        cupola_frames: FRAMES + 1,
        size: (96, 96),
        cupola: &options,
        environment: &environment,
        ..Run::new("by_time")
    };
    let (count, has_ended) = (AtomicU64::new(0), AtomicBool::new(false));
    // The other reader has read a picture.
    let is_read = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let reading = scope.spawn(|| {
            let mut reader = loop {
                match Reader::open(&file) {
                    Ok(reader) => break reader,
                    Err(_) if has_ended.load(Relaxed) => return,
                    Err(_) => std::thread::sleep(Duration::from_millis(5)),
                }
            };
            let mut frame = Frame::default();
            while reader.next(LIMIT, &mut frame).expect("frames") == Next::Frame {
                assert_eq!(frame.number, count.load(Relaxed), "a frame is missing");
                count.store(frame.number + 1, Relaxed);
                // The program waits for this reader, so that the other one has time to begin.
                if !is_read.load(Relaxed) {
                    std::thread::sleep(Duration::from_millis(20));
                }
            }
            assert_eq!(reader.lost(), 0);
        });
        let killing = scope.spawn(|| {
            while count.load(Relaxed) == 0 && !has_ended.load(Relaxed) {
                std::thread::sleep(Duration::from_millis(1));
            }
            let mut other = Command::new(env!("CARGO_BIN_EXE_cupola"));
            other.args(["stream", "-", "--format", "raw", "--published"]).arg(&file);
            let mut other = other.stdin(Stdio::null()).stdout(Stdio::piped()).spawn().expect("a reader starts");
            let (id, pipe) = (other.id(), other.stdout.as_mut().expect("a pipe"));
            std::thread::scope(|inner| {
                // If the program ends meanwhile, the reader waits for the next one.
                inner.spawn(|| {
                    while !is_read.load(Relaxed) {
                        if has_ended.load(Relaxed) {
                            return signal("KILL", id);
                        }
                        std::thread::sleep(Duration::from_millis(20));
                    }
                });
                // It has read when it writes.
                let read = std::io::Read::read_exact(pipe, &mut [0; 4096]);
                is_read.store(true, Relaxed);
                read.expect("the other reader reads before the program ends");
            });
            signal("STOP", other.id());
            std::thread::sleep(Duration::from_millis(200));
            let before = count.load(Relaxed);
            std::thread::sleep(Duration::from_millis(300));
            let (after, was_drawing) = (count.load(Relaxed), !has_ended.load(Relaxed));
            signal("KILL", other.id());
            other.wait().expect("it ends");
            (before, after, was_drawing)
        });
        let finished = run.under("identity");
        has_ended.store(true, Relaxed);
        let (before, after, was_drawing) = killing.join().expect("the other reader");
        reading.join().expect("a reader");
        if finished.is_some() {
            assert!(was_drawing && before == after, "the program does not wait: {before}, {after}");
            assert_eq!(count.load(Relaxed), FRAMES as u64);
        }
    });
}

fn picture(frame: &Frame, name: &str) -> Picture {
    let found = frame.pictures.iter().find(|picture| picture.name == name);
    let found = found.unwrap_or_else(|| panic!("no picture {name} of {:?}", frame.pictures.len()));
    let (width, height) = (found.size.0 as usize, found.size.1 as usize);
    assert!(found.rgba.chunks_exact(4).all(|pixel| pixel[3] == 255), "alpha is 255");
    Picture::from_fn(width, height, |x, y| {
        let at = (y * width + x) * 4;
        [found.rgba[at], found.rgba[at + 1], found.rgba[at + 2]]
    })
}

fn a_reader_gets_what_the_window_shows() {
    for program in ["core330_mvp", "immediate", "gles2"] {
        let run = Run { frames: 8, cupola_frames: 8, ..Run::new(program) };
        let Some((finished, seen)) = recorded(&run, |run| run.under("fisheye"), &[]) else { return };
        assert_eq!((&seen.indices, seen.lost), (&(1..=8).collect(), 0), "{program}");
        let shown = finished.expect_no_gl_errors().picture("capture.png");
        let name = &seen.last.pictures[0].name;
        assert!(picture(&seen.last, name) == shown, "{program}");
        let mut wrong = seen.last.clone();
        wrong.pictures[0].rgba[4 * (128 * 256 + 128)] ^= 1;
        assert!(picture(&wrong, name) != shown, "a wrong pixel is not detected");
    }
}

/// The rig's own outputs are six projectors. No picture in the window has the size of the
/// domemaster.
fn a_domemaster_beside_the_window_is_as_one_in_it() {
    let run = Run { size: (300, 200), frames: 4, cupola_frames: 4, ..Run::new("core330_mvp") };
    let options = ["--domemaster", "200"];
    let Some((finished, seen)) = recorded(&run, |run| run.under("planetarium-6"), &options) else { return };
    finished.expect_no_gl_errors();
    assert_eq!((seen.indices, seen.lost, seen.last.pictures.len()), ((1..=4).collect(), 0, 1));
    let beside = picture(&seen.last, "domemaster");
    let dome = cupola::rig::load("planetarium-6").expect("a preset").dome;
    let rig = format!(
        "[dome]\ntilt = {}\ncoverage = {}\n[[output]]\nkind = \"domemaster\"\n",
        dome.tilt.to_degrees(),
        dome.coverage.to_degrees()
    );
    let file = scratch("domemaster").join("rig.toml");
    std::fs::write(&file, rig).expect("a rig");
    let alone = Run { size: (200, 200), ..run };
    let Some(alone) = alone.under(file.to_str().expect("UTF-8")) else { return };
    let alone = alone.expect_success().picture("capture.png");
    // Views of other sizes are filtered differently: 43 % of the pixels were found to differ.
    expect_similar(&beside, &alone, 2, 0.86, "a domemaster beside the window");
    let shifted = Picture::from_fn(200, 200, |x, y| alone.at((x + 1).min(199), y));
    let beyond = beside.pixels.iter().zip(&shifted.pixels).filter(|(a, b)| (0..3).any(|c| a[c].abs_diff(b[c]) > 2));
    assert!(beyond.count() > 10_000, "a shift by one pixel is not detected");
}

fn vulkan_publishes_the_same() {
    let run = Run { size: (240, 200), frames: 5, cupola_frames: 5, ..Run::new("vk_cube") };
    let under = |run: &Run<'_>| run.vulkan_under("planetarium-6");
    let Some((finished, seen)) = recorded(&run, under, &["--frames", "5", "--domemaster", "150"]) else { return };
    assert_eq!((&seen.indices, seen.lost), (&(1..=5).collect(), 0));
    let beside = picture(&seen.last, "domemaster");
    assert_eq!((beside.width, beside.height, seen.last.pictures.len()), (150, 150, 1));
    assert!(beside.pixels.iter().filter(|pixel| **pixel != [0; 3]).count() > 500, "the picture is nearly black");
    assert_eq!(beside.at(0, 0), [0; 3], "outside of the circle");
    drop(finished);
    let Some((finished, seen)) = recorded(&run, under, &["--frames", "5"]) else { return };
    for found in &seen.last.pictures {
        let captured = finished.picture(&format!("capture-{}.png", found.name));
        assert!(picture(&seen.last, &found.name) == captured, "{}", found.name);
    }
    assert_eq!(seen.last.pictures.len(), 6);
}

const DEEP: (&str, &str) = ("CUPOLA_PUBLISH_DEPTH", "16");

/// Compares the published pictures of 16 bits with the captured ones of 8 bits of the same frame.
fn expect_deep(finished: &Finished, seen: &Seen, what: &str) {
    let mut most = 0;
    for found in &seen.last.pictures {
        let several = seen.last.pictures.len() > 1;
        let name = if several { format!("capture-{}.png", found.name) } else { "capture.png".to_owned() };
        let captured = finished.picture(&name);
        assert_eq!(found.format, Format::Rgba16, "{what}");
        let (width, height) = (found.size.0 as usize, found.size.1 as usize);
        assert_eq!((captured.width, captured.height), (width, height));
        let colors: Vec<u16> = found.rgba.as_chunks::<2>().0.iter().map(|bytes| u16::from_ne_bytes(*bytes)).collect();
        let pixels = colors.as_chunks::<4>().0;
        assert!(pixels.iter().all(|pixel| pixel[3] == u16::MAX), "{what}: alpha");
        let rounded = |color: u16| ((u32::from(color) + 128) / 257) as u8;
        let at = |x: usize, y: usize| pixels[y * width + x];
        let deep = Picture::from_fn(width, height, |x, y| [0, 1, 2].map(|channel| rounded(at(x, y)[channel])));
        let (_, greatest) = deep.difference(&captured);
        assert!(greatest <= 1, "{what}, {}: differs by {greatest} levels from the window", found.name);
        let levels =
            |channel: usize| pixels.iter().map(|pixel| pixel[channel]).collect::<std::collections::BTreeSet<_>>();
        let between = pixels.iter().flatten().filter(|color| !color.is_multiple_of(257)).count();
        crate::harness::note(format_args!(
            "{what}, {}: {:?} levels, {between} of {} values between those of 8 bits",
            found.name,
            [0, 1, 2].map(|channel| levels(channel).len()),
            pixels.len() * 3
        ));
        most = (0..3).map(|channel| levels(channel).len()).chain([most]).max().unwrap_or(0);
        // Controls: a picture that is shifted by a pixel, and the rounded picture.
        let shifted = Picture::from_fn(width, height, |x, y| captured.at((x + 1).min(width - 1), y));
        assert!(deep.difference(&shifted).1 > 1, "{what}: a shift is not detected");
    }
    assert!(most > 256, "{what}: no more than 8 bits");
}

/// A rig whose pictures have more than 8 bits although the views have 8: sums of several texels have
/// more. Mesa's own filter rounds to the bits of the texels, so the correction filters by itself.
pub fn filtered() -> PathBuf {
    let file = scratch("filtered").join("rig.toml");
    let text = "[views]\nfilter = \"catmull-rom\"\n[[output]]\nkind = \"domemaster\"\n";
    std::fs::write(&file, text).expect("a rig");
    file
}

fn pictures_of_16_bits_have_more_levels() {
    let filtered = filtered();
    for (program, rig) in [("core330_mvp", filtered.to_str().expect("UTF-8")), ("immediate", "planetarium-2")] {
        let run = Run { frames: 4, cupola_frames: 4, environment: &[DEEP], ..Run::new(program) };
        let Some((finished, seen)) = recorded(&run, |run| run.under(rig), &[]) else { return };
        let finished = finished.expect_no_gl_errors();
        assert_eq!((&seen.indices, seen.lost), (&(1..=4).collect(), 0), "{program}");
        expect_deep(&finished, &seen, program);
    }
    // A context that cannot do it says so.
    let run = Run { frames: 4, cupola_frames: 4, environment: &[DEEP], ..Run::new("gles2") };
    let Some((finished, seen)) = recorded(&run, |run| run.under("fisheye"), &[]) else { return };
    assert_eq!(seen.last.pictures[0].format, Format::Rgba8);
    assert!(finished.words().contains("OpenGL ES have 8 bits"), "{}", finished.words());
}

fn vulkan_publishes_16_bits() {
    let filtered = filtered();
    for rig in [filtered.to_str().expect("UTF-8"), "planetarium-6"] {
        let run = Run { size: (240, 200), frames: 5, cupola_frames: 5, environment: &[DEEP], ..Run::new("vk_cube") };
        let under = |run: &Run<'_>| run.vulkan_under(rig);
        let Some((finished, seen)) = recorded(&run, under, &["--frames", "5"]) else { return };
        assert_eq!((&seen.indices, seen.lost), (&(1..=5).collect(), 0));
        expect_deep(&finished, &seen, rig);
    }
}

/// Builds the example that uses only `cupola_ring.h`, in both languages.
fn reader_in_c() -> PathBuf {
    let folder = scratch("reader");
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let languages = [("cc", "-xc", "-std=c99", "reader"), ("c++", "-xc++", "-std=c++11", "reader++")];
    for (compiler, language, standard, name) in languages {
        let mut command = Command::new(compiler);
        command.args([language, standard, "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O1"]);
        command.arg("-I").arg(root.join("include")).arg("-o").arg(folder.join(name));
        let output = command.arg(root.join("examples/c/ring_reader.c")).output().expect("a compiler");
        assert!(output.status.success(), "{compiler}: {}", String::from_utf8_lossy(&output.stderr));
    }
    folder.join("reader")
}

fn a_reader_in_c_gets_the_same() {
    let folder = scratch("published");
    let (file, last, reader) = (folder.join("ring"), folder.join("last.ppm"), reader_in_c());
    let publish = format!("--publish={}", file.display());
    let (options, environment) = ([publish.as_str()], [("CUPOLA_PUBLISH_WAIT", "1")]);
    let run =
        Run { frames: 8, cupola_frames: 8, cupola: &options, environment: &environment, ..Run::new("core330_mvp") };
    // The reader ends with the program, or after a minute without a program.
    let mut reading = Command::new(reader);
    reading.arg(&file).arg(&last).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut reading = reading.spawn().expect("a reader");
    let Some(finished) = run.under("fisheye") else {
        reading.kill().and_then(|()| reading.wait()).expect("the reader ends");
        return;
    };
    let shown = finished.expect_success().picture("capture.png");
    let read = reading.wait_with_output().expect("a reader");
    let words = String::from_utf8_lossy(&read.stdout).into_owned();
    assert!(read.status.success(), "{}", String::from_utf8_lossy(&read.stderr));
    let indices: Vec<u64> = words.lines().filter_map(|line| line.split(' ').nth(1)?.parse().ok()).collect();
    assert_eq!(indices, [1, 2, 3, 4, 5, 6, 7, 8, 0], "eight frames, none lost: {words}");
    let bytes = std::fs::read(&last).expect("a picture");
    let pixels = bytes.strip_prefix(b"P6\n256 256\n255\n").expect("256 × 256 pixels");
    let found = |pixels: &[u8]| {
        Picture::from_fn(256, 256, |x, y| {
            let at = (y * 256 + x) * 3;
            [pixels[at], pixels[at + 1], pixels[at + 2]]
        })
    };
    assert!(found(pixels) == shown);
    let mut wrong = pixels.to_vec();
    wrong[3 * (128 * 256 + 128)] ^= 1;
    assert!(found(&wrong) != shown, "a wrong pixel is not detected");
}
