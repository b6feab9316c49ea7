//! The rig's file changes while a program runs with it.

use crate::compare::expect_identical;
use crate::programs::{Finished, Run, scratch};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

const RIG: &str =
    "[[output]]\nkind = \"domemaster\"\n[output.blend]\nramps = [{ angle = \"polar\", zero = 90, full = 80 }]\n";

/// What says that the file was read again.
const FOLLOWED: &str = "windows follow it (1)";
const REFUSED: &str = "the rig stays as it was";

/// The rig of this test's own, unchanged.
fn rig(name: &str) -> PathBuf {
    let file = scratch("live").join(format!("{name}.toml"));
    std::fs::write(&file, RIG).expect("a rig file");
    file
}

/// Runs a program, on Vulkan or not, and changes its rig a second after its start. More and more frames, until one run
/// is long enough to say `message`. `None` where there is no display.
fn changed_meanwhile(run: &Run, vulkan: bool, name: &str, change: fn(&Path), message: &str) -> Option<Finished> {
    for frames in [400, 1_600, 6_400, 25_600] {
        let file = rig(name);
        let changing = file.clone();
        let helper = std::thread::spawn(move || {
            std::thread::sleep(Duration::from_secs(1));
            change(&changing);
        });
        let run = Run { frames, cupola_frames: frames, ..run.clone() };
        let rig = file.to_string_lossy();
        let finished = if vulkan { run.vulkan_under(&rig) } else { run.under(&rig) };
        helper.join().expect("changes the file");
        let finished = finished?;
        if finished.words().contains(message) {
            return Some(finished);
        }
    }
    panic!("{}: no run noticed the change", run.program);
}

fn tuned(file: &Path, changes: &[&str]) {
    let status = Command::new(env!("CARGO_BIN_EXE_cupola")).arg("tune").arg(file).args(changes).status();
    assert!(status.expect("runs").success(), "{changes:?}");
}

/// What a run shows from the start whose rig has these changes, once its views are planned for its number of draws.
fn from_the_start(run: &Run, vulkan: bool, name: &str, change: fn(&Path)) -> Option<Finished> {
    let run = Run { frames: 20, cupola_frames: 20, ..run.clone() };
    let file = rig(name);
    change(&file);
    let rig = file.to_string_lossy();
    if vulkan { run.vulkan_under(&rig) } else { run.under(&rig) }
}

fn ramps(file: &Path) {
    tuned(file, &["output.*.blend.ramps=[{ angle = \"polar\", zero = 70, full = 20 }]"]);
}

fn viewer(file: &Path) {
    tuned(file, &["viewer.yaw=30", "viewer.position=[0.5, 0.3, -1.0]", "output.output-1.blend.black_level=0.05"]);
}

fn mistake(file: &Path) {
    std::fs::write(file, "[[output]]\nkind = \"domemaster\"\naperture = 1000\n").expect("writes");
}

fn follows(run: &Run, vulkan: bool, name: &str, change: fn(&Path)) {
    let Some(found) = changed_meanwhile(run, vulkan, name, change, FOLLOWED) else { return };
    let Some(expected) = from_the_start(run, vulkan, name, change) else { return };
    let Some(before) = from_the_start(run, vulkan, name, |_| ()) else { return };
    let (found, expected) = (found.picture("capture.png"), expected.picture("capture.png"));
    expect_identical(&found, &expected, run.program);
    // Negative control: the change is one that shows.
    assert!(before.picture("capture.png").difference(&expected).0 > 1_000);
}

#[test]
fn ramps_follow_the_file() {
    follows(&Run::new("core330_mvp"), false, "ramps", ramps);
}

#[test]
fn the_viewer_follows_the_file() {
    follows(&Run::new("immediate"), false, "viewer", viewer);
}

#[test]
fn ramps_follow_the_file_on_vulkan() {
    follows(&Run::new("vk_cube"), true, "vulkan", ramps);
}

/// Other views: the program makes a new swapchain, and keeps the pictures that it draws its scene to.
#[test]
fn scenes_off_screen_follow_the_file_on_vulkan() {
    for way in ["post", "chain", "blit"] {
        let extra = ["--way", way];
        follows(&Run { extra: &extra, ..Run::new("vk_scenes") }, true, way, viewer);
    }
}

#[test]
fn a_file_with_a_mistake_changes_nothing() {
    let run = Run::new("core330_mvp");
    let Some(found) = changed_meanwhile(&run, false, "mistake", mistake, REFUSED) else { return };
    let Some(expected) = from_the_start(&run, false, "mistake", |_| ()) else { return };
    expect_identical(&found.picture("capture.png"), &expected.picture("capture.png"), "as before");
    let words = found.words();
    assert!(words.contains("aperture") && words.contains(":3:"), "{words}");
}
