//! Complete rigs that `cupola convert` makes of other programs' calibrations: configurations of
//! SGCT.

mod convert;

use convert::{convert, file};
use cupola::geom::PixelRect;
use std::path::PathBuf;

#[test]
fn a_configuration_of_sgct_becomes_a_rig() {
    let text = r#"{ "nodes": [{ "address": "a", "windows": [{ "pos": { "x": 5, "y": 7 }, "size": { "x": 200, "y": 100 }, "viewports": [
        { "size": { "x": 0.5, "y": 1 }, "projection": { "type": "FisheyeProjection", "fov": 170, "tilt": 30 } },
        { "pos": { "x": 0.5, "y": 0 }, "size": { "x": 0.5, "y": 1 }, "eye": "right", "mesh": "some.sgc", "projection": {
            "type": "PlanarProjection", "fov": { "hfov": 90, "vfov": 60 }, "orientation": { "yaw": 20, "pitch": 5, "roll": -3 } } }
        ] }] }], "users": [{ "pos": { "x": 0, "y": 0, "z": 4 } }] }"#;
    let (config, rig) = (file("config.json"), file("config.toml"));
    std::fs::write(&config, text).unwrap();
    let answer = convert(config.to_str().unwrap(), &rig, &[]);
    assert!(answer["notes"][0].as_str().unwrap().contains("some.sgc"), "{answer}");
    let rig = cupola::rig::load(rig.to_str().unwrap()).unwrap();
    let windows = [0, 1].map(|index| rig.outputs[index].window);
    assert_eq!(windows, [0, 100].map(|x| Some(PixelRect::new(x, 0, 100, 100))));
    let cupola::rig::OutputKind::Perspective { angles: [yaw, pitch, roll], frustum: Some(frustum) } =
        rig.outputs[1].kind
    else {
        panic!("{:?}", rig.outputs[1].kind)
    };
    assert!((yaw.to_degrees() - 20.0).abs() < 1e-6 && (pitch.to_degrees() - 5.0).abs() < 1e-6);
    assert!((roll.to_degrees() + 3.0).abs() < 1e-6 && (frustum.right - 1.0).abs() < 1e-6 && rig.outputs[1].eye > 0.0);
}

/// Direction in which SGCT looks up a cube's direction. Its cube's +Z face looks down to −Z of the
/// world, turned by 90° around x and before that by 45° around z.
fn of_cube(cube: glam::DVec3) -> glam::DVec3 {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};
    let turned = glam::DMat3::from_rotation_x(FRAC_PI_2) * glam::DMat3::from_rotation_z(FRAC_PI_4);
    turned * glam::DVec3::new(cube.x, -cube.y, -cube.z)
}

