//! Method `primitive` in Vulkan programs: triangles and lines that a stage of ours divides, against the exact map.

use crate::compare::{Report, compare, expect_good};
use crate::dialects::{camera_of, shown_by_fisheye};
use crate::picture::Picture;
use crate::programs::{Finished, Run};
use crate::reference::Fisheye;

const CIRCLE: Fisheye = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };

/// A camera that shows all kinds of corners and edges.
fn run<'a>(extra: &'a [&'a str], cupola: &'a [&'a str]) -> Run<'a> {
    Run { fov: 90.0, yaw: 33.0, pitch: -17.0, extra, cupola, ..Run::new("vk_cube") }
}

fn fisheye(run: &Run) -> Option<Finished> {
    run.vulkan_under("fisheye")
}

fn against_the_map(run: &Run, picture: &Picture) -> Report {
    compare(picture, shown_by_fisheye(CIRCLE, camera_of(run)))
}

/// One view, nothing that is flat, and nothing that the log says of the method.
fn expect_divided(finished: &Finished, what: &str) {
    let statistics = finished.statistics();
    assert_eq!(statistics["views"].as_array().map(Vec::len), Some(1), "{what}: {statistics:#}");
    assert_eq!(statistics["panel_draws"], 0, "{what}: {statistics:#}");
    let words = finished.words();
    assert!(!words.contains("divided") && !words.contains("instead"), "{what}: {words}");
}

#[test]
fn large_triangles_are_where_the_exact_map_has_them() {
    let run = run(&[], &["--method", "primitive,max_error=0.5"]);
    let Some(finished) = fisheye(&run) else { return };
    let picture = finished.picture("capture.png");
    expect_good(&against_the_map(&run, &picture), &picture, "vk_cube, primitive");
    expect_divided(&finished, "vk_cube");
}
