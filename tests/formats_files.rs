//! Calibration files: hostile ones, and what `cupola convert` writes.

use cupola::formats::{Raster, bourke, domeprojection, easyblend, mpcdi, pfm, sgct, vwf};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// A SplitMix64 generator: the same damage in every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }
}

/// One to four changes: a byte, a bit, a large number, a piece cut out, doubled or replaced, the end cut off.
fn damaged(good: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = good.to_vec();
    for _ in 0..=random.below(4) {
        if bytes.is_empty() {
            break;
        }
        // Headers are short and matter most.
        let reach = if random.below(2) == 0 { bytes.len().min(64) } else { bytes.len() };
        let at = random.below(reach);
        let end = (at + 1 + random.below(16)).min(bytes.len());
        match random.below(7) {
            0 => bytes[at] = random.next() as u8,
            1 => bytes[at] ^= 1 << random.below(8),
            2 => bytes[at..end].fill([0xff, 0x7f, 0, b'9', b'-'][random.below(5)]),
            3 => drop(bytes.drain(at..end)),
            4 => drop(bytes.splice(at..at, bytes[at..end].to_vec())),
            5 => drop(
                bytes.splice(at..end, [&b"nan"[..], b"1e999", b"4294967296", b"-1", b"\n"][random.below(5)].to_vec()),
            ),
            _ => bytes.truncate(at),
        }
    }
    bytes
}

fn raster() -> Raster {
    let value = |i: usize| if i == 5 { [f32::NAN; 3] } else { [0.1 * i as f32, 0.5, 0.25] };
    Raster::new((4, 3), (0..12).map(value).collect()).unwrap()
}

fn warp_mesh() -> bourke::WarpMesh {
    let node = |i: usize| {
        let (x, y) = ((i % 4) as f64 / 3.0, (i / 4) as f64 / 2.0);
        [2.0 * x - 1.0, 2.0 * y - 1.0, x, y, if i == 11 { -1.0 } else { 1.0 }]
    };
    bourke::WarpMesh {
        arrangement: bourke::Arrangement::Rectangular,
        columns: 4,
        rows: 3,
        nodes: (0..12).map(node).collect(),
    }
}

fn archive() -> mpcdi::Archive {
    let alpha = mpcdi::Alpha { size: (4, 3), weights: vec![0.5; 12], gamma: 2.2 };
    let beta = mpcdi::Levels { size: (2, 2), levels: vec![0.125; 4] };
    let frustum = cupola::geom::Frustum { left: -1.0, right: 1.0, bottom: -1.0, top: 1.0 };
    let camera = cupola::formats::Camera { offset: glam::DVec3::X, rotation: glam::DMat3::IDENTITY, frustum };
    let region = mpcdi::Region {
        id: "one".into(),
        size: (4, 3),
        warp: raster(),
        alpha: Some(alpha),
        beta: Some(beta),
        camera: Some(camera),
    };
    mpcdi::Archive { profile: mpcdi::Profile::ShaderLamps, regions: vec![region] }
}

/// Damages `good` in many ways. Nothing may panic; what is refused names the file.
fn survives(good: &[u8], read: impl Fn(&[u8]) -> cupola::Result<()>) {
    read(good).expect("the undamaged file is good");
    let (mut random, mut refused) = (Random(7), 0);
    for _ in 0..4000 {
        if let Err(error) = read(&damaged(good, &mut random)) {
            assert!(error.message.starts_with("some.file") && error.message.len() < 600, "{}", error.message);
            refused += 1;
        }
    }
    // Most damage is seen; what is not, changed a number into another.
    assert!(refused > 1000, "only {refused} of 4000 were refused");
}

#[test]
fn damaged_warp_meshes_do_no_harm() {
    let read = |bytes: &[u8]| bourke::read("some.file", bytes)?.value.mesh("some.file").map(drop);
    survives(bourke::write(&warp_mesh()).as_bytes(), read);
}