#[test]
fn pictures_of_all_directions_of_sgct_look_where_its_cube_does() {
    use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};
    let viewport = |place: u32, projection: &str| {
        let (x, size) = (f64::from(place) / 4.0, 0.25);
        format!(
            r#"{{ "pos": {{ "x": {x}, "y": 0 }}, "size": {{ "x": {size}, "y": 1 }}, "projection": {{ {projection} }} }}"#
        )
    };
    let viewports = [
        viewport(0, r#""type": "FisheyeProjection", "fov": 200"#),
        viewport(1, r#""type": "EquirectangularProjection""#),
        viewport(2, r#""type": "CylindricalProjection", "rotation": 30, "heightoffset": -0.25"#),
        viewport(3, r#""type": "CylindricalProjection""#),
    ];
    let text = |viewports: &str| {
        format!(
            r#"{{ "nodes": [{{ "address": "a", "windows": [{{ "size": {{ "x": 400, "y": 100 }}, "viewports": [{viewports}] }}] }}] }}"#
        )
    };
    let (config, rig) = (file("around.json"), file("around.toml"));
    std::fs::write(&config, text(&viewports.join(", "))).unwrap();
    let answer = convert(config.to_str().unwrap(), &rig, &[]);
    assert_eq!(answer["notes"].to_string(), "[]");
    let rig = cupola::rig::load(rig.to_str().unwrap()).unwrap();
    let maps = [0, 1, 2, 3].map(|index| cupola::warp::WarpMap::new(&rig, index, (100, 100), None).unwrap());
    // s and t count from the bottom left of each viewport.
    let cylinder = |s: f64, t: f64, rotation: f64, offset: f64| {
        let angle = rotation - TAU * s;
        glam::DVec3::new(angle.cos(), angle.sin(), t + offset)
    };
    for (s, t) in [(0.105, 0.305), (0.5, 0.505), (0.605, 0.205), (0.885, 0.695), (0.255, 0.755)] {
        // The fisheye, whose formula turns the cube back, shows that the cube is the right one.
        let (x, y) = (2.0 * s - 1.0, 2.0 * t - 1.0);
        let (angle, around) = (f64::hypot(x, y) * 100f64.to_radians(), f64::atan2(x, y));
        let (x, y) = (angle.sin() * around.sin(), -angle.sin() * around.cos());
        let fisheye = glam::DVec3::new(FRAC_1_SQRT_2 * (x - y), FRAC_1_SQRT_2 * (x + y), angle.cos());
        let (down, right) = (PI * (1.0 - t), TAU * (s - 0.5));
        let even = glam::DVec3::new(down.sin() * right.sin(), down.sin() * right.cos(), down.cos());
        let cubes = [fisheye, even, cylinder(s, t, 30f64.to_radians(), -0.25), cylinder(s, t, 0.0, 0.0)];
        for (map, cube) in maps.iter().zip(cubes) {
            let found = map.direction(glam::DVec2::new(100.0 * s, 100.0 * (1.0 - t))).expect("shown");
            let expected = of_cube(cube).normalize();
            assert!(found.distance(expected) < 1e-6, "{s} {t}: {found} for {expected}");
        }
    }
    // What is not imported is told.
    let refused = |projection: &str, why: &str| {
        std::fs::write(&config, text(&projection.replace("PLACE", &viewport(0, r#""type": "FisheyeProjection""#))))
            .unwrap();
        let answer = convert(config.to_str().unwrap(), &file("around-less.toml"), &[]);
        assert!(answer["notes"].to_string().contains(why), "{answer}");
    };
    refused(r#"PLACE, { "projection": { "type": "CubemapProjection" } }"#, "viewport-2: CubemapProjection is left out");
    let low = r#"PLACE, { "projection": { "type": "CylindricalProjection", "heightoffset": -0.8 } }"#;
    refused(low, "viewport-2: CylindricalProjection with heightoffset -0.8");
    let mesh = r#"PLACE, { "mesh": "a.data", "projection": { "type": "EquirectangularProjection" } }"#;
    refused(mesh, "viewport-2 is left out: no rig has the mesh a.data");
}

#[test]
fn a_mesh_in_a_configuration_of_sgct_is_run_by_the_rig() {
    std::fs::write(file("warp.data"), "2\n2 2\n-1 -1 0.1 0.2 1\n1 -1 0.9 0.2 1\n-1 1 0.1 0.8 1\n1 1 0.9 0.8 1\n")
        .unwrap();
    let text = r#"{ "nodes": [{ "address": "a", "windows": [{ "pos": { "x": 0, "y": 0 }, "size": { "x": 200, "y": 100 }, "viewports": [
        { "size": { "x": 0.5, "y": 1 }, "mesh": "warp.data", "projection": { "type": "FisheyeProjection", "fov": 170, "tilt": 30 } },
        { "pos": { "x": 0.5, "y": 0 }, "size": { "x": 0.5, "y": 1 }, "mesh": "warp.data", "projection": {
            "type": "PlanarProjection", "fov": { "hfov": 90, "vfov": 60 }, "orientation": { "yaw": 20, "pitch": 5, "roll": -3 } } }
        ] }] }] }"#;
    let (config, rig) = (file("meshes.json"), file("meshes.toml"));
    std::fs::write(&config, text).unwrap();
    let answer = convert(config.to_str().unwrap(), &rig, &[]);
    assert!(!answer["notes"].to_string().contains("warp.data"), "{answer}");
    let rig = cupola::rig::load(rig.to_str().unwrap()).unwrap();
    let map = cupola::warp::WarpMap::new(&rig, 1, (100, 100), None).unwrap();
    // The mesh's middle is the middle of the picture, where the viewport looks. The mesh's corners
    // are within the picture.
    let middle = map.direction(glam::DVec2::new(50.0, 50.0)).expect("shown");
    let (yaw, pitch) = (20f64.to_radians(), 5f64.to_radians());
    let towards = glam::DVec3::new(yaw.sin() * pitch.cos(), pitch.sin(), -yaw.cos() * pitch.cos());
    assert!(middle.distance(towards) < 1e-6, "{middle} {towards}");
    assert!(matches!(rig.outputs[0].kind, cupola::rig::OutputKind::Mesh(_)));
}

#[test]
fn mirrored_windows_of_sgct_are_mirrored_by_the_rig() {
    // A mesh that is not symmetric, over the middle of the viewport only.
    let node = |x: f64, y: f64| format!("{x} {y} {} {} 1\n", 0.3 + 0.2 * x, 0.4 + 0.3 * y);
    let nodes: String = [(-0.9, -0.8), (0.5, -0.8), (-0.9, 0.6), (0.5, 0.6)].map(|(x, y)| node(x, y)).concat();
    std::fs::write(file("lopsided.data"), format!("2\n2 2\n{nodes}")).unwrap();
    let mask = image::GrayImage::from_fn(10, 10, |x, y| image::Luma([(20 * x + y) as u8]));
    mask.save(file("lopsided.png")).unwrap();
    let planar = r#"{ "type": "PlanarProjection", "fov": { "hfov": 90, "vfov": 60 }, "orientation": { "yaw": 20, "pitch": 5, "roll": -3 } }"#;
    let viewport = |more: &str| format!(r#"{{ "size": {{ "x": 1, "y": 1 }}, {more} "projection": {planar} }}"#);
    let rig = |name: &str, flags: &str, viewport: &str| {
        let text = format!(
            r#"{{ "nodes": [{{ "address": "a", "windows": [{{ {flags} "size": {{ "x": 100, "y": 100 }}, "viewports": [{viewport}] }}] }}] }}"#
        );
        let (config, rig) = (file(&format!("{name}.json")), file(&format!("{name}.toml")));
        std::fs::write(&config, text).unwrap();
        let answer = convert(config.to_str().unwrap(), &rig, &[]);
        assert_eq!(answer["notes"].to_string(), "[]");
        cupola::rig::load(rig.to_str().unwrap()).unwrap()
    };
    let map = |rig: &cupola::rig::Rig| cupola::warp::WarpMap::new(rig, 0, (100, 100), None).unwrap();
    let with_mesh = viewport(r#""mesh": "lopsided.data", "blendmask": "lopsided.png","#);
    let plain = rig("sgct-plain", "", &viewport(""));
    let picture = map(&plain);
    let flags = [
        ("\"mirrorx\": true,", true, false),
        ("\"mirrory\": true,", false, true),
        ("\"mirrorx\": true, \"mirrory\": true,", true, true),
    ];
    for (number, (flags, across, up)) in flags.into_iter().enumerate() {
        // Without a mesh the output is mirrored together with its mask, so the mask's file is not
        // mirrored. Its values are the factors on displayed values, converted to light.
        let turned = rig(&format!("sgct-flat-{number}"), flags, &viewport(r#""blendmask": "lopsided.png","#));
        assert_eq!(turned.outputs[0].flip, cupola::rig::Flip { horizontal: across, vertical: up });
        expect_light(&turned, &mask, [false; 2]);
        let turned = map(&turned);
        let at = |along: bool, place: f64| if along { 100.0 - place } else { place };
        for pixel in [(3.5, 80.5), (50.5, 50.5), (99.5, 0.5), (20.0, 30.0)].map(glam::DVec2::from) {
            let there = glam::DVec2::new(at(across, pixel.x), at(up, pixel.y));
            assert!(turned.direction(pixel).unwrap().distance(picture.direction(there).unwrap()) < 1e-12);
        }
        // With a mesh the mesh stays in place, and its nodes look at mirrored places.
        let warped = rig(&format!("sgct-warped-{number}"), flags, &with_mesh);
        assert!(warped.outputs[0].flip.is_none());
        let found = map(&warped);
        let (mut shown, mut worst) = (0, 0.0f64);
        for (x, y) in (0..100).flat_map(|y| (0..100).map(move |x| (f64::from(x) + 0.5, f64::from(y) + 0.5))) {
            let (across_half, up_half) = (x / 50.0 - 1.0, 1.0 - y / 50.0);
            let inside = (-0.9..0.5).contains(&across_half) && (-0.8..0.6).contains(&up_half);
            let direction = found.direction(glam::DVec2::new(x, y));
            assert_eq!(direction.is_some(), inside, "{x} {y}");
            let Some(direction) = direction else { continue };
            let (u, v) = (0.3 + 0.2 * across_half, 0.4 + 0.3 * up_half);
            let (u, v) = (if across { 1.0 - u } else { u }, if up { 1.0 - v } else { v });
            let expected = picture.direction(glam::DVec2::new(100.0 * u, 100.0 - 100.0 * v)).unwrap();
            worst = worst.max(direction.distance(expected));
            shown += 1;
        }
        assert!(shown > 4000 && worst < 1e-6, "{shown} {worst}");
        expect_light(&warped, &mask, [across, up]);
        // Negative control: a mirrored output would show the mesh at another place.
        let mut wrong = rig(&format!("sgct-wrong-{number}"), "", &with_mesh);
        wrong.outputs[0].flip = cupola::rig::Flip { horizontal: across, vertical: up };
        let corner = glam::DVec2::new(at(false, 10.0), at(false, 85.0));
        assert!(map(&wrong).direction(corner) != map(&warped).direction(corner));
    }
}

/// Panics unless a rig's mask, mirrored as given, has the values of `factors`, converted from
/// displayed values to light with the rig's gamma.
fn expect_light(rig: &cupola::rig::Rig, factors: &image::GrayImage, [across, up]: [bool; 2]) {
    let output = &rig.outputs[0];
    let found = image::open(output.mask.as_ref().unwrap()).unwrap().into_luma16();
    assert_eq!(found.dimensions(), factors.dimensions());
    for (x, y, value) in found.enumerate_pixels() {
        let (x, y) = (if across { 9 - x } else { x }, if up { 9 - y } else { y });
        let expected = (f64::from(factors.get_pixel(x, y).0[0]) / 255.0).powf(output.blend.gamma);
        assert!((f64::from(value.0[0]) / 65535.0 - expected).abs() < 1e-5, "{x} {y}: {value:?} for {expected}");
    }
}

#[test]
fn a_mirror_in_a_configuration_of_sgct_becomes_a_map_of_directions() {
    // The view straight ahead is in the left half. The face above is in the right half and covers a
    // part of the first.
    let mesh = |left: f64, right: f64, light: f64| {
        format!("2\n2 2\n{left} -1 0 0 {light}\n{right} -1 1 0 {light}\n{left} 1 0 1 {light}\n{right} 1 1 1 {light}\n")
    };
    std::fs::write(file("ahead.data"), mesh(-1.0, 0.5, 1.0)).unwrap();
    std::fs::write(file("above.data"), mesh(0.0, 1.0, 0.5)).unwrap();
    std::fs::write(file("nowhere.data"), mesh(3.0, 4.0, 1.0)).unwrap();
    image::GrayImage::from_fn(80, 80, |x, _| image::Luma([2 * x as u8 + 50])).save(file("fading.png")).unwrap();
    let text = r#"{ "nodes": [{ "address": "a", "windows": [{ "size": { "x": 80, "y": 80 }, "viewports": [
        { "blendmask": "fading.png", "projection": { "type": "SphericalMirrorProjection", "tilt": 45, "mesh": { "bottom": "ahead.data",
          "left": "nowhere.data", "right": "nowhere.data", "top": "above.data" } } } ] }] }] }"#;
    let (config, rig) = (file("mirror.json"), file("mirror.toml"));
    std::fs::write(&config, text).unwrap();
    convert(config.to_str().unwrap(), &rig, &[]);
    let rig = cupola::rig::load(rig.to_str().unwrap()).unwrap();
    let map = cupola::warp::WarpMap::new(&rig, 0, (80, 80), None).unwrap();
    let towards = |x: f64, y: f64| map.direction(glam::DVec2::new(x, y)).expect("shown");
    // A third of the way to the side of a face of 90°, at pixel centres.
    let ahead = glam::DVec3::new(2.0 * 19.5 / 60.0 - 1.0, 0.0125, -1.0).normalize();
    assert!(towards(19.5, 39.5).distance(ahead) < 1e-6, "{}", towards(19.5, 39.5));
    let above = glam::DVec3::new(2.0 * 19.5 / 40.0 - 1.0, 1.0, 0.0125).normalize();
    assert!(towards(59.5, 39.5).distance(above) < 1e-6, "{}", towards(59.5, 39.5));
    // The face above has half the value. The mask multiplies its own factor.
    let mask = image::open(rig.outputs[0].mask.as_ref().unwrap()).unwrap().into_luma16();
    for (x, factor) in [(19, 1.0), (59, 0.5)] {
        let expected = (factor * (2.0 * f64::from(x) + 50.0) / 255.0).powf(rig.outputs[0].blend.gamma);
        let found = f64::from(mask.get_pixel(x, 39).0[0]) / 65535.0;
        assert!((found - expected).abs() < 1e-5, "{x}: {found} for {expected}");
    }
}

