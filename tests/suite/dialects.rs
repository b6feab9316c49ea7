//! The direction test: unmodified programs of each dialect show the predicted colour in every
//! pixel.

use crate::compare::{Limits, Report, Shown, compare, compare_with, expect_good, expect_identical, expect_similar};
use crate::harness::tests;
use crate::picture::Picture;
use crate::programs::{Finished, Run, scratch};
use crate::reference::{Dome, Fisheye, Opening, ProgramCamera, Projector, Vector, cube_colour, cube_face, cube_point};
use crate::rigs;

tests! {
    a_shader_without_a_matrix,
    a_program_that_loads_gl_by_dlopen,
    desktop_gl_through_egl,
    a_multisampled_window,
    tight_planes,
    an_srgb_window,
    a_zoomed_camera,
    a_domemaster_of_210_degrees,
    an_output_outside_of_the_window_costs_nothing_and_the_others_are_as_without_it,
    ; modules immediate, display_list, client_arrays, glsl120, core330_p_mv, core330_mvp, core330_block, geometry, tessellation, gles2, gles3, draws, rectangles
}

/// Lens, yaw and pitch of the camera. Together they show all views and the seams between them.
pub const CAMERAS: [(f64, f64, f64); 3] = [(60.0, 0.0, 0.0), (90.0, 33.0, -17.0), (110.0, -128.0, 41.0)];

/// Expected content of a domemaster for the program's camera.
pub fn shown_by_fisheye(fisheye: Fisheye, camera: ProgramCamera) -> impl Fn(f64, f64) -> Shown {
    move |x, y| {
        if fisheye.inside_by(x, y) < 0.0 {
            // Pixels at the rim may be lit only in part.
            return if fisheye.inside_by(x, y) < -1.0 { Shown::Black } else { Shown::Unknown };
        }
        Shown::Direction(camera.to_world(fisheye.direction(x, y)))
    }
}

/// Expected content of the program's own picture.
pub fn shown_by_window(size: (usize, usize), fov: f64, camera: ProgramCamera) -> impl Fn(f64, f64) -> Shown {
    let opening = Opening::vertical(fov, size.0 as f64 / size.1 as f64);
    move |x, y| Shown::Direction(camera.to_world(opening.direction(x / size.0 as f64, y / size.1 as f64)))
}

/// Expected content of a projector's picture.
pub fn shown_by_projector(projector: &Projector, dome: &Dome, camera: ProgramCamera) -> impl Fn(f64, f64) -> Shown {
    move |x, y| match projector.hit(dome, x, y) {
        Some(point) if dome.within_screen(point) > 0.0 => Shown::Direction(camera.to_world(dome.eye_direction(point))),
        _ => Shown::Black,
    }
}

/// The camera of a run.
pub fn camera_of(run: &Run) -> ProgramCamera {
    ProgramCamera { yaw: run.yaw, pitch: run.pitch }
}

/// Compares a picture of a program. The programs of this suite draw a cube whose colour depends on
/// the point. `rectangles` divides two faces into tiles.
fn compare_program(program: &str, picture: &Picture, shown: impl Fn(f64, f64) -> Shown) -> Report {
    if program != "rectangles" {
        return compare(picture, shown);
    }
    let tile = |component: f64| ((component + 1.0) * 4.0).floor().clamp(0.0, 7.0);
    let tiled = |direction: Vector| cube_face(direction) >= 4;
    let colour = |direction: Vector| {
        if !tiled(direction) {
            return cube_colour(direction);
        }
        let [x, y, z] = cube_point(direction);
        [(tile(x) + 0.5) / 8.0, (tile(y) + 0.5) / 8.0, 0.5 + 0.5 * z]
    };
    let cell = |direction: Vector| {
        if !tiled(direction) {
            return cube_face(direction);
        }
        let [x, y, _] = cube_point(direction);
        100 * cube_face(direction) + 10 * tile(x) as usize + tile(y) as usize
    };
    compare_with(picture, Limits::TILES, shown, colour, cell)
}