#[test]
fn damaged_float_maps_do_no_harm() {
    survives(&pfm::write(4, raster().values()), |bytes| pfm::read("some.file", bytes).map(drop));
}

/// The mesh of a camera that looks up by 30°.
const EASYBLEND: &str = "OPENMESH Version 1.1\nVERTICES 4\nFACES 2\nMAPPING NORMALIZED\nNATIVEXRES 40\nNATIVEYRES 20\n\
    PERSPECTIVE_LEFT -45\nPERSPECTIVE_RIGHT 45\nPERSPECTIVE_BOTTOM -30\nPERSPECTIVE_TOP 30\nPERSPECTIVE_PITCH 30\n\
    0 0 255 0 1\n40 0 255 1 1\n40 20 255 1 0\n0 20 255 0 0\n[ 0 1 2 ]\n[ 0 2 3 ]\n";

/// A mesh over the whole output and the whole picture.
const DOMEPROJECTION: &str = "x;y;u;v;column;row\n0;0;0;0;0;0\n1;0;1;0;1;0\n0;1;0;1;0;1\n1;1;1;1;1;1\n";

#[test]
fn damaged_easyblend_meshes_do_no_harm() {
    survives(EASYBLEND.as_bytes(), |bytes| easyblend::read("some.file", bytes).map(drop));
}

#[test]
fn damaged_domeprojection_meshes_do_no_harm() {
    survives(DOMEPROJECTION.as_bytes(), |bytes| domeprojection::read("some.file", bytes).map(drop));
}

#[test]
fn meshes_of_other_tools_become_maps() {
    let (mesh, out) = (file("camera.ol"), file("camera.pfm"));
    std::fs::write(&mesh, EASYBLEND).unwrap();
    let written = convert(mesh.to_str().unwrap(), &out, &[]);
    assert_eq!(written["files"][0]["values"], "directions");
    let directions = map(&out);
    assert_eq!(directions.size(), (40, 20));
    // The middle of the picture looks up by 30°, its pixels left and right of it at equal heights.
    let [x, y, z] = directions.values()[10 * 40 + 20].map(f64::from);
    let ahead = |x: f64, y: f64| glam::DMat3::from_rotation_x(30f64.to_radians()) * glam::DVec3::new(x, y, -1.0);
    let expected = ahead(0.025, -0.05 * 30f64.to_radians().tan()).normalize();
    assert!(glam::DVec3::new(x, y, z).distance(expected) < 1e-6, "{x} {y} {z}");
    let (mesh, out) = (file("dome.csv"), file("dome.pfm"));
    std::fs::write(&mesh, DOMEPROJECTION).unwrap();
    convert(mesh.to_str().unwrap(), &out, &["--size", "8x4"]);
    assert_eq!(map(&out).values()[0], [1.0 / 16.0, 7.0 / 8.0, 0.0]);
}

#[test]
fn damaged_vioso_files_do_no_harm() {
    let map = vwf::VwfMap { name: "one".into(), points: false, raster: raster(), blend: None };
    survives(&vwf::write(&[map]).unwrap(), |bytes| vwf::read("some.file", bytes).map(drop));
}

#[test]
fn damaged_archives_do_no_harm() {
    survives(&mpcdi::write(&archive(), mpcdi::Version::Two).unwrap(), |bytes| {
        mpcdi::read("some.file", bytes).map(drop)
    });
}

fn cupola(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_cupola")).args(arguments).output().unwrap()
}

#[track_caller]
fn convert(from: &str, to: &Path, more: &[&str]) -> serde_json::Value {
    let output = cupola(&[&["convert", from, to.to_str().unwrap(), "--json"], more].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).unwrap()
}

fn file(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("formats_files");
    std::fs::create_dir_all(&folder).unwrap();
    folder.join(name)
}

fn map(path: &Path) -> Raster {
    pfm::read("the map", &std::fs::read(path).unwrap()).unwrap()
}

