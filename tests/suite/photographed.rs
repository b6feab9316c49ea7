//! `cupola calibrate --camera`: patterns on several screens, and the camera's command.

use crate::display::{self, Display};
use crate::harness::tests;
use crate::programs::scratch;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};

tests! {
    patterns_are_shown_on_their_screens_and_photographed,
    a_camera_that_fails_ends_the_series,
}

/// Size of an output in pixels.
const SIZE: (u32, u32) = (60, 40);

/// Two projectors: one in the rig's window, and one with the keys `other`.
fn rig(folder: &Path, other: &str) -> String {
    let text = format!(
        "[[output]]\nname = \"left\"\nkind = \"projector\"\nposition = [0.5, 0, 1]\nyaw = -40\npitch = 40\n\
         fov = [70, 47]\nsize = [60, 40]\n\n[[output]]\nname = \"right\"\nkind = \"projector\"\n\
         position = [-0.5, 0, 1]\nyaw = 40\npitch = 40\nfov = [70, 47]\nsize = [60, 40]\n{other}\n"
    );
    let file = folder.join("dome.toml");
    std::fs::write(&file, text).expect("written");
    file.to_string_lossy().into_owned()
}

/// Grey values at the upper left corner of a screen. All pixels must be grey.
fn screen(display: &Display) -> Vec<u8> {
    let pixels = display.pixels(SIZE);
    assert!(pixels.iter().all(|[red, green, blue]| red == green && green == blue));
    pixels.iter().map(|pixel| pixel[0]).collect()
}

fn calibrate(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_cupola"));
    command.arg("calibrate").args(arguments).stdin(Stdio::null());
    command
}

/// A process that ends if the test fails.
struct Running(Option<Child>);

impl Drop for Running {
    fn drop(&mut self) {
        if let Some(child) = &mut self.0 {
            let _ = child.kill();
        }
    }
}

fn words(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

fn patterns_are_shown_on_their_screens_and_photographed() {
    let (Some(one), Some(two)) = (display::own(24), display::own(24)) else { return };
    let folder = scratch("photographed");
    let rig = rig(&folder, &format!("display = \"{}\"", two.name));
    let place = |name: &str| folder.join(name).to_string_lossy().into_owned();
    let (patterns, photos, ask) = (place("patterns"), place("the photos"), place("ask"));
    let written = calibrate(&[&rig, "--patterns", &patterns, "--light"]).output().expect("it runs");
    assert!(written.status.success() && words(&written).contains("of right are for its own window"));
    let mut files: Vec<_> =
        std::fs::read_dir(&patterns).expect("patterns").map(|entry| entry.expect("an entry").path()).collect();
    files.sort();
    // 15 × 10 cells of 4 pixels: 4 bits in each direction, and 14 grey pictures.
    assert_eq!(files.len(), 2 * (2 + 2 * (4 + 4) + 14));
    // This test acts as the camera: the command writes the file's name to the pipe and waits for
    // the file.
    assert!(Command::new("mkfifo").arg(&ask).status().expect("mkfifo").success());
    let camera = format!("echo {{}}.png > {ask}; while ! [ -e {{}}.png ]; do sleep 0.002; done");
    let child = calibrate(&[&rig, "--photos", &photos, "--light", "--pause", "0", "--display", &one.name])
        .args(["--camera", &camera])
        .stdout(Stdio::piped())
        .spawn()
        .expect("it starts");
    let mut running = Running(Some(child));
    for (number, file) in files.iter().enumerate() {
        let mut asked = String::new();
        // The previous command may not have closed the pipe yet. Then the read returns nothing.
        while asked.is_empty() {
            BufReader::new(std::fs::File::open(&ask).expect("a pipe")).read_line(&mut asked).expect("a name");
        }
        let asked = Path::new(asked.trim_end());
        assert_eq!(asked.file_name(), file.file_name());
        let pattern = image::open(file).expect("a pattern").into_luma8();
        assert_eq!(pattern.dimensions(), SIZE, "size of the pattern");
        let black = vec![0; pattern.as_raw().len()];
        let (lit, dark) = if number < files.len() / 2 { (&one, &two) } else { (&two, &one) };
        assert!(screen(lit) == *pattern.as_raw() && screen(dark) == black, "{}", asked.display());
        // The rename makes the complete file appear at once for the waiting command.
        let part = asked.with_extension("part");
        pattern.save_with_format(&part, image::ImageFormat::Png).expect("written");
        std::fs::rename(part, asked).expect("renamed");
    }
    let output = running.0.take().expect("it runs").wait_with_output().expect("it ends");
    assert!(output.status.success());
    assert!(String::from_utf8_lossy(&output.stdout).contains(": 64 photographs"), "{output:?}");
    // New photographs are not mixed with existing ones.
    let again = calibrate(&[&rig, "--photos", &photos, "--camera", "cp {}", "--display", &one.name]).output();
    assert!(words(&again.expect("it runs")).contains("has 64 photographs already"));
}

fn a_camera_that_fails_ends_the_series() {
    let Some(screen) = display::own(24) else { return };
    let folder = scratch("camera");
    let place = |name: &str| folder.join(name).to_string_lossy().into_owned();
    let shoot = |rig: &str, photos: &str, camera: &str| {
        let arguments = [rig, "--photos", photos, "--pause", "0", "--display", &screen.name, "--camera", camera];
        let output = calibrate(&arguments).output().expect("it runs");
        assert!(!output.status.success());
        words(&output)
    };
    let hidden = rig(&folder, "shown = false");
    let refused = shoot(&hidden, &place("a"), "true {}");
    assert!(refused.contains("the patterns of right cannot be shown"), "{refused}");
    let rig = rig(&folder, "");
    let refused = shoot(&rig, &place("a"), "true");
    assert!(refused.contains("{} is missing"), "{refused}");
    let refused = shoot(&rig, &place("a"), "true {}");
    assert!(refused.contains("photograph 1 (0001-left-white)") && refused.contains("made no file"), "{refused}");
    let refused = shoot(&rig, &place("a"), "echo no light >&2; false {}");
    assert!(refused.contains("exit status: 1") && refused.contains("no light"), "{refused}");
    // A file that is no picture is detected before the next pattern is shown.
    let refused = shoot(&rig, &place("b"), "echo no picture > {}.png");
    assert!(refused.contains("photograph 1") && refused.contains("cannot be read"), "{refused}");
    assert_eq!(std::fs::read_dir(place("b")).expect("a folder").count(), 1);
    // If the camera fails later, the photographs that it made stay.
    let (photos, white) = (place("c"), place("white.png"));
    image::GrayImage::from_pixel(SIZE.0, SIZE.1, image::Luma([255])).save(&white).expect("written");
    let refused = shoot(&rig, &photos, &format!("[ -e {photos}/0003-left-x3.png ] && exit 3; cp {white} {{}}.png"));
    assert!(refused.contains("photograph 4") && refused.contains("exit status: 3"), "{refused}");
    assert_eq!(std::fs::read_dir(photos).expect("a folder").count(), 3);
}
