//! Presets and example rigs: they load, have the values that they should have, and light their
//! screens completely.

#[path = "../src/testing/random.rs"]
mod random;

use cupola::rig::{Camera, DomeAngle, Output, OutputKind, Rig, ViewMethod, load, parse, presets};
use glam::DVec3;
use random::Random;
use std::f64::consts::PI;
use std::path::Path;

fn examples() -> Vec<Rig> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/rigs");
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<_> = entries.filter(|path| path.extension().is_some_and(|kind| kind == "toml")).collect();
    files.sort();
    assert!(files.len() >= 5, "examples are missing");
    files.iter().map(|file| load(file.to_str().unwrap()).unwrap_or_else(|error| panic!("{error}"))).collect()
}

/// For points all over the screen, the number of `outputs` that light each point. Computed here
/// with sines, cosines and the projectors' axes, so that it does not share a mistake with the
/// library.
fn covers(rig: &Rig, outputs: &[Output]) -> Vec<usize> {
    const POINTS: usize = 20_000;
    let cap = (rig.dome.coverage / 2.0).cos();
    let spiral = (0..POINTS).map(|i| {
        let height = 1.0 - (1.0 - cap) * (i as f64 + 0.5) / POINTS as f64;
        (height, i as f64 * 2.399_963_229_728_653)
    });
    let rim = (0..2000).map(|i| (cap, i as f64 * PI / 1000.0));
    let (sin_tilt, cos_tilt) = rig.dome.tilt.sin_cos();
    let point = |(height, turn): (f64, f64)| {
        let ring = (1.0 - height * height).max(0.0).sqrt();
        let (x, back) = (ring * turn.cos(), ring * turn.sin());
        rig.dome.radius * DVec3::new(x, height * cos_tilt + back * sin_tilt, back * cos_tilt - height * sin_tilt)
    };
    let lights = |output: &Output, point: DVec3| {
        let OutputKind::Projector { position, angles: [yaw, pitch, roll], frustum } = output.kind else { return false };
        let forward = DVec3::new(yaw.sin() * pitch.cos(), pitch.sin(), -yaw.cos() * pitch.cos());
        let level = DVec3::new(yaw.cos(), 0.0, yaw.sin());
        let raised = level.cross(forward);
        let right = level * roll.cos() - raised * roll.sin();
        let up = raised * roll.cos() + level * roll.sin();
        let ray = point - position;
        let (x, y) = (ray.dot(right) / ray.dot(forward), ray.dot(up) / ray.dot(forward));
        let inside = frustum.left < x && x < frustum.right && frustum.bottom < y && y < frustum.top;
        ray.dot(forward) > 0.0 && inside
    };
    spiral.chain(rim).map(point).map(|point| outputs.iter().filter(|output| lights(output, point)).count()).collect()
}

#[test]
fn presets_load_under_their_names() {
    assert_eq!(presets()[0].name, "fisheye");
    for preset in presets() {
        let rig = load(preset.name).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(rig.name, preset.name);
        assert_eq!(rig.passthrough, preset.name == "identity");
    }
}

#[test]
fn examples_load() {
    for rig in examples() {
        assert!(!rig.outputs.is_empty(), "{}", rig.name);
    }
}

#[test]
fn fisheye_looks_where_the_program_looks() {
    let rig = load("fisheye").unwrap();
    assert_eq!(rig.outputs[0].kind, OutputKind::Domemaster { aperture: PI, tilt: PI / 2.0 });
    assert_eq!(rig.viewer.position, DVec3::ZERO);
    let rig = load("fisheye-210").unwrap();
    assert_eq!(rig.outputs[0].kind, OutputKind::Domemaster { aperture: 210_f64.to_radians(), tilt: 0.0 });
    let rig = load("identity-captured").unwrap();
    assert_eq!(rig.outputs[0].kind, OutputKind::Perspective { angles: [0.0; 3], frustum: None });
}