/// Without Cupola the programs draw the predicted picture.
pub fn plain(program: &str) {
    for (fov, yaw, pitch) in CAMERAS {
        let run = Run { fov, yaw, pitch, size: (256, 192), extra: &["--shot", "shot.ppm"], ..Run::new(program) };
        let Some(finished) = run.plain() else { return };
        let picture = finished.expect_success().picture("shot.ppm");
        let report = compare_program(program, &picture, shown_by_window(run.size, fov, camera_of(&run)));
        expect_good(&report, &picture, &format!("{program} without Cupola, fov {fov}"));
    }
}

/// The default rig, with every camera of [`CAMERAS`].
pub fn fisheye(program: &str, extra: &[&str]) {
    for (fov, yaw, pitch) in CAMERAS {
        let run = Run { fov, yaw, pitch, extra, ..Run::new(program) };
        let Some(finished) = run.under("fisheye") else { return };
        let picture = finished.expect_success().expect_no_gl_errors().picture("capture.png");
        assert_eq!((picture.width, picture.height), run.size, "the capture is as large as the window");
        let circle = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };
        let report = compare_program(program, &picture, shown_by_fisheye(circle, camera_of(&run)));
        expect_good(&report, &picture, &format!("{program} {extra:?} fisheye fov {fov}"));
    }
}

/// A program whose shader has no matrix, under a rig that gives the lens and under a rig that does
/// not.
pub fn given_lens<'a>(name: &str, run: &Run<'a>, under: impl Fn(&Run<'a>, &str) -> Option<Finished>) {
    let fov = run.fov;
    let dome = "[dome]\ntilt = 90\n[[output]]\nkind = \"domemaster\"\naperture = 180\ntilt = 90\n";
    let circle = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };
    let path = scratch("lens").join(format!("{name}.toml"));
    for (camera, fits) in [(format!("[camera]\nlens = [{fov}, {fov}]\n"), true), (String::new(), false)] {
        std::fs::write(&path, format!("{camera}{dome}")).expect("a file can be written");
        let Some(finished) = under(run, path.to_str().expect("a UTF-8 path")) else { return };
        let picture = finished.expect_success().picture("capture.png");
        let report = compare(&picture, shown_by_fisheye(circle, camera_of(run)));
        if fits {
            expect_good(&report, &picture, "a lens that the rig gives");
        } else {
            assert!(report.wrong > 1000, "control: without a lens it is flat");
        }
    }
    let _ = std::fs::remove_file(path);
}

fn a_shader_without_a_matrix() {
    plain("no_matrix");
    let (fov, yaw, pitch) = CAMERAS[1];
    given_lens("opengl", &Run { fov, yaw, pitch, ..Run::new("no_matrix") }, Run::under);
}

/// The X server shows the picture that Cupola captures.
pub fn presented(program: &str) {
    let run = Run { extra: &["--shot", "shot.ppm"], frames: 4, ..Run::new(program) };
    let Some(finished) = run.under("fisheye") else { return };
    let finished = finished.expect_success();
    let what = format!("{program} fisheye, window against capture");
    expect_identical(&finished.picture("shot.ppm"), &finished.picture("capture.png"), &what);
}

/// Every projector of a planetarium, without blending.
pub fn planetarium(program: &str) {
    planetarium_of(program, &[], |run, rig| Some(run.under(rig)?.expect_success().expect_no_gl_errors()));
}

/// As [`planetarium`], for a program with options that `start` starts.
pub fn planetarium_of<'a>(
    program: &'a str,
    extra: &'a [&'a str],
    start: impl FnOnce(&Run<'a>, &str) -> Option<Finished>,
) {
    let (size, columns) = ((128, 96), 3);
    let rig = rigs::projectors("planetarium-6", size, columns);
    let rows = rig.projectors.len().div_ceil(columns);
    let size_of_all = (columns * size.0, rows * size.1);
    let run = Run { size: size_of_all, fov: 70.0, yaw: -50.0, pitch: 20.0, extra, ..Run::new(program) };
    let file = scratch("rig").join("planetarium-6-unblended.toml");
    std::fs::write(&file, &rig.unblended).expect("a rig can be written");
    let Some(finished) = start(&run, file.to_str().expect("a UTF-8 path")) else { return };
    for projector in &rig.projectors {
        let picture = finished.picture(&format!("capture-{}.png", projector.name));
        assert_eq!((picture.width, picture.height), size, "the capture is as large as its place in the window");
        let report = compare_program(program, &picture, shown_by_projector(projector, &rig.dome, camera_of(&run)));
        expect_good(&report, &picture, &format!("{program} {extra:?} planetarium-6 {}", projector.name));
    }
}

