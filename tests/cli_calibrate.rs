//! `cupola calibrate`: marks, photographs, light, one known length.

mod tool;

use cupola::blend;
use cupola::calibrate::{Camera, CameraLens};
use cupola::geom::Pose;
use cupola::rig::{self, OutputKind, Rig};
use cupola::warp::WarpMap;
use glam::{DVec2, DVec3};
use std::fmt::Write;
use std::path::Path;
use tool::Tool;

const CUPOLA: Tool = Tool { path: env!("CARGO_BIN_EXE_cupola"), name: "cupola" };

const TWO_OUTPUTS: &str = "[dome]\ntilt = 15 # leans\n\n[[output]]\nname = \"left\"\nkind = \"projector\"\nsize = [1280, 800]\n\
    position = [0.5, -0.2, 1.0] # metres\nyaw = -40\npitch = 30\nfov = [70, 47.26]\n\n[[output]]\nkind = \"domemaster\"\n";

/// Marks of the output `left`. Each `wrong`th mark is moved by 33 pixels.
fn marks_of_left(rig: &Rig, wrong: usize) -> String {
    format!("output,x,y,azimuth,elevation\n{}", marks_of(rig, 0, wrong))
}

fn marks_of(rig: &Rig, output: usize, wrong: usize) -> String {
    let map = WarpMap::new(rig, output, (1280, 800), None).unwrap();
    let (name, mut text) = (&rig.outputs[output].name, String::new());
    for index in 0..30 {
        let pixel = DVec2::new(100.0 + 120.0 * f64::from(index % 10), 150.0 + 250.0 * f64::from(index / 10));
        let point = map.hit(pixel).unwrap();
        let moved = if index as usize % wrong == wrong - 1 { 33.0 } else { 0.0 };
        let (azimuth, elevation) = (point.x.atan2(-point.z), point.y.atan2(point.x.hypot(point.z)));
        writeln!(
            text,
            "{name},{},{},{:.12},{:.12}",
            pixel.x + moved,
            pixel.y,
            azimuth.to_degrees(),
            elevation.to_degrees()
        )
        .unwrap();
    }
    text
}

#[test]
fn marks_lead_back_to_the_rig_that_made_them() {
    let exact = TWO_OUTPUTS
        .replace("[0.5, -0.2, 1.0]", "[0.53, -0.17, 1.06]")
        .replace("yaw = -40", "yaw = -42.3\nroll = 1.5")
        .replace("[70, 47.26]", "[71.5, 48.1]\nshift = [0.01, -0.02]");
    let exact = rig::parse(&exact, "exact.toml", "".as_ref()).unwrap();
    let [rough, csv, out] = ["rough.toml", "marks.csv", "found.toml"].map(|name| CUPOLA.file(name));
    std::fs::write(&rough, TWO_OUTPUTS).unwrap();
    std::fs::write(&csv, marks_of_left(&exact, 10)).unwrap();
    // An earlier run of this test may have left the file.
    let _ = std::fs::remove_file(&out);
    let [rough, csv, out] = [&rough, &csv, &out].map(|path| path.to_str().unwrap());
    let arguments = ["calibrate", rough, "--marks", csv, "--out", out, "--solve", "fov,shift", "--json"];
    let answer = CUPOLA.json(&arguments);
    let output = &answer["outputs"][0];
    assert_eq!((output["name"].as_str(), output["marks"].as_u64()), (Some("left"), Some(30)));
    let left_out: Vec<u64> =
        output["left_out"].as_array().unwrap().iter().map(|mark| mark["line"].as_u64().unwrap()).collect();
    assert_eq!(left_out, [11, 21, 31], "lines of the wrong marks");
    let found = rig::load(out).unwrap();
    let [right, found] = [&exact, &found].map(|rig| match &rig.outputs[0].kind {
        OutputKind::Projector { position, angles, frustum } => (*position, *angles, *frustum),
        other => panic!("{other:?}"),
    });
    assert!(found.0.distance(right.0) < 1e-6, "{found:?}");
    assert!(found.1.iter().zip(right.1).all(|(found, right)| (found - right).abs() < 1e-6), "{found:?}");
    assert!((found.2.left - right.2.left).abs() < 1e-6 && (found.2.top - right.2.top).abs() < 1e-6, "{found:?}");
    let text = std::fs::read_to_string(out).unwrap();
    assert!(text.starts_with("[dome]\ntilt = 15 # leans\n") && text.contains("] # metres\n"), "{text}");
    assert!(text.contains("# calibrated: 27 of 30 marks, 0.000 px rms"), "{text}");
    CUPOLA.refused(&arguments, "exists");
    let picture = CUPOLA.file("before-after.png");
    let pictured = ["--force", "--picture", picture.to_str().unwrap()];
    CUPOLA.answer(&[&arguments[..8], &pictured].concat());
    check_picture(&picture);
    let wrong = ["--force", "--picture", "a.svg"];
    CUPOLA.refused(&[&arguments[..8], &wrong].concat(), "ends in .png");
}

