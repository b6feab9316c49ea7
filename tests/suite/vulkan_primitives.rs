//! Method `primitive` in Vulkan programs: triangles and lines that a shader stage of Cupola
//! divides, compared with the exact map.

use crate::compare::{LINES, Limits, Shown, compare_with, expect_good, expect_identical, expect_similar};
use crate::dialects::{camera_of, shown_by_fisheye};
use crate::harness::{note, tests};
use crate::picture::Picture;
use crate::programs::{Finished, Run, scratch};
use crate::projected::{
    CIRCLE, GREY, Projectors, against_the_map, expect_one_pass, on_vulkan, run, vk_cube, vulkan_fisheye,
};
use crate::reference::{Vector, cube_colour, cube_face, cube_point};
use crate::vkcube::{self, expect_cube};

tests! {
    large_triangles_are_where_the_exact_map_has_them,
    a_greater_error_is_worse,
    as_with_opengl_and_by_either_stage,
    all_that_shaders_hand_on_arrives,
    clip_distances_are_handed_on,
    what_is_not_divided_far_enough_is_counted,
    as_many_are_coarse_as_with_opengl,
    lines_are_divided,
    what_cannot_be_divided_is_projected,
    libraries_with_all_shaders_are_divided,
    every_projector_gets_its_own_pass_and_blends,
    outputs_with_other_methods_beside,
    flat_drawing_over_and_behind_the_scene,
    scenes_that_are_drawn_off_screen,
    vkcube_in_one_pass,
}

/// Options for an allowed error of half a pixel.
const DIVIDED: [&str; 2] = ["--method", "primitive,max_error=0.5"];

/// Message in the log about a pipeline that is drawn as with the method `vertex`.
const UNDIVIDED: &str = "what a pipeline draws is not divided";

/// Checks that there is one view, nothing is flat, all primitives are fine enough, and the log says
/// nothing about the method.
fn expect_divided(finished: &Finished, what: &str) {
    expect_one_pass(finished, what);
    let statistics = finished.statistics();
    assert_eq!(statistics["coarse_primitives"].as_u64(), Some(0), "{what}: {statistics:#}");
    assert_eq!(statistics["undivided_pipelines"].as_object().map(|all| all.len()), Some(0), "{what}: {statistics:#}");
    let words = finished.words();
    assert!(!words.contains("divided") && !words.contains("instead"), "{what}: {words}");
}

/// The same for several ways of drawing.
fn large_triangles_are_where_the_exact_map_has_them() {
    let ways: [&[&str]; 4] = [
        &["--pass", "1", "--matrix", "push"],
        &["--pass", "2", "--matrix", "block", "--samples", "4", "--indirect"],
        &["--pass", "dynamic", "--matrix", "pushed", "--flip", "--fixed"],
        &["--pass", "1", "--matrix", "copied", "--secondary", "--once"],
    ];
    for way in ways {
        let run = vk_cube(way, &DIVIDED);
        let Some(finished) = vulkan_fisheye(&run) else { return };
        let picture = finished.picture("capture.png");
        expect_good(&against_the_map(&run, &picture), &picture, &format!("vk_cube {way:?}, primitive"));
        expect_divided(&finished, &format!("{way:?}"));
    }
}

/// A greater allowed error gives a greater error. Without division the error is obvious.
fn a_greater_error_is_worse() {
    let worst = |method: &str| {
        let cupola = ["--method", method];
        let run = vk_cube(&[], &cupola);
        let picture = vulkan_fisheye(&run)?.picture("capture.png");
        let report = against_the_map(&run, &picture);
        Some((report.worst, report.wrong * 4 > report.compared))
    };
    let mut last = 0.0;
    for (bound, allowed) in [("0.25", 2.0), ("0.5", 2.0), ("2", 8.0), ("8", 32.0)] {
        let Some((worst, _)) = worst(&format!("primitive,max_error={bound}")) else { return };
        note(format_args!("{bound} px allowed: {worst:.2}/255"));
        assert!(worst <= allowed && worst >= 0.5 * last, "{bound} px: {worst:.2}/255 after {last:.2}/255");
        last = worst;
    }
    assert!(last > 3.0, "with 8 pixels allowed an error of {last:.2}/255 is too small to be measured");
    let Some((_, a_quarter_is_wrong)) = worst("vertex") else { return };
    assert!(a_quarter_is_wrong, "the picture without division is nearly right");
}

