//! `[views]` and `[overlay]`: choice of the views, and the flat panel.

use super::{PITCH, YAW};
use crate::rig::reading::allowed::Allowed;
use crate::rig::reading::problems::Problems;
use crate::rig::reading::reader::Section;
use crate::rig::{Defaults, Duplicate, Favour, Filter, Overlay, Resolution, ViewMethod, Views};
use glam::DVec3;
use std::f64::consts::FRAC_1_SQRT_2;

/// Greatest number of cells. More views would cost more than the faces of a cube in any rig.
const MOST_CELLS: usize = 24;

/// Cells of a cube with an upright edge in front of the viewer: a hemisphere needs four of them
/// (Bourke 2009).
const ROTATED_CUBE: [DVec3; 6] = [
    DVec3::new(-FRAC_1_SQRT_2, 0.0, -FRAC_1_SQRT_2),
    DVec3::new(FRAC_1_SQRT_2, 0.0, -FRAC_1_SQRT_2),
    DVec3::Y,
    DVec3::NEG_Y,
    DVec3::new(-FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2),
    DVec3::new(FRAC_1_SQRT_2, 0.0, FRAC_1_SQRT_2),
];

/// Absent keys that a profile can have too take the profile's values.
pub(super) fn views(section: Option<Section>, profile: &Defaults, problems: &mut Problems) -> Views {
    let mut views = Views { favour: profile.favour, duplicate: profile.duplicate, ..Views::default() };
    let Some(mut section) = section else { return views };
    // The method, and the cells that it stands for if the file has none.
    let methods = [
        ("auto", (ViewMethod::Auto, &[][..])),
        ("cube", (ViewMethod::Cube, &[])),
        ("single", (ViewMethod::Single, &[])),
        ("rotated-cube", (ViewMethod::Cube, &ROTATED_CUBE)),
    ];
    let (method, cells) = section.choice_or("method", &methods, (ViewMethod::Auto, &[]), problems);
    views.method = method;
    let allowed = Allowed::closed(0.1, 8.0, "a factor on the views' resolution");
    views.quality = section.number("quality", &allowed, 1.0, problems);
    let filters = [
        ("bilinear", Filter::Bilinear),
        ("catmull-rom", Filter::CatmullRom),
        ("bilinear-4", Filter::Bilinear4),
        ("catmull-rom-4", Filter::CatmullRom4),
    ];
    views.filter = section.choice_or("filter", &filters, Filter::Bilinear, problems);
    views.favour = favour(&mut section, profile.favour, problems);
    let resolutions = [("nominal", Resolution::Nominal), ("full", Resolution::Full)];
    views.resolution = section.choice_or("resolution", &resolutions, Resolution::Nominal, problems);
    let allowed = Allowed::closed(-1e3, 1e3, "a vector in the viewer's axes for each view");
    views.cells = section.vectors("cells", MOST_CELLS, &allowed, problems).unwrap_or_else(|| cells.to_vec());
    let allowed = Allowed::closed(0.0, 60.0, "a number of frames");
    views.warm_up = section.number("warm_up", &allowed, 0.0, problems).ceil() as usize;
    views.duplicate = duplicate(&mut section, profile.duplicate, problems);
    section.finish(&[], problems);
    views
}

pub(super) fn favour(section: &mut Section, default: Favour, problems: &mut Problems) -> Favour {
    let favours = [("balanced", Favour::Balanced), ("cpu", Favour::Processor), ("gpu", Favour::Graphics)];
    section.choice_or("favour", &favours, default, problems)
}

pub(super) fn duplicate(section: &mut Section, default: Duplicate, problems: &mut Problems) -> Duplicate {
    let duplicates = [
        ("auto", Duplicate::Auto),
        ("never", Duplicate::Never),
        ("always", Duplicate::Always),
        ("in-turn", Duplicate::InTurn),
    ];
    section.choice_or("duplicate", &duplicates, default, problems)
}

/// Absent keys have the values of `default`.
pub(super) fn overlay(section: Option<Section>, default: Overlay, problems: &mut Problems) -> Overlay {
    let mut overlay = default;
    let Some(mut section) = section else { return overlay };
    let width = Allowed::between(0.0, 180.0, "the angle in degrees that a window's width fills");
    for (key, allowed, angle) in
        [("yaw", &YAW, &mut overlay.yaw), ("pitch", &PITCH, &mut overlay.pitch), ("width", &width, &mut overlay.width)]
    {
        *angle = section.angle(key, allowed, *angle, problems);
    }
    section.finish(&[], problems);
    overlay
}
