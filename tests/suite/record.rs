//! `cupola record`: two recordings are equal, and an interrupted recording can be continued.

use crate::display;
use crate::harness::{note, tests};
use crate::programs::{Finished, Run, built, is_installed, library, scratch, vulkan_apps};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

tests! {
    two_recordings_are_equal,
    an_interrupted_recording_goes_on,
    pictures_are_shown_as_long_as_the_program_shows_them,
    a_part_far_from_the_beginning_is_that_of_the_whole_recording,
    several_outputs_have_a_folder_each,
    a_range_has_the_frames_of_the_whole_recording,
    files_of_16_bits_and_open_exr,
    a_recording_without_flat_drawing,
    a_film_has_each_frame_in_order,
    a_terminal_shows_the_progress,
    a_full_disk_leaves_whole_files,
}

const FRAMES: usize = 6;

/// Records a program that moves by time and random numbers. The program itself draws `drawn`
/// frames.
fn record(out: &Path, drawn: usize, options: &[&str]) -> Option<Finished> {
    let options = [options, &["--frames", "6"]].concat();
    record_run(out, &Run { frames: drawn, size: (96, 96), ..Run::new("by_time") }, &options)
}

/// Records a program.
fn record_run(out: &Path, run: &Run<'_>, options: &[&str]) -> Option<Finished> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cupola"));
    command.env("CUPOLA_LIBRARY", library()).arg("record").args(options).arg("--out").arg(out).arg("--");
    let place = display::place();
    let folder = if run.program.starts_with("vk_") { vulkan_apps()? } else { built() };
    command.arg(folder.join(run.program)).args(run.arguments(&place));
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

/// A program that limits itself to 30 pictures a second plays at its speed in a film of 60.
fn pictures_are_shown_as_long_as_the_program_shows_them() {
    let folder = scratch("slow");
    let options = ["--name", "Show", "--frames", "12"];
    let run = |mode: &'static [&'static str]| Run { frames: 100, size: (96, 96), extra: mode, ..Run::new("by_time") };
    let Some(finished) = record_run(&folder.join("free"), &run(&[]), &options) else { return };
    finished.expect_success();
    let Some(finished) = record_run(&folder.join("slow"), &run(&["--mode", "limit"]), &options) else { return };
    finished.expect_success();
    let [free, slow] = ["free", "slow"].map(|name| files(&folder.join(name)).into_values().collect::<Vec<_>>());
    assert_eq!((free.len(), slow.len()), (12, 12));
    let changes = |pictures: &[Vec<u8>]| pictures.windows(2).filter(|pair| pair[0] != pair[1]).count();
    assert_eq!((changes(&free), changes(&slow)), (11, 5));
    // The part from frame 6 on has the picture that began before it.
    let part = folder.join("part");
    let options = ["--name", "Show", "--from", "6", "--to", "9"];
    let Some(finished) = record_run(&part, &run(&["--mode", "limit"]), &options) else { return };
    finished.expect_success();
    assert!(files(&part).into_values().eq(slow[5..9].iter().cloned()), "a part differs from the whole recording");
    // The last picture of a program that ends is shown as long as the one before.
    let six = Run { frames: 6, ..run(&["--mode", "limit"]) };
    let Some(finished) = record_run(&folder.join("end"), &six, &["--name", "Show", "--frames", "12"]) else { return };
    finished.expect_success();
    assert!(files(&folder.join("end")).into_values().eq(slow.iter().cloned()), "the end differs");
}

/// What lies long before a part is not read back. If the part would need it, that is an error.
fn a_part_far_from_the_beginning_is_that_of_the_whole_recording() {
    let folder = scratch("far");
    let run = |mode: &'static [&'static str]| Run { frames: 54, size: (64, 64), extra: mode, ..Run::new("by_time") };
    let record = |name: &str, mode, options: &[&str]| {
        let options = [&["--name", "Show", "--fps", "20", "--stats", "stats.json"], options].concat();
        record_run(&folder.join(name), &run(mode), &options)
    };
    let Some(whole) = record("whole", &[], &["--frames", "54"]) else { return };
    let Some(part) = record("part", &[], &["--from", "2.5s", "--to", "54"]) else { return };
    let published = |run: &Finished| run.statistics()["published"]["frames"].as_u64().expect("a number");
    // The first one, and from one second before frame 51 on.
    assert_eq!((published(&whole.expect_success()), published(&part.expect_success())), (54, 25));
    let [whole, part] = ["whole", "part"].map(|name| files(&folder.join(name)));
    assert_eq!(part.keys().collect::<Vec<_>>(), whole.keys().skip(50).collect::<Vec<_>>());
    assert!(part.iter().all(|(name, bytes)| whole[name] == *bytes), "the part differs from the whole recording");
    // Pictures every 1.5 s.
    const SLIDES: &[&str] = &["--mode", "slides"];
    let Some(finished) = record("slides", SLIDES, &["--from", "4s", "--to", "4.5s"]) else { return };
    finished.expect_success();
    let Some(refused) = record("refused", SLIDES, &["--from", "4.2s", "--to", "4.5s"]) else { return };
    assert!(refused.words().contains("more than a second before"), "{}", refused.words());
    assert!(!refused.succeeded() && files(&folder.join("refused")).is_empty());
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

