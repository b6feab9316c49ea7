//! The page that `cupola inspect` writes.

use crate::compare::expect_identical;
use crate::harness::tests;
use crate::programs::{Finished, Run};

tests! {
    passes_and_matrices_of_an_opengl_program,
    matrices_of_a_camera_and_flat_drawing,
    draws_of_a_vulkan_program,
    a_program_that_a_signal_ends,
}

const PAGE: &[(&str, &str)] = &[("CUPOLA_INSPECT", "inspect.html")];

/// The page without the bytes of its pictures, and the number of the pictures.
fn page(finished: &Finished) -> (String, usize) {
    let text = finished.text("inspect.html");
    let mut parts = text.split("base64,");
    let mut page = parts.next().unwrap_or_default().to_owned();
    let mut pictures = 0;
    for part in parts {
        let (picture, rest) = part.split_once('"').expect("a picture ends");
        assert!(picture.starts_with("iVBORw0KGgo"), "the signature of a PNG file");
        page.push_str(rest);
        pictures += 1;
    }
    (page, pictures)
}

fn expect(page: &str, texts: &[&str]) {
    let missing: Vec<_> = texts.iter().filter(|text| !page.contains(**text)).collect();
    assert!(missing.is_empty(), "missing: {missing:?} in\n{page}");
}

fn passes_and_matrices_of_an_opengl_program() {
    let plain = Run { frames: 5, cupola_frames: 5, ..Run::new("post_process") };
    let run = Run { environment: PAGE, ..plain.clone() };
    let (Some(plain), Some(finished)) = (plain.under("fisheye"), run.under("fisheye")) else { return };
    let [plain, finished] = [plain, finished].map(|finished| finished.expect_success().expect_no_gl_errors());
    // The inspection does not change the picture.
    expect_identical(&finished.picture("capture.png"), &plain.picture("capture.png"), "an inspected program");
    let (text, pictures) = page(&finished);
    // The passes are a map in a corner, the scene, a pass over the scene, and the window. Draws to
    // the map are issued once.
    expect(
        &text,
        &["<th>passes<td>4<", "2 scene, 2 pass over the screen", "<code>MVP</code> (uniform)", "75.00° × 75.00°"],
    );
    expect(&text, &["Draws are issued once: it was not seen to fill the window.", "RGBA8, 256 × 256"]);
    let views = finished.statistics()["views"].as_array().map_or(0, Vec::len);
    // The pictures are the output, the views, the panel, and three framebuffers.
    assert_eq!(pictures, 1 + views + 1 + 3, "{text}");
}

fn matrices_of_a_camera_and_flat_drawing() {
    let extra = ["--mode", "sky_all"];
    let run = Run { extra: &extra, frames: 6, cupola_frames: 6, environment: PAGE, ..Run::new("camera_matrices") };
    let Some(finished) = run.under("fisheye") else { return };
    let (text, _) = page(&finished.expect_success());
    expect(&text, &["a matrix of the camera with 75.00° × 75.00°: each view has its own", "pass over the screen"]);
    let run = Run { environment: PAGE, ..Run::new("hud") };
    let Some(finished) = run.under("fisheye") else { return };
    let (text, _) = page(&finished.expect_success());
    expect(&text, &["<td>flat<td>", "GL_PROJECTION", "fixed function", "no perspective"]);
}

fn draws_of_a_vulkan_program() {
    let run = Run { environment: PAGE, cupola: &["--frames", "3"], ..Run::new("vk_cube") };
    let Some(finished) = run.vulkan_under("fisheye") else { return };
    let (text, pictures) = page(&finished);
    expect(&text, &["scene", "75.00° × 75.00°", "Draws of the scene are issued to"]);
    assert!(pictures > 2, "{text}");
}

/// The page describes the frame after the signal.
fn a_program_that_a_signal_ends() {
    let run = Run { extra: &["--mode", "killed"], cupola_frames: 0, environment: PAGE, ..Run::new("ending") };
    let Some(finished) = run.under("fisheye") else { return };
    assert_eq!(finished.status(), 128 + libc::SIGTERM, "{}", finished.words());
    let (text, _) = page(&finished);
    expect(&text, &["fixed-function projection with a perspective", "75.00° × 75.00°"]);
}
