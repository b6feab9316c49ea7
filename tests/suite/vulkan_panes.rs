//! Vulkan programs that show their scene in a part of the window, between widgets.

use crate::compare::{Limits, expect_identical};
use crate::harness::tests;
use crate::offscreen::expect_between_widgets;
use crate::programs::Run;

tests! {
    a_scene_that_is_copied_between_widgets,
    a_scene_that_is_drawn_between_widgets,
    scenes_between_widgets_with_the_programs_own_lens,
    a_scene_between_widgets_that_is_read,
    a_window_with_widgets_that_is_read,
    a_window_with_widgets_is_resized,
    a_scene_in_a_small_part_stays_flat,
}

fn panes<'a>(extra: &'a [&'a str]) -> Run<'a> {
    Run { extra, frames: 12, cupola_frames: 12, ..Run::new("vk_panes") }
}

/// Checks ways to show the scene in most of the window: it is all around, and the panel has the
/// widgets and a hole.
fn between_widgets(ways: &[&str]) {
    for way in ways {
        let extra = ["--way", way];
        let run = panes(&extra);
        let Some(finished) = run.vulkan_under("fisheye") else { return };
        expect_between_widgets(&finished.picture("capture.png"), Limits::USUAL, &run, &[], &format!("vk_panes {way}"));
        let statistics = finished.statistics();
        assert_eq!(statistics["duplicated_framebuffers"], 1, "{way}: {statistics:#}");
        assert!(!statistics["notes"].to_string().contains("flat"), "{way}: {statistics:#}");
    }
}

fn a_scene_that_is_copied_between_widgets() {
    between_widgets(&["blit", "copy"]);
}

/// The place of the picture is that of the draw's vertices, or of its viewport.
fn a_scene_that_is_drawn_between_widgets() {
    between_widgets(&["drawn", "viewport"]);
}

/// With the program's own lens the window is the same as without Cupola, to the byte.
fn scenes_between_widgets_with_the_programs_own_lens() {
    for way in ["blit", "drawn", "small"] {
        let extra = ["--way", way, "--shot", "shot.ppm"];
        let run = panes(&extra);
        let (Some(plain), Some(under)) = (run.vulkan_plain(), run.vulkan_under("identity-captured")) else { return };
        let plain = plain.expect_success().picture("shot.ppm");
        expect_identical(&under.picture("shot.ppm"), &plain, &format!("vk_panes {way}, identity-captured"));
    }
}

/// A program that reads its scene gets its own picture, also if the views are found meanwhile.
fn a_scene_between_widgets_that_is_read() {
    // Then each view is as large as the image, and a blit scales it once more.
    for (way, limits) in [("blit", Limits::ROUNDED), ("drawn", Limits::USUAL)] {
        let extra = ["--way", way, "--picture", "own.ppm"];
        let run = panes(&extra);
        let (Some(plain), Some(under)) = (run.vulkan_plain(), run.vulkan_under("fisheye")) else { return };
        let plain = plain.expect_success().picture("own.ppm");
        expect_identical(&under.picture("own.ppm"), &plain, &format!("vk_panes {way}, read"));
        expect_between_widgets(&under.picture("capture.png"), limits, &run, &[], &format!("vk_panes {way}, read"));
        assert_eq!(under.statistics()["duplicated_framebuffers"], 1, "{way}");
    }
}

/// A program that reads its window gets its own picture, with the scene between the widgets.
fn a_window_with_widgets_that_is_read() {
    for way in ["blit", "copy", "drawn", "viewport"] {
        let extra = ["--way", way, "--window", "own.ppm"];
        let run = panes(&extra);
        let (Some(plain), Some(under)) = (run.vulkan_plain(), run.vulkan_under("fisheye")) else { return };
        let plain = plain.expect_success().picture("own.ppm");
        expect_identical(&under.picture("own.ppm"), &plain, &format!("vk_panes {way}, window read"));
        let what = format!("vk_panes {way}, window read");
        expect_between_widgets(&under.picture("capture.png"), Limits::USUAL, &run, &[], &what);
    }
}

/// The window and the image get other sizes, and back. The scene is found again each time.
fn a_window_with_widgets_is_resized() {
    for way in ["copy", "drawn"] {
        let extra = ["--way", way, "--resizes", "6"];
        let run = Run { frames: 70, cupola_frames: 70, ..panes(&extra) };
        let Some(finished) = run.vulkan_under("fisheye") else { return };
        expect_between_widgets(
            &finished.picture("capture.png"),
            Limits::USUAL,
            &run,
            &[],
            &format!("vk_panes {way}, resized"),
        );
    }
}

/// A picture in a small part of the window stays flat, and the log and the statistics say why.
fn a_scene_in_a_small_part_stays_flat() {
    let reason = "it is shown in less than half of the window: make it larger, or close what is beside it";
    for (way, note) in [("small", reason), ("small-blit", "it copies its picture to the window")] {
        let extra = ["--way", way];
        let run = Run { frames: 110, cupola_frames: 110, ..panes(&extra) };
        let Some(finished) = run.vulkan_under("fisheye") else { return };
        let (statistics, words) = (finished.statistics(), finished.words());
        assert_eq!(statistics["duplicated_framebuffers"], 0, "{way}: {statistics:#}");
        assert!(statistics["notes"].to_string().contains(note), "{way}: {statistics:#}");
        assert_eq!(words.matches(note).count(), 1, "{way}: {words}");
        assert_eq!(statistics["single_framebuffers"][reason].is_u64(), way == "small", "{way}: {statistics:#}");
        // The window's middle is the background of the widgets.
        let middle = finished.picture("capture.png").at(128, 128);
        assert!(middle.iter().zip([255, 128, 0]).all(|(a, b)| a.abs_diff(b) <= 2), "{way}: {middle:?}");
    }
}