/// Rig `identity`: the presented picture and the pixels that the program reads are the same as
/// without Cupola, to the byte.
pub fn identity(program: &str) {
    let extra: &[&str] = &["--shot", "shot.ppm", "--dump", "dump.ppm"];
    let run = Run { extra, frames: 4, ..Run::new(program) };
    let (Some(plain), Some(under)) = (run.plain(), run.under("identity")) else { return };
    let (plain, under) = (plain.expect_success(), under.expect_success());
    for file in ["shot.ppm", "dump.ppm"] {
        expect_identical(&under.picture(file), &plain.picture(file), &format!("{program} identity {file}"));
    }
}

/// Rig `identity-captured`: the picture differs from the window only by rounding, because the rows
/// of a window are in the opposite order. It equals a picture that the program draws into an FBO of
/// its own, to the byte.
pub fn identity_captured(program: &str) {
    let run = Run { extra: &["--shot", "shot.ppm"], frames: 4, ..Run::new(program) };
    let into_fbo = Run { extra: &["--shot", "shot.ppm", "--fbo"], ..run.clone() };
    let (Some(plain), Some(fbo), Some(under)) = (run.plain(), into_fbo.plain(), run.under("identity-captured")) else {
        return;
    };
    let under = under.expect_success().expect_no_gl_errors();
    let shot = under.picture("shot.ppm");
    expect_similar(
        &shot,
        &plain.expect_success().picture("shot.ppm"),
        1,
        1e-3,
        &format!("{program} identity-captured"),
    );
    let own = fbo.expect_success().picture("shot.ppm");
    expect_identical(&shot, &own, &format!("{program} identity-captured against its own FBO"));
}

/// Tests of one dialect. Each is a separate test, so that a failure names the dialect and the test.
macro_rules! dialect {
    ($name:ident) => {
        mod $name {
            crate::harness::tests![plain, fisheye, presented, planetarium, identity, identity_captured];

            fn plain() {
                super::plain(stringify!($name));
            }
            fn fisheye() {
                super::fisheye(stringify!($name), &[]);
            }
            fn presented() {
                super::presented(stringify!($name));
            }
            fn planetarium() {
                super::planetarium(stringify!($name));
            }
            fn identity() {
                super::identity(stringify!($name));
            }
            fn identity_captured() {
                super::identity_captured(stringify!($name));
            }
        }
    };
}

dialect!(immediate);
dialect!(display_list);
dialect!(client_arrays);
dialect!(glsl120);
dialect!(core330_p_mv);
dialect!(core330_mvp);
dialect!(core330_block);
dialect!(geometry);
dialect!(tessellation);
dialect!(gles2);
dialect!(gles3);
dialect!(draws);
dialect!(rectangles);

fn a_program_that_loads_gl_by_dlopen() {
    fisheye("cube_dlopen", &[]);
}

fn desktop_gl_through_egl() {
    fisheye("immediate", &["--egl"]);
    fisheye("core330_mvp", &["--egl"]);
}

fn a_multisampled_window() {
    fisheye("core330_p_mv", &["--samples", "4"]);
    fisheye("display_list", &["--samples", "4"]);
}

/// The near and the far plane just enclose the cube. The axes of turned views reach its corners,
/// which are farther than the far plane, and its oblique faces, which are nearer than the near
/// plane. Nothing may be cut off.
fn tight_planes() {
    for program in ["immediate", "core330_mvp"] {
        for yaw in [0.0, 45.0] {
            let run = Run { fov: 30.0, yaw, pitch: 0.0, extra: &["--near", "9.5", "--far", "18"], ..Run::new(program) };
            let Some(finished) = run.under("fisheye") else { return };
            let picture = finished.expect_success().expect_no_gl_errors().picture("capture.png");
            let circle = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };
            let report = compare(&picture, shown_by_fisheye(circle, camera_of(&run)));
            expect_good(&report, &picture, &format!("{program} fisheye, tight planes, yaw {yaw}"));
        }
    }
}

