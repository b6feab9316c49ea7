//! Method `vertex` in Vulkan programs: vertices that are projected directly to an output, compared
//! with the exact map.

use crate::compare::{compare, expect_good, expect_identical, expect_points, expect_similar};
use crate::dialects::{camera_of, shown_by_fisheye};
use crate::harness::{note, tests};
use crate::programs::Run;
use crate::projected::{
    CIRCLE, GREY, Projectors, against_the_map, expect_one_pass, on_vulkan, vk_cube, vulkan_fisheye,
};
use crate::reference::Fisheye;
use crate::vkcube::{self, expect_cube};

tests! {
    fine_triangles_are_where_the_exact_map_has_them,
    other_stages_project,
    what_is_nearer_hides_what_is_farther,
    large_triangles_stay_straight_between_their_vertices,
    points_are_where_the_exact_map_has_them,
    as_with_opengl,
    every_projector_gets_its_own_pass_and_blends,
    flat_drawing_over_and_behind_the_scene,
    scenes_that_are_drawn_off_screen,
    vkcube_in_one_pass,
    a_shader_of_the_program_s_own_projects_to_the_picture,
}

/// Ways to draw the cube: how the pass begins, where the matrix is, the direction of y, the number
/// of samples.
const WAYS: [&[&str]; 6] = [
    &["--pass", "1", "--matrix", "push"],
    &["--pass", "2", "--matrix", "block", "--samples", "4"],
    &["--pass", "dynamic", "--matrix", "push", "--flip"],
    &["--pass", "imageless", "--matrix", "dynamic", "--flip"],
    &["--pass", "1", "--matrix", "copied", "--secondary", "--once"],
    &["--pass", "dynamic", "--matrix", "pushed", "--fixed"],
];

fn fine_triangles_are_where_the_exact_map_has_them() {
    for (way, cells) in WAYS.into_iter().zip(["triangles", "ball"].into_iter().cycle()) {
        let extra = [way, &["--cells", cells]].concat();
        let run = vk_cube(&extra, &["--method", "vertex"]);
        let Some(finished) = vulkan_fisheye(&run) else { return };
        let picture = finished.picture("capture.png");
        expect_good(&against_the_map(&run, &picture), &picture, &format!("vk_cube {extra:?}, vertex"));
        expect_one_pass(&finished, &format!("{extra:?}"));
    }
}

/// A geometry shader or a tessellation shader is the last stage and projects.
fn other_stages_project() {
    for stage in ["geometry", "tessellation"] {
        let extra = ["--cells", "triangles", "--stage", stage];
        for method in ["vertex", "fragment"] {
            let cupola = ["--method", method];
            let run = vk_cube(&extra, &cupola);
            let Some(finished) = vulkan_fisheye(&run) else { return };
            let picture = finished.picture("capture.png");
            expect_good(&against_the_map(&run, &picture), &picture, &format!("vk_cube {extra:?}, {method}"));
            if method == "vertex" {
                expect_one_pass(&finished, stage);
            }
        }
    }
}

/// The depth test uses the distance as depth: a ball hides everything that is drawn around it
/// later.
fn what_is_nearer_hides_what_is_farther() {
    for turned in [&[][..], &["--flip"]] {
        let extra = [&["--cells", "behind"], turned].concat();
        let run = vk_cube(&extra, &["--method", "vertex"]);
        let Some(finished) = vulkan_fisheye(&run) else { return };
        let picture = finished.picture("capture.png");
        expect_good(&against_the_map(&run, &picture), &picture, &format!("vk_cube {extra:?}, vertex"));
    }
}

/// Negative control: large triangles differ from the exact map.
fn large_triangles_stay_straight_between_their_vertices() {
    let run = vk_cube(&[], &["--method", "vertex"]);
    let Some(finished) = vulkan_fisheye(&run) else { return };
    let report = against_the_map(&run, &finished.picture("capture.png"));
    assert!(report.wrong > report.compared / 4, "{} of {} pixels are wrong", report.wrong, report.compared);
}

fn points_are_where_the_exact_map_has_them() {
    let run = vk_cube(&["--cells", "points"], &["--method", "vertex"]);
    let Some(finished) = vulkan_fisheye(&run) else { return };
    let picture = finished.picture("capture.png");
    expect_points(&picture, GREY, shown_by_fisheye(CIRCLE, camera_of(&run)));
}

/// Both APIs use the same functions.
fn as_with_opengl() {
    let vulkan = vk_cube(&["--cells", "triangles"], &["--method", "vertex"]);
    let opengl = Run { program: "fine", extra: &[], ..vulkan.clone() };
    let (Some(vulkan), Some(opengl)) = (vulkan_fisheye(&vulkan), opengl.under("fisheye")) else { return };
    let opengl = opengl.expect_success().picture("capture.png");
    // 2 pixels were found to differ.
    expect_similar(&vulkan.picture("capture.png"), &opengl, 1, 1e-4, "fine triangles on Vulkan against OpenGL");
}