fn a_range_has_the_frames_of_the_whole_recording() {
    let folder = scratch("range");
    let whole = folder.join("whole");
    let Some(finished) = record(&whole, FRAMES, &["--name", "Show"]) else { return };
    finished.expect_success();
    let whole = files(&whole);
    let run = Run { frames: FRAMES, size: (96, 96), ..Run::new("by_time") };
    for (name, options, numbers) in [
        ("frames", &["--from", "3", "--to", "5"][..], 3..=5),
        ("length", &["--from", "0.05s", "--frames", "2"], 4..=5),
        ("times", &["--from", "0.05s", "--to", "0.1s"], 4..=6),
        ("beginning", &["--to", "2"], 1..=2),
    ] {
        let part = folder.join(name);
        let options = [options, &["--name", "Show"]].concat();
        let Some(finished) = record_run(&part, &run, &options) else { return };
        finished.expect_success();
        let part = files(&part);
        let names: Vec<String> = numbers.map(|number| format!("Show_{number:06}.png")).collect();
        assert_eq!(part.keys().collect::<Vec<_>>(), names.iter().collect::<Vec<_>>());
        assert!(part.iter().all(|(name, bytes)| whole[name] == *bytes), "{name} differs from the whole recording");
        // Control: the frames differ from each other.
        assert!(part[&names[0]] != part[&names[1]]);
    }
    // A range that is interrupted goes on with its own numbers.
    let part = folder.join("frames");
    std::fs::remove_file(part.join("Show_000005.png")).expect("removed");
    let options = ["--from", "3", "--to", "5", "--name", "Show"];
    let Some(finished) = record_run(&part, &run, &options) else { return };
    assert!(finished.expect_success().words().contains("goes on with frame 5"));
    assert!(files(&part)["Show_000005.png"] == whole["Show_000005.png"]);
    let Some(finished) = record_run(&folder.join("wrong"), &run, &["--from", "5", "--to", "4"]) else { return };
    assert!(!finished.succeeded() && finished.words().contains("--to: frame 4 is before frame 5"));
}

/// Light of a value by the curve of sRGB.
fn light(value: f64) -> f64 {
    if value <= 0.04045 { value / 12.92 } else { ((value + 0.055) / 1.055).powf(2.4) }
}