/// In the left half the projector's grid lies beside that of the other output, in the right half on
/// it.
fn check_picture(file: &std::path::Path) {
    let picture = image::open(file).unwrap().into_rgb8();
    assert_eq!(picture.dimensions(), (2048, 1024));
    let lit = |left: u32| {
        let places = (0..1024).flat_map(|y| (left..left + 1024).map(move |x| (x, y)));
        places.filter(|(x, y)| picture.get_pixel(*x, *y).0.iter().any(|value| *value > 60)).count()
    };
    let (before, after) = (lit(0), lit(1024));
    println!("{before} and {after} pixels have lines");
    assert!(after > 10_000 && before > after + after / 20, "{before} {after}");
}

/// Angles do not determine the size of a dome. One known length does.
#[test]
fn one_length_leads_to_the_radius_of_the_dome() {
    let rig_of = |radius: f64, places: [&str; 2]| {
        let output = |name: &str, place: &str| {
            format!(
                "[[output]]\nname = \"{name}\"\nkind = \"projector\"\nsize = [1280, 800]\n{place}\nfov = [70, 47.26]\n"
            )
        };
        format!("[dome]\nradius = {radius}\n\n{}{}", output("left", places[0]), output("right", places[1]))
    };
    let (left, right) = ("yaw = -40\npitch = 30", "yaw = 40\npitch = 30");
    let place = |x: f64, z: f64, aim: &str| format!("position = [{x}, -0.2, {z}]\n{aim}");
    let exact = rig_of(4.0, [&place(0.53, 1.06, left), &place(-0.47, 0.9, right)]);
    let exact = rig::parse(&exact, "exact.toml", "".as_ref()).unwrap();
    let [rough, csv, out] = ["large.toml", "both.csv", "small.toml"].map(|name| CUPOLA.file(name));
    std::fs::write(&rough, rig_of(5.0, [&place(0.5, 1.0, left), &place(-0.5, 1.0, right)])).unwrap();
    std::fs::write(&csv, marks_of(&exact, 0, 10) + &marks_of(&exact, 1, 10)).unwrap();
    let [rough, csv, out] = [&rough, &csv, &out].map(|path| path.to_str().unwrap());
    let positions = |rig: &Rig| {
        [0, 1].map(|output| match &rig.outputs[output].kind {
            OutputKind::Projector { position, .. } => *position,
            other => panic!("{other:?}"),
        })
    };
    let right = positions(&exact);
    let length = format!("left,right,{}", right[0].distance(right[1]));
    let arguments = ["calibrate", rough, "--marks", csv, "-o", out, "--force"];
    let words = CUPOLA.answer(&[&arguments[..], &["--length", &length]].concat());
    assert!(words.contains("dome: radius 4.0000 m"), "{words}");
    let found = rig::load(out).unwrap();
    assert!((found.dome.radius - 4.0).abs() < 1e-6, "{}", found.dome.radius);
    assert!(positions(&found).iter().zip(right).all(|(found, right)| found.distance(right) < 1e-6));
    // Standard errors are the roots of the covariance, whose lengths are also those of this radius.
    let report = CUPOLA.json(&[&arguments[..], &["--length", &length, "--json"]].concat());
    assert!((report["radius"].as_f64().unwrap() - 4.0).abs() < 1e-6, "{report:#}");
    let output = &report["outputs"][0];
    let error = |at: usize| output["standard_errors"]["position"][at].as_f64().unwrap();
    let variance = |at: usize| output["covariance"][at][at].as_f64().unwrap();
    assert!((0..3).all(|at| error(at) > 0.0 && (variance(at).sqrt() / error(at) - 1.0).abs() < 1e-6), "{report:#}");
    // Without the length the radius stays, and all lengths are too large by a quarter.
    CUPOLA.answer(&arguments);
    let found = rig::load(out).unwrap();
    assert!((positions(&found)[0] / right[0] - 1.25).abs().max_element() < 1e-6 && found.dome.radius == 5.0);
    CUPOLA
        .refused(&[&arguments[..], &["--length", "left,camera,2"]].concat(), "\"camera\" is no output that was found");
}

