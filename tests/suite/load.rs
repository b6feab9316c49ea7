//! Loads: many draws, contexts, threads or outputs, and windows of odd shapes, give the same result
//! as small loads. Otherwise Cupola says what does not fit and what to change. `CUPOLA_ALL_LOADS=1`
//! tries the largest loads.

use crate::compare::{compare, expect_good, expect_similar};
use crate::dialects::{camera_of, shown_by_fisheye};
use crate::harness::{note, tests};
use crate::programs::{Finished, Run, installed, scratch, vulkan_apps};
use crate::reference::Fisheye;
use std::fmt::Write as _;
use std::time::Instant;

tests! {
    windows_of_any_shape,
    windows_that_are_too_small_for_a_rig,
    many_draws_in_a_frame,
    many_contexts,
    many_threads_with_contexts,
    sixty_four_outputs,
    twelve_outputs_of_4k,
    views_that_do_not_fit_an_image,
}

fn tries_all() -> bool {
    std::env::var_os("CUPOLA_ALL_LOADS").is_some()
}

/// The full load, or a smaller one that does not take long.
fn load(all: usize, usual: usize) -> String {
    if tries_all() { all } else { usual }.to_string()
}

/// Runs the Vulkan cube without the validation layer, which takes most of the time. `None` if that
/// is not possible.
fn vulkan(rig: &str, size: &str, cupola: &[&str], extra: &[&str]) -> Option<Finished> {
    let program = vulkan_apps()?.join("vk_cube");
    let cupola = [cupola, &["--capture", "capture.png", "--stats", "stats.json"]].concat();
    let program = program.to_str().expect("a UTF-8 path");
    let arguments = [
        &[
            "--size", size, "--pass", "1", "--matrix", "push", "--frames", "3", "--fov", "75", "--yaw", "20",
            "--pitch", "-10",
        ],
        extra,
    ]
    .concat();
    installed(program, &arguments, rig, &cupola).map(Finished::expect_success)
}

fn expect_corrected(finished: &Finished, what: &str) {
    assert!(!finished.words().contains("cupola: "), "{what}: {}", finished.words());
    let statistics = finished.statistics();
    assert_eq!(statistics["own_errors"], 0, "{what}: {statistics:#}");
    assert_eq!(statistics["frames"], 3, "{what}: {statistics:#}");
    assert_eq!(statistics["panel_draws"], 0, "{what}: {statistics:#}");
}

/// The smallest window, and the widest and highest that the renderer supports.
fn windows_of_any_shape() {
    for (width, height) in [(1, 1), (16384, 1), (1, 16384)] {
        for rig in ["fisheye", "identity-captured"] {
            let what = format!("{width} × {height}, {rig}");
            let run = Run { size: (width, height), extra: &["--seed", "12"], ..Run::new("load") };
            let Some(under) = run.under(rig) else { return };
            let under = under.expect_success();
            expect_corrected(&under, &what);
            let size = format!("{width}x{height}");
            let Some(vulkan) = vulkan(rig, &size, &[], &[]) else { return };
            expect_corrected(&vulkan, &format!("{what}, Vulkan"));
            let (picture, same) = (under.picture("capture.png"), vulkan.picture("capture.png"));
            assert_eq!((picture.width, picture.height), (width, height), "{what}");
            assert_eq!((same.width, same.height), (width, height), "{what}, Vulkan");
        }
    }
}

/// Six outputs do not fit into a window of one pixel. The program keeps running, and the log says
/// what to change.
fn windows_that_are_too_small_for_a_rig() {
    let says = |finished: &Finished| {
        let words = finished.words();
        assert!(words.contains("keeps") && words.contains("use a larger window"), "{words}");
        // The program's own picture is captured and counted.
        assert!(finished.wrote("capture.png") && finished.statistics()["frames"] == 3);
    };
    let run = Run { size: (1, 1), extra: &["--seed", "12"], ..Run::new("load") };
    let Some(under) = run.under("planetarium-6") else { return };
    says(&under.expect_success());
    let Some(vulkan) = vulkan("planetarium-6", "1x1", &[], &[]) else { return };
    says(&vulkan);
}

/// 100,000 draws with one matrix each.
fn many_draws_in_a_frame() {
    let count = load(100_000, 5_000);
    let circle = Fisheye { width: 128.0, height: 128.0, aperture: 180.0, tilt: 90.0 };
    let run = Run { size: (128, 128), extra: &["--seed", &count], ..Run::new("load") };
    let started = Instant::now();
    let Some(under) = run.under("fisheye") else { return };
    let under = under.expect_success();
    note(format_args!("OpenGL, {count} draws: {:.1} s", started.elapsed().as_secs_f64()));
    expect_corrected(&under, "many draws");
    let picture = under.picture("capture.png");
    expect_good(&compare(&picture, shown_by_fisheye(circle, camera_of(&run))), &picture, "many draws");
    let started = Instant::now();
    let (Some(one), Some(many)) = (
        vulkan("fisheye", "128x128", &[], &[]),
        vulkan("fisheye", "128x128", &["--frames", "3"], &["--draws", &count]),
    ) else {
        return;
    };
    note(format_args!("Vulkan, {count} draws: {:.1} s", started.elapsed().as_secs_f64()));
    expect_corrected(&many, "many draws, Vulkan");
    expect_similar(&many.picture("capture.png"), &one.picture("capture.png"), 1, 0.01, "many draws, Vulkan");
}

