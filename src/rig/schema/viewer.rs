//! `[viewer]` and `[camera]`: the viewer, and the adaptation of the program's camera.

use super::{METRES, PITCH, ROLL, YAW, angles};
use crate::rig::reading::allowed::Allowed;
use crate::rig::reading::problems::Problems;
use crate::rig::reading::reader::Section;
use crate::rig::{Camera, Viewer};
use glam::DVec3;

pub(super) fn viewer(section: Option<Section>, problems: &mut Problems) -> Viewer {
    let mut viewer = Viewer { position: DVec3::ZERO, yaw: 0.0, pitch: 0.0, roll: 0.0 };
    let Some(mut section) = section else { return viewer };
    viewer.position = section.vector("position", &METRES, problems);
    [viewer.yaw, viewer.pitch, viewer.roll] = angles(&mut section, problems);
    section.finish(&[], problems);
    viewer
}

/// Absent keys have the values of `default`.
pub(super) fn camera(section: Option<Section>, default: &Camera, problems: &mut Problems) -> Camera {
    let mut camera = *default;
    let Some(mut section) = section else { return camera };
    camera.zoom = section.number("zoom", &crate::rig::model::camera::ZOOM, default.zoom, problems);
    let shift = default.shift.to_array();
    camera.shift = DVec3::from_array(section.numbers_or("move", &crate::rig::model::camera::MOVE, shift, problems));
    let units = Allowed::above(0.0, 1e9, "the program's units in a metre");
    camera.units_per_meter = section.number("units_per_meter", &units, default.units_per_meter, problems);
    for (key, allowed, angle) in
        [("yaw", &YAW, &mut camera.yaw), ("pitch", &PITCH, &mut camera.pitch), ("roll", &ROLL, &mut camera.roll)]
    {
        *angle = section.angle(key, allowed, *angle, problems);
    }
    let lens = section.numbers::<2>("lens", &crate::rig::model::camera::LENS, problems);
    camera.lens = lens.map(|lens| lens.map(f64::to_radians)).or(default.lens);
    camera.answer_wide = section.boolean("answer_wide", default.answer_wide, problems);
    section.finish(&[("position", "[viewer]; the program's camera has `move`")], problems);
    camera
}
