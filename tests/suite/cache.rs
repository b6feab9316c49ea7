//! Results of a start are cached for the next start and change no picture.

use crate::compare::expect_identical;
use crate::harness::tests;
use crate::programs::{Finished, Run, embedding, scratch};
use cupola::digest::Digest;
use std::path::{Path, PathBuf};

tests! {
    the_second_start_computes_nothing_and_shows_the_same,
    what_is_damaged_is_computed_again,
    a_folder_that_cannot_be_changes_nothing,
    vulkan_programs_start_from_it_too,
    embedding_programs_start_from_it_too,
}

fn folder() -> PathBuf {
    scratch("results").join("new")
}

fn files(folder: &Path, kind: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
    files.retain(|path| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with(kind)));
    files
}

/// A run whose results are cached in `folder`.
fn run(program: &str, rig: &str, folder: &Path, cupola: &[&str]) -> Option<Finished> {
    let environment = [("CUPOLA_CACHE", folder.to_str().expect("a UTF-8 path"))];
    let run = Run { size: (160, 120), environment: &environment, cupola, ..Run::new(program) };
    Some(run.under(rig)?.expect_success().expect_no_gl_errors())
}

/// Number of results that were read from files, were missing, and were written.
fn counts(finished: &Finished) -> [u64; 3] {
    let statistics = finished.statistics();
    assert!(statistics["own_errors"].is_null() || statistics["own_errors"] == 0, "{statistics}");
    ["read", "missing", "written"].map(|name| statistics["cache"][name].as_u64().expect("a number"))
}

/// Picture of the first run. The other runs must show the same.
struct Same {
    what: String,
    picture: crate::picture::Picture,
}

impl Same {
    fn expect(&self, finished: &Finished, output: &str) {
        expect_identical(&finished.picture(output), &self.picture, &self.what);
    }
}

fn the_second_start_computes_nothing_and_shows_the_same() {
    let cases = [
        ("core330_mvp", "fisheye", "capture.png", true),
        ("glsl120", "idome", "capture.png", false),
        ("immediate", "planetarium-2", "capture-front.png", true),
        ("gles3", "fisheye", "capture.png", true),
        ("hud", "fisheye", "capture.png", true),
    ];
    for (program, rig, output, closed_form) in cases {
        let folder = folder();
        let Some(first) = run(program, rig, &folder, &[]) else { return };
        let same = Same { what: format!("{program} {rig}"), picture: first.picture(output) };
        let [read, missing, written] = counts(&first);
        assert!(read == 0 && missing > 1 && written == missing, "{}: {read} {missing} {written}", same.what);
        for (kind, expected) in [("views", true), ("table", !closed_form), ("program", true)] {
            assert_eq!(!files(&folder, kind).is_empty(), expected, "{}: {kind}", same.what);
        }
        let second = run(program, rig, &folder, &[]).expect("a display");
        same.expect(&second, output);
        let again = counts(&second);
        assert_eq!(again, [written, 0, 0], "{}", same.what);
        let without = run(program, rig, &folder, &["--no-cache"]).expect("a display");
        same.expect(&without, output);
        let [read, missing, none] = counts(&without);
        assert!(read == 0 && missing > 1 && none == 0, "{}: {read} {missing} {none}", same.what);
    }
}

/// Inverts the bytes of the file from byte `from` of its content on, and puts the right checksum
/// into the header.
fn replaced(path: &Path, from: usize) {
    let mut bytes = std::fs::read(path).expect("a file");
    let (header, content) = bytes.split_at_mut(56);
    content[from..].iter_mut().for_each(|byte| *byte = !*byte);
    header[40..].copy_from_slice(&Digest::of(content).value().to_le_bytes());
    std::fs::write(path, bytes).expect("written");
}

fn what_is_damaged_is_computed_again() {
    let folder = folder();
    let Some(first) = run("core330_mvp", "idome", &folder, &[]) else { return };
    let same = Same { what: "core330_mvp idome".into(), picture: first.picture("capture.png") };
    let [_, kept, _] = counts(&first);
    type Damage<'a> = (&'a str, &'a dyn Fn(&Path));
    let damage: [Damage; 4] = [
        ("bytes", &|path| {
            let mut bytes = std::fs::read(path).expect("a file");
            let middle = bytes.len() / 2;
            bytes[middle] ^= 1;
            std::fs::write(path, bytes).expect("written");
        }),
        ("ends", &|path| {
            let bytes = std::fs::read(path).expect("a file");
            std::fs::write(path, &bytes[..bytes.len() - 1]).expect("written");
        }),
        ("contents that say they are whole", &|path| replaced(path, 0)),
        // The file has the driver's format of a program but content that the driver did not write.
        ("programs", &|path| replaced(path, if path.to_string_lossy().contains("/program-") { 12 } else { 0 })),
    ];
    for (what, damage) in damage {
        files(&folder, "").iter().for_each(|path| damage(path));
        let again = run("core330_mvp", "idome", &folder, &[]).expect("a display");
        same.expect(&again, "capture.png");
        let [_, missing, written] = counts(&again);
        assert_eq!([missing, written], [kept, kept], "damaged {what}");
        assert_eq!(counts(&run("core330_mvp", "idome", &folder, &[]).expect("a display")), [kept, 0, 0], "{what}");
    }
}

fn a_folder_that_cannot_be_changes_nothing() {
    let Some(first) = run("glsl120", "fisheye", &folder(), &[]) else { return };
    let same = Same { what: "glsl120".into(), picture: first.picture("capture.png") };
    let blocked = run("glsl120", "fisheye", Path::new("/dev/null/results"), &[]).expect("a display");
    same.expect(&blocked, "capture.png");
    let [read, missing, written] = counts(&blocked);
    assert!(read == 0 && missing > 1 && written == 0);
}

fn vulkan_programs_start_from_it_too() {
    let folder = folder();
    let environment = [("CUPOLA_CACHE", folder.to_str().expect("a UTF-8 path"))];
    let start = || Run { size: (160, 120), environment: &environment, ..Run::new("vk_cube") }.vulkan_under("idome");
    let Some(first) = start() else { return };
    let same = Same { what: "vk_cube".into(), picture: first.picture("capture.png") };
    assert_eq!([files(&folder, "views").len(), files(&folder, "table").len()], [1, 1]);
    let second = start().expect("a display");
    same.expect(&second, "capture.png");
    let [read, _, written] = counts(&second);
    // Mesa's lavapipe returns no pipeline data.
    assert_eq!([read >= 2, written == 0], [true, true], "{read} {written}");
}

fn embedding_programs_start_from_it_too() {
    let folder = folder();
    let environment = [("CUPOLA_CACHE", folder.to_str().expect("a UTF-8 path"))];
    let start = || embedding("embed", &["256", "33", "-17"], &environment).map(Finished::expect_success);
    let Some(first) = start() else { return };
    assert!(!files(&folder, "views").is_empty() && !files(&folder, "program").is_empty());
    let second = start().expect("a display");
    expect_identical(&second.picture("views.ppm"), &first.picture("views.ppm"), "embed");
}
