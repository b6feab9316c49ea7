//! Damaged files: reading them must not panic, and each error names the file.

use super::random::Random;
use super::*;

/// Makes one to four changes: a byte, a bit, a large number, a piece that is cut out, doubled or
/// replaced, or the end cut off.
fn damaged(good: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = good.to_vec();
    for _ in 0..=random.below(4) {
        if bytes.is_empty() {
            break;
        }
        // Headers are short and important, so half of the changes are there.
        let reach = if random.below(2) == 0 { bytes.len().min(64) } else { bytes.len() };
        let at = random.below(reach);
        let end = (at + 1 + random.below(16)).min(bytes.len());
        match random.below(7) {
            0 => bytes[at] = random.bits() as u8,
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

/// Damages `good` in many ways. Reading must not panic, and each error must name the file.
fn survives(good: &[u8], read: impl Fn(&[u8]) -> cupola::Result<()>) {
    read(good).expect("the undamaged file is good");
    let (mut random, mut refused) = (Random::new(7), 0);
    for _ in 0..4000 {
        if let Err(error) = read(&damaged(good, &mut random)) {
            assert!(error.message.starts_with("some.file") && error.message.len() < 600, "{}", error.message);
            refused += 1;
        }
    }
    // Most damage is detected. The rest changed a number into another valid number.
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

#[test]
fn damaged_easyblend_meshes_do_no_harm() {
    survives(EASYBLEND.as_bytes(), |bytes| easyblend::read("some.file", bytes).map(drop));
}

#[test]
fn damaged_domeprojection_meshes_do_no_harm() {
    survives(DOMEPROJECTION.as_bytes(), |bytes| domeprojection::read("some.file", bytes).map(drop));
}

#[test]
fn damaged_vioso_files_do_no_harm() {
    let map =
        vwf::VwfMap { name: "one".into(), points: false, raster: raster(), blend: None, black: None, white: None };
    survives(&vwf::write(&[map]).unwrap(), |bytes| vwf::read("some.file", bytes).map(drop));
}

#[test]
fn damaged_archives_do_no_harm() {
    survives(&mpcdi::write(&archive(), mpcdi::Version::Two).unwrap(), |bytes| {
        mpcdi::read("some.file", bytes).map(drop)
    });
}

#[test]
fn damaged_configurations_do_no_harm() {
    let text = r#"{ "nodes": [{ "address": "a", "windows": [{ "pos": { "x": 5, "y": 7 }, "size": { "x": 200, "y": 100 }, "viewports": [
        { "size": { "x": 0.5, "y": 1 }, "projection": { "type": "FisheyeProjection", "fov": 170, "tilt": 30 } },
        { "pos": { "x": 0.5, "y": 0 }, "size": { "x": 0.5, "y": 1 }, "eye": "right", "mesh": "some.sgc", "projection": {
            "type": "PlanarProjection", "fov": { "hfov": 90, "vfov": 60 }, "orientation": { "yaw": 20, "pitch": 5, "roll": -3 } } }
        ] }] }], "users": [{ "pos": { "x": 0, "y": 0, "z": 4 } }] }"#;
    survives(text.as_bytes(), |bytes| sgct::read("some.file", bytes).map(drop));
}
