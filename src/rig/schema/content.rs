//! `[content]`: the window of a program that projects its picture by itself.

use super::{ROLL, TILT, YAW, angles, lens, output};
use crate::geom::{Panorama, Region};
use crate::rig::Dome;
use crate::rig::model::content::{Content, ContentKind, Stereo};
use crate::rig::reading::allowed::Allowed;
use crate::rig::reading::problems::Problems;
use crate::rig::reading::reader::Section;
use glam::DVec2;
use std::f64::consts::FRAC_PI_2;

#[derive(Clone, Copy)]
enum Kind {
    Domemaster,
    Equirectangular,
    Cylindrical,
    Cubemap,
    Flat,
}

const KINDS: [(&str, Kind); 5] = [
    ("domemaster", Kind::Domemaster),
    ("equirectangular", Kind::Equirectangular),
    ("cylindrical", Kind::Cylindrical),
    ("cubemap", Kind::Cubemap),
    ("flat", Kind::Flat),
];

/// Kind to which each key belongs, for users who give a key to another kind.
const KINDS_OF_KEYS: [(&str, &str); 7] = [
    ("aperture", "kind = \"domemaster\""),
    ("projection", "kind = \"domemaster\""),
    ("coefficients", "kind = \"domemaster\""),
    ("tilt", "kind = \"domemaster\""),
    ("pitch", "the other kinds; a domemaster has `tilt`"),
    ("width", "kind = \"equirectangular\", \"cylindrical\" or \"flat\""),
    ("latitudes", "kind = \"equirectangular\" or \"cylindrical\""),
];

const PANEL: Allowed = Allowed::between(0.0, 180.0, "the angle in degrees that the picture's width fills");
const PART: Allowed =
    Allowed::closed(0.0, 1.0, "[x, y, width, height] as parts of the window, x and y from its top left");
/// Least width and height of a part of the window. A smaller part has hardly any pixels.
const LEAST_PART: f64 = 1e-3;

pub(super) fn content(mut section: Section, dome: &Dome, problems: &mut Problems) -> Option<Content> {
    if !section.has("kind") {
        let words = KINDS.map(|(word, _)| format!("\"{word}\"")).join(", ");
        problems.add(&section.path("kind"), format!("is missing; expected one of kind = {words}"));
    }
    let kind = section.choice("kind", &KINDS, problems)?;
    let (angles, kind) = match kind {
        Kind::Domemaster => {
            let [yaw, roll] = [("yaw", &YAW), ("roll", &ROLL)]
                .map(|(key, allowed)| section.number(key, allowed, 0.0, problems).to_radians());
            let tilt = section.number("tilt", &TILT, dome.tilt.to_degrees(), problems).to_radians();
            ([yaw, FRAC_PI_2 - tilt, roll], {
                let lens = lens::formula_fisheye(&mut section, dome.coverage.to_degrees(), problems);
                lens.map(|lens| ContentKind::Directions(Panorama::Fisheye(lens)))
            })
        }
        Kind::Flat => {
            let width = section.number("width", &PANEL, 60.0, problems).to_radians();
            (angles(&mut section, problems), Some(ContentKind::Flat { width }))
        }
        Kind::Equirectangular | Kind::Cylindrical | Kind::Cubemap => {
            let panorama = match kind {
                Kind::Equirectangular => output::span(&mut section, 90.0, problems).map(Panorama::Equirectangular),
                Kind::Cylindrical => output::span(&mut section, 45.0, problems).map(Panorama::Cylindrical),
                _ => Some(Panorama::CubeStrip),
            };
            (angles(&mut section, problems), panorama.map(ContentKind::Directions))
        }
    };
    let region = region(&mut section, problems);
    let stereo = section.choice_or("stereo", &Stereo::WORDS, Stereo::default(), problems);
    section.finish(&KINDS_OF_KEYS, problems);
    kind.map(|kind| Content { kind, angles, region, stereo })
}

fn region(section: &mut Section, problems: &mut Problems) -> Option<Region> {
    let [x, y, width, height] = section.numbers::<4>("region", &PART, problems)?;
    if width < LEAST_PART || height < LEAST_PART || x + width > 1.0 + 1e-9 || y + height > 1.0 + 1e-9 {
        let why = "does not lie in the window; expected [x, y, width, height], x + width and y + height at most 1";
        problems.add(&section.path("region"), why);
        return None;
    }
    Some(Region { origin: DVec2::new(x, 1.0 - y - height), size: DVec2::new(width, height) })
}
