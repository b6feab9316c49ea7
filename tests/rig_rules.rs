//! Rules of the rig file: a file that breaks one is refused, and the message has line, key and
//! remedy.

use cupola::rig::{Rig, parse};
use std::path::Path;

/// A valid rig that uses every key of the format.
const COMPLETE: &str = r#"
name = "complete"
passthrough = false

[dome]
radius = 5
tilt = 20.0
coverage = 200

[viewer]
position = [0.5, -0.2, 1]
yaw = 10
pitch = -5
roll = 1

[camera]
zoom = 2
move = [0, 0, -20]
yaw = 90
pitch = 10
roll = -10

[views]
method = "cube"
quality = 1.5

[overlay]
yaw = 10
pitch = 20
width = 70

[[output]]
name = "left"
kind = "projector"
size = [1920, 1080]
window = [0, 0, 1920, 1080]
position = [1, 0, 2]
yaw = -30
pitch = 15
roll = 2
fov = [60, 40]
shift = [0, 0.5]
[output.blend]
overlap = true
ramp = 0.2
gamma = 2.4
black_level = 0.01
ramps = [{ angle = "polar", zero = 100, full = 90 }, { angle = "azimuth", zero = -90, full = -80 }]

[[output]]
name = "right"
kind = "projector"
window = [1920, 0, 1920, 1080]
yaw = 30
angles = { left = -30, right = 20, bottom = -10, top = 30 }

[[output]]
name = "master"
kind = "domemaster"
window = [0, 1080, 1080, 1080]
aperture = 180
tilt = 90
method = "mesh"
max_error = 0.2

[[output]]
name = "monitor"
kind = "perspective"
window = [1080, 1080, 1080, 1080]
yaw = 10
fov = [90, 60]

[[output]]
name = "as-is"
kind = "perspective"
window = [2160, 1080, 1080, 1080]
lens = "program"
"#;

fn read(text: &str) -> Result<Rig, String> {
    parse(text, "some/dome.toml", Path::new("")).map_err(|error| error.message)
}

/// `COMPLETE` with the only occurrence of `line` replaced by `by`, and the number of that line.
fn with(line: &str, by: &str) -> (String, usize) {
    let marked = format!("\n{line}\n");
    assert_eq!(COMPLETE.matches(&marked).count(), 1, "{line:?} does not stand alone in the text");
    let at = COMPLETE.find(&marked).unwrap();
    (COMPLETE.replace(&marked, &format!("\n{by}\n")), COMPLETE[..=at].matches('\n').count() + 1)
}

/// Checks that the rig with `by` in place of `line` is refused with one problem. The message must
/// contain the number of the last line of `by`, `key` and `words`.
#[track_caller]
fn refused(line: &str, by: &str, key: &str, words: &[&str]) {
    let (text, number) = with(line, by);
    refused_text(&text, number + by.matches('\n').count(), key, words);
}

#[track_caller]
fn refused_text(text: &str, number: usize, key: &str, words: &[&str]) {
    let message = read(text).expect_err("this rig should have been refused");
    let start = format!("some/dome.toml:{number}: {key}");
    assert!(message.starts_with(&start), "{message:?} does not start with {start:?}");
    for word in words {
        assert!(message.contains(word), "{message:?} does not say {word:?}");
    }
    assert!(!message.contains('\n'), "one problem was expected, not these:\n{message}");
}

#[test]
fn the_complete_rig_is_valid() {
    read(COMPLETE).unwrap();
    // Control of this function: a rig with a line that is replaced by itself is accepted.
    assert!(read(&with("radius = 5", "radius = 5").0).is_ok());
}

#[test]
fn text_that_is_no_toml() {
    refused("radius = 5", "radius = = 5", "this is not TOML", &[]);
    refused("radius = 5", "radius = 5\nradius = 6", "this is not TOML", &["duplicate"]);
}

