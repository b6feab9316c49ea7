//! `cupola check`, `map`, `simulate`, `plan` and `doctor`.

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
    // What is printed is a rig file.
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
        // The equidistant fisheye by hand: the angle from straight ahead grows with the distance
        // from the middle.
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
    // The camera looks to the right, so what is ahead of the viewer is to its left.
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

/// A calibration's blending is often a mask: here half of the light everywhere.
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
    // Without blending the overlap is twice as bright, which has to be noticed.
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
    // Its exit code depends on the machine; that it answers, and in both forms, does not.
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
    // The dome fills the front half (a column beside the border of views); nothing of the back half
    // is sampled.
    assert!(sphere(330) > 600 && sphere(1260) < 100, "{} and {}", sphere(330), sphere(1260));

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
    // One alone meets nobody.
    let single = CUPOLA.file("single.toml");
    std::fs::write(&single, format!("[dome]\ntilt = 90.0\n{}", output(0, 0))).unwrap();
    let text = CUPOLA.answer(&["plan", single.to_str().unwrap(), "--picture", drawn]);
    assert!(!text.contains("jump") && red(&picture) < 10, "{}", red(&picture));
}
