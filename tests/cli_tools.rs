//! `cupola check`, `map`, `simulate`, `plan`, `setup` and `doctor`.

mod tool;

use std::path::Path;
use std::process::Command;
use tool::Tool;

const CUPOLA: Tool = Tool { path: env!("CARGO_BIN_EXE_cupola"), name: "cupola" };

fn example(name: &str) -> String {
    format!("{}/examples/rigs/{name}.toml", env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn check_describes_rigs_in_words() {
    let text = CUPOLA.answer(&["check", "fisheye"]);
    for expected in ["fisheye is a valid rig", "pole straight ahead", "domemaster of 180°", "views", "texels"] {
        assert!(text.contains(expected), "{expected} is not in\n{text}");
    }
    let text = CUPOLA.answer(&["check", &example("small-dome-one-projector")]);
    assert!(text.contains("0.412 m from the dome's centre at (0, -0.1, 0.4) m"), "{text}");
    assert!(text.contains("11° down") && text.contains("1.5 times as large"), "{text}");
    assert!(CUPOLA.answer(&["check", "identity"]).contains("is not changed"));
    for name in ["domemaster-4k", "masked-fisheye", "three-walls", "two-projectors"] {
        CUPOLA.answer(&["check", &example(name)]);
    }
}

#[test]
fn check_answers_machines() {
    let rig = CUPOLA.json(&["check", "planetarium-6", "--json"]);
    assert_eq!(rig["valid"], true);
    assert_eq!(rig["outputs"].as_array().unwrap().len(), 6);
    assert_eq!(rig["window"], serde_json::json!([5760, 2160]));
    assert!((rig["dome"]["tilt"].as_f64().unwrap() - 25.0).abs() < 1e-12);
    assert!(!rig["views"].as_array().unwrap().is_empty());
    let broken = CUPOLA.file("broken.toml");
    std::fs::write(&broken, "[dome]\nradius = -1\ntillt = 3\n").unwrap();
    let output = CUPOLA.run(&["check", broken.to_str().unwrap(), "--json"]);
    assert_eq!(output.status.code(), Some(2));
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!((answer["valid"].as_bool(), answer["problems"].as_array().unwrap().len()), (Some(false), 2));
    CUPOLA.refused(&["check", broken.to_str().unwrap()], "broken.toml:2: dome.radius");
}

#[test]
fn check_lists_and_prints_presets() {
    let list = CUPOLA.answer(&["check", "--presets"]);
    let names: Vec<&str> = list.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert_eq!(
        names,
        ["fisheye", "fisheye-210", "planetarium-6", "planetarium-2", "idome", "identity", "identity-captured"]
    );
    assert_eq!(CUPOLA.json(&["check", "--presets", "--json"])[0]["name"], "fisheye");
    // The printed text is a rig file.
    let copy = CUPOLA.file("copy.toml");
    std::fs::write(&copy, CUPOLA.answer(&["check", "planetarium-6", "--print"])).unwrap();
    assert!(CUPOLA.answer(&["check", copy.to_str().unwrap()]).contains("planetarium-6 is a valid rig"));
}

/// The pixels of a PFM file, row by row from the bottom.
fn read_pfm(path: &Path) -> (usize, usize, Vec<[f32; 3]>) {
    let bytes = std::fs::read(path).unwrap();
    let lines: Vec<&[u8]> = bytes.splitn(4, |byte| *byte == b'\n').collect();
    assert_eq!((lines[0], lines[2]), (&b"PF"[..], &b"-1.0"[..]));
    let size: Vec<usize> = std::str::from_utf8(lines[1]).unwrap().split(' ').map(|n| n.parse().unwrap()).collect();
    let floats: Vec<f32> = lines[3].chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    assert_eq!(floats.len(), size[0] * size[1] * 3);
    (size[0], size[1], floats.chunks_exact(3).map(|p| [p[0], p[1], p[2]]).collect())
}

#[test]
fn map_writes_where_pixels_look() {
    let out = CUPOLA.file("fisheye.pfm");
    let text = CUPOLA.answer(&["map", "fisheye", "-o", out.to_str().unwrap(), "--size", "64x64"]);
    let (width, height, pixels) = read_pfm(&out);
    assert_eq!((width, height), (64, 64));
    for (index, pixel) in pixels.iter().enumerate() {
        // The equidistant fisheye, computed here: the angle from straight ahead is proportional to
        // the distance from the middle.
        let (x, y) = ((index % 64) as f64 + 0.5 - 32.0, (index / 64) as f64 + 0.5 - 32.0);
        let radius = x.hypot(y) / 32.0;
        if radius > 1.0 {
            assert!(pixel.iter().all(|value| value.is_nan()), "{index}");
            continue;
        }
        let angle = radius * std::f64::consts::FRAC_PI_2;
        let expected = [angle.sin() * x / x.hypot(y), angle.sin() * y / x.hypot(y), -angle.cos()];
        for (value, expected) in pixel.iter().zip(expected) {
            assert!((f64::from(*value) - expected).abs() < 1e-6, "{index}: {pixel:?}, not {expected:?}");
        }
    }
    let shown = pixels.iter().filter(|pixel| pixel[0].is_finite()).count();
    assert!(text.contains(&format!("{shown} of them show something")), "{text}");
}

#[test]
fn map_is_in_the_axes_of_the_programs_camera() {
    let rig = CUPOLA.file("turned.toml");
    std::fs::write(&rig, "[camera]\nyaw = 90\n[[output]]\nkind = \"perspective\"\nfov = [10, 10]\n").unwrap();
    let out = CUPOLA.file("turned.pfm");
    CUPOLA.answer(&["map", rig.to_str().unwrap(), "-o", out.to_str().unwrap(), "--size", "1x1"]);
    let (_, _, pixels) = read_pfm(&out);
    // The camera looks to the right, so the viewer's direction straight ahead is to the left of the
    // camera.
    assert!((pixels[0][0] + 1.0).abs() < 1e-6 && pixels[0][1].abs() < 1e-6 && pixels[0][2].abs() < 1e-6, "{pixels:?}");
}

#[test]
fn map_says_which_outputs_there_are() {
    let out = CUPOLA.file("none.pfm");
    let out = out.to_str().unwrap();
    CUPOLA.refused(&["map", "planetarium-6", "-o", out], "--output takes one of front, right");
    CUPOLA
        .refused(&["map", "planetarium-6", "-o", out, "--output", "middle"], "has no output \"middle\"; it has front");
    CUPOLA.refused(&["map", "identity", "-o", out], "has no outputs");
    CUPOLA.refused(&["map", "identity-captured", "-o", out, "--size", "8x8"], "program's own lens");
    assert!(!Path::new(out).exists());
}

/// The blending of a calibration is often a mask. This mask halves the light everywhere.
#[test]
fn simulate_counts_masks() {
    let mask = CUPOLA.file("half.png");
    image::GrayImage::from_pixel(3, 2, image::Luma([128])).save(&mask).unwrap();
    let text = "[[output]]\nkind = \"domemaster\"\nsize = [96, 96]\nflip = \"both\"\n";
    let means = ["", "mask = { image = \"half.png\" }\n"].map(|masked| {
        let (rig, out) = (CUPOLA.file("masked.toml"), CUPOLA.file("masked.png"));
        std::fs::write(&rig, format!("{text}{masked}")).unwrap();
        let (rig, out) = (rig.to_str().unwrap(), out.to_str().unwrap());
        let answer = CUPOLA.json(&["simulate", rig, "--white", "-o", out, "--size", "64", "--json"]);
        answer["uniformity"]["mean"].as_f64().unwrap()
    });
    assert!((means[0] - 1.0).abs() < 1e-3 && (means[1] - 128.0 / 255.0).abs() < 1e-3, "{means:?}");
}

#[test]
fn simulate_finds_white_even_and_gaps_dark() {
    let out = CUPOLA.file("white.png");
    let rig = CUPOLA.file("pair.toml");
    let text =
        std::fs::read_to_string(example("two-projectors")).unwrap().replace("1920", "192").replace("1200", "120");
    std::fs::write(&rig, &text).unwrap();
    let (rig, out) = (rig.to_str().unwrap(), out.to_str().unwrap());
    let answer = CUPOLA.json(&["simulate", rig, "--white", "-o", out, "--size", "128", "--json"]);
    assert!(answer["uniformity"]["rms"].as_f64().unwrap() < 0.01, "{answer}");
    assert!(answer["lit_by"][2].as_f64().unwrap() > 0.05, "{answer}");
    assert_eq!(image::image_dimensions(out).unwrap(), (128, 128));
    // Negative control: without blending the overlap is twice as bright.
    let unblended = CUPOLA.file("unblended.toml");
    std::fs::write(&unblended, text.replace("ramp = 0.3", "overlap = false")).unwrap();
    let answer =
        CUPOLA.json(&["simulate", unblended.to_str().unwrap(), "--white", "-o", out, "--size", "128", "--json"]);
    assert!(answer["uniformity"]["max"].as_f64().unwrap() > 0.9, "{answer}");
}

#[test]
fn simulate_takes_captures_by_name() {
    let rig = CUPOLA.file("named.toml");
    let output = |name: &str, yaw: i32| {
        format!("[[output]]\nname = \"{name}\"\nkind = \"projector\"\nyaw = {yaw}\npitch = 45\nfov = [80, 80]\n")
    };
    std::fs::write(&rig, output("left", -40) + &output("back-left", 140)).unwrap();
    let folder = CUPOLA.file("captures");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir(&folder).unwrap();
    let picture = |name: &str, grey: u8| {
        image::GrayImage::from_pixel(8, 8, image::Luma([grey])).save(folder.join(name)).unwrap();
    };
    let out = CUPOLA.file("named.png");
    let arguments = |json: bool| {
        let mut list = vec![
            "simulate",
            rig.to_str().unwrap(),
            "--captures",
            folder.to_str().unwrap(),
            "-o",
            out.to_str().unwrap(),
            "--size",
            "64",
        ];
        list.extend(json.then_some("--json"));
        list.into_iter().map(str::to_owned).collect::<Vec<_>>()
    };
    let call = |json: bool| arguments(json);
    picture("a-left.png", 255);
    let without = call(false);
    CUPOLA.refused(&without.iter().map(String::as_str).collect::<Vec<_>>(), "no picture of back-left");
    picture("a-back-left.png", 255);
    let with = call(true);
    let bright = CUPOLA.json(&with.iter().map(String::as_str).collect::<Vec<_>>());
    assert!((bright["uniformity"]["mean"].as_f64().unwrap() - 1.0).abs() < 1e-3, "{bright}");
    picture("a-back-left.png", 0);
    let dark = CUPOLA.json(&with.iter().map(String::as_str).collect::<Vec<_>>());
    assert!(dark["uniformity"]["mean"].as_f64().unwrap() < 0.7, "{dark}");
    picture("left.png", 255);
    CUPOLA.refused(&without.iter().map(String::as_str).collect::<Vec<_>>(), "several pictures fit the output left");
}

#[test]
fn doctor_tells_what_it_found() {
    // The exit code depends on the machine. Both forms of the answer do not.
    let output = CUPOLA.run(&["doctor", "--json"]);
    let answer: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let keys: Vec<&str> = answer["findings"].as_array().unwrap().iter().filter_map(|f| f["key"].as_str()).collect();
    for key in ["version", "xvfb", "display", "library", "glx", "egl"] {
        assert!(keys.contains(&key), "{key} is not in {keys:?}");
    }
    assert_eq!(output.status.success(), answer["usable"].as_bool().unwrap());
    let switched_off = Command::new(env!("CARGO_BIN_EXE_cupola")).arg("doctor").env("CUPOLA", "0").output().unwrap();
    let text = String::from_utf8(switched_off.stdout).unwrap();
    assert_eq!(switched_off.status.code(), Some(1));
    assert!(text.contains("CUPOLA=0 switches Cupola off") && text.contains("cannot be corrected"), "{text}");
}

#[test]
fn plan_says_what_views_cost_and_draws_them() {
    let picture = CUPOLA.file("plan.png");
    let text = CUPOLA.answer(&["plan", "fisheye", "--size", "512x512", "--picture", picture.to_str().unwrap()]);
    for expected in ["% hidden", "sharpness  at least 1.00", "note       no view"] {
        assert!(text.contains(expected), "{expected} is not in\n{text}");
    }
    let drawn = image::open(&picture).unwrap().to_rgb8();
    let sphere = |x: u32| (200..880).filter(|&y| drawn.get_pixel(x, y).0[2] > 100).count();
    // The dome fills the front half (column 330 is beside the border of two views). Nothing of the
    // back half is sampled.
    assert!(sphere(330) > 600 && sphere(1260) < 100, "{} and {}", sphere(330), sphere(1260));

    // A name that cannot be written is refused before the rig is read.
    CUPOLA.refused(&["plan", "no-rig.toml", "--picture", "plan.svg"], "plan.svg: no picture of this kind");

    let plan = CUPOLA.json(&["plan", "planetarium-6", "--json"]);
    assert!(plan["least_texels_per_pixel"].as_f64().unwrap() >= 0.999);
    assert!(plan["directions"].as_u64().unwrap() > 100_000);
    assert!(plan["sampled_texels_per_pixel"].as_f64().unwrap() < plan["texels_per_pixel"].as_f64().unwrap());
    assert!(CUPOLA.json(&["plan", "identity", "--json"])["least_texels_per_pixel"].is_null());
}

#[test]
fn plan_tells_jumps() {
    // Two pictures side by side, one of them higher: their borders cross twice.
    let output = |yaw: i32, pitch: i32| {
        format!("[[output]]\nkind = \"projector\"\nsize = [320, 200]\nyaw = {yaw}\npitch = {pitch}\nfov = [60, 40]\n")
    };
    let pair = CUPOLA.file("crossing.toml");
    std::fs::write(&pair, format!("[dome]\ntilt = 90.0\n{}{}", output(0, 0), output(40, 10))).unwrap();
    let picture = CUPOLA.file("crossing.png");
    let (pair, drawn) = (pair.to_str().unwrap(), picture.to_str().unwrap());
    let text = CUPOLA.answer(&["plan", pair, "--picture", drawn]);
    assert_eq!(text.matches("jump       the light of output-1 and output-2 meets abruptly").count(), 2, "{text}");
    let plan = CUPOLA.json(&["plan", pair, "--json"]);
    assert_eq!(plan["jumps"].as_array().unwrap().len(), 2);
    assert!(plan["jumps"][0]["direction"][2].as_f64().unwrap() < -0.5, "{plan:#}");
    let red = |path: &Path| {
        let drawn = image::open(path).unwrap().to_rgb8();
        drawn.rows().take(880).flatten().filter(|pixel| pixel.0[0] > 240 && pixel.0[1] < 80 && pixel.0[2] < 80).count()
    };
    assert!(red(&picture) > 50, "{}", red(&picture));
    // A single picture crosses no other.
    let single = CUPOLA.file("single.toml");
    std::fs::write(&single, format!("[dome]\ntilt = 90.0\n{}", output(0, 0))).unwrap();
    let text = CUPOLA.answer(&["plan", single.to_str().unwrap(), "--picture", drawn]);
    assert!(!text.contains("jump") && red(&picture) < 10, "{}", red(&picture));
}

/// Runs `setup` for a new file, checks that `check` and `plan` accept the rig, and returns it.
#[track_caller]
fn set_up(name: &str, arguments: &[&str]) -> (cupola::rig::Rig, serde_json::Value) {
    let file = CUPOLA.file(name);
    let _ = std::fs::remove_file(&file);
    let path = file.to_str().unwrap();
    let answer = CUPOLA.json(&[&["setup", path, "--json", "--force"], arguments].concat());
    assert_eq!(CUPOLA.json(&["check", path, "--json"])["valid"], true);
    assert!(!CUPOLA.json(&["plan", path, "--json"])["views"].as_array().unwrap().is_empty());
    (cupola::rig::load(path).unwrap(), answer)
}

#[test]
fn setup_writes_the_rig_of_the_measures() {
    let listed = CUPOLA.file("xrandr.txt");
    std::fs::write(
        &listed,
        "DP-1 connected 1280x800+0+0 (normal) 1mm x 1mm\nDP-2 connected 1280x800+1280+0 (n) 1mm x 1mm\n",
    )
    .unwrap();
    let places =
        ["azimuth=180,distance=3.5,throw=0.5,aim=0:40,name=rear", "azimuth=0,distance=3.5,throw=0.5,aim=180:40"];
    let (rig, _) = set_up(
        "measured.toml",
        &[
            &["--diameter", "8", "--tilt", "15", "--seat", "0,-0.5,1", "--xrandr", listed.to_str().unwrap()][..],
            &["--projector", places[0], "--projector", places[1]],
        ]
        .concat(),
    );
    assert_eq!((rig.dome.radius, rig.viewer.position), (4.0, glam::DVec3::new(0.0, -0.5, 1.0)));
    assert!((rig.dome.tilt.to_degrees() - 15.0).abs() < 1e-9);
    assert_eq!([&rig.outputs[0].name, &rig.outputs[1].name], ["rear", "projector-2"]);
    assert_eq!(rig.outputs[1].window, Some(cupola::geom::PixelRect::new(1280, 0, 1280, 800)));
    // The middle of each picture is at the given place of the dome: 40° from the tilted pole.
    for (index, aim) in [(0, 40.0 + 15.0), (1, 40.0 - 15.0)] {
        let map = cupola::warp::WarpMap::new(&rig, index, (1280, 800), None).unwrap();
        let point = map.hit(glam::DVec2::new(640.0, 400.0)).unwrap() / 4.0;
        let zenith = point.y.acos().to_degrees();
        assert!((zenith - aim).abs() < 0.05 && point.x.abs() < 1e-3, "{index}: {zenith} {point}");
    }
    assert_eq!(set_up("fisheye-lens.toml", &["--diameter", "6", "--fisheye"]).0.outputs.len(), 1);
    assert_eq!(set_up("five.toml", &["--diameter", "12", "--projectors", "5"]).0.outputs.len(), 5);
}

#[test]
fn setup_refuses_what_no_dome_has_and_replaces_nothing() {
    let file = CUPOLA.file("refused.toml");
    let path = file.to_str().unwrap();
    let _ = std::fs::remove_file(&file);
    let usual = ["--diameter", "8", "--projector"];
    for (arguments, expected) in [
        (&["--fisheye"][..], "--diameter METRES is needed"),
        (&["--diameter", "8"], "--projectors N"),
        (&["--diameter", "8000", "--fisheye"], "0.2 to 200 metres"),
        (&["--diameter", "8", "--projectors", "2", "--monitors", "DP-9"], "no monitor \"DP-9\""),
        (&["--diameter", "8", "--projectors", "2", "--xrandr", "/nowhere"], "--xrandr: /nowhere"),
        (&["--diameter", "8", "--projectors", "2", "--seat", "9,0,0"], "viewer.position: is 9 m"),
        (&[usual[0], usual[1], usual[2], "azimuth=0,distance=4,aim=0:90"], "at the place that it aims at"),
        (&[usual[0], usual[1], usual[2], "name=a", "--projector", "name=a"], "name of another output"),
        (&["--from", "/nowhere.mpcdi"], "/nowhere.mpcdi cannot be read"),
    ] {
        CUPOLA.refused(&[&["setup", path], arguments].concat(), expected);
        assert!(!file.exists(), "{arguments:?} left a file");
    }
    // The reader of the options refuses this value with its own message.
    let said = CUPOLA.run(&["setup", path, "--diameter", "8,5", "--fisheye"]);
    assert!(said.status.code() == Some(2) && String::from_utf8_lossy(&said.stderr).contains("decimal sign is a point"));
    std::fs::write(&file, "# mine").unwrap();
    CUPOLA.refused(&["setup", path, "--diameter", "8", "--fisheye"], "refused.toml exists");
    CUPOLA.refused(&["setup", path, "--from", "planetarium-2"], "refused.toml exists");
    assert_eq!(std::fs::read(&file).unwrap(), b"# mine");
}

#[test]
fn setup_takes_calibrations_over_and_says_what_not() {
    let config = CUPOLA.file("cluster.json");
    let window = r#""pos": { "x": 0, "y": 0 }, "size": { "x": 200, "y": 100 }, "msaa": 4"#;
    let flat = r#"{ "type": "PlanarProjection", "fov": { "hfov": 90, "vfov": 60 }, "orientation": { "yaw": 20, "pitch": 5, "roll": 0 } }"#;
    std::fs::write(
        &config,
        format!(r#"{{ "scene": {{ "scale": 2 }}, "nodes": [{{ "windows": [{{ {window}, "viewports": [{{ "projection": {flat} }}] }}] }}] }}"#),
    )
    .unwrap();
    let (rig, answer) = set_up("cluster.toml", &["--from", config.to_str().unwrap()]);
    assert_eq!((rig.outputs.len(), answer["rigs"].as_array().unwrap().len()), (1, 1));
    let notes = answer["notes"].to_string();
    assert!(notes.contains("not taken over: nodes.windows.msaa, scene"), "{notes}");
    for archive in ["set.mpcdi", "set.vwf"] {
        let file = CUPOLA.file(archive);
        CUPOLA.answer(&["convert", "planetarium-2", file.to_str().unwrap(), "--size", "48x30", "--force"]);
        let (rig, answer) = set_up("set.toml", &["--from", file.to_str().unwrap()]);
        assert_eq!(rig.outputs.len(), 2);
        // An archive of Cupola contains the dome.
        let told = answer["notes"].to_string().contains("does not say how the dome is tilted");
        assert_eq!(told, archive == "set.vwf", "{answer}");
    }
    // A map that exists is not replaced either, and nothing is written beside it.
    let (archive, rig) = (CUPOLA.file("set.vwf"), CUPOLA.file("beside.toml"));
    let (map, other) = (CUPOLA.file("beside-back.pfm"), CUPOLA.file("beside-front.pfm"));
    let leftovers = ["pfm", "png"].map(|ending| ["front", "back"].map(|name| format!("beside-{name}.{ending}")));
    leftovers.iter().flatten().for_each(|name| drop(std::fs::remove_file(CUPOLA.file(name))));
    let _ = std::fs::remove_file(&rig);
    std::fs::write(&map, "mine").unwrap();
    CUPOLA.refused(&["setup", rig.to_str().unwrap(), "--from", archive.to_str().unwrap()], "beside-back.pfm exists");
    assert!(std::fs::read(&map).unwrap() == b"mine" && !rig.exists() && !other.exists());
}

/// A reader that wants no more is no error. A full disk is one, with a message.
#[test]
fn standard_output_that_cannot_be_written_ends_the_command() {
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").expect("a device");
    let output = Command::new(env!("CARGO_BIN_EXE_cupola")).args(["check", "--presets"]).stdout(full).output().unwrap();
    let words = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{words}");
    assert!(words.starts_with("cupola: standard output cannot be written: No space left"), "{words}");
    for command in [env!("CARGO_BIN_EXE_cupola"), env!("CARGO_BIN_EXE_cupola-lab")] {
        // The shell reports the exit code after the reader has ended.
        let script = "{ sleep 0.3; \"$0\" $1; echo $? >&2; } | true";
        let arguments = if command.ends_with("lab") { "structure" } else { "check --presets" };
        let output = Command::new("sh").args(["-c", script, command, arguments]).output().unwrap();
        assert_eq!(String::from_utf8_lossy(&output.stderr), "0\n", "{command}");
    }
}