#[test]
fn six_projectors_light_the_whole_planetarium() {
    let rig = load("planetarium-6").unwrap();
    assert_eq!(rig.outputs.len(), 6);
    assert!(rig.outputs.iter().all(|output| output.blend.overlap && output.size == Some((1920, 1080))));
    let counts = covers(&rig, &rig.outputs);
    assert_eq!(counts.iter().filter(|count| **count == 0).count(), 0);
    let several = counts.iter().filter(|count| **count > 1).count() as f64 / counts.len() as f64;
    assert!((0.5..0.9).contains(&several), "{several} of the screen is lit by more than one projector");
    // Negative control: without any one of the six projectors a part of the screen is dark.
    for index in 0..6 {
        let mut rest = rig.outputs.clone();
        rest.remove(index);
        assert!(covers(&rig, &rest).contains(&0), "{} is not needed", rig.outputs[index].name);
    }
}

#[test]
fn projectors_of_the_examples_light_their_screens() {
    let on_the_dome = |rig: &&Rig| rig.screen.is_none() && matches!(rig.outputs[0].kind, OutputKind::Projector { .. });
    for rig in examples().iter().filter(on_the_dome) {
        let counts = covers(rig, &rig.outputs);
        let dark = counts.iter().filter(|count| **count == 0).count();
        assert!(dark * 100 < counts.len(), "{}: {dark} of {} points are dark", rig.name, counts.len());
    }
}

#[test]
fn degrees_become_radians_and_defaults_hold() {
    let rig = parse(
        "[dome]\ntilt = 30\ncoverage = 160\n[camera]\nmove = [1, 2, 3]\nyaw = 90\n[[output]]\nkind = \"domemaster\"",
        "here/my.rig.toml",
        Path::new(""),
    )
    .unwrap();
    assert_eq!(rig.name, "my.rig");
    assert_eq!((rig.dome.radius, rig.dome.tilt, rig.dome.coverage), (5.0, 30_f64.to_radians(), 160_f64.to_radians()));
    assert_eq!(rig.camera, Camera { shift: DVec3::new(1.0, 2.0, 3.0), yaw: PI / 2.0, ..Camera::default() });
    assert_eq!((rig.views.method, rig.views.quality), (ViewMethod::Auto, 1.0));
    assert_eq!(rig.overlay.width, 60_f64.to_radians());
    // A domemaster without keys of its own shows the rig's dome.
    let kind = OutputKind::Domemaster { aperture: 160_f64.to_radians(), tilt: 30_f64.to_radians() };
    assert_eq!((rig.outputs[0].name.as_str(), rig.outputs[0].kind.clone()), ("output-1", kind));
    assert_eq!((rig.outputs[0].blend.overlap, rig.outputs[0].blend.gamma), (false, 2.2));
}

#[test]
fn fov_with_shift_and_angles_say_the_same() {
    let opening = |keys: &str| {
        let text = format!("[[output]]\nkind = \"perspective\"\n{keys}");
        match parse(&text, "rig.toml", Path::new("")).unwrap().outputs[0].kind {
            OutputKind::Perspective { frustum: Some(frustum), .. } => frustum,
            _ => panic!("no opening"),
        }
    };
    // Shifted by half a picture, a lens of 90° × 90° reaches from 0 to twice the tangent of 45°.
    let [shifted, angles] = [
        "fov = [90, 90]\nshift = [0.5, -0.25]",
        "angles = { left = 0, right = 63.43494882292201, bottom = -56.309932474020215, top = 26.56505117707799 }",
    ]
    .map(opening);
    for (a, b, closed) in [
        (shifted.left, angles.left, 0.0),
        (shifted.right, angles.right, 2.0),
        (shifted.bottom, angles.bottom, -1.5),
        (shifted.top, angles.top, 0.5),
    ] {
        assert!((a - closed).abs() < 1e-14 && (b - closed).abs() < 1e-14, "{a} {b} {closed}");
    }
}