#[test]
fn mistakes_in_marks_are_named_and_nothing_is_written() {
    let [rough, csv, out] = ["wrong.toml", "wrong.csv", "nothing.toml"].map(|name| CUPOLA.file(name));
    std::fs::write(&rough, TWO_OUTPUTS).unwrap();
    let refused = |text: &str, expected: &str| {
        std::fs::write(&csv, text).unwrap();
        let [rough, csv, out] = [&rough, &csv, &out].map(|path| path.to_str().unwrap());
        CUPOLA.refused(&["calibrate", rough, "--marks", csv, "-o", out], expected);
    };
    refused("left,1,2,x,4\n", "wrong.csv:1:10: \"x\" is no number; expected azimuth");
    refused("left,1,2,3,4\n", "output \"left\" has 1 marks");
    refused("output-2,1,2,3,4\n", "is no projector");
    refused("", "has no marks");
    refused("photo,1,2,3,4\n", "there are no photographs");
    assert!(!out.exists());
}

const PHOTOGRAPH: u32 = 400;

/// For each pixel of a photograph of the dome by `camera`: the places of the output's picture that
/// are visible at four points of the pixel.
fn shown(rig: &Rig, output: usize, size: (u32, u32), camera: &Camera) -> Vec<[Option<DVec2>; 4]> {
    let map = WarpMap::new(rig, output, size, None).unwrap();
    let pixel = |place: DVec2| {
        let ray = camera.pose.direction_to_parent(camera.ideal_ray(place)?);
        map.pixel(map.screen().hit(camera.pose.position, ray)?.point)
    };
    let places = (0..PHOTOGRAPH).flat_map(|y| (0..PHOTOGRAPH).map(move |x| DVec2::new(f64::from(x), f64::from(y))));
    places
        .map(|place| [0.25, 0.75].map(|x| [0.25, 0.75].map(|y| pixel(place + DVec2::new(x, y)))))
        .map(|[a, b]| [a[0], a[1], b[0], b[1]])
        .collect()
}

/// Brightness of the two projectors that are photographed, and their responses.
const BRIGHTNESS: [f64; 2] = [1.0, 0.7];
const GAMMA: [f64; 2] = [2.2, 1.8];

/// Takes a photograph of each pattern in a folder as the outputs of a rig show it. The values are
/// proportional to light. As with a real projector, the light is less where a pixel covers a larger
/// area of the screen.
fn photograph(rig: &Rig, patterns: &Path, photos: &Path, camera: &Camera) {
    let mut files: Vec<_> = std::fs::read_dir(patterns).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    let places = rig.layout(rig.extent().unwrap());
    let shown: Vec<_> = (0..2).map(|output| shown(rig, output, (480, 300), camera)).collect();
    let maps = [0, 1].map(|output| WarpMap::new(rig, output, (480, 300), None).unwrap());
    let middle = maps[0].area(DVec2::new(240.0, 150.0)).unwrap();
    for (number, file) in files.iter().enumerate() {
        let pattern = image::open(file).unwrap().into_luma8();
        // The first half of the patterns is for the first output, the other half for the second.
        let output = number / (files.len() / 2);
        let place = places[output];
        let light = |pixel: &Option<DVec2>| {
            let pixel = pixel.unwrap_or(DVec2::splat(f64::INFINITY)).min(DVec2::splat(1e4));
            let (x, y) = (pixel.x as u32, pixel.y as u32);
            if x >= place.width || y >= place.height {
                return 0.0;
            }
            let value = f64::from(pattern.get_pixel(place.x + x, place.y + y).0[0]) / 255.0;
            BRIGHTNESS[output] * value.powf(GAMMA[output]) / 4.0
        };
        let value = |(index, pixels): (usize, &[Option<DVec2>; 4])| {
            // Light of the room and noise.
            let noise = (index * 7919 + number * 104_729) % 11;
            let area = pixels[0].and_then(|pixel| maps[output].area(pixel)).unwrap_or(middle);
            (12.0 + 120.0 * middle / area * pixels.iter().map(light).sum::<f64>() + noise as f64) as u8
        };
        let values: Vec<u8> = shown[output].iter().enumerate().map(value).collect();
        let jpeg = std::fs::File::create(photos.join(file.with_extension("jpg").file_name().unwrap())).unwrap();
        image::codecs::jpeg::JpegEncoder::new_with_quality(jpeg, 97)
            .encode(&values, PHOTOGRAPH, PHOTOGRAPH, image::ExtendedColorType::L8)
            .unwrap();
    }
}

