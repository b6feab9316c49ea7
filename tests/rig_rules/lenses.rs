//! Lenses: openings, shifts, fisheyes, mirrors.

use super::*;

#[test]
fn openings_of_pinholes() {
    refused(
        "fov = [60, 40]",
        "fov = [180, 40]",
        "output[0].fov[0]",
        &["180 is out of range", "at most 179", "domemaster"],
    );
    refused("fov = [60, 40]", "fov = [60, 0]", "output[0].fov[1]", &["at least 0.01"]);
    refused("fov = [90, 60]", "fov = [-90, 60]", "output[3].fov[0]", &["at least 0.01"]);
    let (text, _) = with("fov = [60, 40]\nshift = [0, 0.5]", "");
    refused_text(&text, 32, "output[0].fov", &["is missing", "angles = { left, right, bottom, top }"]);
}

#[test]
fn an_opening_is_said_once() {
    let angles = "angles = { left = -30, right = 20, bottom = -10, top = 30 }";
    refused(
        "shift = [0, 0.5]",
        &format!("shift = [0, 0.5]\n{angles}"),
        "output[0].angles",
        &["a second time", "leave out"],
    );
    let (text, number) = with(angles, &format!("shift = [0, 1]\n{angles}"));
    refused_text(&text, number, "output[1].shift", &["needs `fov`"]);
    refused("lens = \"program\"", "fov = [60, 40]\nlens = \"program\"", "output[4].lens", &["leave out"]);
}

#[test]
fn sides_of_pinholes() {
    let angles = "angles = { left = -30, right = 20, bottom = -10, top = 30 }";
    let right = "angles = { left = 30, right = 20, bottom = -10, top = 30 }";
    refused(angles, right, "output[1].angles.right", &["20 is not above left = 30", "left is negative"]);
    let top = "angles = { left = -30, right = 20, bottom = -10, top = -10 }";
    refused(angles, top, "output[1].angles.top", &["-10 is not above bottom = -10"]);
    let wide = "angles = { left = -90, right = 20, bottom = -10, top = 30 }";
    refused(angles, wide, "output[1].angles.left", &["at least -89.5"]);
    let missing = "angles = { left = -30, right = 20, bottom = -10 }";
    refused(angles, missing, "output[1].angles.top", &["is missing"]);
    let unknown = "angles = { left = -30, right = 20, bottom = -10, top = 30, topp = 3 }";
    refused(angles, unknown, "output[1].angles.topp", &["`top`"]);
}

#[test]
fn lens_shifts() {
    refused("shift = [0, 0.5]", "shift = [0, 2.5]", "output[0].shift[1]", &["at most 2", "0.5 = half a picture"]);
    refused("shift = [0, 0.5]", "shift = [-3, 0]", "output[0].shift[0]", &["at least -2"]);
}

#[test]
fn apertures() {
    refused("aperture = 180", "aperture = 0", "output[2].aperture", &["greater than 0", "at most 360"]);
    refused("aperture = 180", "aperture = 361", "output[2].aperture", &["at most 360", "degrees"]);
    read(&with("aperture = 180", "aperture = 360").0).unwrap();
}

#[test]
fn projectors_see_the_screen() {
    // The projector is below the tilted dome and aims further down.
    let why = ["sees no part of the screen", "position", "yaw", "fov"];
    let text = "[dome]\ncoverage = 90\n[[output]]\nkind = \"projector\"\npitch = -90\nfov = [60, 40]";
    refused_text(text, 3, "output[0]", &why);
    // The projector is outside and turned away from the dome.
    let text = "[[output]]\nkind = \"projector\"\nposition = [0, 0, 20]\nyaw = 180\nfov = [60, 40]";
    refused_text(text, 1, "output[0]", &why);
    // The same projector, turned towards the dome.
    read(&text.replace("180", "0")).unwrap();
    let text = "[[output]]\nkind = \"projector\"\nposition = [0, 0, 1e6]\nfov = [1, 1]\n[dome]\nradius = 0.5";
    refused_text(text, 3, "output[0].position", &["at most 500000 m"]);
}

/// A rig with a projector that has these lines, in a dome of 3 m.
fn special(lines: &str) -> String {
    format!("[dome]\nradius = 3\n[[output]]\nkind = \"projector\"\nposition = [0, -1, 0]\npitch = 60\n{lines}\n")
}

#[test]
fn lenses_and_mirrors_that_cannot_be_are_refused() {
    let good = [
        "fisheye = { projection = \"stereographic\", aperture = 200 }",
        "fisheye = { projection = \"polynomial\", coefficients = [1, 0, 0, 0] }",
        "fov = [60, 40]\ndistortion = { radial = [-0.1, 0, 0] }",
        "fov = [20, 15]\nmirror = { center = [0, 0.3, -0.75], radius = 0.3 }\neven_light = 1",
    ];
    for lines in good {
        assert!(read(&special(lines)).is_ok(), "{lines}: {:?}", read(&special(lines)));
    }
    let bad = [
        ("fisheye = { projection = \"flat\" }", "output[0].fisheye.projection", "equidistant"),
        ("fisheye = { projection = \"orthographic\", aperture = 200 }", "output[0].fisheye.aperture", "at most 180"),
        ("fisheye = { projection = \"polynomial\" }", "output[0].fisheye.coefficients", "f1"),
        (
            "fisheye = { projection = \"polynomial\", coefficients = [1, -1, 0, 0] }",
            "output[0].fisheye.coefficients",
            "rises",
        ),
        ("fisheye = { coefficients = [1, 0, 0, 0] }", "output[0].fisheye.coefficients", "polynomial"),
        ("fisheye = {}\nfov = [60, 40]", "output[0].fov", "pinhole"),
        ("fov = [100, 80]\ndistortion = { radial = [-0.5, 0, 0] }", "output[0].distortion", "folds"),
        ("fov = [60, 40]\nmirror = { center = [0, 0, -2.9], radius = 0.3 }", "output[0].mirror", "through the dome"),
        ("fov = [60, 40]\nmirror = { center = [0, -1, 0.1], radius = 0.3 }", "output[0].mirror", "encloses"),
        ("fov = [9, 9]\nmirror = { center = [0, -1, 1.5], radius = 0.3 }", "output[0]", "aim at it"),
        ("fov = [60, 40]\nmirror = { center = [0, 0, 0] }", "output[0].mirror.radius", "is missing"),
        ("fov = [60, 40]\neven_light = 2", "output[0].even_light", "at most 1"),
    ];
    for (lines, key, word) in bad {
        let message = read(&special(lines)).expect_err(lines);
        assert!(message.contains(&format!(": {key} (output-1): ")) && message.contains(word), "{lines}: {message}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
}
