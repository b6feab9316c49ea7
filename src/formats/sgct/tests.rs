//! Reads configurations.

use super::*;
use crate::geom::Frustum;
use glam::DMat3;

/// A configuration with one viewport.
fn text(viewport: &str) -> String {
    format!(
        r#"{{ "version": 1, "nodes": [{{ "address": "here", "windows": [{{ "pos": {{ "x": 10, "y": 20 }},
        "size": {{ "x": 400, "y": 200 }}, "viewports": [{viewport}] }}] }}],
        "users": [{{ "pos": {{ "x": 0, "y": 0, "z": 4 }} }}] }}"#
    )
}

fn only(viewport: &str) -> Viewport {
    read("a.json", text(viewport).as_bytes()).unwrap().value.nodes.remove(0).viewports.remove(0)
}

#[test]
fn parts_of_windows_are_counted_from_the_bottom() {
    let viewport = only(
        r#"{ "pos": { "x": 0.5, "y": 0.75 }, "size": { "x": 0.5, "y": 0.25 }, "mesh": "a.data", "eye": "left",
        "projection": { "type": "FisheyeProjection", "tilt": 27 } }"#,
    );
    assert_eq!(viewport.place, [210, 20, 200, 50]);
    assert_eq!((viewport.mesh.as_deref(), viewport.eye), (Some("a.data"), Some(Eye::Left)));
    let expected = Projection::Fisheye { aperture: 180f64.to_radians(), tilt: 27f64.to_radians() };
    assert_eq!(viewport.projection, expected);
}

#[test]
fn yaw_turns_right_and_angles_become_tangents() {
    let viewport = only(
        r#"{ "projection": { "type": "PlanarProjection", "fov": { "left": 45, "right": 30, "down": 10, "up": 20 },
        "orientation": { "yaw": 90, "pitch": 0, "roll": 0 } } }"#,
    );
    let Projection::Planar { rotation, frustum } = viewport.projection else { panic!("{viewport:?}") };
    assert!((rotation * DVec3::NEG_Z).distance(DVec3::X) < 1e-12);
    assert!((frustum.left + 1.0).abs() < 1e-12 && (frustum.top - 20f64.to_radians().tan()).abs() < 1e-12);
    assert!((frustum.bottom + 10f64.to_radians().tan()).abs() < 1e-12);
}

#[test]
fn a_negative_left_or_down_is_an_angle_to_the_other_side() {
    let of = |fov: &str| {
        let viewport = format!(r#"{{ "projection": {{ "type": "PlanarProjection", "fov": {{ {fov} }} }} }}"#);
        let mut read = read("a.json", text(&viewport).as_bytes()).unwrap();
        let projection = read.value.nodes.remove(0).viewports.remove(0).projection;
        let Projection::Planar { frustum, .. } = projection else { panic!("{projection:?}") };
        (frustum, read.notes)
    };
    let (frustum, notes) = of(r#""left": -10, "right": 30, "down": -5, "up": 20"#);
    let tangent = |degrees: f64| degrees.to_radians().tan();
    assert!((frustum.left - tangent(10.0)).abs() < 1e-12 && (frustum.bottom - tangent(5.0)).abs() < 1e-12);
    assert!(notes.len() == 2 && notes[0].contains("fov.left: -10 is taken as SGCT takes it"), "{notes:?}");
    assert!(notes[0].contains("10° right of the middle") && notes[1].contains("5° above the middle"), "{notes:?}");
    assert!(of(r#""left": 10, "right": 30, "down": 5, "up": 20"#).1.is_empty());
}

#[test]
fn a_plane_is_seen_from_the_user() {
    // The plane is 2 m wide and 1 m high, 2 m in front of the user, who stands at z = 4; its left
    // edge is straight ahead.
    let viewport = only(
        r#"{ "projection": { "type": "ProjectionPlane", "lowerleft": { "x": 0, "y": 0, "z": 2 },
        "upperleft": { "x": 0, "y": 1, "z": 2 }, "upperright": { "x": 2, "y": 1, "z": 2 } } }"#,
    );
    let Projection::Planar { rotation, frustum } = viewport.projection else { panic!("{viewport:?}") };
    assert!(rotation.abs_diff_eq(DMat3::IDENTITY, 1e-12));
    assert_eq!(frustum, Frustum { left: 0.0, right: 1.0, bottom: 0.0, top: 0.5 });
}

#[test]
fn a_mirror_has_four_faces_of_a_cube() {
    let viewport = only(
        r#"{ "projection": { "type": "SphericalMirrorProjection", "tilt": 15, "mesh": { "bottom": "b.data",
        "left": "l.data", "right": "r.data", "top": "t.data" } } }"#,
    );
    let Projection::Mirror { tilt, meshes } = viewport.projection else { panic!("{viewport:?}") };
    assert_eq!(meshes, ["b.data", "l.data", "r.data", "t.data"]);
    let [ahead, left, right, top] = mirror_faces(tilt).map(|face| face * DVec3::NEG_Z);
    let up = 30f64.to_radians();
    assert!(ahead.distance(DVec3::new(0.0, up.sin(), -up.cos())) < 1e-12);
    assert!(left.distance(DVec3::NEG_X) < 1e-12 && right.distance(DVec3::X) < 1e-12);
    assert!(top.distance(DVec3::new(0.0, up.cos(), up.sin())) < 1e-12);
}

