//! Vulkan programs that show their scene in a part of the window, between widgets.

use crate::harness::tests;
use crate::offscreen::expect_between_widgets;
use crate::programs::Run;

tests! {
    a_scene_that_is_copied_between_widgets,
    a_scene_that_is_drawn_between_widgets,
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
        expect_between_widgets(&finished.picture("capture.png"), &run, &format!("vk_panes {way}"));
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
