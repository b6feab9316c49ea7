//! Calibration files: damaged files, and the files that `cupola convert` writes.

#[path = "../convert/mod.rs"]
mod convert;
mod damaged;
#[path = "../../src/testing/random.rs"]
mod random;

use convert::{convert, cupola, file};
use cupola::formats::{Raster, bourke, domeprojection, easyblend, mpcdi, pictures::pfm, sgct, vwf};
use std::path::Path;

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
    let beta = cupola::formats::Levels::even((2, 2), 0.125);
    let frustum = cupola::geom::Frustum { left: -1.0, right: 1.0, bottom: -1.0, top: 1.0 };
    let camera = cupola::formats::Camera { offset: glam::DVec3::X, rotation: glam::DMat3::IDENTITY, frustum };
    let region = mpcdi::Region {
        id: "one".into(),
        size: (4, 3),
        warp: Some(raster()),
        alpha: Some(alpha),
        beta: Some(beta),
        camera: Some(camera),
        fisheye: None,
    };
    mpcdi::Archive { profile: mpcdi::Profile::ShaderLamps, regions: vec![region], dome: None }
}

/// The mesh of a camera that looks up by 30°.
const EASYBLEND: &str = "OPENMESH Version 1.1\nVERTICES 4\nFACES 2\nMAPPING NORMALIZED\nNATIVEXRES 40\nNATIVEYRES 20\n\
    PERSPECTIVE_LEFT -45\nPERSPECTIVE_RIGHT 45\nPERSPECTIVE_BOTTOM -30\nPERSPECTIVE_TOP 30\nPERSPECTIVE_PITCH 30\n\
    0 0 255 0 1\n40 0 255 1 1\n40 20 255 1 0\n0 20 255 0 0\n[ 0 1 2 ]\n[ 0 2 3 ]\n";

/// A mesh over the whole output and the whole picture.
const DOMEPROJECTION: &str = "x;y;u;v;column;row\n0;0;0;0;0;0\n1;0;1;0;1;0\n0;1;0;1;0;1\n1;1;1;1;1;1\n";

#[test]
fn meshes_of_other_tools_become_maps() {
    let (mesh, out) = (file("camera.ol"), file("camera.pfm"));
    std::fs::write(&mesh, EASYBLEND).unwrap();
    let written = convert(mesh.to_str().unwrap(), &out, &[]);
    assert_eq!(written["files"][0]["values"], "directions");
    let directions = map(&out);
    assert_eq!(directions.size(), (40, 20));
    // The middle of the picture looks up by 30°. Pixels left and right of it look at equal heights.
    let [x, y, z] = directions.values()[10 * 40 + 20].map(f64::from);
    let ahead = |x: f64, y: f64| glam::DMat3::from_rotation_x(30f64.to_radians()) * glam::DVec3::new(x, y, -1.0);
    let expected = ahead(0.025, -0.05 * 30f64.to_radians().tan()).normalize();
    assert!(glam::DVec3::new(x, y, z).distance(expected) < 1e-6, "{x} {y} {z}");
    let (mesh, out) = (file("dome.csv"), file("dome.pfm"));
    std::fs::write(&mesh, DOMEPROJECTION).unwrap();
    convert(mesh.to_str().unwrap(), &out, &["--size", "8x4"]);
    assert_eq!(map(&out).values()[0], [1.0 / 16.0, 7.0 / 8.0, 0.0]);
}

fn map(path: &Path) -> Raster {
    pfm::read("the map", &std::fs::read(path).unwrap()).unwrap()
}

/// Greatest difference of two maps. Both must cover the same pixels.
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
            // A 2D VIOSO map counts v from the top, which rounds once more.
            assert!(difference(&direct, &map(&back)) <= 1.2e-7, "{format}");
        }
        // Negative control: the map of another projector.
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
    // In an archive of profile sl the projector is where the rig has it.
    let bytes = std::fs::read(file("sl-2.mpcdi")).unwrap();
    let archive = mpcdi::read("sl-2.mpcdi", &bytes).unwrap().value;
    let camera = archive.regions[0].camera.unwrap();
    let rig = cupola::rig::load("planetarium-6").unwrap();
    let zenith = rig.outputs.iter().find(|output| output.name == "zenith").unwrap();
    let cupola::rig::OutputKind::Projector { position, .. } = zenith.kind else { panic!("a projector") };
    assert_eq!(camera.offset, position);
    // The projector lights the points of the map: the point at the middle of the picture lies on
    // its axis.
    let [x, y, z] = archive.regions[0].warp.as_ref().unwrap().values()[27 * 96 + 48].map(f64::from);
    let place = camera.place(glam::DVec3::new(x, y, z) - position).unwrap();
    assert!(place.distance(glam::DVec2::new(48.5 / 96.0, 26.5 / 54.0)) < 1e-6, "{place}");
}