#[test]
fn a_moved_plane_is_a_plane() {
    let viewport = only(
        r#"{ "projection": { "type": "PlanarProjection", "fov": { "hfov": 90, "vfov": 90 }, "distance": 2,
        "offset": { "x": 1, "y": 0, "z": 0 } } }"#,
    );
    let Projection::Planar { frustum, .. } = viewport.projection else { panic!("{viewport:?}") };
    assert!((frustum.left + 0.5).abs() < 1e-12 && (frustum.right - 1.5).abs() < 1e-12, "{frustum:?}");
}

#[test]
fn damaged_files_are_refused_with_the_key() {
    let planar = r#"{ "projection": { "type": "PlanarProjection", "fov": { "hfov": 200, "vfov": 50 } } }"#;
    for (text, why) in [
        ("{".to_owned(), "no JSON"),
        ("{}".to_owned(), "no viewports"),
        (text("{}"), "nodes[0].windows[0].viewports[0].projection is missing"),
        (text(planar), "projection.fov.hfov: is no number from"),
        (text(&planar.replace("200", "\"wide\"")), "hfov: is no number"),
        (text(r#"{ "size": { "x": 0, "y": 1 }, "projection": { "type": "x" } }"#), "no screen has"),
    ] {
        let message = read("a.json", text.as_bytes()).unwrap_err().message;
        assert!(message.starts_with("a.json: ") && message.contains(why), "{message}");
    }
}

#[test]
fn viewports_of_mirrored_windows_show_what_lies_at_their_mirrored_places() {
    let fisheye = |pos: &str, tilt: u32| {
        format!(
            r#"{{ {pos} "size": {{ "x": 0.5, "y": 1 }}, "mesh": "m{tilt}.data", "blendmask": "m{tilt}.png", "eye": "{}",
            "projection": {{ "type": "FisheyeProjection", "tilt": {tilt} }} }}"#,
            if tilt == 10 { "left" } else { "right" }
        )
    };
    let both = format!("{}, {}", fisheye("", 10), fisheye(r#""pos": { "x": 0.5, "y": 0 },"#, 20));
    let of = |flags: &str, viewports: &str| {
        let text = text(viewports).replace(r#""pos": { "x": 10"#, &format!(r#"{flags} "pos": {{ "x": 10"#));
        read("a.json", text.as_bytes()).map(|read| (read.value.nodes[0].viewports.clone(), read.notes))
    };
    let seen = |viewport: &Viewport| match &viewport.projection {
        Projection::Fisheye { tilt, .. } => tilt.to_degrees().round() as u32,
        other => panic!("{other:?}"),
    };
    let (plain, _) = of("", &both).unwrap();
    assert_eq!((seen(&plain[0]), seen(&plain[1]), plain[0].mirrored), (10, 20, [false; 2]));
    let (across, notes) = of(r#""mirrorx": true, "mirrory": false,"#, &both).unwrap();
    assert_eq!((seen(&across[0]), seen(&across[1]), across[0].mirrored), (20, 10, [true, false]));
    assert_eq!((across[0].eye, across[0].place, notes.len()), (Some(Eye::Right), plain[0].place, 0));
    // Mesh and mask belong to the place.
    assert_eq!((across[0].mesh.as_deref(), across[0].mask.as_deref()), (Some("m10.data"), Some("m10.png")));
    let (up, _) = of(r#""mirrory": true,"#, &both).unwrap();
    assert_eq!((seen(&up[0]), seen(&up[1]), up[0].mirrored), (10, 20, [false, true]));
    // There may be no viewport opposite another one.
    let whole = r#"{ "projection": { "type": "FisheyeProjection" } }"#;
    let (some, notes) = of(r#""mirrorx": true,"#, &format!("{}, {whole}", fisheye("", 10))).unwrap();
    assert!(some.len() == 1 && notes[0].contains("viewports[0] is left out"), "{notes:?}");
    let message = of(r#""mirrorx": true,"#, &fisheye("", 10)).unwrap_err().message;
    assert!(message.contains("viewports[0] is left out"), "{message}");
    let message = of(r#""mirrorx": 1,"#, &both).unwrap_err().message;
    assert!(message.contains("windows[0].mirrorx: is neither true nor false"), "{message}");
}