#[test]
fn unknown_keys() {
    refused("radius = 5", "radios = 5", "dome.radios: unknown key", &["did you mean `radius`?"]);
    refused("radius = 5", "diameter = 5", "dome.diameter: unknown key", &["possible here: coverage, radius, tilt"]);
    refused("name = \"complete\"", "nmae = \"complete\"", "nmae: unknown key", &["did you mean `name`?"]);
    refused("zoom = 2", "zom = 2", "camera.zom: unknown key", &["`zoom`"]);
    refused("roll = 1", "rol = 1", "viewer.rol: unknown key", &["`roll`"]);
    refused("quality = 1.5", "qualty = 1.5", "views.qualty: unknown key", &["`quality`"]);
    refused("width = 70", "widht = 70", "overlay.widht: unknown key", &["`width`"]);
    refused("gamma = 2.4", "gama = 2.4", "output[0].blend.gama (left): unknown key", &["`gamma`"]);
    refused(
        "fov = [90, 60]",
        "fov = [90, 60]\nfow = 3",
        "output[3].fow (monitor): unknown key",
        &["did you mean `fov`?"],
    );
}

#[test]
fn keys_of_another_kind_of_output() {
    let expected = ["it belongs to kind = \"domemaster\""];
    let (text, number) = with("fov = [90, 60]", "fov = [90, 60]\naperture = 180");
    refused_text(&text, number + 1, "output[3].aperture (monitor): unknown key", &expected);
    let (text, number) = with("aperture = 180", "aperture = 180\nfov = [60, 40]");
    refused_text(
        &text,
        number + 1,
        "output[2].fov (master): unknown key",
        &["kind = \"projector\" or \"perspective\""],
    );
    refused_text(
        "[[outputs]]\nkind = \"domemaster\"\n[[output]]\nkind = \"domemaster\"",
        1,
        "outputs",
        &["[[output]]"],
    );
}

#[test]
fn wrong_types_and_units() {
    refused("radius = 5", "radius = \"5 m\"", "dome.radius", &["\"5 m\"", "without quotes", "metres"]);
    refused("radius = 5", "radius = [5]", "dome.radius", &["not a number"]);
    refused("radius = 5", "radius = true", "dome.radius", &["not a number"]);
    refused("radius = 5", "radius = 1979-05-27", "dome.radius", &["a date is not a number"]);
    refused("passthrough = false", "passthrough = \"no\"", "passthrough", &["neither true nor false"]);
    refused("name = \"complete\"", "name = 3", "name", &["3 is not text", "in quotes"]);
    refused(
        "position = [0.5, -0.2, 1]",
        "position = [0.5, -0.2]",
        "viewer.position",
        &["expected 3 numbers", "metres"],
    );
    refused(
        "position = [0.5, -0.2, 1]",
        "position = [0.5, \"a\", 1]",
        "viewer.position[1]",
        &["\"a\" is not a number"],
    );
    refused("fov = [60, 40]", "fov = 60", "output[0].fov", &["expected 2 numbers", "degrees"]);
    refused(
        "method = \"cube\"",
        "method = \"cub\"",
        "views.method",
        &["\"auto\", \"cube\", \"single\"", "did you mean \"cube\"?"],
    );
    refused(
        "kind = \"domemaster\"",
        "kind = \"fisheye\"",
        "output[2].kind",
        &["\"domemaster\", \"projector\", \"perspective\""],
    );
    refused("lens = \"program\"", "lens = \"programm\"", "output[4].lens", &["did you mean \"program\"?"]);
    refused_text("dome = 3\n[[output]]\nkind = \"domemaster\"", 1, "dome", &["3 is not a table", "[dome]"]);
    refused_text("[output]\nkind = \"domemaster\"", 1, "output", &["[[output]] with double brackets"]);
    refused_text("output = [3]", 1, "output[0]", &["3 is not a table"]);
}

#[test]
fn methods_of_outputs() {
    let line = "method = \"mesh\"";
    refused(line, "method = \"mash\"", "output[2].method", &["did you mean \"mesh\"?"]);
    refused("max_error = 0.2", "max_error = 0", "output[2].max_error", &["pixels", "at least 0.005"]);
    refused("max_error = 0.2", "density = 8", "output[2].density", &["it belongs to method = \"cube-mesh\""]);
    let (text, number) = with(line, "method = \"fragment\"");
    refused_text(
        &text,
        number + 1,
        "output[2].max_error (master): unknown key",
        &["method = \"table\", \"mesh\" or \"primitive\""],
    );
    let (text, number) = with(line, "method = \"cube-mesh\"");
    refused_text(&text.replace("max_error = 0.2", "density = 7.5"), number + 1, "output[2].density", &["not whole"]);
    assert!(read(&text.replace("max_error = 0.2", "density = 7")).is_ok());
    refused(
        "lens = \"program\"",
        "lens = \"program\"\nmethod = \"table\"",
        "output[4].method",
        &["before the program draws"],
    );
    let special = "kind = \"domemaster\"\nprojection = \"equisolid\"";
    let (text, number) = with(line, "method = \"cube-mesh\"\ndensity = 7");
    let text = text.replace("max_error = 0.2\n", "").replace("kind = \"domemaster\"", special);
    refused_text(&text, number + 1, "output[2].method", &["equidistant"]);
    let blacks = "[[output]]\nkind = \"domemaster\"\n[[output]]\nkind = \"projector\"\nfov = [60, 40]\nmethod = \"mesh\"\n\
                  [output.blend]\ncontrast = 1000\n";
    refused_text(blacks, 6, "output[1].method", &["blend.contrast"]);
}

