//! Vulkan programs that show their scene in a part of the window, between widgets.

use crate::harness::tests;
use crate::offscreen::expect_between_widgets;
use crate::programs::Run;

tests! {
    a_scene_that_is_copied_between_widgets,
}

fn panes<'a>(extra: &'a [&'a str]) -> Run<'a> {
    Run { extra, frames: 12, cupola_frames: 12, ..Run::new("vk_panes") }
}

/// The scene is all around, and the panel has the widgets and a hole.
fn a_scene_that_is_copied_between_widgets() {
    for way in ["blit", "copy"] {
        let extra = ["--way", way];
        let run = panes(&extra);
        let Some(finished) = run.vulkan_under("fisheye") else { return };
        expect_between_widgets(&finished.picture("capture.png"), &run, &format!("vk_panes {way}"));
        let statistics = finished.statistics();
        assert_eq!(statistics["duplicated_framebuffers"], 1, "{way}: {statistics:#}");
        assert!(!statistics["notes"].to_string().contains("flat"), "{way}: {statistics:#}");
    }
}