/// Checks that the responses are those that were photographed, and that the masks make the light of
/// both projectors even.
fn check_light(exact: &Rig, found: &Rig) {
    let weights = blend::Weights::new(exact, &[(480, 300); 2]).unwrap();
    let maps = [0, 1].map(|output| WarpMap::new(exact, output, (480, 300), None).unwrap());
    let masks = [0, 1].map(|output: usize| rig::read_mask(found.outputs[output].mask.as_deref().unwrap()).unwrap());
    let shown = |output: usize, point: DVec3| {
        let pixel = maps[output].pixel(point).unwrap_or(DVec2::splat(-1.0));
        let Some(area) = maps[output].area(pixel) else { return 0.0 };
        let ((width, height), mask) = &masks[output];
        let (x, y) = ((pixel.x / 480.0 * f64::from(*width)) as u32, (pixel.y / 300.0 * f64::from(*height)) as u32);
        let dimmed = f64::from(mask[(y * width + x) as usize]) / 65535.0;
        weights.weight_at(output, point) * dimmed * BRIGHTNESS[output] / area
    };
    let mut light = Vec::new();
    for (output, described) in found.outputs.iter().enumerate() {
        for value in [0.3f64, 0.5, 0.8] {
            let error = blend::light_of(value, &described.blend, 1) - value.powf(GAMMA[output]);
            assert!(error.abs() < 0.01, "{output}: {value}: {error}");
        }
        for place in 0..80 {
            let part = DVec2::new(f64::from(place % 10) + 0.5, f64::from(place / 10) + 0.5) / DVec2::new(10.0, 8.0);
            let point = maps[output].hit(part * DVec2::new(480.0, 300.0));
            light.extend(point.map(|point| shown(0, point) + shown(1, point)));
        }
    }
    let mean = light.iter().sum::<f64>() / light.len() as f64;
    let off = light.iter().map(|light| (light / mean - 1.0).powi(2)).sum::<f64>() / light.len() as f64;
    assert!(light.len() > 100 && off.sqrt() < 0.03, "{} places, {}", light.len(), off.sqrt());
}