/// Exact map of an output of a rig, and the blend weight of the output, at each pixel.
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
        // If the source is a rig, the result is that rig itself.
        let rig = if ending == "toml" {
            middle
        } else {
            convert(middle.to_str().unwrap(), &rig, values);
            rig
        };
        // Only archives and rigs contain the dome, so it is added here.
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
        // The rig can be planned and drawn, and the shaders use the same table.
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
        // From a point of the screen the map leads back to the pixel.
        let map = cupola::warp::WarpMap::new(&loaded, 0, size, None).unwrap();
        for pixel in [glam::DVec2::new(20.3, 30.1), glam::DVec2::new(70.0, 40.0)] {
            let Some(point) = map.hit(pixel) else { continue };
            assert!(map.pixel(point).is_some_and(|found| found.distance(pixel) < 1e-3), "{profile} {ending} {pixel}");
        }
    }
    // The light of an archive's alpha map is preserved, too.
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
    // The error of linear interpolation falls with the square of the distance between nodes: 16
    // times here.
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
        (&["convert", "fisheye", archive, "--profile", "3d"], "too wide an angle"),
        (&["convert", "fisheye", archive, "--profile", "sl"], "needs a pinhole projector"),
        (&["convert", "missing.mpcdi", out], "missing.mpcdi cannot be read"),
    ] {
        let output = cupola(arguments);
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(why), "{said}");
    }
}

/// The error of the rig `found` against the preset or rig `exact`, in pixels of its first output.
fn error_pixels(exact: &cupola::rig::Rig, found: &cupola::rig::Rig, size: (u32, u32)) -> cupola::warp::MapError {
    let map = |rig| cupola::warp::WarpMap::new(rig, 0, size, None).unwrap();
    let (exact, found) = (map(exact), map(found));
    let pixel = |x: u32, y: u32| glam::DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
    cupola::warp::compare(&exact, 3, |x, y| found.direction(pixel(x, y)))
}

#[test]
fn a_projector_before_a_mirror_is_the_same_map_as_a_dense_warp_mesh() {
    let (mesh, size) = (file("idome.data"), (960, 540));
    let exact = cupola::rig::load("idome").unwrap();
    let written = convert("idome", &mesh, &["--size", "960x540", "--nodes", "385x217"]);
    let stated = written["files"][0]["error_pixels"]["max"].as_f64().unwrap();
    assert!(stated > 0.0 && stated < 0.2, "{written}");
    let rig = |tilt: f64| {
        let text = format!("[dome]\nradius = 1.5\ntilt = {tilt}\n[[output]]\nkind = \"mesh\"\nfile = \"idome.data\"\n");
        cupola::rig::parse(&text, "by-hand.toml", mesh.parent().unwrap()).unwrap()
    };
    let found = error_pixels(&exact, &rig(90.0), size);
    // The error that the command stated for its mesh is the error of the rig that uses the mesh.
    assert!(found.max <= stated * 1.001 + 1e-6 && found.ghosts == 0, "{found:?}, stated {stated}");
    let left_out = written["files"][0]["error_pixels"]["uncovered"].as_u64().unwrap();
    assert!(found.uncovered <= left_out / 4, "{found:?}, stated {left_out} of all pixels");
    // Negative control: a tenth of a degree is detected.
    let wrong = error_pixels(&exact, &rig(90.1), size);
    assert!(wrong.max > 10.0 * stated.max(0.02), "{wrong:?}");
    // The same through `convert`, with the values added that the mesh's file does not contain.
    let again = file("idome-again.toml");
    convert(mesh.to_str().unwrap(), &again, &["--size", "960x540"]);
    let text = std::fs::read_to_string(&again).unwrap();
    std::fs::write(&again, text.replace("tilt = 0.0 #", "tilt = 90.0 #").replace("radius = 5.0000", "radius = 1.5"))
        .unwrap();
    let found = error_pixels(&exact, &cupola::rig::load(again.to_str().unwrap()).unwrap(), size);
    assert!(found.max <= stated + 0.002 && found.ghosts == 0, "{found:?}, stated {stated}");
}