#[test]
fn ramps_keep_their_sign() {
    let text =
        "[[output]]\nkind = \"domemaster\"\nblend = { ramps = [{ angle = \"azimuth\", zero = -90, full = -80 }] }";
    let rig = parse(text, "rig.toml", Path::new("")).unwrap();
    let ramp = rig.outputs[0].blend.ramps[0];
    assert_eq!((ramp.angle, ramp.zero, ramp.full), (DomeAngle::Azimuth, -PI / 2.0, -80_f64.to_radians()));
}

/// A rig with `count` perspectives, each with `keys(index)`.
fn row(count: usize, keys: impl Fn(usize) -> String) -> Rig {
    let output = |index| format!("[[output]]\nkind = \"perspective\"\nfov = [60, 40]\n{}\n", keys(index));
    parse(&(0..count).map(output).collect::<String>(), "rig.toml", Path::new("")).unwrap()
}

/// Rectangles of a rig's outputs: x, y, width, height.
fn layout(rig: &Rig, window: (u32, u32)) -> Vec<[u32; 4]> {
    rig.layout(window).iter().map(|place| [place.x, place.y, place.width, place.height]).collect()
}

#[test]
fn outputs_without_a_place_share_the_window() {
    let plain = |_| String::new();
    assert_eq!(layout(&row(1, plain), (801, 599)), [[0, 0, 801, 599]]);
    assert_eq!(layout(&row(2, plain), (801, 600)), [[0, 0, 400, 600], [400, 0, 401, 600]]);
    let six = layout(&row(6, plain), (5760, 2160));
    assert_eq!(six[0], [0, 0, 1920, 1080]);
    assert_eq!(six[4], [1920, 1080, 1920, 1080]);
    // For any number of outputs and any window, no outputs overlap and none is outside.
    for count in 1..=64_usize {
        for window in [(1, 1), (7, 5), (1920, 1080), (32767, 3)] {
            let places = row(count, plain).layout(window);
            let area: u64 = places.iter().map(|place| u64::from(place.width) * u64::from(place.height)).sum();
            let columns = (1..).find(|n| n * n >= count).unwrap();
            let whole = u64::from(window.0) * u64::from(window.1);
            assert!(places.iter().all(|place| place.x + place.width <= window.0 && place.y + place.height <= window.1));
            assert!(area <= whole, "{count} in {window:?}");
            assert!(count % columns != 0 || area == whole, "{count} in {window:?} leave a gap");
        }
    }
    assert!(load("identity").unwrap().layout((800, 600)).is_empty());
}

#[test]
fn places_in_the_window_are_cropped_and_not_scaled() {
    let rig = row(2, |index| format!("window = [{}, 10, 100, 50]", index * 100));
    assert_eq!(layout(&rig, (1000, 1000)), [[0, 10, 100, 50], [100, 10, 100, 50]]);
    assert_eq!(layout(&rig, (150, 40)), [[0, 10, 100, 30], [100, 10, 50, 30]]);
    assert_eq!(layout(&rig, (50, 5)), [[0, 5, 0, 0], [50, 5, 0, 0]]);
    assert_eq!(rig.extent(), Some((200, 60)));
}

#[test]
fn extent_is_the_window_of_native_resolutions() {
    assert_eq!(load("planetarium-6").unwrap().extent(), Some((5760, 2160)));
    assert_eq!(load("fisheye").unwrap().extent(), None);
    assert_eq!(load("identity").unwrap().extent(), None);
    assert_eq!(row(2, |index| format!("size = [{}, {}]", 100 + index, 50 - index)).extent(), Some((202, 50)));
}

