//! Tests of the tests: each comparison accepts a right picture and refuses wrong ones.

use crate::compare::{Shown, compare};
use crate::dialects::{shown_by_fisheye, shown_by_projector, shown_by_window};
use crate::display;
use crate::harness::{self, tests};
use crate::picture::Picture;
use crate::programs::scratch;
use crate::reference::{
    Dome, Fisheye, Opening, ProgramCamera, Projector, Turn, add_scaled, cube_colour, dot, normalised,
};
use crate::vkcube;
use libtest_mimic::Completion;
use std::panic::catch_unwind;
use std::process::Command;

tests! {
    the_place_of_vkcube_is_judged,
    the_harness_tells_what_became_of_a_test,
    a_display_is_there,
    what_is_missing_counts_as_ignored,
    the_domemaster_comparer_fails_wrong_pictures,
    the_perspective_comparer_fails_wrong_pictures,
    the_projector_comparer_fails_wrong_pictures,
    the_reference_is_consistent,
    the_picture_comparers_fail_wrong_pictures,
}

const CAMERA: ProgramCamera = ProgramCamera { yaw: 33.0, pitch: -17.0 };

/// Ideal picture for `shown`.
fn ideal(size: (usize, usize), shown: impl Fn(f64, f64) -> Shown) -> Picture {
    Picture::from_fn(size.0, size.1, |x, y| match shown(x as f64 + 0.5, y as f64 + 0.5) {
        Shown::Direction(direction) => cube_colour(direction).map(|channel| (255.0 * channel).round() as u8),
        _ => [0; 3],
    })
}

fn turned(yaw: f64, pitch: f64) -> ProgramCamera {
    ProgramCamera { yaw: CAMERA.yaw + yaw, pitch: CAMERA.pitch + pitch }
}

fn the_domemaster_comparer_fails_wrong_pictures() {
    let right = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };
    let judge = |picture: &Picture| compare(picture, shown_by_fisheye(right, CAMERA));
    let picture = ideal((256, 256), shown_by_fisheye(right, CAMERA));
    let report = judge(&picture);
    assert!(report.good() && report.worst <= 0.5 + 1e-9 && report.black > 1000);

    let wrong = [
        ("yaw", right, turned(2.0, 0.0)),
        ("pitch", right, turned(0.0, 2.0)),
        ("aperture", Fisheye { aperture: 184.0, ..right }, CAMERA),
        ("tilt", Fisheye { tilt: 88.0, ..right }, CAMERA),
        ("mirror", Fisheye { tilt: -90.0, ..right }, CAMERA),
    ];
    for (name, fisheye, camera) in wrong {
        assert!(!judge(&ideal((256, 256), shown_by_fisheye(fisheye, camera))).good(), "{name} is not noticed");
    }
    let upside_down = Picture::from_fn(256, 256, |x, y| picture.at(x, 255 - y));
    assert!(!judge(&upside_down).good(), "a picture upside down is not noticed");
    let shifted = Picture::from_fn(256, 256, |x, y| picture.at((x + 2).min(255), y));
    assert!(!judge(&shifted).good(), "two pixels to the left are not noticed");
    let mut lit = picture.clone();
    lit.pixels[3] = [1, 0, 0];
    assert!(!judge(&lit).good(), "light outside the circle is not noticed");
    let mut spot = picture.clone();
    spot.pixels[100 * 256 + 77][2] ^= 0x20;
    assert!(!judge(&spot).good(), "one wrong pixel is not noticed");
    assert!(!judge(&Picture::from_fn(256, 256, |_, _| [0; 3])).good(), "a black picture is not noticed");
    // A comparison of no pixels does not succeed, nor one of few pixels.
    assert!(!compare(&picture, |_, _| Shown::Unknown).good());
    let half = |x: f64, y: f64| if x < 128.0 { Shown::Unknown } else { shown_by_fisheye(right, CAMERA)(x, y) };
    let report = compare(&picture, half);
    assert!(report.wrong == 0 && report.share() > 0.3 && !report.good(), "{:.3} of the picture", report.share());
    // Nor does one that leaves out the black pixels, here lines that are narrower than their zone.
    let line = |x: f64, y: f64| match (x, y) {
        (128.0..130.0, _) => Shown::Black,
        _ => shown_by_window((256, 256), 75.0, CAMERA)(x, y),
    };
    let report = compare(&ideal((256, 256), line), line);
    assert!(report.wrong == 0 && report.dark == 512 && report.black == 0 && !report.good(), "{} black", report.black);
}

