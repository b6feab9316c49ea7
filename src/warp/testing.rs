//! Rigs for the tests of the mathematical modules, made without files.

use crate::geom::Frustum;
use crate::rig::*;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};

/// An output of a kind, with overlap blending and a ramp of a tenth of the picture.
pub(crate) fn output(name: &str, kind: OutputKind) -> Output {
    let blend = Blend { overlap: true, ramp: 0.1, ..Blend::default() };
    Output {
        name: name.into(),
        kind,
        method: Default::default(),
        size: None,
        window: None,
        blend,
        mask: None,
        black: None,
        eye: 0.0,
        flip: Flip::default(),
        publish: false,
        shown: true,
        own_window: None,
        node: None,
        here: true,
    }
}

/// A rig with a hemispherical dome of 5 m, its pole `tilt` towards the front, and the viewer at
/// `position`.
pub(crate) fn rig(tilt: f64, position: DVec3, kinds: &[OutputKind]) -> Rig {
    Rig {
        name: "test".into(),
        passthrough: false,
        dome: Dome { radius: 5.0, tilt, coverage: PI },
        screen: None,
        viewer: Viewer { position, yaw: 0.0, pitch: 0.0, roll: 0.0 },
        camera: Camera::default(),
        views: Views::default(),
        content: None,
        overlay: Overlay { yaw: 0.0, pitch: 0.0, width: 1.0 },
        outputs: kinds
            .iter()
            .enumerate()
            .map(|(index, kind)| output(&format!("output-{index}"), kind.clone()))
            .collect(),
        beside: Vec::new(),
        window: crate::rig::WindowSwaps::default(),
    }
}

/// A projector with openings in degrees, aimed by yaw and pitch in degrees.
pub(crate) fn projector(position: DVec3, yaw: f64, pitch: f64, fov: (f64, f64)) -> OutputKind {
    OutputKind::Projector {
        position,
        angles: [yaw.to_radians(), pitch.to_radians(), 0.0],
        frustum: Frustum::symmetric(fov.0.to_radians(), fov.1.to_radians()),
    }
}

/// Two projectors that overlap in front of the viewer, on a dome whose pole is straight ahead.
pub(crate) fn two_projectors(position: DVec3) -> Rig {
    let left = projector(DVec3::new(-1.0, -0.5, 2.0), -14.0, 10.0, (70.0, 50.0));
    let right = projector(DVec3::new(1.2, -0.4, 1.8), 14.0, 8.0, (70.0, 50.0));
    rig(FRAC_PI_2, position, &[left, right])
}
