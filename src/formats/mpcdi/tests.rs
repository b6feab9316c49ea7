use super::*;
use crate::geom::{Frustum, pose};
use glam::DVec3;
use std::io::{Cursor, Write};

fn archive(profile: Profile) -> Archive {
    let region = |id: &str| {
        let values = (0..6).map(|i| if i == 4 { [f32::NAN; 3] } else { [i as f32 * 0.125, 0.5, 0.0] }).collect();
        let alpha = Alpha { size: (3, 2), weights: vec![0.0, 0.25, 0.5, 0.75, 1.0, 1.0], gamma: 2.2 };
        let beta = Levels { size: (2, 1), levels: vec![0.0, 0.125] };
        let camera = Camera {
            offset: if profile == Profile::ShaderLamps { DVec3::new(1.0, -2.0, 0.5) } else { DVec3::ZERO },
            rotation: pose::rotation(0.5, -0.3, 0.2),
            frustum: Frustum { left: -0.5, right: 0.25, bottom: -0.125, top: 1.0 },
        };
        Region {
            id: id.into(),
            size: (3, 2),
            warp: Raster::new((3, 2), values).unwrap(),
            alpha: Some(alpha),
            beta: (id == "left").then_some(beta),
            camera: profile.has_cameras().then_some(camera),
        }
    };
    Archive { profile, regions: vec![region("left"), region("\"right\" & <up>")] }
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

/// A description with one region of the size, whose map is `path`.
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
            assert!(found.warp.values().iter().zip(expected.warp.values()).all(same));
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
                assert!((found.levels[1] - expected.levels[1]).abs() < 1e-5);
            }
            let (found, expected) = (found.alpha.as_ref().unwrap(), expected.alpha.as_ref().unwrap());
            assert_eq!((found.size, found.gamma), (expected.size, expected.gamma));
            assert!(found.weights.iter().zip(&expected.weights).all(|(a, b)| (a - b).abs() < 1e-5));
        }
    }
}

#[test]
fn version_2_and_other_cases_are_read_and_positions_are_placed_in_the_whole_picture() {
    let map = pfm::write(2, &[[0.0, 0.25, 0.0], [1.0, 0.5, 0.0]]);
    let bytes = zipped(&[("mpcdi.xml", described("a.pfm", 2).as_bytes()), ("a.pfm", &map)]);
    let region = &read("a", &bytes).unwrap().value.regions[0];
    assert_eq!(region.warp.values(), [[0.5, 0.25, 0.0], [1.0, 0.5, 0.0]]);
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
    for path in ["../a.pfm", "/a.pfm", "x\\a.pfm", "C:a.pfm"] {
        refused(&with(&described(path, 2), &map), "leads out of the archive");
    }
    refused(&with(&described("b.pfm", 2), &map), "a.mpcdi/b.pfm: cannot be unpacked");
    refused(&with(&described("a.pfm", u32::MAX), &map), "pixels altogether");
    // A bomb: 8 MiB of nothing in a few kilobytes.
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