#[test]
fn windows_of_their_own() {
    let head = "[[output]]\nkind = \"domemaster\"\n[[output]]\nkind = \"domemaster\"\n";
    let own = |keys: &str| format!("{head}{keys}");
    let rig = read(&own("size = [64, 64]\ndisplay = \":0.1\"\nfullscreen = true")).expect("a rig");
    assert_eq!((rig.outputs.len(), rig.beside.len()), (1, 1));
    let window = rig.beside[0].own_window.as_ref().expect("a window");
    assert_eq!((window.display.as_deref(), window.fullscreen), (Some(":0.1"), true));
    assert!(read(&own("size = [64, 64]\nfullscreen = false")).is_ok_and(|rig| rig.outputs.len() == 2));
    refused_text(&own("monitor = \"DP-2\""), 3, "output[1].shown", &["needs a size"]);
    let keys = "size = [64, 64]\nmonitor = \"DP-2\"\n";
    refused_text(&own(&format!("{keys}fullscreen = true")), 7, "output[1].fullscreen", &["leave out one"]);
    refused_text(&own(&format!("{keys}shown = true")), 7, "output[1].shown", &["a window of its own"]);
    let only = "[[output]]\nkind = \"domemaster\"\nsize = [64, 64]\ndisplay = \":1\"";
    refused_text(only, 1, "output", &["none of them has a place in the program's window"]);
}

#[test]
fn numbers_that_are_none() {
    for number in ["nan", "inf", "-inf", "+nan"] {
        refused("radius = 5", &format!("radius = {number}"), "dome.radius", &["no number that can be used", "metres"]);
    }
    refused("move = [0, 0, -20]", "move = [0, nan, -20]", "camera.move[1]", &["NaN"]);
    // A number beyond the range of f64.
    refused("radius = 5", "radius = 1e999", "dome.radius", &[]);
    refused("radius = 5", "radius = 99999999999999999999", "dome.radius", &[]);
}

#[test]
fn ranges_of_the_dome() {
    refused("radius = 5", "radius = 0", "dome.radius", &["greater than 0", "metres"]);
    refused("radius = 5", "radius = -5", "dome.radius", &["-5", "greater than 0"]);
    refused("tilt = 20.0", "tilt = 181", "dome.tilt", &["at most 180"]);
    refused("coverage = 200", "coverage = 0", "dome.coverage", &["greater than 0", "degrees"]);
    refused("coverage = 200", "coverage = 361", "dome.coverage", &["at most 360"]);
}

#[test]
fn ranges_of_viewer_and_camera() {
    refused("yaw = 90", "yaw = 361", "camera.yaw", &["at most 360", "to the right"]);
    refused("pitch = -5", "pitch = -181", "viewer.pitch", &["at least -180", "upwards"]);
    refused("roll = 1", "roll = 400", "viewer.roll", &["at most 360", "clockwise"]);
    refused("zoom = 2", "zoom = 0", "camera.zoom", &["at least 0.001"]);
    refused("zoom = 2", "zoom = -1", "camera.zoom", &["at least 0.001"]);
    refused("move = [0, 0, -20]", "move = [0, 0, 1e10]", "camera.move[2]", &["program's own units"]);
}

#[test]
fn ranges_of_views_and_overlay() {
    refused("quality = 1.5", "quality = 0.05", "views.quality", &["at least 0.1 and at most 8"]);
    refused("quality = 1.5", "quality = 9", "views.quality", &["at least 0.1 and at most 8"]);
    refused("width = 70", "width = 0", "overlay.width", &["greater than 0 and less than 180"]);
    refused("width = 70", "width = 180", "overlay.width", &["greater than 0 and less than 180"]);
}