fn files_of_16_bits_and_open_exr() {
    use exr::prelude::{ReadChannels, ReadLayers, read};
    let folder = scratch("deep");
    let run = Run { frames: 2, ..Run::new("core330_mvp") };
    let rig = crate::published::filtered();
    let rig = ["--rig", rig.to_str().expect("UTF-8"), "--frames", "2", "--name", "A"];
    for (name, options) in [("usual", &[][..]), ("deep", &["--depth", "16"]), ("exr", &["--exr"])] {
        let Some(finished) = record_run(&folder.join(name), &run, &[options, &rig].concat()) else { return };
        finished.expect_success();
    }
    let open = |name: &str| image::open(folder.join(name)).expect("a picture");
    let usual = open("usual/A_000002.png");
    assert_eq!(usual.color(), image::ColorType::Rgb8);
    let (usual, deep) = (usual.into_rgb8(), open("deep/A_000002.png"));
    assert_eq!(deep.color(), image::ColorType::Rgb16);
    let deep = deep.into_rgb16();
    let levels: std::collections::BTreeSet<u16> = deep.pixels().map(|pixel| pixel[0]).collect();
    assert!(levels.len() > 256, "{}", levels.len());
    let far = |usual: &image::RgbImage| {
        let values = deep.pixels().zip(usual.pixels()).flat_map(|(deep, usual)| (0..3).map(|i| (deep[i], usual[i])));
        values.map(|(deep, usual)| (f64::from(deep) / 257.0 - f64::from(usual)).abs()).fold(0.0, f64::max)
    };
    assert!(far(&usual) <= 1.0, "{}", far(&usual));
    assert!(far(&image::imageops::flip_horizontal(&usual)) > 1.0, "another picture is not detected");
    let file = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgb_channels(
            |size, _| (size.width(), vec![(0.0, 0.0, 0.0); size.area()]),
            |(width, pixels): &mut (usize, Vec<(f32, f32, f32)>),
             place: exr::prelude::Vec2<usize>,
             pixel: (f32, f32, f32)| pixels[place.y() * *width + place.x()] = pixel,
        )
        .first_valid_layer()
        .all_attributes()
        .from_file(folder.join("exr/A_000002.exr"))
        .expect("an OpenEXR file");
    let lights = &file.layer_data.channel_data.pixels.1;
    assert_eq!(lights.len(), deep.pixels().len());
    // Half floats have 11 bits.
    let is_near = |light: f32, value: u16| {
        let expected = self::light(f64::from(value) / 65535.0);
        (f64::from(light) - expected).abs() <= expected / 2000.0 + 1e-7
    };
    let all_near = |deep: &image::ImageBuffer<image::Rgb<u16>, Vec<u16>>| {
        lights.iter().zip(deep.pixels()).all(|(light, pixel)| {
            is_near(light.0, pixel[0]) && is_near(light.1, pixel[1]) && is_near(light.2, pixel[2])
        })
    };
    assert!(all_near(&deep), "OpenEXR and PNG differ");
    assert!(!all_near(&image::imageops::flip_horizontal(&deep)), "another picture is not detected");
    // OpenGL ES publishes 8 bits: the recording says so, and writes nothing.
    let es = Run { frames: 2, ..Run::new("gles2") };
    let Some(finished) = record_run(&folder.join("es"), &es, &["--frames", "2", "--depth", "16"]) else { return };
    assert!(!finished.succeeded() && finished.words().contains("8 bits for each colour"), "{}", finished.words());
    assert!(files(&folder.join("es")).is_empty());
}

/// The programs draw squares over a cube: half-transparent ones with OpenGL, one with Vulkan.
fn a_recording_without_flat_drawing() {
    let cube = |extra| Run { extra, ..Run::new("vk_cube") };
    without_flat_drawing(&Run::new("hud"), &Run::new("immediate"));
    without_flat_drawing(&cube(&["--flat", "over"]), &cube(&[]));
    without_flat_drawing(&cube(&["--flat", "over", "--pass", "dynamic", "--secondary"]), &cube(&[]));
}

/// A recording of `flat` without flat drawing shows what `scene` shows.
fn without_flat_drawing(flat: &Run<'_>, scene: &Run<'_>) {
    let folder = scratch("flat");
    let mut pictures = Vec::new();
    for (run, options) in [(flat, &[][..]), (flat, &["--no-overlay"]), (scene, &[])] {
        let options = [options, &["--frames", "2", "--name", "A"]].concat();
        let out = folder.join(pictures.len().to_string());
        let Some(finished) = record_run(&out, &Run { frames: 2, ..run.clone() }, &options) else { return };
        finished.expect_success();
        pictures.push(crate::picture::Picture::load(&out.join("A_000002.png")));
    }
    let [with, without, alone] = &pictures[..] else { unreachable!() };
    assert!(with.difference(without).0 > 100, "the squares are not left out");
    assert!(
        without.difference(alone).1 <= 2,
        "something else than the squares is left out: {:?}",
        without.difference(alone)
    );
}

/// Side of the pictures of films.
const SIDE: usize = 96;

/// A program that paints the number of each frame into the picture. It ends after `frames`; with 0
/// it does not end.
fn painting(frames: usize) -> Run<'static> {
    Run { frames, size: (SIDE, SIDE), ..Run::new("frame_index") }
}