/// Greatest difference of two maps; what one shows the other has to show too.
#[track_caller]
fn difference(a: &Raster, b: &Raster) -> f32 {
    assert_eq!(a.size(), b.size());
    a.values().iter().zip(b.values()).fold(0.0, |greatest: f32, (a, b)| {
        assert_eq!(a[0].is_nan(), b[0].is_nan());
        (0..3).map(|i| (a[i] - b[i]).abs()).filter(|d| !d.is_nan()).fold(greatest, f32::max)
    })
}

#[test]
fn a_projector_is_the_same_map_after_a_way_through_every_format() {
    let size = ["--size", "96x54", "--output", "front"];
    for (values, formats) in [("picture", &["mpcdi", "vwf"][..]), ("points", &["mpcdi", "vwf"][..])] {
        let values = ["--values", values];
        let direct = file(&format!("direct-{}.pfm", values[1]));
        convert("planetarium-6", &direct, &[&size[..], &values[..]].concat());
        let direct = map(&direct);
        assert!(direct.values().iter().any(|value| value[0].is_finite()));
        for format in formats {
            let (middle, back) =
                (file(&format!("{}.{format}", values[1])), file(&format!("{}-{format}.pfm", values[1])));
            convert("planetarium-6", &middle, &[&size[..], &values[..]].concat());
            convert(middle.to_str().unwrap(), &back, &[]);
            // A 2D VIOSO map counts v from the top: one rounding.
            assert!(difference(&direct, &map(&back)) <= 1.2e-7, "{format}");
        }
        // Negative control: another projector is another map.
        let other = file("other.pfm");
        convert("planetarium-6", &other, &[&["--size", "96x54", "--output", "zenith"][..], &values[..]].concat());
        let other = map(&other);
        let differ = |(a, b): (&[f32; 3], &[f32; 3])| (a[0] - b[0]).abs() > 0.01;
        assert!(direct.values().iter().zip(other.values()).any(differ));
    }
}

#[test]
fn archives_of_every_profile_and_version_are_the_same_map() {
    let size = ["--size", "96x54", "--output", "zenith"];
    for (profile, values, bound) in
        [("2d", "picture", 1e-7), ("a3", "points", 1e-7), ("sl", "points", 1e-7), ("3d", "directions", 3e-7)]
    {
        let direct = file(&format!("direct-{profile}.pfm"));
        convert("planetarium-6", &direct, &[&size[..], &["--values", values]].concat());
        for version in ["1", "2"] {
            let (middle, back) =
                (file(&format!("{profile}-{version}.mpcdi")), file(&format!("{profile}-{version}.pfm")));
            convert(
                "planetarium-6",
                &middle,
                &[&size[..], &["--profile", profile, "--archive-version", version]].concat(),
            );
            let written = convert(middle.to_str().unwrap(), &back, &[]);
            assert_eq!(written["files"][0]["values"], values);
            let found = difference(&map(&direct), &map(&back));
            assert!(found <= bound, "{profile} {version}: {found}");
        }
    }
    // The projector of profile sl is where the rig has it.
    let bytes = std::fs::read(file("sl-2.mpcdi")).unwrap();
    let archive = mpcdi::read("sl-2.mpcdi", &bytes).unwrap().value;
    let camera = archive.regions[0].camera.unwrap();
    let rig = cupola::rig::load("planetarium-6").unwrap();
    let zenith = rig.outputs.iter().find(|output| output.name == "zenith").unwrap();
    let cupola::rig::OutputKind::Projector { position, .. } = zenith.kind else { panic!("a projector") };
    assert_eq!(camera.offset, position);
    // And it lights the points of the map: the middle of the picture lies on its axis.
    let [x, y, z] = archive.regions[0].warp.values()[27 * 96 + 48].map(f64::from);
    let place = camera.place(glam::DVec3::new(x, y, z) - position).unwrap();
    assert!(place.distance(glam::DVec2::new(48.5 / 96.0, 26.5 / 54.0)) < 1e-6, "{place}");
}

