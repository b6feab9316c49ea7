//! The Vulkan layer: unmodified programs are drawn for each view. They are shown flat if that is
//! not possible, and stay unchanged with the rig `identity`.

use crate::compare::{Limits, Shown, compare, compare_with, expect_good, expect_identical, expect_similar};
use crate::dialects::{CAMERAS, camera_of, planetarium_of, shown_by_fisheye, shown_by_window};
use crate::harness::tests;
use crate::picture::Picture;
use crate::programs::Run;
use crate::reference::{Fisheye, Vector, cube_colour, cube_face};

tests! {
    the_cube_without_cupola,
    every_way_of_drawing_fills_the_dome,
    depth_in_a_pass_of_its_own,
    every_lens_and_turn,
    six_projectors,
    identity_changes_no_byte,
    identity_captured_loses_nothing,
    a_lens_that_the_rig_gives,
    a_program_without_a_scene_is_told_so,
    an_srgb_swapchain,
    as_with_opengl,
    flat_drawing_over_and_behind_the_scene,
    a_program_that_reads_the_window_is_shown_flat,
    scenes_that_are_drawn_off_screen,
    scenes_off_screen_from_the_first_frame_on,
    scenes_off_screen_with_the_programs_own_lens,
    a_scene_off_screen_that_is_read,
    a_scene_off_screen_whose_colours_and_depths_are_read,
    a_background_off_screen,
    six_projectors_of_scenes_off_screen,
    scenes_off_screen_that_stay_flat,
    a_window_that_is_read,
    the_newest_ways_to_present,
    pipelines_that_are_linked,
    programs_that_stay_flat_say_why,
    passes_of_two_subpasses,
    a_part_of_the_window,
    the_window_is_resized,
    many_sizes_leave_nothing_behind,
    the_panel_is_where_the_angles_say,
    what_is_out_of_sight_is_not_drawn,
    places_in_the_window,
}

/// Ways to draw the cube: how the pass begins, where the matrix is, and other things that programs
/// do.
const WAYS: [&[&str]; 17] = [
    &["--pass", "1", "--matrix", "push"],
    &["--pass", "2", "--matrix", "block"],
    &["--pass", "dynamic", "--matrix", "push"],
    &["--pass", "imageless", "--matrix", "dynamic", "--flip"],
    &["--pass", "dynamic", "--matrix", "block", "--samples", "4", "--once"],
    &["--pass", "1", "--matrix", "copied", "--samples", "4"],
    &["--pass", "1", "--matrix", "block", "--once", "--fixed", "--indirect"],
    &["--pass", "1", "--matrix", "dynamic", "--secondary"],
    &["--pass", "dynamic", "--matrix", "push", "--secondary", "--flip", "--samples", "4"],
    &["--pass", "2", "--matrix", "copied", "--secondary", "--once"],
    &["--pass", "imageless", "--matrix", "push", "--secondary"],
    &["--pass", "dynamic", "--matrix", "pushed", "--flip"],
    &["--pass", "dynamic", "--array", "columns", "--once"],
    &["--pass", "1", "--array", "rows", "--flip"],
    &["--pass", "1", "--array", "row-vector", "--once"],
    &["--pass", "1", "--clip"],
    &["--pass", "dynamic", "--clip", "--flip", "--samples", "4"],
];

const CIRCLE: Fisheye = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };

fn run<'a>(extra: &'a [&'a str], (fov, yaw, pitch): (f64, f64, f64)) -> Run<'a> {
    Run { fov, yaw, pitch, extra, ..Run::new("vk_cube") }
}

/// Without Cupola the program draws the predicted picture in every way.
fn the_cube_without_cupola() {
    for way in WAYS {
        let extra = [way, &["--shot", "shot.ppm"]].concat();
        let run = Run { size: (256, 192), ..run(&extra, CAMERAS[1]) };
        let Some(finished) = run.vulkan_plain() else { return };
        let picture = finished.expect_success().picture("shot.ppm");
        let report = compare(&picture, shown_by_window(run.size, run.fov, camera_of(&run)));
        expect_good(&report, &picture, &format!("vk_cube {way:?}"));
    }
}

/// In every way each pixel of the domemaster shows its direction, and nothing is flat.
fn every_way_of_drawing_fills_the_dome() {
    for (index, way) in WAYS.into_iter().enumerate() {
        let run = run(way, CAMERAS[index % CAMERAS.len()]);
        let Some(finished) = run.vulkan_under("fisheye") else { return };
        let picture = finished.picture("capture.png");
        let report = compare(&picture, shown_by_fisheye(CIRCLE, camera_of(&run)));
        expect_good(&report, &picture, &format!("vk_cube {way:?} fisheye"));
        let statistics = finished.statistics();
        assert_eq!(statistics["draws_seen"], 3, "{way:?}: {statistics:#}");
        assert_eq!(statistics["panel_draws"], 0, "{way:?}: {statistics:#}");
    }
}

/// A fragment shader that reads its place gets, in each view, the place in the program's window.
fn places_in_the_window() {
    for way in [&["--place"][..], &["--place", "--flip", "--pass", "dynamic", "--once"]] {
        let run = Run { cupola: &["--capture-views", "views"], ..run(way, CAMERAS[1]) };
        let Some(finished) = run.vulkan_under("fisheye") else { return };
        let views = std::fs::read_dir(finished.directory.join("views")).expect("views");
        let names = views.map(|file| file.expect("a file").file_name().to_string_lossy().into_owned());
        let names: Vec<String> = names.filter(|name| !name.contains("panel")).collect();
        assert!(names.len() > 2, "{way:?}: {names:?}");
        for name in names {
            let view = finished.picture(&format!("views/{name}"));
            let place = |at: usize, length: usize| 255.0 * (at as f64 + 0.5) / length as f64;
            let expected = |x, y| [place(x, view.width), place(y, view.height)];
            let off = |x, y| view.at(x, y).into_iter().zip(expected(x, y)).map(|(a, b)| (f64::from(a) - b).abs());
            let places = (0..view.height).flat_map(|y| (0..view.width).map(move |x| (x, y)));
            let worst = places.flat_map(|(x, y)| off(x, y)).fold(0.0, f64::max);
            assert!(worst < 1.1, "{way:?} {name}: off by {worst}/255");
        }
    }
}

/// A pass without colours clears or draws depth. The next pass draws to the window with that depth.
fn depth_in_a_pass_of_its_own() {
    for (index, way) in DEPTHS.into_iter().enumerate() {
        let way = &[way, &["--shot", "shot.ppm"][..]].concat();
        let run = run(way, CAMERAS[index % CAMERAS.len()]);
        let Some(finished) = run.vulkan_under("fisheye") else { return };
        let picture = finished.picture("capture.png");
        let report = compare(&picture, shown_by_fisheye(CIRCLE, camera_of(&run)));
        expect_good(&report, &picture, &format!("vk_cube {way:?} fisheye"));
        assert_eq!(finished.statistics()["panel_draws"], 0, "{way:?}");
        let (Some(plain), Some(under)) = (run.vulkan_plain(), run.vulkan_under("identity-captured")) else { return };
        let plain = plain.expect_success().picture("shot.ppm");
        expect_identical(&under.picture("shot.ppm"), &plain, &format!("vk_cube {way:?} identity-captured"));
    }
}

const DEPTHS: [&[&str]; 6] = [
    &["--depth", "cleared"],
    &["--depth", "drawn", "--once"],
    &["--depth", "cleared", "--pass", "dynamic", "--once"],
    &["--depth", "drawn", "--pass", "dynamic", "--draws", "3"],
    &["--depth", "readable", "--pass", "dynamic", "--once"],
    &["--depth", "drawn", "--samples", "4"],
];

fn every_lens_and_turn() {
    for camera in CAMERAS {
        let run = run(&["--shot", "shot.ppm"], camera);
        let Some(finished) = run.vulkan_under("fisheye") else { return };
        let picture = finished.picture("capture.png");
        expect_good(&compare(&picture, shown_by_fisheye(CIRCLE, camera_of(&run))), &picture, &format!("{camera:?}"));
        expect_identical(&finished.picture("shot.ppm"), &picture, "window against capture");
    }
}

fn six_projectors() {
    for way in &WAYS[..4] {
        planetarium_of("vk_cube", way, Run::vulkan_under);
    }
}

fn identity_changes_no_byte() {
    for way in &WAYS[..6] {
        let extra = [way, &["--shot", "shot.ppm"][..]].concat();
        let run = run(&extra, CAMERAS[1]);
        let (Some(plain), Some(under)) = (run.vulkan_plain(), run.vulkan_under("identity")) else { return };
        let plain = plain.expect_success().picture("shot.ppm");
        expect_identical(&under.picture("shot.ppm"), &plain, &format!("vk_cube {way:?} identity"));
    }
}

/// With the program's own lens the picture is the same as the window's, to the byte, although it
/// passes through the atlas and the correction.
fn identity_captured_loses_nothing() {
    for (way, camera) in [WAYS[0], WAYS[3], WAYS[5]].into_iter().zip(CAMERAS) {
        let extra = [way, &["--shot", "shot.ppm"][..]].concat();
        let run = run(&extra, camera);
        let (Some(plain), Some(under)) = (run.vulkan_plain(), run.vulkan_under("identity-captured")) else { return };
        let plain = plain.expect_success().picture("shot.ppm");
        expect_identical(&under.picture("shot.ppm"), &plain, &format!("vk_cube {way:?} identity-captured"));
    }
}

/// The shader has no matrix. If the rig gives the program's lens, the picture is right. Otherwise
/// it is flat.
fn a_lens_that_the_rig_gives() {
    crate::dialects::given_lens("vulkan", &run(&["--columns"], CAMERAS[1]), Run::vulkan_under);
}

/// After some hundred draws without a scene the log says what to try. A program with a scene gets
/// no such message.
fn a_program_without_a_scene_is_told_so() {
    for (way, told) in [("--columns", true), ("--indirect", false)] {
        let extra = [way, "--draws", "120"];
        let run = run(&extra, CAMERAS[0]);
        let Some(finished) = run.vulkan_under("fisheye") else { return };
        assert_eq!(finished.words().contains("set camera.lens"), told, "{way}: {}", finished.words());
    }
    for (program, frames, told) in [("no_matrix", 301, true), ("many_calls", 30, false)] {
        let run = Run { frames, cupola_frames: frames, size: (64, 64), ..Run::new(program) };
        let Some(finished) = run.under("fisheye") else { return };
        assert_eq!(finished.words().contains("set camera.lens"), told, "{program}: {}", finished.words());
    }
}

/// Images that encode written colours as sRGB.
fn an_srgb_swapchain() {
    let run = run(&["--srgb"], CAMERAS[1]);
    let Some(finished) = run.vulkan_under("fisheye") else { return };
    let encoded = |direction: Vector| {
        cube_colour(direction).map(|c| if c <= 0.0031308 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 })
    };
    let picture = finished.picture("capture.png");
    let report = compare_with(&picture, Limits::USUAL, shown_by_fisheye(CIRCLE, camera_of(&run)), encoded, cube_face);
    expect_good(&report, &picture, "vk_cube sRGB");
}