fn the_perspective_comparer_fails_wrong_pictures() {
    let size = (256, 192);
    let judge = |picture: &Picture| compare(picture, shown_by_window(size, 75.0, CAMERA));
    assert!(judge(&ideal(size, shown_by_window(size, 75.0, CAMERA))).good());
    assert!(!judge(&ideal(size, shown_by_window(size, 77.0, CAMERA))).good());
    assert!(!judge(&ideal(size, shown_by_window(size, 75.0, turned(0.0, -1.5)))).good());
}

fn projector() -> (Projector, Dome) {
    let (width, height) = (200.0, 150.0);
    let turn = Turn { yaw: 40.0, pitch: 25.0, roll: 10.0 };
    let opening = Opening { left: -0.6, right: 0.5, bottom: -0.2, top: 0.7 };
    let name = "p".to_owned();
    let projector = Projector { name, width, height, position: [1.0, -2.0, 0.5], turn, opening };
    let still = Turn::default();
    let viewer_turn = Turn { yaw: 10.0, ..still };
    let viewer = [0.2, -0.5, 0.3];
    (projector, Dome { radius: 5.0, tilt: 20.0, coverage: 190.0, viewer, viewer_turn, camera_turn: still })
}

fn the_projector_comparer_fails_wrong_pictures() {
    let (right, dome) = projector();
    let picture_of =
        |projector: &Projector, dome: &Dome| ideal((200, 150), shown_by_projector(projector, dome, CAMERA));
    let judge = |picture: &Picture| compare(picture, shown_by_projector(&right, &dome, CAMERA)).good();
    assert!(judge(&picture_of(&right, &dome)));
    let moved = Projector { position: add_scaled(right.position, [1.0, 0.0, 0.0], 0.4), ..right.clone() };
    assert!(!judge(&picture_of(&moved, &dome)), "a moved projector is not noticed");
    let rolled = Projector { turn: Turn { roll: 12.0, ..right.turn }, ..right.clone() };
    assert!(!judge(&picture_of(&rolled, &dome)), "a rolled projector is not noticed");
    assert!(!judge(&picture_of(&right, &Dome { viewer: [0.2, 0.1, 0.3], ..dome })), "a moved viewer is not noticed");
    assert!(!judge(&picture_of(&right, &Dome { coverage: 130.0, ..dome })), "a smaller screen is not noticed");
}

/// Consistency of the reference: a point that is projected is hit again, and a direction that is
/// turned turns back.
fn the_reference_is_consistent() {
    let (projector, dome) = projector();
    for (x, y) in [(0.5, 0.5), (100.0, 75.0), (13.25, 140.5), (199.5, 3.0)] {
        let point = projector.hit(&dome, x, y).expect("a projector inside the dome hits it");
        assert!((dot(point, point).sqrt() - dome.radius).abs() < 1e-12);
        let [back_x, back_y] = projector.place(point).expect("the projector sees what it lights");
        assert!((back_x - x).abs() < 1e-9 && (back_y - y).abs() < 1e-9);
    }
    let turn = Turn { yaw: 123.0, pitch: -45.0, roll: 67.0 };
    let direction = normalised([0.3, -0.8, 0.4]);
    let back = turn.inward(turn.outward(direction));
    assert!((0..3).all(|axis| (back[axis] - direction[axis]).abs() < 1e-15));

    let close = |found: [f64; 3], expected: [f64; 3]| (0..3).all(|axis| (found[axis] - expected[axis]).abs() < 1e-12);
    let forward = [0.0, 0.0, -1.0];
    let up = [0.0, 1.0, 0.0];
    assert!(
        close(Turn { yaw: 90.0, pitch: 0.0, roll: 0.0 }.outward(forward), [1.0, 0.0, 0.0]),
        "yaw is right-positive"
    );
    assert!(close(Turn { yaw: 0.0, pitch: 90.0, roll: 0.0 }.outward(forward), up), "pitch is up-positive");
    assert!(close(Turn { yaw: 0.0, pitch: 0.0, roll: 90.0 }.outward(up), [1.0, 0.0, 0.0]), "roll is clockwise");
    // The fulldome convention: the zenith is in the centre, the front at the bottom edge, right at
    // the right.
    let master = Fisheye { width: 100.0, height: 100.0, aperture: 180.0, tilt: 0.0 };
    assert!(close(master.direction(50.0, 50.0), up));
    assert!(close(master.direction(50.0, 100.0), forward));
    assert!(close(master.direction(100.0, 50.0), [1.0, 0.0, 0.0]));
}