/// Projectors away from the middle of the dome, with y up and y down.
fn every_projector_gets_its_own_pass_and_blends() {
    let (vertex, fine, flipped) =
        (["--method", "vertex"], ["--cells", "triangles"], ["--cells", "triangles", "--flip"]);
    let projectors = Projectors::new();
    let run = vk_cube(&fine, &vertex);
    let Some(plain) = projectors.unblended(&run, on_vulkan) else { return };
    let Some(blended) = projectors.blended(&vk_cube(&flipped, &vertex), on_vulkan) else { return };
    let Some(expected) = projectors.blended(&vk_cube(&fine, &[]), on_vulkan) else { return };
    projectors.expect_good(&plain, &run, "vk_cube, vertex");
    projectors.expect_blended(&plain, &blended, &expected);
}

/// Flat drawing is at the same place as with views: on the panel after the scene, behind the scene
/// before it.
fn flat_drawing_over_and_behind_the_scene() {
    let start = |flat: &str, method: &str| {
        let (extra, cupola) = (["--cells", "triangles", "--flat", flat], ["--method", method]);
        vulkan_fisheye(&Run { frames: 5, cupola_frames: 5, ..vk_cube(&extra, &cupola) })
    };
    let (Some(found), Some(expected)) = (start("over", "vertex"), start("over", "fragment")) else { return };
    assert_eq!(found.statistics()["panel_draws"], 5);
    let (found, expected) = (found.picture("capture.png"), expected.picture("capture.png"));
    // 31 % of the pixels were found to differ.
    expect_similar(&found, &expected, 1, 0.62, "flat over the projected scene");
    let Some(behind) = start("before", "vertex") else { return };
    let picture = behind.picture("capture.png");
    expect_good(&against_the_map(&vk_cube(&[], &[]), &picture), &picture, "vk_cube, vertex, with a background");
}

/// The vertices of a scene that the program draws off screen are projected, too.
fn scenes_that_are_drawn_off_screen() {
    let vertex = ["--method", "vertex"];
    let direct = vk_cube(&[], &vertex);
    let Some(expected) = vulkan_fisheye(&direct) else { return };
    for way in ["post", "blit"] {
        let extra = ["--way", way];
        let Some(found) = vulkan_fisheye(&Run { program: "vk_scenes", extra: &extra, frames: 6, ..direct.clone() })
        else {
            return;
        };
        let statistics = found.statistics();
        assert_eq!(statistics["views"].as_array().map(Vec::len), Some(1), "{way}: {statistics:#}");
        assert_eq!(statistics["duplicated_framebuffers"], 1, "{way}: {statistics:#}");
        let (found, expected) = (found.picture("capture.png"), expected.picture("capture.png"));
        expect_identical(&found, &expected, way);
    }
}

/// A program by other authors: the cube is at the same place as with views, except for edges that
/// stay straight.
fn vkcube_in_one_pass() {
    let start = |method: &str| vkcube::fisheye(&["--method", method]);
    let (Some(found), Some(expected)) = (start("vertex"), start("fragment")) else { return };
    expect_one_pass(&found, "vkcube");
    let [found, expected] = [found, expected].map(|finished| finished.picture("capture.png"));
    let cubes = [&found, &expected].map(|picture| expect_cube(picture, "vkcube"));
    let off = vkcube::off(&found, &expected);
    note(format_args!("{cubes:?} pixels of cubes, {off:.3} of them are off"));
    assert!(off < 0.04, "{off:.3} of the cube's pixels are off");
}

/// A program whose own shader projects to the output, with the library's functions in its text, in
/// each arrangement of the views. The same program, compiled with the published headers of version
/// 0.1, shows the same.
fn a_shader_of_the_program_s_own_projects_to_the_picture() {
    for method in ["vertex", "fragment"] {
        for views in ["atlas", "layers", "images"] {
            let extra = ["--method", method, "--views", views, "--shot", "shot.ppm"];
            let run = Run { program: "vk_project", ..vk_cube(&extra, &[]) };
            let Some(finished) = run.vulkan_embedding() else { return };
            let picture = finished.picture("shot.ppm");
            let Some(first) = run.vulkan_embedding_of_first_version() else { return };
            expect_identical(&first.picture("shot.ppm"), &picture, &format!("vk_project 0.1 {extra:?}"));
            expect_good(&against_the_map(&run, &picture), &picture, &format!("vk_project {extra:?}"));
            // Negative control: a lens with another opening angle.
            let other = Fisheye { aperture: 176.0, ..CIRCLE };
            assert!(!compare(&picture, shown_by_fisheye(other, camera_of(&run))).good(), "{extra:?}");
        }
    }
}