#[test]
fn the_viewer_is_inside_the_dome() {
    refused(
        "position = [0.5, -0.2, 1]",
        "position = [3, 4, 0]",
        "viewer.position",
        &["5 m", "radius 5 m", "at most 4.95 m"],
    );
    refused("position = [0.5, -0.2, 1]", "position = [0, 10, 0]", "viewer.position", &["10 m", "not inside the dome"]);
    // Without a screen that limits it, the viewer may be anywhere.
    read("[viewer]\nposition = [0, 10, 0]\n[[output]]\nkind = \"perspective\"\nfov = [60, 40]").unwrap();
}

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

#[test]
fn names_of_outputs() {
    refused("name = \"right\"", "name = \"left\"", "output[1].name", &["another output", "of its own"]);
    refused("name = \"right\"", "name = \"Left\"", "output[1].name", &["another output"]);
    for name in ["", "a b", "a/b", "..", "-o", "é", &"n".repeat(65)] {
        refused(
            "name = \"right\"",
            &format!("name = {name:?}"),
            "output[1].name",
            &["cannot be used", "letters", "digits"],
        );
    }
    read(&with("name = \"right\"", &format!("name = \"{}\"", "n".repeat(64))).0).unwrap();
}

#[test]
fn sizes() {
    for (size, which) in
        [("[0, 1080]", 0), ("[1920, 0]", 1), ("[16385, 1080]", 0), ("[-1, 1080]", 0), ("[1920.5, 1080]", 0)]
    {
        let key = format!("output[0].size[{which}]");
        refused(
            "size = [1920, 1080]",
            &format!("size = {size}"),
            &key,
            &["[width, height] in pixels", "from 1 to 16384"],
        );
    }
    refused("size = [1920, 1080]", "size = [1920]", "output[0].size", &["expected 2 numbers"]);
    refused("size = [1920, 1080]", "size = \"1920x1080\"", "output[0].size", &["expected 2 numbers"]);
    read(&with("size = [1920, 1080]", "size = [16384, 16384]").0).unwrap();
}

#[test]
fn windows() {
    let line = "window = [1920, 0, 1920, 1080]";
    refused(line, "window = [1919, 0, 1920, 1080]", "output[1].window", &["overlaps the window of \"left\""]);
    refused(line, "window = [1920, 0, 0, 1080]", "output[1].window[2]", &["from 1 to 16384"]);
    refused(line, "window = [-1, 0, 1920, 1080]", "output[1].window[0]", &["from 0 to 32767"]);
    refused(line, "window = [32000, 0, 1920, 1080]", "output[1].window", &["(33920, 1080)", "32767"]);
    refused(line, "window = [1920, 0, 1920]", "output[1].window", &["expected 4 numbers"]);
    let (text, number) = with(line, "");
    refused_text(&text, number - 3, "output[1].window", &["is missing", "for none"]);
}

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

#[test]
fn numbers_of_outputs() {
    refused_text("name = \"empty\"", 1, "output", &["at least one [[output]]", "passthrough = true"]);
    refused_text("[[output]]\nname = \"n\"", 1, "output[0].kind", &["is missing", "\"domemaster\""]);
    let text = "passthrough = true\n[[output]]\nkind = \"domemaster\"";
    refused_text(text, 1, "passthrough", &["leave out one of them"]);
    let many = |count| "[[output]]\nkind = \"domemaster\"\n".repeat(count);
    read(&many(64)).unwrap();
    refused_text(&many(65), 129, "output[64]", &["at most 64 outputs"]);
    read("passthrough = true").unwrap();
}

#[test]
fn one_message_lists_every_problem_in_the_files_order() {
    let text = COMPLETE
        .replace("radius = 5", "radius = -5")
        .replace("gamma = 2.4", "gamma = 9")
        .replace("zoom = 2", "zom = 2");
    let message = read(&text).unwrap_err();
    let keys: Vec<&str> = message.lines().filter_map(|line| line.split(": ").nth(1)).collect();
    assert_eq!(keys, ["dome.radius", "camera.zom", "output[0].blend.gamma (left)"]);
    // A long list of problems is cut short.
    let many = read(&"[[output]]\nkind = \"x\"\n".repeat(64)).unwrap_err();
    assert_eq!(many.lines().count(), 21);
    assert!(many.ends_with("more problems"), "{many}");
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
        assert!(message.contains(&format!(": {key}: ")) && message.contains(word), "{lines}: {message}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
}