/// Both APIs use the same functions for the division, and Cupola has a geometry stage and a
/// tessellation stage.
fn as_with_opengl_and_by_either_stage() {
    let run = vk_cube(&[], &DIVIDED);
    let opengl = Run { program: "core330_mvp", ..run.clone() };
    let (Some(vulkan), Some(opengl)) = (vulkan_fisheye(&run), opengl.under("fisheye")) else { return };
    let (found, expected) = (vulkan.picture("capture.png"), opengl.expect_success().picture("capture.png"));
    for (picture, api) in [(&found, "Vulkan"), (&expected, "OpenGL")] {
        expect_good(&against_the_map(&run, picture), picture, &format!("large triangles on {api}"));
    }
    expect_similar(&found, &expected, 1, 1e-3, "Vulkan against OpenGL");
    let tessellated = ["--method", "primitive-tessellation,max_error=0.5"];
    let Some(finished) = vulkan_fisheye(&vk_cube(&[], &tessellated)) else { return };
    expect_identical(&finished.picture("capture.png"), &found, "primitive-tessellation");
    expect_divided(&finished, "primitive-tessellation");
}

/// Values of many types are passed through the stage. Flat values come from the right vertex. A
/// wrong value would change the colour.
fn all_that_shaders_hand_on_arrives() {
    let cases: [&[&str]; 5] = [
        &["--shape", "list", "--number"],
        &["--shape", "strip"],
        &["--shape", "fan", "--last", "--number"],
        &["--shape", "strip", "--last", "--by-commands"],
        &["--shape", "fan"],
    ];
    for extra in cases {
        // With a smaller error the stage has no room for so many values.
        let run = run("vk_handed", extra, &["--method", "primitive,max_error=1"]);
        let Some(finished) = vulkan_fisheye(&run) else { return };
        let picture = finished.picture("capture.png");
        let report = compare_with(
            &picture,
            Limits::OF_ONE_PIXEL,
            shown_by_fisheye(CIRCLE, camera_of(&run)),
            cube_colour,
            cube_face,
        );
        expect_good(&report, &picture, &format!("vk_handed {extra:?}"));
        expect_divided(&finished, &format!("{extra:?}"));
    }
}

/// Surfaces beyond a clip plane of the program stay clipped.
fn clip_distances_are_handed_on() {
    for (method, limits) in [("primitive,max_error=1", Limits::OF_ONE_PIXEL), ("fragment", Limits::USUAL)] {
        let cupola = ["--method", method];
        let run = run("vk_handed", &["--clip"], &cupola);
        let Some(finished) = vulkan_fisheye(&run) else { return };
        let picture = finished.picture("capture.png");
        let clipped = |direction: Vector| cube_point(direction)[0] < -0.5;
        let colour = |direction: Vector| match clipped(direction) {
            true => [64.0 / 255.0; 3],
            false => cube_colour(direction),
        };
        let cell = |direction: Vector| 2 * cube_face(direction) + usize::from(clipped(direction));
        let report = compare_with(&picture, limits, shown_by_fisheye(CIRCLE, camera_of(&run)), colour, cell);
        let grey = picture.pixels.iter().filter(|pixel| **pixel == GREY).count();
        assert!(grey > 2000, "{grey} pixels are clipped");
        expect_good(&report, &picture, &format!("vk_handed, clipped, {method}"));
    }
}

/// Number of primitives that a run did not divide far enough.
fn coarse(finished: &Finished) -> u64 {
    let statistics = finished.statistics();
    statistics["coarse_primitives"].as_u64().unwrap_or_else(|| panic!("nothing is counted: {statistics:#}"))
}

/// A rig that shows all directions around the viewer, also the antipode of the axis.
fn whole() -> String {
    let file = scratch("rig").join("whole.toml");
    std::fs::write(&file, "[[output]]\nkind = \"domemaster\"\naperture = 360\ntilt = 90\n")
        .expect("a rig can be written");
    file.to_str().expect("a UTF-8 path").to_owned()
}

/// Triangles and lines that a run of the stage cannot divide far enough are counted, whether Cupola
/// ends the program or the program ends itself. If all are divided far enough, the number is 0.
fn what_is_not_divided_far_enough_is_counted() {
    for (shape, rig) in [("list", "fisheye".to_owned()), ("lines", whole())] {
        let count = |max_error: &str, frames: usize, ends: &[&str]| {
            let (extra, method) = (["--shape", shape], format!("primitive,max_error={max_error}"));
            let cupola = [&["--method", &method], ends].concat();
            let run = Run { frames, ..run("vk_handed", &extra, &cupola) };
            Some(coarse(&run.vulkan_under(&rig)?))
        };
        let (Some(one), Some(five)) = (count("0.05", 1, &[]), count("0.05", 5, &[])) else { return };
        let (Some(ended), Some(none)) = (count("0.05", 9, &["--frames", "5"]), count("2", 5, &[])) else { return };
        let told = format!(
            "{shape}: {one} in a frame, {five} in five, {ended} if Cupola ends the program, {none} with 2 pixels"
        );
        note(format_args!("{told}"));
        assert!(one > 0 && five == 5 * one && ended == five && none == 0, "{told}");
    }
}