/// The exact map of an output of a rig, and what of its light is left, at each pixel.
fn exact(rig: &str, output: &str, size: (u32, u32)) -> Vec<Option<(glam::DVec3, f64)>> {
    let rig = cupola::rig::load(rig).unwrap();
    let index = rig.outputs.iter().position(|known| known.name == output).unwrap();
    let map = cupola::warp::WarpMap::new(&rig, index, size, None).unwrap();
    let weights = cupola::blend::Weights::new(&rig, &vec![size; rig.outputs.len()]).unwrap();
    let pixel = |i: u32| glam::DVec2::new(f64::from(i % size.0) + 0.5, f64::from(i / size.0) + 0.5);
    (0..size.0 * size.1).map(|i| Some((map.direction(pixel(i))?, weights.weight(index, pixel(i))?))).collect()
}

#[test]
fn a_rig_made_of_a_calibration_shows_what_the_calibrated_rig_shows() {
    let size = (96, 54);
    let source = exact("planetarium-6", "front", size);
    let calibrations =
        [("2d", "mpcdi"), ("a3", "mpcdi"), ("3d", "mpcdi"), ("2d", "vwf"), ("a3", "pfm"), ("2d", "toml")];
    for (profile, ending) in calibrations {
        let (middle, rig) =
            (file(&format!("calibrated-{profile}.{ending}")), file(&format!("again-{profile}-{ending}.toml")));
        let more = ["--size", "96x54", "--output", "front", "--profile", profile];
        convert("planetarium-6", &middle, &more);
        let values = if ending == "pfm" { &["--values", "points"][..] } else { &[] };
        // Of a rig, the rig itself is the result.
        let rig = if ending == "toml" {
            middle
        } else {
            convert(middle.to_str().unwrap(), &rig, values);
            rig
        };
        // The dome of a calibration is not in its file: say which it is.
        let text = std::fs::read_to_string(&rig).unwrap();
        let text = text.replace("tilt = 0.0 #", "tilt = 25.0 #");
        std::fs::write(&rig, text).unwrap();
        let loaded = cupola::rig::load(rig.to_str().unwrap()).unwrap();
        let found = exact(rig.to_str().unwrap(), &loaded.outputs[0].name, size);
        for (found, expected) in found.iter().zip(&source) {
            assert_eq!(found.is_some(), expected.is_some(), "{profile} {ending}");
            if let (Some(found), Some(expected)) = (found, expected) {
                assert!(found.0.distance(expected.0) < 1e-6, "{profile} {ending}: {} is not {}", found.0, expected.0);
            }
        }
        // And it can be planned and drawn: what the shaders will use is the same again.
        let request = cupola::views::Request {
            output_sizes: vec![size],
            window: size,
            panel: false,
            primary: false,
            max_atlas: 16384,
        };
        let plan = cupola::correct::build(&loaded, &request).unwrap();
        assert!(
            matches!(plan.passes[0].source, cupola::correct::Source::Table(_)) && !plan.passes[0].batches.is_empty()
        );
        // A point of the screen is found again where it came from.
        let map = cupola::warp::WarpMap::new(&loaded, 0, size, None).unwrap();
        for pixel in [glam::DVec2::new(20.3, 30.1), glam::DVec2::new(70.0, 40.0)] {
            let Some(point) = map.hit(pixel) else { continue };
            assert!(map.pixel(point).is_some_and(|found| found.distance(pixel) < 1e-3), "{profile} {ending} {pixel}");
        }
    }
    // The light of an archive's alpha map is kept too.
    let weighted = file("again-2d-mpcdi.png");
    let picture = weighted.with_file_name("again-2d-mpcdi-front.png");
    let mask = image::open(picture).unwrap().into_luma16();
    let worst = mask
        .pixels()
        .zip(&source)
        .filter_map(|(found, expected)| Some((f64::from(found.0[0]) / 65535.0 - (*expected)?.1).abs()));
    assert!(worst.fold(0.0, f64::max) < 1e-4);
}

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
    assert_eq!((rig.outputs[0].window, rig.outputs[1].window), (Some([0, 0, 100, 100]), Some([100, 0, 100, 100])));
    let cupola::rig::OutputKind::Perspective { angles: [yaw, pitch, roll], frustum: Some(frustum) } =
        rig.outputs[1].kind
    else {
        panic!("{:?}", rig.outputs[1].kind)
    };
    assert!((yaw.to_degrees() - 20.0).abs() < 1e-6 && (pitch.to_degrees() - 5.0).abs() < 1e-6);
    assert!((roll.to_degrees() + 3.0).abs() < 1e-6 && (frustum.right - 1.0).abs() < 1e-6 && rig.outputs[1].eye > 0.0);
    survives(text.as_bytes(), |bytes| sgct::read("some.file", bytes).map(drop));
}