/// Numbers that are painted into pictures of four bytes per pixel, as `frame_index` does it.
fn painted(pixels: &[u8]) -> Vec<u32> {
    const BITS: usize = 24;
    assert_eq!(pixels.len() % (SIDE * SIDE * 4), 0, "{} bytes are no whole pictures", pixels.len());
    let is_white = |picture: &[u8], column: usize| {
        let middle = (2 * column + 1) * SIDE / (2 * BITS);
        picture[4 * (SIDE / 2 * SIDE + middle)] > 127
    };
    let number =
        |picture: &[u8]| (0..BITS).fold(0, |number, column| number << 1 | u32::from(is_white(picture, column)));
    pixels.chunks(SIDE * SIDE * 4).map(number).collect()
}

/// What a command writes to its standard output. Panics if it fails.
fn output_of(program: &str, arguments: &[&str], file: &Path) -> Vec<u8> {
    let (options, rest) = arguments.split_at(arguments.iter().position(|word| *word == "FILE").expect("FILE"));
    let output = Command::new(program).args(options).arg(file).args(&rest[1..]).output().expect("it starts");
    assert!(output.status.success(), "{program} {}: {}", file.display(), String::from_utf8_lossy(&output.stderr));
    output.stdout
}

fn a_film_has_each_frame_in_order() {
    const FRAMES: u32 = 12;
    if !is_installed("ffmpeg") || !is_installed("ffprobe") {
        return;
    }
    let folder = scratch("film");
    let film = |name: &str, run: &Run<'_>, options: &[&str]| {
        let usual = ["--rig", "identity", "--fps", "30", "--name", "Show"];
        record_run(&folder.join(name), run, &[&usual, options].concat())
    };
    for (preset, codec, file) in
        [("h264", "h264", "Show.mp4"), ("h265", "hevc", "Show.mp4"), ("prores", "prores", "Show.mov")]
    {
        let Some(finished) = film(preset, &painting(0), &["--film", preset, "--frames", "12"]) else { return };
        finished.expect_success();
        assert_eq!(files(&folder.join(preset)).into_keys().collect::<Vec<_>>(), [file]);
        let file = folder.join(preset).join(file);
        let entries = "stream=codec_name,width,height,r_frame_rate,nb_read_frames";
        let probe = ["-v", "error", "-count_frames", "-show_entries", entries, "-of", "csv=p=0", "FILE"];
        let words = String::from_utf8(output_of("ffprobe", &probe, &file)).expect("UTF-8");
        assert_eq!(words.trim(), format!("{codec},{SIDE},{SIDE},30/1,{FRAMES}"));
        assert_eq!(painted(&decoded(&file)), (1..=FRAMES).collect::<Vec<_>>(), "{preset}");
    }
    // Control: the numbers are those of the pictures, not those of their places.
    let part = ["--film", "h264", "--from", "5", "--to", "8"];
    let Some(finished) = film("part", &painting(0), &part) else { return };
    finished.expect_success();
    assert_eq!(painted(&decoded(&folder.join("part/Show.mp4"))), [5, 6, 7, 8]);
    // An incomplete film does not have its name.
    let Some(finished) = film("short", &painting(4), &["--film", "h264", "--frames", "12"]) else { return };
    assert!(!finished.succeeded() && finished.words().contains("after 4 of 12 frames"), "{}", finished.words());
    assert!(!folder.join("short/Show.mp4").exists());
}

/// Pixels of all pictures of a film, decoded by ffmpeg, which leaves none out and repeats none.
fn decoded(film: &Path) -> Vec<u8> {
    let way = ["-fps_mode", "passthrough", "-f", "rawvideo", "-pix_fmt", "rgba", "-"];
    output_of("ffmpeg", &[&["-nostdin", "-v", "error", "-i", "FILE"][..], &way].concat(), film)
}

/// A word of a command for the shell.
fn quoted(word: &str) -> String {
    format!("'{}'", word.replace('\'', "'\\''"))
}

/// The first line of a progress bar that has all parts: frames, rate, space on the disk, time to go.
fn line_of_progress(text: &str, frames: usize) -> Option<&str> {
    let is_complete = |line: &&str| {
        let parts = || {
            let (_, rest) = line.split_once(&format!("/{frames} frames, "))?;
            let (rate, rest) = rest.split_once(" in a second, ")?;
            let (space, rest) = rest.split_once(" free, to go: ")?;
            Some((rate.parse::<f64>().ok()?, space.split_once(' ')?, rest.chars().next()?))
        };
        parts().is_some_and(|(rate, (number, unit), time)| {
            rate > 0.0 && number.parse::<f64>().is_ok() && unit.ends_with('B') && time.is_ascii_digit()
        })
    };
    text.split(['\r', '\n']).find(is_complete)
}