#[test]
fn the_camera_is_overridden_in_one_line() {
    let camera = Camera { pitch: 1.0, ..Camera::default() };
    let changed = camera.apply_override("zoom=4, move=0,-1.5,-20 ,yaw=90").unwrap();
    assert_eq!(
        changed,
        Camera { zoom: 4.0, shift: DVec3::new(0.0, -1.5, -20.0), yaw: PI / 2.0, pitch: 1.0, ..Camera::default() }
    );
    assert_eq!(camera.apply_override("").unwrap(), camera);
    assert_eq!(camera.apply_override("pitch=0,roll=180").unwrap().roll, PI);
    for (text, words) in [
        ("zom=4", "did you mean `zoom`?"),
        ("zoom", "\"zoom\" is not a number"),
        ("zoom=", "not a number"),
        ("zoom=0", "at least 0.001"),
        ("zoom=nan", "no number that can be used"),
        ("zoom=1,2", "takes one number, not 2"),
        ("zoom=1,zoom=2", "twice"),
        ("move=1,2", "takes three numbers, not 2"),
        ("move=1,2,inf", "no number that can be used"),
        ("yaw=361", "at most 360"),
        ("4", "no key before it"),
        (",", "not a number"),
        ("zoom=4,", "not a number"),
    ] {
        let error = camera.apply_override(text).unwrap_err();
        assert_eq!(error.kind, cupola::ErrorKind::InvalidArgument);
        assert!(error.message.contains(words) && error.message.contains("zoom=4,move=0,0,-20"), "{}", error.message);
    }
}

#[test]
fn rigs_that_are_not_there() {
    let error = load("fisheyes").unwrap_err();
    assert_eq!(error.kind, cupola::ErrorKind::Io);
    assert!(error.message.contains("did you mean the preset `fisheye`?"), "{error}");
    let error = load("nowhere/rig.toml").unwrap_err();
    assert!(error.message.contains("presets are fisheye, fisheye-210, planetarium-6"), "{error}");
    assert_eq!(load("/").unwrap_err().kind, cupola::ErrorKind::Io);
    let file = Path::new(env!("CARGO_TARGET_TMPDIR")).join("latin1.toml");
    std::fs::write(&file, b"# \n# caf\xe9\n").unwrap();
    let error = load(file.to_str().unwrap()).unwrap_err();
    assert!(error.message.contains("latin1.toml:2: the file is not UTF-8"), "{error}");
}

#[test]
fn nothing_in_a_file_makes_the_reader_panic() {
    let mut random = Random::new(1);
    let texts: Vec<&str> = presets().iter().map(|preset| preset.text).collect();
    let pieces = [
        "[",
        "]",
        "[[output]]\n",
        "{",
        "}",
        "=",
        "\n",
        "\"",
        "'",
        "nan",
        "-inf",
        "1e308",
        "-1e-308",
        "0x7fffffffffffffff",
        "9223372036854775808",
        "é",
        "\u{202e}",
        "kind",
        "\"projector\"",
        "fov = [1e-9, 179]\n",
        "shift = [2, 2]\n",
        "radius",
        "position = [1e6, 1e6, 1e6]\n",
        "angles = { left = -89.5, right = 89.5, bottom = -89.5, top = 89.5 }\n",
        "window = [0,0,1,1]\n",
        "coverage = 1e-300\n",
        "1979-05-27T07:32:00Z",
        "''''''",
        "#",
        ".",
        ",",
        "\r",
        "\0",
        "true",
    ];
    let (mut accepted, mut refused) = (0, 0);
    for _ in 0..20_000 {
        let mut text: Vec<char> = texts[random.below(texts.len())].chars().collect();
        for _ in 0..1 + random.below(4) {
            let at = random.below(text.len() + 1);
            let end = at + random.below(1 + (text.len() - at).min(30));
            let piece = pieces[random.below(pieces.len())];
            text.splice(at..end, if random.below(4) == 0 { "" } else { piece }.chars());
        }
        let text: String = text.into_iter().collect();
        match parse(&text, "rig.toml", Path::new("")) {
            Ok(rig) => {
                accepted += 1;
                rig.layout((640, 480));
                rig.extent();
            }
            Err(error) => {
                refused += 1;
                assert!(error.message.starts_with("rig.toml:"), "{error}");
            }
        }
    }
    assert!(accepted > 100 && refused > 10_000, "{accepted} accepted, {refused} refused");
    // Deep nesting gives an error and does not overflow the stack.
    let deep = format!("x = {}", "[".repeat(100_000));
    assert!(parse(&deep, "rig.toml", Path::new("")).is_err());
}