#[test]
fn points_lie_on_the_dome() {
    let path = file("points.pfm");
    convert("planetarium-6", &path, &["--size", "64x36", "--output", "left", "--values", "points"]);
    for point in map(&path).values().iter().filter(|point| point[0].is_finite()) {
        let distance = point.iter().map(|value| value * value).sum::<f32>().sqrt();
        assert!((distance - 5.0).abs() < 1e-5, "{point:?}");
    }
}

#[test]
fn a_finer_warp_mesh_is_nearer_to_the_exact_map() {
    let error = |nodes: &str| {
        let more = ["--size", "960x540", "--output", "zenith", "--nodes", nodes];
        convert("planetarium-6", &file("mesh.data"), &more)["files"][0]["error_pixels"]["max"].as_f64().unwrap()
    };
    let (coarse, fine) = (error("17x17"), error("65x65"));
    // The error of linear interpolation falls with the square of the distance of the nodes: sixteenfold.
    assert!(fine > 0.0 && (10.0..24.0).contains(&(coarse / fine)), "{coarse} {fine}");
}

#[test]
fn what_cannot_be_converted_is_refused() {
    let broken = file("broken.data");
    std::fs::write(&broken, "2\n2 2\n0 0 0 0 1\nx\n").unwrap();
    let (broken, mesh) = (broken.to_str().unwrap(), file("out.data"));
    let out = mesh.to_str().unwrap();
    let archive = file("out.mpcdi");
    let archive = archive.to_str().unwrap();
    for (arguments, why) in [
        (&["convert", broken, out][..], "broken.data:4"),
        (&["convert", "fisheye", "out.xyz"], "expected a name that ends in"),
        (&["convert", "fisheye", out, "--output", "x"], "no output \"x\""),
        (&["convert", "fisheye", out, "--values", "points"], "--values picture"),
        (&["convert", "identity", out], "has no outputs"),
        (&["convert", "fisheye", archive, "--profile", "3d"], "shows too much"),
        (&["convert", "fisheye", archive, "--profile", "sl"], "no pinhole projector"),
        (&["convert", "missing.mpcdi", out], "missing.mpcdi cannot be read"),
    ] {
        let output = cupola(arguments);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(why), "{said}");
    }
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
    // The mesh's middle is the picture's middle, where the viewport looks; its corners are within.
    let middle = map.direction(glam::DVec2::new(50.0, 50.0)).expect("shown");
    let (yaw, pitch) = (20f64.to_radians(), 5f64.to_radians());
    let towards = glam::DVec3::new(yaw.sin() * pitch.cos(), pitch.sin(), -yaw.cos() * pitch.cos());
    assert!(middle.distance(towards) < 1e-6, "{middle} {towards}");
    assert!(matches!(rig.outputs[0].kind, cupola::rig::OutputKind::Mesh(_)));
}
