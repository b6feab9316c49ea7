//! Vulkan programs whose camera matrix is in a vertex attribute, behind an address, in memory of the
//! device, or where Cupola cannot read it.

use crate::compare::{compare, expect_good};
use crate::dialects::{CAMERAS, camera_of, given_lens, shown_by_fisheye, shown_by_window};
use crate::harness::tests;
use crate::programs::Run;
use crate::reference::Fisheye;

tests! {
    matrices_in_attributes_behind_addresses_and_in_copies,
    flat_drawing_with_such_matrices,
    matrices_that_cannot_be_read,
    programs_without_a_lens_are_told_why,
}

const CIRCLE: Fisheye = Fisheye { width: 256.0, height: 256.0, aperture: 180.0, tilt: 90.0 };

fn run<'a>(extra: &'a [&'a str]) -> Run<'a> {
    let (fov, yaw, pitch) = CAMERAS[1];
    Run { fov, yaw, pitch, extra, ..Run::new("vk_cube") }
}

/// The program shows the predicted picture, without Cupola and on a dome.
fn matrices_in_attributes_behind_addresses_and_in_copies() {
    for way in [
        &["--matrix", "instance"][..],
        &["--matrix", "instance", "--secondary", "--once", "--pass", "dynamic"],
        &["--matrix", "instance-copied", "--flip"],
        &["--matrix", "instance", "--columns"],
        &["--matrix", "instance-copied", "--columns", "--secondary"],
        &["--matrix", "address"],
        &["--matrix", "address", "--secondary", "--flip", "--samples", "4"],
        &["--matrix", "address-in-block", "--once"],
        &["--matrix", "large"],
        &["--matrix", "large", "--secondary", "--once"],
    ] {
        let extra = [way, &["--shot", "shot.ppm"]].concat();
        let run = run(&extra);
        let Some(plain) = run.vulkan_plain() else { return };
        let picture = plain.expect_success().picture("shot.ppm");
        let report = compare(&picture, shown_by_window(run.size, run.fov, camera_of(&run)));
        expect_good(&report, &picture, &format!("vk_cube {way:?} without Cupola"));
        let Some(finished) = run.vulkan_under("fisheye") else { return };
        let picture = finished.picture("capture.png");
        let report = compare(&picture, shown_by_fisheye(CIRCLE, camera_of(&run)));
        expect_good(&report, &picture, &format!("vk_cube {way:?} fisheye"));
        assert_eq!(finished.statistics()["panel_draws"], 0, "{way:?}");
    }
}

/// A square has a matrix of its own, in another instance or at another address: it is flat.
fn flat_drawing_with_such_matrices() {
    for matrix in ["instance", "address"] {
        let extra = ["--matrix", matrix, "--flat", "over"];
        let Some(finished) = run(&extra).vulkan_under("fisheye") else { return };
        assert_eq!(finished.statistics()["panel_draws"], 3, "{matrix}");
        let report = compare(&finished.picture("capture.png"), shown_by_fisheye(CIRCLE, camera_of(&run(&extra))));
        assert!(report.wrong > 100 && report.wrong < 20_000, "{matrix}: {} pixels of a square", report.wrong);
    }
}

/// What is drawn with such a matrix is flat. With a rig that gives the lens the picture is right.
fn matrices_that_cannot_be_read() {
    for matrix in ["vertices", "address-sum", "filled"] {
        given_lens(&format!("vulkan-{matrix}"), &run(&["--matrix", matrix]), Run::vulkan_under);
    }
}

/// After some hundred draws the log and the statistics say why nothing is a scene.
fn programs_without_a_lens_are_told_why() {
    for (way, why) in [
        (&["--columns"][..], "make the matrix of other numbers"),
        (&["--matrix", "vertices"], "in a vertex attribute that cannot be read"),
        (&["--matrix", "address-sum"], "at an address that cannot be followed"),
        (&["--matrix", "filled"], "in memory that only the device can read"),
        (&["--flat", "only"], "have no perspective"),
    ] {
        let extra = [way, &["--draws", "120"]].concat();
        let Some(finished) = run(&extra).vulkan_under("fisheye") else { return };
        let notes = finished.statistics()["notes"].to_string();
        for words in [notes.as_str(), &finished.words()] {
            assert!(words.contains("In 360 of 360 draws their") && words.contains(why), "{way:?}: {words}");
        }
    }
}