#[test]
fn the_documents_examples_are_valid() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let document = std::fs::read_to_string(root.join("docs/rig-file.md")).unwrap();
    let blocks: Vec<&str> = document.split("```toml\n").skip(1).filter_map(|rest| rest.split("```").next()).collect();
    assert!(blocks.len() >= 6, "examples are missing");
    for block in blocks {
        // An example that is part of a file is completed to a whole file.
        let projector = "[[output]]\nkind = \"projector\"\nfov = [60, 40]\n";
        let text = match block {
            _ if block.contains("[[output]]") => block.to_owned(),
            _ if block.starts_with("[output.") || block.starts_with("mask") => format!("{projector}{block}"),
            _ => format!("{block}{projector}"),
        };
        parse(&text, "rig-file.md", &root.join("examples/rigs")).unwrap_or_else(|error| panic!("{error}\n{text}"));
    }
    // The page describes every key that a message lists as possible.
    let unknown =
        ["dome", "viewer", "camera", "views", "overlay"].map(|section| format!("[{section}]\nqqq = 1\n")).concat();
    let outputs = ["domemaster", "projector", "perspective"].map(|kind| {
        let rest = if kind == "domemaster" { "" } else { "fov = [60, 40]\n" };
        let angle = "ramps = [{ angle = \"polar\", zero = 1, full = 2, qqq = 1 }]";
        format!("[[output]]\nkind = \"{kind}\"\nqqq = 1\n{rest}[output.blend]\nqqq = 1\n{angle}\n[output.mask]\nimage = \"x\"\nqqq = 1\n")
    });
    let message = parse(&format!("qqq = 1\n{unknown}{}", outputs.concat()), "x", Path::new("")).unwrap_err().message;
    let mut keys = 0;
    for key in message.lines().filter_map(|line| line.split("possible here: ").nth(1)).flat_map(|list| list.split(", "))
    {
        assert!(
            document.contains(&format!("`{key}`")) || document.contains(&format!("[{key}")),
            "{key} is not described"
        );
        keys += 1;
    }
    assert!(keys > 60, "only {keys} keys were listed in\n{message}");
}

#[test]
fn a_file_of_measurements_is_the_response_that_was_measured() {
    use cupola::blend::{code_of, light_of};
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("responses");
    std::fs::create_dir_all(&folder).expect("a folder");
    let line = |code: f64| {
        let light = |gamma: f64, white: f64| 0.1 + white * (code / 255.0f64).powf(gamma);
        format!("{code}; {:.6}; {:.6};\t{:.6}\n", light(1.9, 20.0), light(2.2, 70.0), light(2.5, 9.0))
    };
    let lines: String = (0..=51).map(|step| line(5.0 * f64::from(step))).collect();
    std::fs::write(folder.join("response.csv"), format!("code red green blue\n# a photometer's\n\n{lines}"))
        .expect("writes");
    let text = "[[output]]\nkind = \"domemaster\"\nblend = { transfer = { file = \"response.csv\" } }\n";
    let rig = cupola::rig::parse(text, "rig.toml", &folder).unwrap_or_else(|error| panic!("{error}"));
    for (channel, gamma) in [1.9, 2.2, 2.5].into_iter().enumerate() {
        for code in [0.0, 0.1, 0.33, 0.5, 0.9, 1.0] {
            let light = light_of(code, &rig.outputs[0].blend, channel);
            assert!((light - code.powf(gamma)).abs() < 2e-3, "{channel} {code}: {light}");
            assert!((code_of(light, &rig.outputs[0].blend, channel) - code).abs() < 1e-12);
        }
    }
    for (bad, words) in [("0 1\n5\n", "line 2"), ("0 1\n255 0.5\n", "both growing"), ("words\nwords\n", "line 2")] {
        std::fs::write(folder.join("response.csv"), bad).expect("writes");
        let error = cupola::rig::parse(text, "rig.toml", &folder).expect_err(bad);
        assert!(error.message.contains(words) && error.message.contains("response.csv"), "{}", error.message);
    }
}
