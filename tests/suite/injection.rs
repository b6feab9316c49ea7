//! Other ways to load Cupola into a program than `cupola run`, and ways to keep it out.

use crate::compare::{compare, expect_good, expect_identical};
use crate::dialects::shown_by_fisheye;
use crate::harness::tests;
use crate::programs::Run;
use crate::reference::{Fisheye, ProgramCamera};

tests! {
    preloaded_into_a_program_that_links_gl,
    preloaded_into_a_program_that_loads_gl_by_dlopen,
    preloaded_into_a_program_that_uses_egl,
    a_program_that_is_left_alone_shows_its_own_picture,
    the_kill_switch_works_under_the_launcher,
}

/// `LD_PRELOAD` alone gives the same domemaster as `cupola run`.
fn preloaded(program: &str) {
    let run = Run { fov: 90.0, yaw: 33.0, pitch: -17.0, ..Run::new(program) };
    let Some(finished) = run.preloaded("fisheye") else { return };
    let picture = finished.expect_success().expect_no_gl_errors().picture("capture.png");
    let circle = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };
    let report = compare(&picture, shown_by_fisheye(circle, ProgramCamera { yaw: run.yaw, pitch: run.pitch }));
    expect_good(&report, &picture, &format!("{program} fisheye preloaded"));
}

fn preloaded_into_a_program_that_links_gl() {
    preloaded("immediate");
}

fn preloaded_into_a_program_that_loads_gl_by_dlopen() {
    preloaded("cube_dlopen");
}

fn preloaded_into_a_program_that_uses_egl() {
    preloaded("gles3");
}

/// Settings that keep Cupola out of a program.
const STAY_OUT: [(&str, &str); 3] =
    [("CUPOLA", "0"), ("CUPOLA_RIG", "/no/such/rig.toml"), ("CUPOLA_CAMERA", "zoom=nothing")];

/// With the kill switch or with wrong settings the program keeps its own picture and exit status.
fn a_program_that_is_left_alone_shows_its_own_picture() {
    for program in ["immediate", "gles3"] {
        let run = Run { extra: &["--shot", "shot.ppm"], ..Run::new(program) };
        let Some(plain) = run.plain() else { return };
        let own = plain.expect_success().picture("shot.ppm");
        for variable in STAY_OUT {
            let environment = [variable];
            let run = Run { environment: &environment, ..run.clone() };
            let Some(finished) = run.preloaded("fisheye") else { return };
            let finished = finished.expect_success();
            let what = format!("{program} preloaded, {}={}", variable.0, variable.1);
            expect_identical(&finished.picture("shot.ppm"), &own, &what);
            assert!(!finished.wrote("capture.png"), "{what}: there is a capture");
            assert_eq!(
                finished.words().contains("switched off"),
                variable.0 != "CUPOLA",
                "{what}: {}",
                finished.words()
            );
        }
    }
}

fn the_kill_switch_works_under_the_launcher() {
    let run = Run { extra: &["--shot", "shot.ppm"], ..Run::new("core330_mvp") };
    let (Some(plain), Some(under)) = (run.plain(), Run { environment: &[("CUPOLA", "0")], ..run }.under("fisheye"))
    else {
        return;
    };
    let (plain, under) = (plain.expect_success(), under.expect_success());
    expect_identical(&under.picture("shot.ppm"), &plain.picture("shot.ppm"), "core330_mvp CUPOLA=0");
    assert!(!under.wrote("capture.png"));
}
