//! Queries of Vulkan programs: each draw is issued for every view, but the program gets the result
//! of one draw.

use crate::compare::{compare, expect_good};
use crate::dialects::{camera_of, shown_by_fisheye};
use crate::harness::tests;
use crate::programs::{Finished, Run};
use crate::reference::Fisheye;
use std::collections::BTreeMap;

tests! {
    the_counts_without_cupola,
    what_is_projected_straight_to_an_output_is_counted_like_the_program_s_own,
    a_draw_for_each_view_is_one_draw_to_its_queries,
    drawing_on_condition,
    shaders_of_a_draw_write_once,
}

const CIRCLE: Fisheye = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };

/// Positions of the queries in passes and command buffers.
const WAYS: [&[&str]; 3] = [&[], &["--spans", "yes"], &["--secondary", "yes"]];

fn run<'a>(extra: &'a [&'a str]) -> Run<'a> {
    Run { extra, frames: 4, ..Run::new("vk_queries") }
}

/// What shaders wrote, by name.
pub fn written(text: &str) -> BTreeMap<&str, u32> {
    text.lines()
        .filter_map(|line| line.split_once(' ').map(|(name, text)| (name, text.parse().expect("a number"))))
        .collect()
}

/// Results by name: as the program read them, and as a command copied them.
fn counts(finished: &Finished) -> BTreeMap<String, (u64, u64)> {
    let line = |line: &str| {
        let mut parts = line.split(' ');
        let number = |text: Option<&str>| text.and_then(|text| text.parse().ok()).expect("a number");
        let name = parts.next().unwrap_or_default().to_owned();
        (name, (number(parts.next()), number(parts.next())))
    };
    finished.text("counts.txt").lines().map(line).collect()
}

/// Results that the program read.
fn read(counts: &BTreeMap<String, (u64, u64)>) -> BTreeMap<&str, u64> {
    counts.iter().map(|(name, (read, _))| (name.as_str(), *read)).collect()
}

/// Checks the counts of the program's own picture against its lens. It shows the nearest and the
/// farthest face of a small cube. The nearest has a third of the picture's height. The cube writes
/// nothing, so its faces do not hide each other.
fn the_counts_without_cupola() {
    for way in WAYS {
        let extra = [way, &["--counts", "counts.txt"]].concat();
        let Some(plain) = run(&extra).vulkan_plain() else { return };
        let counts = counts(&plain.expect_success());
        let counts = read(&counts);
        let face = (256.0_f64 / 3.0).powi(2);
        assert!((counts["ahead"] as f64 / (2.0 * face) - 1.0).abs() < 0.05, "{counts:?}");
        assert_eq!((counts["hidden"], counts["beside"], counts["nothing"]), (0, 0, 0), "{counts:?}");
        assert_eq!((counts["flat"], counts["both"]), (2 * 64 * 64, counts["ahead"]), "{counts:?}");
        let cubes = if way.contains(&"--spans") { 8 } else { 4 };
        assert_eq!(
            (counts["vertices"], counts["primitives"], counts["clipping"]),
            (36 * cubes, 12 * cubes, 12 * cubes)
        );
    }
}

/// An output to which vertices are projected directly shows things at other sizes than views.
fn what_is_projected_straight_to_an_output_is_counted_like_the_program_s_own() {
    for way in WAYS {
        let extra = [way, &["--counts", "counts.txt"]].concat();
        let run = Run { cupola: &["--method", "vertex"], ..run(&extra) };
        let (Some(plain), Some(under)) = (run.vulkan_plain(), run.vulkan_under("fisheye")) else { return };
        let (plain, under) = (counts(&plain.expect_success()), counts(&under));
        let (own, all) = (read(&plain), read(&under));
        assert!((0.5..2.0).contains(&(all["ahead"] as f64 / own["ahead"] as f64)), "{way:?}: {all:?}");
        for same in ["nothing", "flat", "vertices", "primitives"] {
            assert_eq!(all[same], own[same], "{way:?}: {same}");
        }
    }
}

/// Values that are counted once per draw stay the same, and draws that no view shows count nothing.
/// Draws that only a view shows count something. The number of samples that the program's own
/// picture shows is the same, except for the density of the views.
fn a_draw_for_each_view_is_one_draw_to_its_queries() {
    // The last runs also leave out small draws that are out of sight.
    let all: &[(&str, &str)] = &[("CUPOLA_CULL", "all")];
    for (way, environment) in WAYS.into_iter().map(|way| (way, &[][..])).chain(WAYS.map(|way| (way, all))) {
        let extra = [way, &["--counts", "counts.txt"]].concat();
        let run = Run { environment, ..run(&extra) };
        let Some(plain) = run.vulkan_plain() else { return };
        let plain = counts(&plain.expect_success());
        for rig in ["fisheye", "planetarium-6", "identity-captured"] {
            let Some(finished) = run.vulkan_under(rig) else { return };
            let (told, own) = (counts(&finished), read(&plain));
            let all = read(&told);
            assert!(told.values().all(|(read, copied)| read == copied), "{way:?}, {rig}: {told:?}");
            let out_of_sight = finished.statistics()["draws_out_of_sight"].as_u64();
            assert_eq!(out_of_sight > Some(0), !environment.is_empty() && rig != "identity-captured", "{way:?}, {rig}");
            if rig == "identity-captured" {
                assert_eq!(all, own, "{way:?}, {rig}");
                continue;
            }
            for same in ["hidden", "nothing", "flat", "vertices", "primitives", "vertex_runs", "clipping"] {
                assert_eq!(all[same], own[same], "{way:?}, {rig}: {same}");
            }
            assert!((0.5..2.0).contains(&(all["ahead"] as f64 / own["ahead"] as f64)), "{way:?}, {rig}: {all:?}");
            assert_eq!(all["both"], all["ahead"], "{way:?}, {rig}");
            assert!(all["beside"] > 0, "{way:?}, {rig}: {all:?}");
            assert!(!finished.statistics()["notes"].to_string().contains("flat"), "{way:?}, {rig}");
            if rig == "fisheye" {
                let picture = finished.picture("capture.png");
                let report = compare(&picture, shown_by_fisheye(CIRCLE, camera_of(&run)));
                expect_good(&report, &picture, &format!("vk_queries {way:?}"));
            }
        }
    }
}

/// Shaders of a scene and of flat drawing count vertices and fragments in buffers and images. Each
/// draw is issued for several views and for the panel, but counts once, in the program's own
/// picture.
fn shaders_of_a_draw_write_once() {
    for way in [&[][..], &["--flat"], &["--libraries", "2"], &["--libraries", "4"]] {
        let extra = [way, &["--again", "--answers", "answers.txt"]].concat();
        let run = Run { extra: &extra, frames: 4, ..Run::new("vk_writes") };
        let Some(plain) = run.vulkan_plain() else { return };
        let plain = plain.expect_success().text("answers.txt");
        let (own, area) = (written(&plain), 256 * 256);
        let fragments = if way.contains(&"--flat") { area / 16 } else { area };
        let expected = [("fragments", 4 * fragments), ("sums", 4 * fragments), ("vertices", 4 * 36), ("stored", 7)];
        assert!(expected.iter().all(|(name, number)| own[name] == *number), "{way:?}: {own:?}");
        for rig in ["fisheye", "planetarium-6", "identity-captured"] {
            let Some(finished) = run.vulkan_under(rig) else { return };
            assert_eq!(written(&finished.text("answers.txt")), own, "{way:?}, {rig}");
            if rig == "fisheye" && !way.contains(&"--flat") {
                let picture = finished.picture("capture.png");
                let report = compare(&picture, shown_by_fisheye(CIRCLE, camera_of(&run)));
                expect_good(&report, &picture, &format!("vk_writes {way:?}"));
            }
        }
    }
}

/// A program draws on the condition of a query of the last frame. It draws if only a view shows
/// something, and does not draw if nothing is visible. Then the panel stays clear.
fn drawing_on_condition() {
    let condition = |extra: &[&str]| {
        let run = Run { extra, ..run(&[]) };
        let finished = run.vulkan_under("fisheye")?;
        let picture = finished.picture("capture.png");
        let report = compare(&picture, shown_by_fisheye(CIRCLE, camera_of(&run)));
        Some((report, picture))
    };
    let Some((seen, picture)) = condition(&["--condition", "2"]) else { return };
    expect_good(&seen, &picture, "drawn because it is seen beside the program's picture");
    let Some((unseen, picture)) = condition(&["--condition", "4"]) else { return };
    assert!(unseen.wrong > 10_000, "the cube is drawn although nothing was visible");
    let grey = picture.pixels.iter().filter(|pixel| **pixel == [64; 3]).count();
    let black = picture.pixels.iter().filter(|pixel| **pixel == [0; 3]).count();
    assert_eq!(grey + black, picture.pixels.len(), "something else is shown");
}