/// A rig of two outputs. The black of the first differs between pixels and between channels.
fn uneven(name: &str, more: &str) -> (PathBuf, cupola::rig::Rig) {
    let levels = |x: u32, y: u32| [0.004 * x as f32, 0.002 * y as f32, 0.2 - 0.001 * (x + y) as f32];
    let values = (0..54).flat_map(|y| (0..96).map(move |x| levels(x, y))).collect();
    let black = cupola::formats::Levels { size: (96, 54), values };
    std::fs::write(file(&format!("{name}.png")), black.png("black").unwrap()).unwrap();
    let text = format!(
        "[[output]]\nname = \"one\"\nkind = \"projector\"\nsize = [96, 54]\nyaw = -10.0\npitch = 40.0\nfov = [60.0, 36.0]\n\
         black = {{ image = \"{name}.png\" {more} }}\n[[output]]\nname = \"two\"\nkind = \"projector\"\nsize = [96, 54]\n\
         yaw = 30.0\npitch = 40.0\nfov = [60.0, 36.0]\nblend = {{ black_level = 0.01 }}\n"
    );
    let from = file(&format!("{name}.toml"));
    std::fs::write(&from, text).unwrap();
    let rig = cupola::rig::load(from.to_str().unwrap()).unwrap();
    (from, rig)
}