fn a_terminal_shows_the_progress() {
    if !is_installed("script") {
        return;
    }
    // On a fast machine, 40 frames end before the bar is drawn.
    let folder = scratch("progress");
    let run = painting(0);
    let place = display::place();
    let mut words = vec![env!("CARGO_BIN_EXE_cupola").to_owned()];
    words.extend(["record", "--rig", "identity", "--frames", "3000", "--out"].map(str::to_owned));
    words.extend([folder.display().to_string(), "--".to_owned()]);
    words.push(built().join(run.program).display().to_string());
    words.extend(run.arguments(&place));
    let shell = words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ");
    // `script` gives the command a terminal, and writes what is shown there to its own output.
    let mut terminal = Command::new("script");
    // A bar needs a terminal that can move its cursor.
    terminal.env("TERM", "xterm").env("CUPOLA_LIBRARY", library()).args(["-q", "-e", "-c", &shell, "/dev/null"]);
    let Some(finished) = Finished::of(terminal, run.program, "record in a terminal") else { return };
    let finished = finished.expect_success();
    assert_eq!(files(&folder).len(), 3000);
    let shown = finished.messages();
    let line = line_of_progress(&shown, 3000);
    note(format_args!("{line:?}"));
    assert!(line.is_some() && line_of_progress(&shown, 3001).is_none(), "{shown}");
    // Control: where there is no terminal, there is no bar.
    let Some(finished) = record_run(&scratch("without"), &run, &["--rig", "identity", "--frames", "40"]) else {
        return;
    };
    let finished = finished.expect_success();
    assert!(!finished.words().contains("to go:") && !finished.messages().contains("to go:"), "{}", finished.words());
}

/// A file system of 64 KiB has no room for all files.
fn a_full_disk_leaves_whole_files() {
    let mounted = "mount -t tmpfs -o size=64k tmpfs \"$0\"";
    let shell = |way: &[&str], text: &str, folder: &Path| {
        let mut command = Command::new("unshare");
        command.args(way).args(["--mount", "sh", "-c", text]).arg(folder);
        command
    };
    let folder = scratch("full");
    let (full, kept, whole) = (folder.join("full"), folder.join("kept"), folder.join("whole"));
    std::fs::create_dir_all(&full).expect("a folder");
    // In a changed root only root can mount, and the root's propagation cannot be changed.
    let ways: [&[&str]; 2] = [&["--map-root-user"], &["--propagation", "unchanged"]];
    let can_mount = |way: &&&[&str]| {
        let mut mounts = shell(way, &format!("{mounted} && umount \"$0\""), &full);
        mounts.status().is_ok_and(|status| status.success())
    };
    let Some(way) = ways.iter().find(can_mount) else {
        return crate::harness::missing(format_args!("no file system can be mounted here"));
    };
    let recorded = |mut command: Command, out: &Path| {
        let run = Run { frames: 0, size: (96, 96), ..Run::new("by_time") };
        command.env("CUPOLA_LIBRARY", library()).args(["record", "--rig", "fisheye", "--frames", "40", "--out"]);
        let place = display::place();
        command.arg(out).arg("--").arg(built().join(run.program)).args(run.arguments(&place));
        Finished::of(command, run.program, "record")
    };
    let Some(finished) = recorded(Command::new(env!("CARGO_BIN_EXE_cupola")), &whole) else { return };
    finished.expect_success();
    let text =
        format!("{mounted} && (\"$@\"; code=$?; cp -r \"$0\" \"{}\"; umount \"$0\"; exit $code)", kept.display());
    let mut command = shell(way, &text, &full);
    command.arg(env!("CARGO_BIN_EXE_cupola"));
    let Some(finished) = recorded(command, &full) else { return };
    assert!(!finished.succeeded() && finished.words().contains("No space left on device"), "{}", finished.words());
    let (kept, whole) = (files(&kept), files(&whole));
    note(format_args!("{} of {} files", kept.len(), whole.len()));
    let pictures = kept.iter().filter(|(name, _)| name.ends_with(".png"));
    assert!((1..40).contains(&pictures.clone().count()), "{:?}", kept.keys());
    assert!(pictures.clone().all(|(name, bytes)| whole.get(name) == Some(bytes)), "a file is not whole");
}
