//! Method `vertex` in Vulkan programs: vertices that are projected straight to an output, against the exact map.

use crate::compare::{Report, compare, expect_good, expect_points, expect_similar, far};
use crate::dialects::{camera_of, shown_by_fisheye, shown_by_projector};
use crate::picture::Picture;
use crate::programs::{Finished, Run, installed, scratch};
use crate::reference::Fisheye;
use crate::rigs;

const CIRCLE: Fisheye = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };

/// What vk_cube clears its window to.
const GREY: [u8; 3] = [64; 3];

/// The ways in which the cube is drawn: how its pass begins, where its matrix is, which way up, with which samples.
const WAYS: [&[&str]; 6] = [
    &["--pass", "1", "--matrix", "push"],
    &["--pass", "2", "--matrix", "block", "--samples", "4"],
    &["--pass", "dynamic", "--matrix", "push", "--flip"],
    &["--pass", "imageless", "--matrix", "dynamic", "--flip"],
    &["--pass", "1", "--matrix", "copied", "--secondary", "--once"],
    &["--pass", "dynamic", "--matrix", "pushed", "--fixed"],
];

/// A camera that shows all kinds of corners and edges, and cells around the antipode.
fn run<'a>(extra: &'a [&'a str], cupola: &'a [&'a str]) -> Run<'a> {
    Run { fov: 90.0, yaw: 33.0, pitch: -17.0, extra, cupola, ..Run::new("vk_cube") }
}

fn fisheye(run: &Run) -> Option<Finished> {
    run.vulkan_under("fisheye")
}

fn against_the_map(run: &Run, picture: &Picture) -> Report {
    compare(picture, shown_by_fisheye(CIRCLE, camera_of(run)))
}

/// One view, and nothing that is flat.
fn expect_one_pass(finished: &Finished, what: &str) {
    let statistics = finished.statistics();
    assert_eq!(statistics["views"].as_array().map(Vec::len), Some(1), "{what}: {statistics:#}");
    assert_eq!(statistics["panel_draws"], 0, "{what}: {statistics:#}");
}

#[test]
fn fine_triangles_are_where_the_exact_map_has_them() {
    for (way, cells) in WAYS.into_iter().zip(["triangles", "ball"].into_iter().cycle()) {
        let extra = [way, &["--cells", cells]].concat();
        let run = run(&extra, &["--method", "vertex"]);
        let Some(finished) = fisheye(&run) else { return };
        let picture = finished.picture("capture.png");
        expect_good(&against_the_map(&run, &picture), &picture, &format!("vk_cube {extra:?}, vertex"));
        expect_one_pass(&finished, &format!("{extra:?}"));
    }
}

/// The last stage that projects is a geometry shader, or a tessellation shader.
#[test]
fn other_stages_project() {
    for stage in ["geometry", "tessellation"] {
        let extra = ["--cells", "triangles", "--stage", stage];
        for method in ["vertex", "fragment"] {
            let cupola = ["--method", method];
            let run = run(&extra, &cupola);
            let Some(finished) = fisheye(&run) else { return };
            let picture = finished.picture("capture.png");
            expect_good(&against_the_map(&run, &picture), &picture, &format!("vk_cube {extra:?}, {method}"));
            if method == "vertex" {
                expect_one_pass(&finished, stage);
            }
        }
    }
}

/// What is behind what, with depth that is the distance: a ball hides all that is drawn around it later.
#[test]
fn what_is_nearer_hides_what_is_farther() {
    for turned in [&[][..], &["--flip"]] {
        let extra = [&["--cells", "behind"], turned].concat();
        let run = run(&extra, &["--method", "vertex"]);
        let Some(finished) = fisheye(&run) else { return };
        let picture = finished.picture("capture.png");
        expect_good(&against_the_map(&run, &picture), &picture, &format!("vk_cube {extra:?}, vertex"));
    }
}

/// What tells that the comparer would notice.
#[test]
fn large_triangles_stay_straight_between_their_vertices() {
    let run = run(&[], &["--method", "vertex"]);
    let Some(finished) = fisheye(&run) else { return };
    let report = against_the_map(&run, &finished.picture("capture.png"));
    assert!(report.wrong > report.compared / 4, "{} of {} pixels are wrong", report.wrong, report.compared);
}

#[test]
fn points_are_where_the_exact_map_has_them() {
    let run = run(&["--cells", "points"], &["--method", "vertex"]);
    let Some(finished) = fisheye(&run) else { return };
    let picture = finished.picture("capture.png");
    expect_points(&picture, GREY, shown_by_fisheye(CIRCLE, camera_of(&run)));
}

/// Both APIs have the same functions.
#[test]
fn as_with_opengl() {
    let vulkan = run(&["--cells", "triangles"], &["--method", "vertex"]);
    let opengl = Run { program: "fine", extra: &[], ..vulkan.clone() };
    let (Some(vulkan), Some(opengl)) = (fisheye(&vulkan), opengl.under("fisheye")) else { return };
    let opengl = opengl.expect_success().picture("capture.png");
    expect_similar(&vulkan.picture("capture.png"), &opengl, 1, 1.0, "Vulkan against OpenGL");
}

/// Projectors away from the middle of the dome, in both directions of y.
#[test]
fn every_projector_gets_its_own_pass_and_blends() {
    let (size, columns) = ((128, 96), 3);
    let rig = rigs::projectors("planetarium-6", size, columns);
    let rows = rig.projectors.len().div_ceil(columns);
    let size_of_all = (columns * size.0, rows * size.1);
    let folder = scratch("rig");
    let start = |name: &str, text: &str, extra: &[&str], cupola: &[&str]| {
        let file = folder.join(name);
        std::fs::write(&file, text).expect("a rig can be written");
        let run = Run { size: size_of_all, ..run(extra, cupola) };
        run.vulkan_under(file.to_str().expect("a UTF-8 path"))
    };
    let (vertex, fine, flipped) =
        (["--method", "vertex"], ["--cells", "triangles"], ["--cells", "triangles", "--flip"]);
    let Some(plain) = start("unblended.toml", &rig.unblended, &fine, &vertex) else { return };
    let Some(blended) = start("blended.toml", &rig.blended, &flipped, &vertex) else { return };
    let Some(expected) = start("blended.toml", &rig.blended, &fine, &[]) else { return };
    for projector in &rig.projectors {
        let name = format!("capture-{}.png", projector.name);
        let picture = plain.picture(&name);
        let camera = camera_of(&run(&fine, &vertex));
        let report = compare(&picture, shown_by_projector(projector, &rig.dome, camera));
        expect_good(&report, &picture, &format!("vk_cube, vertex, {}", projector.name));
        // The weights are those of the default method; the picture is off where the cube's edges are resampled.
        let (found, expected) = (blended.picture(&name), expected.picture(&name));
        let far = far(&found, &expected);
        assert!(far < 0.01, "{}: {far} of the pixels are off", projector.name);
        assert!(picture.pixels.iter().zip(&found.pixels).any(|(a, b)| a[0].abs_diff(b[0]) > 40), "nothing is blended");
    }
}

/// What is flat is where it is with views: on the panel after the scene, behind it before the scene.
#[test]
fn flat_drawing_over_and_behind_the_scene() {
    let start = |flat: &str, method: &str| {
        let (extra, cupola) = (["--cells", "triangles", "--flat", flat], ["--method", method]);
        fisheye(&Run { frames: 5, cupola_frames: 5, ..run(&extra, &cupola) })
    };
    let (Some(found), Some(expected)) = (start("over", "vertex"), start("over", "fragment")) else { return };
    assert_eq!(found.statistics()["panel_draws"], 5);
    let far = far(&found.picture("capture.png"), &expected.picture("capture.png"));
    assert!(far < 0.01, "{far} of the pixels are off");
    let Some(behind) = start("before", "vertex") else { return };
    let picture = behind.picture("capture.png");
    expect_good(&against_the_map(&run(&[], &[]), &picture), &picture, "vk_cube, vertex, with a background");
}

/// What a program draws off screen first has its vertices projected, too.
#[test]
fn scenes_that_are_drawn_off_screen() {
    let vertex = ["--method", "vertex"];
    let direct = run(&[], &vertex);
    let Some(expected) = fisheye(&direct) else { return };
    for way in ["post", "blit"] {
        let extra = ["--way", way];
        let Some(found) = fisheye(&Run { program: "vk_scenes", extra: &extra, frames: 6, ..direct.clone() }) else {
            return;
        };
        let statistics = found.statistics();
        assert_eq!(statistics["views"].as_array().map(Vec::len), Some(1), "{way}: {statistics:#}");
        assert_eq!(statistics["duplicated_framebuffers"], 1, "{way}: {statistics:#}");
        let far = far(&found.picture("capture.png"), &expected.picture("capture.png"));
        assert!(far < 0.02, "{way}: {far} of the pixels are off");
    }
}

/// A program that others wrote: its cube is where it is with views, but for edges that stay straight.
#[test]
fn vkcube_in_one_pass() {
    let start = |method: &str| {
        let cupola = ["--method", method, "--headless", "--frames", "12", "--capture", "capture.png"];
        let cupola = [&cupola[..], &["--stats", "stats.json"]].concat();
        installed("vkcube", &["--width", "300", "--height", "300"], "fisheye", &cupola).map(Finished::expect_success)
    };
    let (Some(found), Some(expected)) = (start("vertex"), start("fragment")) else { return };
    expect_one_pass(&found, "vkcube");
    let far = far(&found.picture("capture.png"), &expected.picture("capture.png"));
    assert!(far < 0.02, "{far} of the pixels are off");
}

/// A shader of the program's own that projects to the picture, with the library's functions in its text, however the views lie.
#[test]
fn a_shader_of_the_program_s_own_projects_to_the_picture() {
    for method in ["vertex", "fragment"] {
        for views in ["atlas", "layers", "images"] {
            let extra = ["--method", method, "--views", views, "--shot", "shot.ppm"];
            let run = Run { program: "vk_project", ..run(&extra, &[]) };
            let Some(finished) = run.vulkan_embedding() else { return };
            let picture = finished.picture("shot.ppm");
            expect_good(&against_the_map(&run, &picture), &picture, &format!("vk_project {extra:?}"));
            // Negative control: a lens of another opening.
            let other = Fisheye { aperture: 176.0, ..CIRCLE };
            assert!(!compare(&picture, shown_by_fisheye(other, camera_of(&run))).good(), "{extra:?}");
        }
    }
}