fn the_picture_comparers_fail_wrong_pictures() {
    use crate::compare::{expect_alike, expect_identical, expect_similar};
    let right = Picture::from_fn(40, 30, |x, y| [x as u8, y as u8, 7]);
    let mut wrong = right.clone();
    wrong.pixels[17][1] += 1;
    expect_identical(&right, &right, "control");
    expect_similar(&wrong, &right, 1, 1e-3, "control");
    assert!(catch_unwind(|| expect_identical(&wrong, &right, "control")).is_err());
    wrong.pixels[99][0] += 1;
    assert!(catch_unwind(|| expect_similar(&wrong, &right, 1, 1e-3, "control")).is_err(), "2 of 1200 are too many");
    wrong = right.clone();
    wrong.pixels[17][1] += 2;
    assert!(catch_unwind(|| expect_similar(&wrong, &right, 1, 1e-3, "control")).is_err(), "2/255 are too many");

    // An outline may be displaced by one pixel but not by two. In neither picture may a single
    // pixel have another colour.
    let half = |at: usize| Picture::from_fn(40, 30, |x, _| if x < at { [200, 30, 30] } else { [0; 3] });
    expect_alike(&half(20), &half(21), 0, "control");
    assert!(catch_unwind(|| expect_alike(&half(20), &half(22), 100, "control")).is_err(), "two pixels are too many");
    wrong = half(20);
    wrong.pixels[30][1] += 4;
    expect_alike(&wrong, &half(20), 4, "control");
    assert!(catch_unwind(|| expect_alike(&wrong, &half(20), 3, "control")).is_err(), "4/255 are too many");
    wrong.pixels[30] = [200, 255, 30];
    assert!(catch_unwind(|| expect_alike(&wrong, &half(20), 200, "control")).is_err(), "a pixel is wrong");
    assert!(catch_unwind(|| expect_alike(&half(20), &wrong, 200, "control")).is_err(), "a pixel is wrong");
}

/// Counts as ignored if there is no display. The next test runs it.
fn a_display_is_there() {
    let _ = display::get();
}

fn what_is_missing_counts_as_ignored() {
    let (name, times) = ("controls::a_display_is_there", scratch("times").join("times.txt"));
    let run = |variables: &[(&str, &str)]| {
        let mut command = Command::new(std::env::current_exe().expect("a path of this program"));
        command
            .args(["--exact", name])
            .env("PATH", "")
            .env_remove("CUPOLA_REQUIRE_GL")
            .env("CUPOLA_TEST_TIMES", &times);
        let output = command.envs(variables.iter().copied()).output().expect("this program can be started");
        (output.status.success(), String::from_utf8_lossy(&output.stdout).into_owned())
    };
    let (succeeded, words) = run(&[]);
    assert!(succeeded && words.contains("0 passed; 0 failed; 1 ignored"), "{words}");
    let (succeeded, words) = run(&[("CUPOLA_REQUIRE_GL", "1")]);
    assert!(!succeeded && words.contains("0 passed; 1 failed; 0 ignored"), "{words}");
    assert!(words.contains("no X server"), "{words}");
    let lines = std::fs::read_to_string(times).expect("times of the tests");
    let named =
        |line: &str| line.split_once(' ').is_some_and(|(time, test)| time.parse::<f64>().is_ok() && test == name);
    assert!(lines.lines().count() == 2 && lines.lines().all(named), "{lines}");
}

fn the_harness_tells_what_became_of_a_test() {
    let of =
        |test: fn()| std::thread::spawn(move || harness::outcome(test)).join().expect("the harness catches panics");
    assert!(matches!(of(|| ()), Ok(Completion::Completed)));
    let failed = of(|| {
        harness::note("a line");
        assert_eq!(1, 2);
    });
    let words = failed.err().and_then(|failed| failed.message().map(str::to_owned)).expect("a message");
    assert!(words.contains("a line") && words.contains("controls.rs") && words.contains("left: 1"), "{words}");
}

fn the_place_of_vkcube_is_judged() {
    // The ball inside the cube and the ball around it have outlines 16.4 and 28.8 pixels from the
    // middle.
    let cube = |radius, moved_by| vkcube::cube(&vkcube::disc(radius, moved_by));
    assert!(matches!(cube(20.0, 0.0), Ok(1200..=1320)), "{:?}", cube(20.0, 0.0));
    for (radius, moved_by) in [(0.0, 0.0), (14.0, 0.0), (31.0, 0.0), (20.0, 12.0), (20.0, 100.0)] {
        assert!(cube(radius, moved_by).is_err(), "a disc of {radius} pixels, {moved_by} off the middle");
    }
    let off = |moved_by| vkcube::off(&vkcube::disc(20.0, moved_by), &vkcube::disc(20.0, 0.0));
    assert!(off(0.0) == 0.0 && off(1.0) < 0.04 && off(2.5) > 0.04, "{} {} {}", off(0.0), off(1.0), off(2.5));
}