/// A window that encodes written colours as sRGB.
fn an_srgb_window() {
    let encoded = |direction: Vector| {
        cube_colour(direction).map(|c| if c <= 0.0031308 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 })
    };
    for program in ["immediate", "core330_mvp"] {
        let run = Run { extra: &["--srgb", "--shot", "shot.ppm"], ..Run::new(program) };
        let (Some(plain), Some(under)) = (run.plain(), run.under("fisheye")) else { return };
        let picture = plain.expect_success().picture("shot.ppm");
        let report = compare_with(
            &picture,
            Limits::USUAL,
            shown_by_window(run.size, run.fov, camera_of(&run)),
            encoded,
            cube_face,
        );
        expect_good(&report, &picture, &format!("{program} sRGB without Cupola"));
        let under = under.expect_success().expect_no_gl_errors();
        let circle = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };
        for file in ["capture.png", "shot.ppm"] {
            let picture = under.picture(file);
            let report =
                compare_with(&picture, Limits::USUAL, shown_by_fisheye(circle, camera_of(&run)), encoded, cube_face);
            expect_good(&report, &picture, &format!("{program} sRGB fisheye {file}"));
        }
    }
}

/// `--camera zoom` scales the tangents of the angles in the program's scene.
fn a_zoomed_camera() {
    let run = Run { cupola: &["--camera", "zoom=2"], ..Run::new("core330_p_mv") };
    let Some(finished) = run.under("fisheye") else { return };
    let picture = finished.expect_success().picture("capture.png");
    let circle = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };
    let camera = camera_of(&run);
    let shown = move |x: f64, y: f64| match shown_by_fisheye(circle, ProgramCamera::default())(x, y) {
        Shown::Direction([dx, dy, dz]) => Shown::Direction(camera.to_world([dx / 2.0, dy / 2.0, dz])),
        other => other,
    };
    expect_good(&compare(&picture, shown), &picture, "core330_p_mv fisheye zoom 2");
}

/// A domemaster for a planetarium: the zenith is in the middle, the front at the bottom.
fn a_domemaster_of_210_degrees() {
    let run = Run::new("core330_mvp");
    let Some(finished) = run.under("fisheye-210") else { return };
    let picture = finished.expect_success().expect_no_gl_errors().picture("capture.png");
    let circle = Fisheye { width: 256.0, height: 256.0, aperture: 210.0, tilt: 0.0 };
    let report = compare(&picture, shown_by_fisheye(circle, camera_of(&run)));
    expect_good(&report, &picture, "core330_mvp fisheye-210");
}

/// A rig for several screens, used in a smaller window.
fn an_output_outside_of_the_window_costs_nothing_and_the_others_are_as_without_it() {
    let dome = "[dome]\nradius = 5\n[[output]]\nname = \"dome\"\nkind = \"domemaster\"\nwindow = [0, 0, 240, 240]\n";
    let outside =
        "[[output]]\nkind = \"projector\"\nposition = [0, 0, 0]\nfov = [60, 40]\nwindow = [2000, 0, 400, 400]\n";
    let rig = |name: &str, text: &str| {
        let file = scratch("rig").join(name);
        std::fs::write(&file, text).expect("a rig can be written");
        file.to_str().expect("a UTF-8 path").to_owned()
    };
    let (one, two) = (rig("one.toml", dome), rig("two.toml", &format!("{dome}{outside}")));
    let vulkan: &[&str] = &["--pass", "1", "--matrix", "push"];
    for (program, extra) in [("core330_mvp", &[][..]), ("vk_cube", vulkan)] {
        let run = Run { extra, ..Run::new(program) };
        let under = |rig: &str| if program == "vk_cube" { run.vulkan_under(rig) } else { run.under(rig) };
        let (Some(expected), Some(found)) = (under(&one), under(&two)) else { continue };
        let found = found.expect_success();
        let pictures = [expected.expect_success().picture("capture.png"), found.picture("capture-dome.png")];
        expect_identical(&pictures[1], &pictures[0], program);
        assert!(!found.wrote("capture-output-2.png"), "{}", found.words());
        assert!(!found.words().contains("cannot") && !found.words().contains("Zero"), "{}", found.words());
    }
}