#[test]
fn presets_are_the_same_map_after_a_way_through_every_format_that_holds_them() {
    let size = ["--size", "192x108"];
    for (preset, output) in
        [("idome", "mirror"), ("fisheye", "dome"), ("fisheye-210", "dome"), ("planetarium-2", "upper")]
    {
        let exact = cupola::rig::load(preset).unwrap();
        let index = exact.outputs.iter().position(|known| known.name == output).unwrap_or(0);
        let mut only = exact.clone();
        only.outputs = vec![exact.outputs[index].clone()];
        let more = [&size[..], &["--output", &only.outputs[0].name]].concat();
        for ending in ["mpcdi", "vwf", "pfm", "toml"] {
            let (middle, rig) = (file(&format!("{preset}.{ending}")), file(&format!("{preset}-{ending}.toml")));
            convert(preset, &middle, &more);
            let rig = if ending == "toml" { middle } else { rig };
            if ending != "toml" {
                convert(rig.with_file_name(format!("{preset}.{ending}")).to_str().unwrap(), &rig, &[]);
            }
            let (tilt, coverage) = (exact.dome.tilt.to_degrees(), exact.dome.coverage.to_degrees());
            let text = std::fs::read_to_string(&rig).unwrap();
            let text = text.replace("tilt = 0.0 #", &format!("tilt = {tilt} #"));
            let text = text.replace("coverage = 180.0 #", &format!("coverage = {coverage} #"));
            std::fs::write(&rig, text.replace("radius = 5.0000 #", &format!("radius = {} #", exact.dome.radius)))
                .unwrap();
            let found = cupola::rig::load(rig.to_str().unwrap()).unwrap();
            let error = error_pixels(&only, &found, (192, 108));
            assert!(error.max < 0.002 && error.is_sound(), "{preset} by way of {ending}: {error:?}");
        }
    }
}

#[test]
fn a_projector_with_a_fisheye_is_the_same_after_a_way_through_an_archive() {
    let text = "[dome]\nradius = 4.0\n[[output]]\nname = \"lens\"\nkind = \"projector\"\nsize = [192, 120]\nposition = [0.3, -0.2, 0.4]\n\
        pitch = 80.0\nyaw = 10.0\nfisheye = { projection = \"polynomial\", aperture = 170.0, coefficients = [1.0, -0.04, 0.002, 0.0], \
        size = [1.1, 1.6], center = [0.02, -0.15] }\nblend = { black_level = 0.002, gamma = 2.4, overlap = false }\n";
    let (from, archive, back) = (file("lens.toml"), file("lens.mpcdi"), file("lens-again.toml"));
    std::fs::write(&from, text).unwrap();
    convert(from.to_str().unwrap(), &archive, &["--profile", "sl"]);
    convert(archive.to_str().unwrap(), &back, &["--projectors"]);
    let written = std::fs::read_to_string(&back).unwrap();
    assert!(
        written.contains("fisheye = { projection = \"polynomial\"") && written.contains("radius = 4\n"),
        "{written}"
    );
    let [exact, found] = [&from, &back].map(|rig| cupola::rig::load(rig.to_str().unwrap()).unwrap());
    let error = error_pixels(&exact, &found, (192, 120));
    assert!(error.max < 1e-5 && error.is_sound(), "{error:?}");
    let blend = &found.outputs[0].blend;
    assert!((blend.black_level - 0.002).abs() < 1e-5 && blend.gamma == 2.4 && !blend.overlap, "{blend:?}");
    // Without the option the points are used. The map is the same, as exactly as a float map stores
    // it.
    convert(archive.to_str().unwrap(), &back, &[]);
    let found = cupola::rig::load(back.to_str().unwrap()).unwrap();
    assert!(matches!(found.outputs[0].kind, cupola::rig::OutputKind::Mesh(_)));
    let error = error_pixels(&exact, &found, (192, 120));
    assert!(error.max < 0.002 && error.is_sound(), "{error:?}");
    // Negative control: a lens that is turned by a twentieth of a degree.
    let turned = file("lens-turned.toml");
    std::fs::write(&turned, text.replace("yaw = 10.0", "yaw = 10.05")).unwrap();
    let error = error_pixels(&exact, &cupola::rig::load(turned.to_str().unwrap()).unwrap(), (192, 120));
    assert!(error.max > 0.01, "{error:?}");
}