#[test]
fn uneven_blacks_go_through_archives_and_vioso_files() {
    let (from, rig) = uneven("uneven", "");
    let expected = &rig.outputs[0].black.as_ref().unwrap().levels;
    // An archive has 16 bits, VIOSO's file has 8.
    for (set, more, bound) in [
        ("uneven.mpcdi", &[][..], 0.6 / 65535.0),
        ("uneven-2.mpcdi", &["--archive-version", "2"], 0.6 / 65535.0),
        ("uneven.vwf", &[], 0.51 / 255.0),
    ] {
        let (set, back) = (file(set), file(&format!("{}-back.toml", set.replace('.', "-"))));
        convert(from.to_str().unwrap(), &set, more);
        let answer = convert(set.to_str().unwrap(), &back, &[]);
        assert!(!answer["notes"].to_string().contains("black level"), "{answer}");
        let rig = cupola::rig::load(back.to_str().unwrap()).unwrap();
        let found = rig.outputs[0].black.as_ref().expect("a picture");
        assert_eq!((found.levels.size, found.values), ((96, 54), cupola::rig::BlackValues::Displayed));
        let difference = |other: &[[f32; 3]]| {
            let pairs = found.levels.values.as_flattened().iter().zip(other.as_flattened());
            pairs.fold(0.0f32, |worst, (a, b)| worst.max((a - b).abs()))
        };
        assert!(difference(&expected.values) <= bound, "{set:?}: {}", difference(&expected.values));
        // Negative control: the picture in reverse order differs.
        let mut turned = expected.values.clone();
        turned.reverse();
        assert!(difference(&turned) > 0.1);
        // A black that is the same everywhere remains a number.
        assert!(rig.outputs[1].black.is_none() && (rig.outputs[1].blend.black_level - 0.01).abs() < 5e-4);
    }
}