/// The same scene and rig with OpenGL. The pictures differ only by rounding.
fn as_with_opengl() {
    let vulkan = run(&[], CAMERAS[1]);
    let opengl = Run { program: "core330_mvp", ..vulkan.clone() };
    let (Some(vulkan), Some(opengl)) = (vulkan.vulkan_under("fisheye"), opengl.under("fisheye")) else { return };
    let opengl = opengl.expect_success().picture("capture.png");
    // 4 pixels were found to differ.
    expect_similar(&vulkan.picture("capture.png"), &opengl, 1, 1.3e-4, "vk_cube against OpenGL");
}

/// Flat drawing after the scene is on the panel in front of it. Flat drawing before the scene is
/// behind it.
fn flat_drawing_over_and_behind_the_scene() {
    for way in [&["--matrix", "push"][..], &["--matrix", "dynamic", "--pass", "dynamic"], &["--matrix", "pushed"]] {
        let over = [way, &["--flat", "over"]].concat();
        let run_over = run(&over, CAMERAS[1]);
        let Some(finished) = run_over.vulkan_under("fisheye") else { return };
        assert_eq!(finished.statistics()["panel_draws"], 3, "{way:?}");
        let report = compare(&finished.picture("capture.png"), shown_by_fisheye(CIRCLE, camera_of(&run_over)));
        assert!(report.wrong > 100, "control: the square on the panel hides no part of the cube");
        let before = [way, &["--flat", "before"]].concat();
        let run_before = Run { frames: 5, ..run(&before, CAMERAS[1]) };
        let Some(finished) = run_before.vulkan_under("fisheye") else { return };
        let picture = finished.picture("capture.png");
        let report = compare(&picture, shown_by_fisheye(CIRCLE, camera_of(&run_before)));
        expect_good(&report, &picture, &format!("{way:?}: the background is behind"));
    }
}