#[test]
fn weights_and_black_levels_go_through_vioso_files() {
    let text = "[[output]]\nname = \"one\"\nkind = \"projector\"\nsize = [96, 54]\nyaw = -10.0\npitch = 40.0\nfov = [60.0, 36.0]\n\
        blend = { black_level = 0.01 }\n[[output]]\nname = \"two\"\nkind = \"projector\"\nsize = [96, 54]\nyaw = 30.0\npitch = 40.0\n\
        fov = [60.0, 36.0]\n";
    let (from, set, back) = (file("light.toml"), file("light.vwf"), file("light-again.toml"));
    std::fs::write(&from, text).unwrap();
    convert(from.to_str().unwrap(), &set, &[]);
    convert(set.to_str().unwrap(), &back, &[]);
    let expected = exact(from.to_str().unwrap(), "one", (96, 54));
    let mask = image::open(back.with_file_name("light-again-one.png")).unwrap().into_luma16();
    let (mut worst, mut dimmed) = (0.0f64, 0);
    for (found, expected) in mask.pixels().zip(&expected) {
        let Some((_, light)) = expected else { continue };
        worst = worst.max((f64::from(found.0[0]) / 65535.0 - light).abs());
        dimmed += u32::from(*light < 0.9);
    }
    assert!(worst < 1e-4 && dimmed > 500, "{worst} {dimmed}");
    let rig = cupola::rig::load(back.to_str().unwrap()).unwrap();
    // The file has 8 bits of the displayed value.
    assert!((rig.outputs[0].blend.black_level - 0.01).abs() < 5e-4, "{:?}", rig.outputs[0].blend);
    assert_eq!(rig.outputs[1].blend.black_level, 0.0);
}

#[test]
fn a_file_that_exists_is_replaced_only_if_that_is_asked_for() {
    let rig = file("mine.toml");
    std::fs::write(&rig, "# mine").unwrap();
    let arguments = ["convert", "planetarium-2", rig.to_str().unwrap(), "--size", "8x8"];
    let output = cupola(&arguments);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2) && said.contains("mine.toml exists"), "{said}");
    assert_eq!(std::fs::read(&rig).unwrap(), b"# mine");
    let output = cupola(&[&arguments[..], &["--force"]].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(std::fs::read_to_string(&rig).unwrap().contains("[[output]]"));
}

#[test]
fn archives_contain_the_dome_and_other_files_do_not() {
    let rig = file("dome.toml");
    for version in ["1", "2"] {
        let archive = file(&format!("dome-{version}.mpcdi"));
        let size = ["--size", "8x8", "--archive-version", version];
        let exported = convert("planetarium-6", &archive, &size);
        assert_eq!(exported["notes"].as_array().map(Vec::len), Some(0), "{exported}");
        let imported = convert(archive.to_str().unwrap(), &rig, &[]);
        assert_eq!(imported["notes"].as_array().map(Vec::len), Some(0), "{imported}");
        let text = std::fs::read_to_string(&rig).unwrap();
        assert!(text.contains("\ntilt = 25\n") && !text.contains("not in the file"), "{text}");
        let found = cupola::rig::load(rig.to_str().unwrap()).unwrap().dome;
        assert_eq!(found, cupola::rig::load("planetarium-6").unwrap().dome);
    }
    // VIOSO's format has no place for it. Both ways are told.
    let set = file("dome.vwf");
    let notes = convert(file("dome-1.mpcdi").to_str().unwrap(), &set, &[])["notes"].to_string();
    assert!(notes.contains("has no place for the dome's tilt (25.00°)"), "{notes}");
    let notes = convert(set.to_str().unwrap(), &rig, &[])["notes"].to_string();
    assert!(notes.contains("does not say how the dome is tilted"), "{notes}");
    // A rig describes its dome, so there is no note.
    assert_eq!(convert("planetarium-2", &rig, &["--size", "8x8"])["notes"].as_array().map(Vec::len), Some(0));
}