/// 1,000 contexts that share their objects draw to one window.
fn many_contexts() {
    let count = load(1_000, 30);
    let extra = ["--mode", "contexts", "--seed", &count, "--shot", "window.ppm"];
    let run = Run { size: (96, 96), frames: 1, extra: &extra, ..Run::new("load") };
    let (Some(plain), Some(under)) = (run.plain(), run.under("identity-captured")) else { return };
    let right = plain.expect_success().picture("window.ppm");
    let under = under.expect_success();
    assert!(!under.words().contains("cupola: "), "{}", under.words());
    // 2 of 9,216 pixels were found to differ.
    expect_similar(&under.picture("window.ppm"), &right, 1, 4.4e-4, "many contexts");
}

/// 64 threads. Each has a display, a window and a context, and reads the pixels that it has drawn.
fn many_threads_with_contexts() {
    let count = load(64, 24);
    let extra = ["--mode", "threads", "--seed", &count];
    let run = Run { size: (96, 96), frames: 2, cupola_frames: 100_000, extra: &extra, ..Run::new("load") };
    for rig in ["identity-captured", "fisheye"] {
        let Some(under) = run.under(rig) else { return };
        let under = under.expect_success();
        assert!(!under.words().contains("cupola: "), "{rig}: {}", under.words());
    }
}

/// A rig of outputs side by side that together show all directions around: columns, rows, and the
/// size of each output.
fn rig_of(columns: usize, rows: usize, (width, height): (usize, usize)) -> String {
    let mut text = "name = \"load\"\n".to_owned();
    let (across, up) = (360.0 / columns as f64, 120.0 / rows as f64);
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let (yaw, pitch) = ((column as f64 + 0.5) * across - 180.0, 60.0 - (row as f64 + 0.5) * up);
        let (x, y) = (column * width, row * height);
        writeln!(
            text,
            "[[output]]\nname = \"{column}-{row}\"\nkind = \"perspective\"\nyaw = {yaw}\npitch = {pitch}\n\
             fov = [{across}, {up}]\nwindow = [{x}, {y}, {width}, {height}]"
        )
        .expect("a string can be written");
    }
    text
}

/// Path of a rig file with this text.
fn rig_file(text: &str) -> String {
    let path = scratch("load").join("rig.toml");
    std::fs::write(&path, text).expect("a file can be written");
    path.display().to_string()
}

/// As many outputs as a rig may have. With one view per output they show the same as with shared
/// views.
fn sixty_four_outputs() {
    let dedicated = rig_of(8, 8, (40, 30));
    let (own, shared) =
        (rig_file(&dedicated), rig_file(&format!("{dedicated}[views]\nmethod = \"cube\"\nquality = 4.0\n")));
    let run = Run { size: (320, 240), extra: &["--seed", "12"], ..Run::new("load") };
    let (Some(own_views), Some(shared_views)) = (run.under(&own), run.under(&shared)) else { return };
    let (own_views, shared_views) = (own_views.expect_success(), shared_views.expect_success());
    let Some(vulkan) = vulkan(&own, "320x240", &[], &[]) else { return };
    for (finished, what) in [(&own_views, "64 outputs"), (&vulkan, "64 outputs, Vulkan")] {
        expect_corrected(finished, what);
        assert_eq!(finished.statistics()["views"].as_array().map(Vec::len), Some(64), "{what}");
        for (name, picture) in finished.captures() {
            // Colours between vertices are rounded differently: at most 293 of 1,200 pixels were
            // found to differ.
            expect_similar(&picture, &shared_views.picture(&name), 1, 0.49, &format!("{what}, {name}"));
        }
    }
}

/// 100 million pixels in one window.
fn twelve_outputs_of_4k() {
    let (columns, rows, size) = if tries_all() { (4, 3, (3840, 2160)) } else { (4, 3, (384, 216)) };
    let rig = rig_file(&rig_of(columns, rows, size));
    let (width, height) = (columns * size.0, rows * size.1);
    let window = format!("{width}x{height}");
    let headless = ["--headless", "--size", &window];
    let run = Run { size: (width, height), extra: &["--seed", "12"], cupola: &headless, ..Run::new("load") };
    let Some(under) = run.under(&rig) else { return };
    expect_corrected(&under.expect_success(), "twelve outputs");
    let Some(vulkan) = vulkan(&rig, &window, &headless, &[]) else { return };
    expect_corrected(&vulkan, "twelve outputs, Vulkan");
}

/// If the views need more texels than the largest atlas has, they are drawn as finely as the atlas
/// allows, and the statistics say so.
fn views_that_do_not_fit_an_image() {
    let text = "name = \"fine\"\n[views]\nquality = 8.0\n[[output]]\nkind = \"domemaster\"\n";
    let rig = rig_file(text);
    let run = Run { size: (8192, 8192), extra: &["--seed", "12"], ..Run::new("load") };
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_cupola"))
        .args(["plan", &rig, "--size", "8192x8192"])
        .output()
        .expect("the command starts");
    let words = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && words.contains("of the resolution asked for"), "{words}");
    if tries_all() {
        let Some(under) = run.under(&rig) else { return };
        let under = under.expect_success();
        expect_corrected(&under, "views that do not fit");
        assert!(!under.statistics()["notes"].as_array().is_some_and(Vec::is_empty));
    }
}