#[test]
fn light_of_black_and_mirrored_blacks_are_written_as_they_are_shown() {
    let (from, rig) = uneven("uneven-light", ", values = \"light\" }\nflip = \"horizontal\"\n# {");
    let (set, back) = (file("uneven-light.mpcdi"), file("uneven-light-back.toml"));
    convert(from.to_str().unwrap(), &set, &[]);
    convert(set.to_str().unwrap(), &back, &[]);
    let again = cupola::rig::load(back.to_str().unwrap()).unwrap();
    let light = &rig.outputs[0].black.as_ref().unwrap().levels;
    let shown = &again.outputs[0].black.as_ref().expect("a picture").levels;
    let (mut worst, mut upright) = (0.0f64, 0.0f64);
    for (x, y) in (0..54).flat_map(|y| (0..96).map(move |x| (x, y))) {
        let displayed = |x: usize| f64::from(light.values[y * 96 + x][0]).powf(1.0 / 2.2);
        let found = f64::from(shown.values[y * 96 + x][0]);
        worst = worst.max((found - displayed(95 - x)).abs());
        upright = upright.max((found - displayed(x)).abs());
    }
    assert!(worst < 2e-5 && upright > 0.1, "{worst} {upright}");
    // The mirrored map and its black are those of the rig for each kind of values.
    for profile in ["2d", "a3", "3d"] {
        let (set, back) = (file(&format!("mirrored-{profile}.mpcdi")), file(&format!("mirrored-{profile}-back.toml")));
        convert(from.to_str().unwrap(), &set, &["--profile", profile]);
        convert(set.to_str().unwrap(), &back, &[]);
        let again = cupola::rig::load(back.to_str().unwrap()).unwrap();
        let map = |rig| cupola::warp::WarpMap::new(rig, 0, (96, 54), None).unwrap();
        let (before, after) = (map(&rig), map(&again));
        for at in [(20.5, 30.5), (0.5, 53.5), (95.5, 10.5)].map(glam::DVec2::from) {
            let (a, b) = (before.direction(at).unwrap(), after.direction(at).unwrap());
            assert!(a.distance(b) < 1e-5, "{profile}: {a} is not {b}");
        }
    }
    // The profile for projectors cannot describe a projector whose picture is mirrored.
    let refused =
        convert::cupola(&["convert", from.to_str().unwrap(), file("no.mpcdi").to_str().unwrap(), "--profile", "sl"]);
    assert!(!refused.status.success() && String::from_utf8_lossy(&refused.stderr).contains("it is mirrored"));
}