/// On neither API can a stage make enough parts of the sphere around the antipode.
fn as_many_are_coarse_as_with_opengl() {
    let rig = &whole();
    let vulkan = vk_cube(&[], &["--method", "primitive"]);
    let opengl = Run { program: "core330_mvp", ..vulkan.clone() };
    let (Some(vulkan), Some(opengl)) = (vulkan.vulkan_under(rig), opengl.under(rig)) else { return };
    let (vulkan, opengl) = (coarse(&vulkan), coarse(&opengl.expect_success()));
    note(format_args!("coarse: {vulkan} on Vulkan, {opengl} on OpenGL"));
    // The number is 273 on both of Mesa's software renderers.
    assert!(opengl > 0 && vulkan.abs_diff(opengl) * 50 <= opengl, "{vulkan} on Vulkan, {opengl} on OpenGL");
}

/// Number of pixels of lines, and the greatest difference of their colours from the colours of
/// their places.
fn lines(picture: &Picture, run: &Run) -> (usize, f64) {
    let shown = shown_by_fisheye(CIRCLE, camera_of(run));
    let (mut lit, mut worst) = (0, 0.0f64);
    for (x, y) in (0..picture.height).flat_map(|y| (0..picture.width).map(move |x| (x, y))) {
        let found = picture.at(x, y);
        let Shown::Direction(direction) = shown(x as f64 + 0.5, y as f64 + 0.5) else { continue };
        if found == GREY {
            continue;
        }
        lit += 1;
        let expected = cube_colour(direction).map(|channel| 255.0 * channel);
        let off = [0, 1, 2].map(|channel| (f64::from(found[channel]) - expected[channel]).abs());
        worst = worst.max(off.into_iter().fold(0.0, f64::max));
    }
    (lit, worst)
}

fn lines_are_divided() {
    let cases: [&[&str]; 3] = [
        &["--shape", "lines"],
        &["--shape", "line-strip", "--last"],
        &["--shape", "lines", "--by-commands", "--number"],
    ];
    for extra in cases {
        let start = |cupola: &[&str]| {
            let run = run("vk_handed", extra, cupola);
            let finished = vulkan_fisheye(&run)?;
            Some((lines(&finished.picture("capture.png"), &run), finished))
        };
        let Some(((lit, worst), finished)) = start(&DIVIDED) else { return };
        note(format_args!("{extra:?}: {lit} pixels, {worst:.2}/255"));
        assert!((1100..1350).contains(&lit) && worst < LINES, "{extra:?}: {lit} pixels, {worst:.2}/255");
        expect_divided(&finished, &format!("{extra:?}"));
        let Some(((_, worst), _)) = start(&["--method", "vertex"]) else { return };
        assert!(worst > 20.0, "{extra:?}: without division the error is only {worst:.2}/255");
    }
}

/// Pipelines that cannot be divided are drawn as with the method `vertex`, and the log gives the
/// reason once.
fn what_cannot_be_divided_is_projected() {
    let cases: [(&str, &[&str], &str); 4] = [
        ("vk_handed", &["--cull"], "cull distances"),
        ("vk_cube", &["--cells", "triangles", "--stage", "geometry"], "shaders of its own"),
        ("vk_cube", &["--cells", "triangles", "--stage", "tessellation"], "shaders of its own"),
        ("vk_scenes", &["--way", "parts"], "libraries"),
    ];
    for (program, extra, why) in cases {
        let start = |method: &str| vulkan_fisheye(&run(program, extra, &["--method", method]));
        let (Some(found), Some(expected)) = (start("primitive"), start("vertex")) else { return };
        let what = format!("{program} {extra:?}");
        expect_identical(&found.picture("capture.png"), &expected.picture("capture.png"), &what);
        let words = found.words();
        let lines: Vec<&str> = words.lines().filter(|line| line.contains(UNDIVIDED)).collect();
        assert!(lines.len() == 1 && lines[0].contains(why), "{what}: {words}");
        assert!(!expected.words().contains(UNDIVIDED), "{what}: {}", expected.words());
        let statistics = found.statistics();
        let reasons = statistics["undivided_pipelines"].as_object().expect("numbers by reason");
        let told = |(reason, number): (&String, &serde_json::Value)| reason.contains(why) && number.as_u64() > Some(0);
        assert!(reasons.len() == 1 && reasons.iter().all(told), "{what}: {statistics:#}");
    }
    // Points need no division, so the log says nothing.
    let start = |method: &str| vulkan_fisheye(&vk_cube(&["--cells", "points"], &["--method", method]));
    let (Some(found), Some(expected)) = (start("primitive"), start("vertex")) else { return };
    expect_identical(&found.picture("capture.png"), &expected.picture("capture.png"), "points");
    assert!(!found.words().contains(UNDIVIDED), "{}", found.words());
}