#[test]
fn photographs_lead_back_to_the_rig_that_they_show() {
    let rig_of = |left: &str, right: &str| {
        let output = |name: &str, pose: &str| {
            format!(
                "[[output]]\nname = \"{name}\"\nkind = \"projector\"\nsize = [480, 300]\n{pose}\nfov = [70, 47.26]\n"
            )
        };
        output("left", left) + &output("right", right)
    };
    let rough =
        rig_of("position = [0.5, 0, 1]\nyaw = -40\npitch = 40", "position = [-0.5, 0, 1]\nyaw = 40\npitch = 40");
    let exact = rig_of(
        "position = [0.57, -0.08, 1.1]\nyaw = -41.5\npitch = 38\nroll = 1",
        "position = [-0.44, 0.05, 0.9]\nyaw = 42\npitch = 41.5",
    );
    let exact = rig::parse(&exact, "exact.toml", "".as_ref()).unwrap();
    let [file, patterns, photos, marks, out] =
        ["seen.toml", "patterns", "photos", "photo.csv", "from-photos.toml"].map(|name| CUPOLA.file(name));
    for folder in [&patterns, &photos] {
        // An earlier run of this test may have left the folder.
        let _ = std::fs::remove_dir_all(folder);
        std::fs::create_dir_all(folder).unwrap();
    }
    std::fs::write(&file, rough).unwrap();
    let text = |path: &Path| path.to_str().unwrap().to_owned();
    let patterned = ["calibrate", &text(&file), "--patterns", &text(&patterns), "--cell", "8", "--light", "--json"];
    let answer = CUPOLA.json(&patterned);
    let count = 2 * (2 + 2 * (6 + 6) + 14);
    assert_eq!((answer["patterns"].as_u64(), answer["window"][0].as_u64()), (Some(count), Some(960)));
    let camera = Camera::new(
        Pose::new(DVec3::new(0.3, -0.5, 0.2), 0.2, 1.1, 0.1),
        CameraLens::Fisheye,
        0.33 * f64::from(PHOTOGRAPH),
        (PHOTOGRAPH, PHOTOGRAPH),
    );
    photograph(&exact, &patterns, &photos, &camera);
    // Points of the dome whose directions are known, at their places in the photograph.
    let mut lines = String::new();
    for (azimuth, elevation) in
        [(-60.0f64, 30.0f64), (60.0, 30.0), (0.0, 60.0), (30.0, 45.0), (-30.0, 45.0), (0.0, 20.0)]
    {
        let ((sine, cosine), (up, level)) = (azimuth.to_radians().sin_cos(), elevation.to_radians().sin_cos());
        let seen = camera.place(5.0 * DVec3::new(level * sine, up, -level * cosine)).unwrap();
        writeln!(lines, "photo,{},{},{azimuth},{elevation}", seen.x, seen.y).unwrap();
    }
    // A wrong one.
    lines += "photo,100,120,30,45\n";
    std::fs::write(&marks, lines).unwrap();
    let [file, photos, marks, out] = [file, photos, marks, out].map(|path| text(&path));
    let found = ["calibrate", &file, "--photos", &photos, "--cell", "8", "--marks", &marks, "-o", &out, "--force"];
    let words = CUPOLA.answer(&[&found[..], &["--light", "--linear"]].concat());
    assert!(words.contains("camera: fisheye of") && words.contains("light: brightest to darkest"), "{words}");
    assert!(words.contains("photographs: 6 of 7 marks, ") && words.contains("photo.csv:7: left out, "), "{words}");
    let [found, rough] = [rig::load(&out).unwrap(), rig::load(&file).unwrap()];
    check_light(&exact, &found);
    for output in 0..2 {
        let map = |rig: &Rig| WarpMap::new(rig, output, (480, 300), None).unwrap();
        let distance = |rig: &Rig| {
            let places =
                (0..48).map(|index| DVec2::new(30.0 + f64::from(index % 8) * 60.0, 25.0 + f64::from(index / 8) * 50.0));
            let squares = places
                .filter_map(|place| map(rig).pixel(map(&exact).hit(place)?).map(|found| found.distance_squared(place)));
            let squares: Vec<f64> = squares.collect();
            (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
        };
        // A pixel of this small photograph is as wide as three pixels of an output.
        assert!(distance(&found) < 0.5 && distance(&rough) > 10.0, "{} {}", distance(&found), distance(&rough));
    }
    CUPOLA.refused(&["calibrate", &file, "--photos", &photos, "-o", &out, "--force"], "with --cell 4 are");
}

#[test]
fn patterns_fill_their_place_in_a_window_of_any_size() {
    let [file, folder] = ["resized.toml", "resized"].map(|name| CUPOLA.file(name).to_str().unwrap().to_owned());
    std::fs::write(&file, TWO_OUTPUTS).unwrap();
    CUPOLA.answer(&["calibrate", &file, "--patterns", &folder, "--cell", "64", "--size", "640x400"]);
    // The output has 1280 × 800 pixels and gets half of the window. It is 20 cells wide, and the
    // last four have the highest bit. It is 13 cells high, and the last five have the highest bit.
    for (name, is_white) in [
        ("0003-left-x4.png", (|x, _| (256..320).contains(&x)) as fn(u32, u32) -> bool),
        ("0013-left-y3.png", |x, y| x < 320 && y >= 256),
    ] {
        let picture = image::open(Path::new(&folder).join(name)).unwrap().into_luma8();
        assert_eq!(picture.dimensions(), (640, 400));
        let wrong = picture.enumerate_pixels().filter(|(x, y, value)| (value.0 == [255]) != is_white(*x, *y));
        assert_eq!(wrong.count(), 0, "{name}");
    }
}
