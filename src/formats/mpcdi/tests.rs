use super::*;
use crate::geom::{Frustum, pose};
use glam::DVec3;
use std::io::{Cursor, Write};

fn archive(profile: Profile) -> Archive {
    let region = |id: &str| {
        let values = (0..6).map(|i| if i == 4 { [f32::NAN; 3] } else { [i as f32 * 0.125, 0.5, 0.0] }).collect();
        let alpha = Alpha { size: (3, 2), weights: vec![0.0, 0.25, 0.5, 0.75, 1.0, 1.0], gamma: 2.2 };
        let beta = Levels { size: (2, 1), values: vec![[0.0; 3], [0.125, 0.25, 0.5]] };
        let camera = Camera {
            offset: if profile == Profile::ShaderLamps { DVec3::new(1.0, -2.0, 0.5) } else { DVec3::ZERO },
            rotation: pose::rotation(0.5, -0.3, 0.2),
            frustum: Frustum { left: -0.5, right: 0.25, bottom: -0.125, top: 1.0 },
        };
        Region {
            id: id.into(),
            size: (3, 2),
            warp: Raster::new((3, 2), values),
            alpha: Some(alpha),
            beta: (id == "left").then_some(beta),
            camera: profile.has_cameras().then_some(camera),
            fisheye: None,
        }
    };
    Archive { profile, regions: vec![region("left"), region("\"right\" & <up>")], dome: None }
}