/// A program that cannot be followed is shown flat, and the log gives the reason.
fn a_program_that_reads_the_window_is_shown_flat() {
    let run = run(&["--copy-window"], CAMERAS[1]);
    let Some(finished) = run.vulkan_under("fisheye") else { return };
    let notes = finished.statistics()["notes"].to_string();
    assert!(notes.contains("flat") && notes.contains("copies"), "{notes}");
    assert!(finished.words().contains("copies"), "{}", finished.words());
}

fn scenes<'a>(extra: &'a [&'a str]) -> Run<'a> {
    Run { extra, frames: 6, ..Run::new("vk_scenes") }
}

/// A scene that the program first draws to images of its own is drawn for each view, however the
/// program shows it in the window.
fn scenes_that_are_drawn_off_screen() {
    for way in ["post", "matrices", "chain", "place", "passes", "blit", "resolve", "half", "depths"] {
        let extra = ["--way", way];
        let run = scenes(&extra);
        let Some(finished) = run.vulkan_under("fisheye") else { return };
        let picture = finished.picture("capture.png");
        let report = compare(&picture, shown_by_fisheye(CIRCLE, camera_of(&run)));
        expect_good(&report, &picture, &format!("vk_scenes {way}"));
        let statistics = finished.statistics();
        let pictures = if ["chain", "half", "depths"].contains(&way) { 2 } else { 1 };
        assert_eq!(statistics["duplicated_framebuffers"], pictures, "{way}: {statistics:#}");
        assert!(statistics["duplicated_draws"].as_u64() > Some(0), "{way}: {statistics:#}");
    }
}

/// If the setting is `always`, images are drawn for each view before they were seen in the window.
fn scenes_off_screen_from_the_first_frame_on() {
    let run = Run { cupola: &["--duplicate", "always"], frames: 1, cupola_frames: 1, ..scenes(&["--way", "chain"]) };
    let Some(finished) = run.vulkan_under("fisheye") else { return };
    let picture = finished.picture("capture.png");
    expect_good(&compare(&picture, shown_by_fisheye(CIRCLE, camera_of(&run))), &picture, "vk_scenes chain, always");
}

/// With the program's own lens a scene that is drawn off screen shows the same as the window
/// without Cupola, to the byte.
fn scenes_off_screen_with_the_programs_own_lens() {
    for way in ["post", "passes", "blit"] {
        let extra = ["--way", way, "--shot", "shot.ppm"];
        let run = scenes(&extra);
        let (Some(plain), Some(under)) = (run.vulkan_plain(), run.vulkan_under("identity-captured")) else { return };
        let plain = plain.expect_success().picture("shot.ppm");
        expect_identical(&under.picture("shot.ppm"), &plain, &format!("vk_scenes {way}, identity-captured"));
        assert_eq!(under.statistics()["duplicated_framebuffers"], 1, "{way}");
    }
}

/// Checks, for a program with these options that reads its own picture: the picture is the same as
/// without Cupola, and the dome shows the views.
fn expect_own_picture(extra: &[&str], rigs: &[&str]) {
    let run = scenes(extra);
    let Some(plain) = run.vulkan_plain() else { return };
    let own = plain.expect_success().picture("own.ppm");
    for rig in rigs {
        let Some(under) = run.vulkan_under(rig) else { return };
        let what = format!("vk_scenes {}, {rig}", extra[1]);
        expect_identical(&under.picture("own.ppm"), &own, &what);
        if *rig == "fisheye" {
            let picture = under.picture("capture.png");
            expect_good(&compare(&picture, shown_by_fisheye(CIRCLE, camera_of(&run))), &picture, &what);
        }
    }
}

/// A program that reads an image of its own gets its own picture.
fn a_scene_off_screen_that_is_read() {
    expect_own_picture(&["--way", "post", "--picture", "own.ppm"], &["fisheye"]);
}

/// A program may copy its scene to memory although its window cannot be copied. It finds the object
/// below the mouse by colours and depths.
fn a_scene_off_screen_whose_colours_and_depths_are_read() {
    expect_own_picture(&["--way", "pick", "--picture", "own.ppm"], &["fisheye"]);
}

/// One triangle without a matrix fills the image before the scene is drawn. It appears behind the
/// scene in all directions.
fn a_background_off_screen() {
    const COLOUR: [u8; 3] = [51, 153, 102];
    let Some(under) = scenes(&["--way", "background"]).vulkan_under("fisheye") else { return };
    let picture = under.picture("capture.png");
    let count = |is: &dyn Fn(&[u8; 3]) -> bool| picture.pixels.iter().filter(|pixel| is(pixel)).count();
    let (filled, black) = (count(&|pixel| *pixel == COLOUR), count(&|pixel| *pixel == [0; 3]));
    let circle = 0.25 * std::f64::consts::PI * CIRCLE.width * CIRCLE.height;
    let outside = (picture.width * picture.height) as f64 - circle;
    println!(
        "{filled} pixels of the background of {circle:.0}, {black} black ones, {outside:.0} outside of the circle"
    );
    assert!(filled as f64 > 0.5 * circle, "{filled} of {circle:.0} pixels");
    assert!((filled as f64) < 0.99 * circle, "the cube's face is missing");
    assert!((black as f64) < 1.02 * outside, "{black} of {outside:.0} pixels");
}

/// Six projectors show a scene that is drawn off screen.
fn six_projectors_of_scenes_off_screen() {
    planetarium_of("vk_scenes", &["--way", "post"], Run::vulkan_under);
}

/// With the setting `never` the scene stays flat, and the statistics say so.
fn scenes_off_screen_that_stay_flat() {
    let run_never = Run { cupola: &["--duplicate", "never"], ..scenes(&["--way", "post"]) };
    let Some(never) = run_never.vulkan_under("fisheye") else { return };
    assert_eq!(never.statistics()["duplicated_framebuffers"], 0);
    let report = compare(&never.picture("capture.png"), shown_by_fisheye(CIRCLE, camera_of(&run_never)));
    assert!(report.wrong > 1000, "control: a flat picture is accepted as a domemaster");
}

/// A program that reads its window gets its own picture.
fn a_window_that_is_read() {
    expect_own_picture(&["--way", "read", "--picture", "own.ppm"], &["fisheye", "planetarium-6", "identity-captured"]);
}

/// The newest ways to submit and to present change nothing. The program prints the ways that the
/// device does not support.
fn the_newest_ways_to_present() {
    let extra = ["--way", "newest"];
    let run = scenes(&extra);
    let Some(finished) = run.vulkan_under("fisheye") else { return };
    let picture = finished.picture("capture.png");
    expect_good(&compare(&picture, shown_by_fisheye(CIRCLE, camera_of(&run))), &picture, "vk_scenes newest");
    for line in finished.words().lines().filter(|line| line.starts_with("SKIP")) {
        eprintln!("{line}");
    }
}

/// Pipelines that are linked from libraries are drawn for each view. The libraries have all shaders
/// and the outputs, or a single part each.
fn pipelines_that_are_linked() {
    for way in ["library", "parts"] {
        let extra = ["--way", way, "--shot", "shot.ppm"];
        let run = scenes(&extra);
        let Some(finished) = run.vulkan_under("fisheye") else { return };
        let picture = finished.picture("capture.png");
        expect_good(
            &compare(&picture, shown_by_fisheye(CIRCLE, camera_of(&run))),
            &picture,
            &format!("vk_scenes {way}"),
        );
        assert_eq!(finished.statistics()["panel_draws"], 0, "{way}");
        let (Some(plain), Some(same)) = (run.vulkan_plain(), run.vulkan_under("identity-captured")) else { return };
        let plain = plain.expect_success().picture("shot.ppm");
        expect_identical(&same.picture("shot.ppm"), &plain, &format!("vk_scenes {way}"));
    }
}

/// Programs that cannot be followed are flat, and the statistics say why. The validation layer
/// writes no new message.
fn programs_that_stay_flat_say_why() {
    let reasons =
        [("multiview", "notes", "multiview or layers"), ("independent", "notes", "no room for a descriptor set")];
    for (way, told, why) in reasons {
        let extra = ["--way", way, "--shot", "shot.ppm"];
        let run = scenes(&extra);
        let Some(finished) = run.vulkan_under("fisheye") else { return };
        let words = finished.statistics()[told].to_string();
        assert!(words.contains(why), "{way}: {words}");
        let lit = finished.picture("shot.ppm").pixels.iter().filter(|pixel| **pixel != [0; 3]).count();
        assert!(lit > 1000, "{way}: {lit} pixels show something");
    }
}

/// A pass of two subpasses. If the second draws to the window, it is drawn for each view, and the
/// panel is clear. If the first draws off screen and the second reads the same pixel, that is drawn
/// for each view, too.
fn passes_of_two_subpasses() {
    for way in ["second", "input"] {
        let extra = ["--way", way, "--shot", "shot.ppm"];
        let run = Run { extra: &extra, frames: 4, ..Run::new("vk_subpasses") };
        let Some(finished) = run.vulkan_under("fisheye") else { return };
        let notes = finished.statistics()["notes"].to_string();
        assert!(!notes.contains("flat"), "{way}: {notes}");
        let picture = finished.picture("capture.png");
        let report = compare(&picture, shown_by_fisheye(CIRCLE, camera_of(&run)));
        expect_good(&report, &picture, &format!("vk_subpasses {way}"));
        let (Some(plain), Some(same)) = (run.vulkan_plain(), run.vulkan_under("identity-captured")) else { return };
        let plain = plain.expect_success().picture("shot.ppm");
        expect_identical(&same.picture("shot.ppm"), &plain, &format!("vk_subpasses {way}"));
    }
    planetarium_of("vk_subpasses", &["--way", "input"], Run::vulkan_under);
}

/// Passes over a part of the window: what they draw or clear there is on the panel, and the scene
/// stays.
fn a_part_of_the_window() {
    for way in ["part", "clear"] {
        let extra = ["--way", way, "--shot", "shot.ppm"];
        let run = scenes(&extra);
        let Some(finished) = run.vulkan_under("fisheye") else { return };
        assert!(!finished.statistics()["notes"].to_string().contains("flat"), "{way}");
        let picture = finished.picture("capture.png");
        // A filter reads the panel up to a pixel of the picture beyond the part, which is four
        // texels.
        let in_part = |margin: f64| {
            move |[across, down]: [f64; 2]| [across, down].iter().all(|at| (32.0 - margin..64.0 + margin).contains(at))
        };
        let beside_part = in_part(5.0);
        let beside = |x: f64, y: f64| match place_in_window(x, y, 256.0).is_some_and(beside_part) {
            true => Shown::Unknown,
            false => shown_by_fisheye(CIRCLE, camera_of(&run))(x, y),
        };
        expect_good(&compare(&picture, beside), &picture, &format!("vk_scenes {way}, beside the part"));
        let report = compare(&picture, shown_by_fisheye(CIRCLE, camera_of(&run)));
        assert!((90..120).contains(&report.wrong), "{way}: {} pixels are not the cube's", report.wrong);
        let (Some(plain), Some(same)) = (run.vulkan_plain(), run.vulkan_under("identity-captured")) else { return };
        let plain = plain.expect_success().picture("shot.ppm");
        expect_identical(&same.picture("shot.ppm"), &plain, &format!("vk_scenes {way}"));
        let (checked, wrong) = deviations(&plain, &picture, in_part(-5.0));
        assert!(checked > 40 && wrong == 0, "{way}: {wrong} of {checked} pixels of the part are wrong");
    }
}

/// The window gets other sizes while the program runs. The last picture is as right as the first.
fn the_window_is_resized() {
    let more = ["--resizes", "6", "--shot", "shot.ppm"];
    for way in [WAYS[0], WAYS[4], WAYS[9]] {
        let extra = [way, &more].concat();
        let run = Run { frames: 40, ..run(&extra, CAMERAS[1]) };
        let Some(finished) = run.vulkan_under("fisheye") else { return };
        let picture = finished.picture("shot.ppm");
        assert_ne!((picture.width, picture.height), run.size);
        let circle = Fisheye { width: picture.width as f64, height: picture.height as f64, ..CIRCLE };
        let report = compare(&picture, shown_by_fisheye(circle, camera_of(&run)));
        expect_good(&report, &picture, &format!("vk_cube {way:?} resized"));
    }
}

/// Many changes of size under the validation layer, which at the end reports every object that was
/// created and not destroyed. Resident memory after the last change exceeds that after the first
/// changes by no more than one set of atlases.
fn many_sizes_leave_nothing_behind() {
    let more = ["--resizes", "20", "--memory", "memory.txt"];
    for way in [WAYS[0], WAYS[4]] {
        let extra = [way, &more].concat();
        let run = Run { frames: 84, cupola_frames: 84, ..run(&extra, CAMERAS[1]) };
        let Some(finished) = run.vulkan_under("fisheye") else { return };
        finished.expect_flat_memory("memory.txt", 20);
    }
}

/// A program that is shown flat: each pixel of the domemaster is compared with the program's
/// picture, computed from the definitions of the fisheye and the panel.
fn the_panel_is_where_the_angles_say() {
    let run = run(&["--copy-window"], CAMERAS[1]);
    let run = Run { cupola: &["--capture-views", "views"], ..run };
    let Some(under) = run.vulkan_under("fisheye") else { return };
    let (program, shown) = (under.picture("views/program.png"), under.picture("capture.png"));
    let (checked, wrong) = deviations(&program, &shown, |_| true);
    assert!(checked > 4_000 && wrong == 0, "{wrong} of {checked} pixels are wrong");
    let turned =
        Picture::from_fn(shown.width, shown.height, |x, y| shown.pixels[(shown.height - 1 - y) * shown.width + x]);
    assert!(deviations(&program, &turned, |_| true).1 > 100, "control: an upside-down picture is accepted");
}

/// Place in the program's window that the panel shows at (x, y) of the domemaster, both in pixels
/// from the top left of squares with sides of `length` pixels. `None` far from the panel.
fn place_in_window(x: f64, y: f64, length: f64) -> Option<[f64; 2]> {
    // The preset's panel is 60° wide.
    let half = 30_f64.to_radians().tan();
    let (x, y) = (2.0 * x / length - 1.0, 2.0 * y / length - 1.0);
    let radius = x.hypot(y);
    let angle = radius * std::f64::consts::FRAC_PI_2;
    let tangent = angle.tan() / radius.max(1e-9) / half;
    (angle <= 1.2).then(|| [x, y].map(|part| (0.5 + 0.5 * part * tangent) * length))
}

/// Number of pixels that show the panel where `is_asked` is true of the place in the window, and
/// number of those that differ by more than 2/255 from the interpolated texels at their place.
fn deviations(program: &Picture, shown: &Picture, is_asked: impl Fn([f64; 2]) -> bool) -> (usize, usize) {
    let (length, whole) = (shown.width as f64, shown.width);
    let (mut checked, mut wrong) = (0, 0);
    for (at, pixel) in shown.pixels.iter().enumerate() {
        let (x, y) = (at % whole, at / whole);
        let Some(place) = place_in_window(x as f64 + 0.5, y as f64 + 0.5, length) else { continue };
        let inside = place.iter().all(|part| (1.5..=length - 1.5).contains(part));
        if !inside || !is_asked(place) {
            continue;
        }
        checked += 1;
        let [across, down] = place.map(|part| part - 0.5);
        let (left, top) = (across.floor() as usize, down.floor() as usize);
        let (part, under) = (across.fract(), down.fract());
        let texel = |x: usize, y: usize, channel: usize| f64::from(program.pixels[y * whole + x][channel]);
        wrong += usize::from((0..3).any(|channel| {
            let upper = texel(left, top, channel) * (1.0 - part) + texel(left + 1, top, channel) * part;
            let lower = texel(left, top + 1, channel) * (1.0 - part) + texel(left + 1, top + 1, channel) * part;
            (upper * (1.0 - under) + lower * under - f64::from(pixel[channel])).abs() > 2.0
        }));
    }
    (checked, wrong)
}

/// Draws that are flat cannot appear in the views, and draws of the scene cannot appear on the
/// panel. Such draws are left out there, and nothing else changes.
fn what_is_out_of_sight_is_not_drawn() {
    let every = [("CUPOLA_CULL", "all")];
    let cases: [(&[&str], bool, u64); 4] = [
        (&["--cells", "triangles"], false, 1),
        (&["--cells", "triangles", "--flat", "over"], true, 1 + 4),
        (&["--cells", "triangles", "--secondary", "--flat", "over"], true, 1 + 4),
        (&[], false, 0),
    ];
    for (extra, small_ones_too, times) in cases {
        let environment = if small_ones_too { &every[..] } else { &[] };
        let start =
            |cupola| Run { environment, cupola, ..Run { extra, ..Run::new("vk_cube") } }.vulkan_under("fisheye");
        let Some(culled) = start(&[]) else { return };
        let whole = start(&["--no-cull"]).expect("a display");
        expect_identical(&culled.picture("capture.png"), &whole.picture("capture.png"), &format!("vk_cube {extra:?}"));
        let counts = culled.statistics();
        let frames = counts["frames"].as_u64().expect("a number");
        assert_eq!(counts["views"].as_array().map(Vec::len), Some(4));
        assert_eq!(counts["draws_out_of_sight"].as_u64(), Some(times * frames), "{extra:?}");
        assert_eq!(whole.statistics()["draws_out_of_sight"], 0);
    }
}
