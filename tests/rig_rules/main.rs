//! Rules of the rig file: a file that breaks one is refused, and the message has line, key and
//! remedy.

mod blending;
mod lenses;
mod outputs;
mod scene;

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