/// A library with all shaders also gets the stage. Its structure chain enables features.
fn libraries_with_all_shaders_are_divided() {
    let extra = ["--way", "library"];
    let run = run("vk_scenes", &extra, &DIVIDED);
    let Some(finished) = vulkan_fisheye(&run) else { return };
    let picture = finished.picture("capture.png");
    expect_good(&against_the_map(&run, &picture), &picture, "vk_scenes, libraries");
    assert!(!finished.words().contains("divided"), "{}", finished.words());
}

/// Projectors away from the middle of the dome, with lenses of their own and with blending.
fn every_projector_gets_its_own_pass_and_blends() {
    let divided = ["--method", "primitive,max_error=0.25"];
    let projectors = Projectors::new();
    let run = vk_cube(&[], &divided);
    let Some(plain) = projectors.unblended(&run, on_vulkan) else { return };
    let Some(blended) = projectors.blended(&vk_cube(&["--flip"], &divided), on_vulkan) else { return };
    let Some(expected) = projectors.blended(&vk_cube(&[], &[]), on_vulkan) else { return };
    projectors.expect_good(&plain, &run, "vk_cube, primitive");
    projectors.expect_blended(&plain, &blended, &expected);
}

/// Of two outputs one is divided and one is drawn from a view.
fn outputs_with_other_methods_beside() {
    let output = |name: &str, left: u32, method: &str| {
        format!(
            "[[output]]\nname = \"{name}\"\nkind = \"domemaster\"\naperture = 180\ntilt = 90\n\
             window = [{left}, 0, 256, 256]\nmethod = \"{method}\"\n"
        )
    };
    let file = scratch("rig").join("two.toml");
    let text = [output("divided", 0, "primitive"), output("views", 256, "fragment")].concat();
    std::fs::write(&file, text).expect("a rig can be written");
    let run = Run { size: (512, 256), ..vk_cube(&[], &[]) };
    let Some(finished) = run.vulkan_under(file.to_str().expect("a UTF-8 path")) else { return };
    for name in ["divided", "views"] {
        let picture = finished.picture(&format!("capture-{name}.png"));
        expect_good(&against_the_map(&run, &picture), &picture, &format!("output {name} of two"));
    }
}

/// Flat drawing over the scene and before it is neither divided nor projected.
fn flat_drawing_over_and_behind_the_scene() {
    let start = |flat: &str, method: &str| {
        let (extra, cupola) = (["--flat", flat], ["--method", method]);
        vulkan_fisheye(&Run { frames: 5, cupola_frames: 5, ..vk_cube(&extra, &cupola) })
    };
    let (Some(found), Some(expected)) = (start("over", DIVIDED[1]), start("over", "fragment")) else { return };
    assert_eq!(found.statistics()["panel_draws"], 5);
    let (found, expected) = (found.picture("capture.png"), expected.picture("capture.png"));
    // 36 % of the pixels were found to differ.
    expect_similar(&found, &expected, 2, 0.73, "flat over the divided scene");
    let Some(behind) = start("before", DIVIDED[1]) else { return };
    let picture = behind.picture("capture.png");
    expect_good(&against_the_map(&vk_cube(&[], &[]), &picture), &picture, "vk_cube, primitive, with a background");
}

/// A scene that the program draws off screen is divided, too.
fn scenes_that_are_drawn_off_screen() {
    let direct = vk_cube(&[], &DIVIDED);
    let Some(expected) = vulkan_fisheye(&direct) else { return };
    let extra = ["--way", "post"];
    let Some(found) = vulkan_fisheye(&Run { program: "vk_scenes", extra: &extra, frames: 6, ..direct.clone() }) else {
        return;
    };
    let statistics = found.statistics();
    assert_eq!(statistics["duplicated_framebuffers"], 1, "{statistics:#}");
    let (found, expected) = (found.picture("capture.png"), expected.picture("capture.png"));
    expect_identical(&found, &expected, "drawn off screen");
}

/// A program by other authors: the cube is at the same place as with views.
fn vkcube_in_one_pass() {
    let start = |method: &str| vkcube::fisheye(&["--method", method]);
    let (Some(found), Some(expected)) = (start("primitive"), start("fragment")) else { return };
    expect_divided(&found, "vkcube");
    let [found, expected] = [found, expected].map(|finished| finished.picture("capture.png"));
    let cubes = [&found, &expected].map(|picture| expect_cube(picture, "vkcube"));
    let off = vkcube::off(&found, &expected);
    note(format_args!("{cubes:?} pixels of cubes, {off:.3} of them are off"));
    assert!(off < 0.04, "{off:.3} of the cube's pixels are off");
}