/// A zip archive of the given files.
fn zipped(files: &[(&str, &[u8])]) -> Vec<u8> {
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    for (name, bytes) in files {
        zip.start_file(*name, zip::write::SimpleFileOptions::default()).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// A description with one region of this width, whose map is `path`.
fn described(path: &str, width: u32) -> String {
    format!(
        "<MPCDI profile=\"2d\" geometry=\"1\" color=\"1\" version=\"2.0\"><display><buffer id=\"b\" xResolution=\"9\" yResolution=\"9\">\
         <region id=\"r\" xResolution=\"{width}\" yResolution=\"1\" x=\"0.5\" y=\"0\" xSize=\"0.5\" ySize=\"1\"/></buffer></display>\
         <files><fileset region=\"r\"><geometryWarpFile><path> {path}\n</path></geometryWarpFile></fileset></files></MPCDI>"
    )
}

#[test]
fn what_is_written_is_read_back() {
    for (profile, version) in
        Profile::ALL.into_iter().flat_map(|profile| [(profile, Version::One), (profile, Version::Two)])
    {
        let expected = archive(profile);
        let found = read("a.mpcdi", &write(&expected, version).unwrap()).unwrap();
        assert_eq!((found.value.profile, &found.notes[..]), (profile, &[][..]));
        let found = found.value;
        for (found, expected) in found.regions.iter().zip(&expected.regions) {
            assert_eq!((&found.id, found.size), (&expected.id, expected.size));
            let same = |(a, b): (&[f32; 3], &[f32; 3])| a == b || (a[0].is_nan() && b[0].is_nan());
            let values = |region: &Region| region.warp.clone().unwrap().values().to_vec();
            assert!(values(found).iter().zip(&values(expected)).all(same));
            assert_eq!(found.camera.is_some(), expected.camera.is_some());
            if let (Some(found), Some(expected)) = (&found.camera, &expected.camera) {
                assert_eq!(found.offset, expected.offset);
                assert!(found.rotation.abs_diff_eq(expected.rotation, 1e-12));
                assert!((found.frustum.left - expected.frustum.left).abs() < 1e-12);
                assert!((found.frustum.top - expected.frustum.top).abs() < 1e-12);
            }
            assert_eq!(found.beta.is_some(), expected.beta.is_some());
            if let (Some(found), Some(expected)) = (&found.beta, &expected.beta) {
                assert_eq!(found.size, expected.size);
                let near = |(a, b): (&f32, &f32)| (a - b).abs() < 1e-5;
                assert!(found.values.as_flattened().iter().zip(expected.values.as_flattened()).all(near), "{found:?}");
            }
            let (found, expected) = (found.alpha.as_ref().unwrap(), expected.alpha.as_ref().unwrap());
            assert_eq!((found.size, found.gamma), (expected.size, expected.gamma));
            assert!(found.weights.iter().zip(&expected.weights).all(|(a, b)| (a - b).abs() < 1e-5));
        }
    }
}

/// Other readers ignore extensions whose name they do not know; without it the dome is not known.
#[test]
fn the_dome_is_an_extension() {
    let dome = Dome { radius: 4.5, tilt: 25f64.to_radians(), coverage: 200f64.to_radians() };
    for version in [Version::One, Version::Two] {
        let bytes = write(&Archive { dome: Some(dome), ..archive(Profile::Flat) }, version).unwrap();
        let found = read("a.mpcdi", &bytes).unwrap();
        assert!(found.notes.is_empty() && found.value.regions.len() == 2, "{:?}", found.notes);
        let found = found.value.dome.unwrap();
        assert!((found.tilt - dome.tilt).abs() + (found.coverage - dome.coverage).abs() < 1e-9 && found.radius == 4.5);
        let (name, text) = Files::open("a.mpcdi", &bytes).unwrap().description().unwrap();
        let start = text.find("  <extensionSet>").unwrap();
        let end = text.find("</MPCDI>").unwrap();
        let without = format!("{}{}", &text[..start], &text[end..]);
        assert_eq!(document::read("a.mpcdi", &name, &without).unwrap().dome, None);
        for (tilt, why) in [("nan", "tilt = \"nan\" is no number from -180 to 180"), ("", "has no tilt")] {
            let damaged = text.replace("<tilt>25<", &format!("<tilt>{tilt}<"));
            let message = document::read("a.mpcdi", &name, &damaged).err().unwrap().message;
            assert!(message.contains("<extension> ") && message.contains(why), "{message}");
        }
    }
    assert_eq!(read("a.mpcdi", &write(&archive(Profile::Flat), Version::One).unwrap()).unwrap().value.dome, None);
}

#[test]
fn version_2_and_other_cases_are_read_and_positions_are_placed_in_the_whole_picture() {
    let map = pfm::write(2, &[[0.0, 0.25, 0.0], [1.0, 0.5, 0.0]]);
    let bytes = zipped(&[("mpcdi.xml", described("a.pfm", 2).as_bytes()), ("a.pfm", &map)]);
    let region = &read("a", &bytes).unwrap().value.regions[0];
    assert_eq!(region.warp.as_ref().unwrap().values(), [[0.5, 0.25, 0.0], [1.0, 0.5, 0.0]]);
    assert_eq!(region.alpha, None);
}

#[track_caller]
fn refused(bytes: &[u8], why: &str) {
    let message = read("a.mpcdi", bytes).unwrap_err().message;
    assert!(message.starts_with("a.mpcdi") && message.contains(why), "{message}");
}

#[test]
fn hostile_archives_are_refused() {
    let map = pfm::write(2, &[[0.0; 3]; 2]);
    let with = |xml: &str, map: &[u8]| zipped(&[("mpcdi.xml", xml.as_bytes()), ("a.pfm", map)]);
    refused(b"PK", "no zip archive");
    refused(&zipped(&[("a.txt", b"")]), "no mpcdi.xml");
    refused(&with("<MPCDI", &map), "not XML");
    refused(&with("<other/>", &map), "a.mpcdi/mpcdi.xml:1: <other> is no description");
    refused(&zipped(&[("old.xml", b"<other/>")]), "a.mpcdi/old.xml:1: <other> is no description");
    for path in ["../a.pfm", "/a.pfm", "x\\a.pfm", "C:a.pfm"] {
        refused(&with(&described(path, 2), &map), "leads out of the archive");
    }
    refused(&with(&described("b.pfm", 2), &map), "a.mpcdi/b.pfm: cannot be unpacked");
    refused(&with(&described("a.pfm", u32::MAX), &map), "pixels altogether");
    // A zip bomb: 8 MiB of zeroes in a few kilobytes.
    refused(&with(&described("a.pfm", 2), &vec![0; 8 << 20]), "unpacks to more than");
    let sl = described("a.pfm", 2).replace("\"2d\"", "\"sl\"");
    refused(&with(&sl, &map), "has no frustum");
    let angles = |left: f64| {
        let angle = |name: &str, angle: f64| format!("<{name}>{angle}</{name}>");
        let sides = [("leftAngle", left), ("rightAngle", 20.0), ("downAngle", -10.0), ("upAngle", 10.0)];
        let turns = ["yaw", "pitch", "roll"].map(|name| angle(name, 0.0)).concat();
        format!("><frustum>{}{turns}</frustum></region>", sides.map(|(name, side)| angle(name, side)).concat())
    };
    let frustum = |left: f64| sl.replacen("/></buffer>", &format!("{}</buffer>", angles(left)), 1);
    assert!(read("a.mpcdi", &with(&frustum(-20.0), &map)).is_ok());
    refused(&with(&frustum(30.0), &map), "opens from 30° to 20°");
    let entities = "<!DOCTYPE a [<!ENTITY x \"y\">]><MPCDI profile=\"2d\" version=\"1.0\">&x;</MPCDI>";
    refused(&with(entities, &map), "not XML");
}

/// Regions may share one file: the bound is on what they contain together.
#[test]
fn the_pixels_of_all_regions_are_bounded() {
    let map = pfm::write(2, &[[0.0; 3]; 2]);
    let one = described("a.pfm", 2);
    let region = |text: &str| {
        let start = text.find("<region").unwrap();
        text[start..text.find("/></buffer>").unwrap() + 2].to_owned()
    };
    let many = one.replacen("</buffer>", &format!("{}</buffer>", region(&one).repeat(9)), 1);
    let bytes = zipped(&[("mpcdi.xml", many.as_bytes()), ("a.pfm", &map)]);
    assert_eq!(read_within("a.mpcdi", &bytes, 20).unwrap().value.regions.len(), 10);
    let message = read_within("a.mpcdi", &bytes, 19).unwrap_err().message;
    assert!(message.contains("more than 19 pixels"), "{message}");
}

/// A PNG whose header promises more than a file of its length can contain, and a valid one.
#[test]
fn pictures_are_refused_by_their_header() {
    let mut png = Vec::new();
    let black = image::GrayImage::new(1, 1);
    black.write_to(&mut Cursor::new(&mut png), image::ImageFormat::Png).unwrap();
    // Sets the size, and the checksum of its chunk of the file.
    png[16..24].copy_from_slice(&[0, 0, 0xff, 0xff, 0, 0, 0xff, 0xff]);
    let sum = crc32(&png[12..29]);
    png[29..33].copy_from_slice(&sum.to_be_bytes());
    let message = levels::read_png("a.png", &png).unwrap_err().message;
    assert!(message.contains("65535 × 65535 pixels; expected 1 to"), "{message}");
}

/// Checksum of PNG chunks.
fn crc32(bytes: &[u8]) -> u32 {
    let step = |sum: u32, byte: &u8| {
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| if sum & 1 == 1 { sum >> 1 ^ 0xEDB8_8320 } else { sum >> 1 })
    };
    !bytes.iter().fold(u32::MAX, step)
}

/// A description alone, as Christie's Mystique writes it (z up, no files), with one region that has
/// the lens `lens`.
fn alone(lens: &str) -> Vec<u8> {
    let text = |name: &str, value: f64| format!("<{name}>{value}</{name}>");
    let vector = |name: &str, [x, y, z]: [f64; 3]| {
        [("x", x), ("y", y), ("z", z)].map(|(axis, value)| text(&format!("{name}{axis}"), value)).concat()
    };
    let frame = vector("pos", [0.6, -0.5, -0.4])
        + &vector("yaw", [0.0, 0.0, -1.0])
        + &vector("pitch", [1.0, 0.0, 0.0])
        + &vector("roll", [0.0, 1.0, 0.0]);
    // Such writers put these angles there for a fisheye; they have no meaning.
    let sides = [("leftAngle", 89.795), ("rightAngle", 89.7957), ("downAngle", 89.8275), ("upAngle", 89.828)];
    let turns = [("yaw", -45.0), ("pitch", 20.0), ("roll", -30.0)];
    let frustum = sides.iter().chain(&turns).map(|(name, value)| text(name, *value)).collect::<String>();
    format!(
        "<?xml version=\"1.0\" encoding=\"utf-8\"?>\n<MPCDI profile=\"sl\" geometry=\"2\" color=\"1\" version=\"2.0\"><display><buffer id=\"b\">\
         <region id=\"r 1\" xResolution=\"1400\" yResolution=\"1050\" x=\"0\" y=\"0\" xsize=\"1\" ysize=\"1\"><frustum>{frustum}</frustum>\
         <coordinateFrame>{frame}</coordinateFrame></region></buffer></display><files><fileset region=\"r 1\"><geometryWarpFile><path></path>\
         </geometryWarpFile><alphaMap><gammaEmbedded>1.0</gammaEmbedded><path></path></alphaMap></fileset></files><extensionSet>\
         <extension Name=\"BufferExtension\" hasExternalFiles=\"false\"><buffer id=\"b\"><region id=\"r 1\">{lens}</region></buffer></extension>\
         <extension Name=\"MystiqueExtension\"><GeneratedBy>x</GeneratedBy></extension></extensionSet></MPCDI>"
    )
    .into_bytes()
}

fn polynomial(factors: [f64; 4]) -> String {
    let of = |name: &str, value: f64| format!("<{name}>{value}</{name}>");
    let offsets = of("horizontalOffset", 0.2) + &of("verticalOffset", 0.3);
    let factors =
        ["f1", "f3", "f5", "f7"].iter().zip(factors).map(|(name, factor)| of(name, factor)).collect::<String>();
    format!("<fisheye>{offsets}{factors}</fisheye><anamorphic><ratio>1.3</ratio><angle>0</angle></anamorphic>")
}

#[test]
fn a_fisheye_is_read_in_radians_or_in_degrees_and_turned_out_of_its_frame() {
    let degree = 1f64.to_radians();
    let radians = [0.5, -0.02, 0.003, -1e-4];
    let in_degrees =
        [radians[0] * degree, radians[1] * degree.powi(3), radians[2] * degree.powi(5), radians[3] * degree.powi(7)];
    for (factors, word) in [(radians, "radians"), (in_degrees, "degrees")] {
        let found = read("a.xml", &alone(&polynomial(factors))).unwrap();
        assert!(found.notes.iter().any(|note| note.contains(&format!("taken as {word}"))), "{:?}", found.notes);
        assert!(found.notes.iter().any(|note| note.contains("MystiqueExtension")), "{:?}", found.notes);
        let region = &found.value.regions[0];
        assert!(region.warp.is_none() && region.camera.is_none() && region.alpha.is_none());
        let optics = region.fisheye.as_ref().unwrap();
        // z up, y forward becomes y up, −z forward.
        assert!(optics.pose.position.distance(DVec3::new(0.6, -0.4, 0.5)) < 1e-12, "{}", optics.pose.position);
        let turned = pose::rotation(-45f64.to_radians(), 20f64.to_radians(), -30f64.to_radians());
        assert!(optics.pose.rotation.abs_diff_eq(turned, 1e-12));
        // By hand: the axis lies left of the middle by 0.2 half widths and below it by 0.3 half
        // heights; pixels are higher than wide by 1.3.
        let ray = |x: f64, y: f64| optics.lens.ray(glam::DVec2::new(x, y), 4.0 / 3.0).unwrap();
        assert!(ray(-0.2, -0.3).normalize().distance(DVec3::NEG_Z) < 1e-12);
        let angle = 0.7f64;
        let radius = angle * (0.5 + angle.powi(2) * (-0.02 + angle.powi(2) * (0.003 - 1e-4 * angle.powi(2))));
        assert!(ray(-0.2 + radius, -0.3).normalize().distance(DVec3::new(angle.sin(), 0.0, -angle.cos())) < 1e-9);
        let up = ray(-0.2, -0.3 + radius * 4.0 / 3.0 / 1.3).normalize();
        assert!(up.distance(DVec3::new(0.0, angle.sin(), -angle.cos())) < 1e-9, "{up}");
    }
}

#[test]
fn the_angle_of_a_squeeze_is_told_with_what_it_may_move() {
    use glam::{DMat2, DVec2};
    let notes = |ratio: &str, angle: &str| {
        let lens = polynomial([0.5, 0.0, 0.0, 0.0]).replace("<angle>0<", &format!("<angle>{angle}<"));
        let found = read("a.xml", &alone(&lens.replace("1.3", ratio))).unwrap();
        found.notes.into_iter().find(|note| note.contains("angle of its anamorphic lens"))
    };
    for (ratio, angle) in [(1.3, 10.0), (0.75, -3.5), (2.0, 90.0), (1.0, 20.0)] {
        // The rim is 0.5 · π/2 half widths of 700 pixels from the axis; with turned axes of the
        // squeeze its position differs.
        let squeeze = DMat2::from_diagonal(DVec2::new(1.0, 1.0 / ratio));
        let turn = DMat2::from_angle(f64::to_radians(angle));
        let rim = (0..3600)
            .map(|i| DVec2::from_angle(f64::from(i).to_radians() / 10.0) * 0.25 * std::f64::consts::PI * 700.0);
        let moved = rim.map(|at| (turn * squeeze * turn.transpose() * at).distance(squeeze * at)).fold(0.0, f64::max);
        let note = notes(&ratio.to_string(), &angle.to_string()).expect("a note");
        assert!(note.contains(&format!("lens, {angle}, is not taken over")), "{note}");
        assert!(note.contains(&format!("up to {moved:.1} pixels")), "{moved}: {note}");
    }
    assert_eq!(notes("1.3", "0"), None);
}

#[test]
fn what_is_written_of_a_fisheye_is_read_back() {
    use crate::geom::{Circle, FisheyeLens, Lens, Optics, Pose, Projection};
    let projections = [Projection::Equidistant, Projection::Polynomial([2.0, -0.05, 0.002, -0.0001])];
    let circles =
        [Circle::Inscribed, Circle::Placed { center: glam::DVec2::new(0.1, -0.4), half: glam::DVec2::new(1.2, 1.5) }];
    for ((projection, circle), aperture) in projections.into_iter().zip(circles).zip([3.0, 3.6]) {
        let lens = Lens::Fisheye { lens: FisheyeLens { projection, aperture }, circle };
        let optics = Optics { pose: Pose::new(DVec3::new(1.0, -2.0, 0.5), 0.5, -0.3, 0.2), lens, mirror: None };
        let mut expected = archive(Profile::ShaderLamps);
        for region in &mut expected.regions {
            (region.camera, region.fisheye) = (None, Some(optics.clone()));
        }
        let found = read("a.mpcdi", &write(&expected, Version::One).unwrap()).unwrap();
        assert_eq!(found.notes, Vec::<String>::new());
        for region in &found.value.regions {
            let found = region.fisheye.as_ref().unwrap();
            for (x, y) in [(0.0, 0.0), (0.3, 0.2), (-0.5, 0.6), (0.9, -0.9), (1.0, 1.0)] {
                let at = glam::DVec2::new(x, y);
                let rays = [found, &optics].map(|optics| optics.ray(at, 1.5).map(|(_, ray)| ray.normalize()));
                match rays {
                    [Some(a), Some(b)] => assert!(a.distance(b) < 1e-9, "{at}: {a} {b}"),
                    rays => assert_eq!(rays, [None, None], "{at}"),
                }
            }
        }
    }
    // The format cannot describe this lens.
    let mut wrong = archive(Profile::ShaderLamps);
    let lens = FisheyeLens { projection: Projection::Equisolid, aperture: 3.0 };
    let lens = Lens::Fisheye { lens, circle: Circle::Inscribed };
    wrong.regions[0].fisheye = Some(Optics { pose: Pose::new(DVec3::ZERO, 0.0, 0.0, 0.0), lens, mirror: None });
    assert!(write(&wrong, Version::One).unwrap_err().message.contains("no words for its lens"));
}

#[test]
fn a_fisheye_that_fits_neither_unit_is_told_and_damage_is_refused() {
    // Numbers from one of Christie's own files.
    let message = read("a.xml", &alone(&polynomial([75.0, 0.0, 0.0, 0.0]))).unwrap_err().message;
    assert!(message.contains("is not taken over") && message.contains("117.8097"), "{message}");
    assert!(read("a.xml", &alone(&polynomial([0.5, -0.3, 0.0, 0.0]))).is_err(), "it folds");
    for (lens, why) in [
        (polynomial([0.5, f64::NAN, 0.0, 0.0]), "f3 = \"NaN\""),
        (polynomial([1e300, 0.0, 0.0, 0.0]), "is no number from"),
        (polynomial([0.5; 4]).replace("0.2", "inf"), "horizontalOffset"),
        (polynomial([0.5; 4]).replace("1.3", "0"), "ratio"),
    ] {
        let message = read("a.xml", &alone(&lens)).unwrap_err().message;
        assert!(message.starts_with("a.xml:2: <") && message.contains(why), "{message}");
    }
    // Without its archive a description has no files.
    let text = String::from_utf8(alone(&polynomial([0.5, 0.0, 0.0, 0.0]))).unwrap();
    let with_file = text.replace("<path></path>", "<path>a.file</path>");
    assert!(read("a.xml", with_file.as_bytes()).unwrap_err().message.contains("without its archive"));
    let flat = text.replace("\"sl\"", "\"2d\"");
    assert!(read("a.xml", flat.as_bytes()).unwrap_err().message.contains("no geometryWarpFile"));
    for end in (0..text.len()).step_by(7) {
        let _ = read("a.xml", &text.as_bytes()[..end]);
    }
}
