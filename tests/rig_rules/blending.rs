//! Blending and ramps.

use super::*;

#[test]
fn blending() {
    refused("ramp = 0.2", "ramp = 0", "output[0].blend.ramp", &["greater than 0 and at most 0.5"]);
    refused("ramp = 0.2", "ramp = 0.6", "output[0].blend.ramp", &["greater than 0 and at most 0.5"]);
    refused("gamma = 2.4", "gamma = 0.45", "output[0].blend.gamma", &["at least 1 and at most 4"]);
    refused("black_level = 0.01", "black_level = 1", "output[0].blend.black_level", &["less than 1"]);
    refused("black_level = 0.01", "black_level = -0.1", "output[0].blend.black_level", &["at least 0"]);
    for (given, key, words) in [
        ("shape = \"cosin\"", "shape", "cosine"),
        ("shape = \"cosine\"\npower = 2", "power", "needs shape"),
        ("shape = \"power\"\npower = 9", "power", "at least 0.5 and at most 4"),
        ("exponent = 3", "exponent", "at least 1 and at most 2"),
        ("contrast = 2", "contrast", "at least 10"),
        ("dither = 4", "dither", "at least 6 and at most 16"),
    ] {
        refused("ramp = 0.2", &format!("ramp = 0.2\n{given}"), &format!("output[0].blend.{key}"), &[words]);
    }
    refused("gamma = 2.4", "transfer = \"srgb\"\ngamma = 2.4", "output[0].blend.gamma", &["needs transfer"]);
    for (given, key, words) in [
        ("{ red = 2.2, green = 2.2 }", "blue", "is missing"),
        ("{ red = 2.2, green = 0.5, blue = 2 }", "green", "at least 1 and at most 4"),
        ("{ measured = [[0, 0], [128, 9], [255, 8]] }", "measured", "both growing"),
        ("{ measured = [[1, 0], [255, 8]] }", "measured", "the first with the value 0"),
        ("{ red = 2.2, green = [[0, 1]], blue = 2.2 }", "green", "two points or more"),
        ("{ file = \"no-such-response.csv\" }", "file", "no-such-response.csv"),
        ("{ }", "measured", "0 ways"),
        ("{ measured = [[0, 0], [1, 1]], file = \"a.csv\" }", "measured", "2 ways"),
        ("{ rad = 2.2, red = 2, green = 2.2, blue = 2.2 }", "rad", "did you mean `red`"),
    ] {
        refused("gamma = 2.4", &format!("transfer = {given}"), &format!("output[0].blend.transfer.{key}"), &[words]);
    }
    refused("overlap = true", "overlap = 1", "output[0].blend.overlap", &["neither true nor false"]);
    refused(
        "aperture = 180",
        "aperture = 180\nblend = { overlap = true }",
        "output[2].blend.overlap",
        &["only projectors"],
    );
}

#[test]
fn ramps_of_dome_angles() {
    let line = r#"ramps = [{ angle = "polar", zero = 100, full = 90 }, { angle = "azimuth", zero = -90, full = -80 }]"#;
    let cases = [
        (r#"ramps = [{ angle = "polar", zero = 100, full = 100 }]"#, "ramps[0].full", "needs a width"),
        (r#"ramps = [{ angle = "polar", zero = 181, full = 100 }]"#, "ramps[0].zero", "at most 180"),
        (r#"ramps = [{ angle = "polar", zero = -1, full = 100 }]"#, "ramps[0].zero", "at least 0"),
        (r#"ramps = [{ angle = "azimuth", zero = -181, full = 100 }]"#, "ramps[0].zero", "at least -180"),
        (r#"ramps = [{ angle = "azimut", zero = 0, full = 100 }]"#, "ramps[0].angle", "did you mean \"azimuth\"?"),
        (r#"ramps = [{ zero = 0, full = 100 }]"#, "ramps[0].angle", "is missing"),
        (r#"ramps = [{ angle = "polar", full = 100 }]"#, "ramps[0].zero", "is missing"),
        (r#"ramps = [{ angle = "polar", zero = 100 }]"#, "ramps[0].full", "is missing"),
        (r#"ramps = [{ angle = "polar", zero = 100, fill = 3, full = 4 }]"#, "ramps[0].fill", "unknown key"),
        (r#"ramps = 3"#, "ramps", "not a list of tables"),
    ];
    for (by, key, words) in cases {
        refused(line, by, &format!("output[0].blend.{key}"), &[words]);
    }
}
