//! `[[output]]`: what every output has, and what each kind has of its own.

use super::{METRES, OPENING, TILT, angles, blend, lens};
use crate::geom::{Lens, Optics, Pose, Sphere};
use crate::rig::problems::Problems;
use crate::rig::reader::{Allowed, Section};
use crate::rig::{Dome, Output, OutputKind};
use glam::DVec3;
use std::path::Path;

/// Greatest width and height of a picture in pixels: the greatest texture of today's graphics hardware.
const LARGEST_PICTURE: u32 = 16384;
/// Greatest coordinate in a window: the X protocol's.
const LARGEST_WINDOW: u32 = 32767;

/// Where the keys of one kind of output belong, for those who give them to another kind.
const KINDS_OF_KEYS: [(&str, &str); 10] = [
    ("aperture", "kind = \"domemaster\""),
    ("tilt", "kind = \"domemaster\" (and to [dome])"),
    ("position", "kind = \"projector\" (and to [viewer])"),
    ("shift", "kind = \"projector\" or \"perspective\", beside fov"),
    ("fisheye", "kind = \"projector\""),
    ("distortion", "kind = \"projector\""),
    ("mirror", "kind = \"projector\""),
    ("even_light", "kind = \"projector\""),
    ("fov", "kind = \"projector\" or \"perspective\""),
    ("lens", "kind = \"perspective\""),
];

/// What `kind` says.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Kind {
    Domemaster,
    Projector,
    Perspective,
}

pub(super) fn output(
    mut section: Section,
    index: usize,
    dome: &Dome,
    directory: &Path,
    problems: &mut Problems,
) -> Option<Output> {
    let kinds = [("domemaster", Kind::Domemaster), ("projector", Kind::Projector), ("perspective", Kind::Perspective)];
    if !section.has("kind") {
        let path = section.path("kind");
        problems.add(&path, "is missing; expected kind = \"domemaster\", \"projector\" or \"perspective\"");
    }
    let kind = section.choice("kind", &kinds, problems)?;
    let name =
        section.text("name", "the output's name", problems).map_or(format!("output-{}", index + 1), str::to_owned);
    let sides = [(1, LARGEST_PICTURE); 2];
    let size =
        section.pixels("size", sides, "[width, height] in pixels", problems).map(|[width, height]| (width, height));
    let places = [(0, LARGEST_WINDOW), (0, LARGEST_WINDOW), (1, LARGEST_PICTURE), (1, LARGEST_PICTURE)];
    let window =
        section.pixels("window", places, "[x, y, width, height] in pixels from the window's top left", problems);
    let output_kind = match kind {
        Kind::Domemaster => Some(OutputKind::Domemaster {
            aperture: section.number("aperture", &OPENING, dome.coverage.to_degrees(), problems).to_radians(),
            tilt: section.number("tilt", &TILT, dome.tilt.to_degrees(), problems).to_radians(),
        }),
        Kind::Projector => {
            let position = section.vector("position", &METRES, problems);
            let angles = angles(&mut section, problems);
            projector(&mut section, position, angles, problems)
        }
        Kind::Perspective => {
            let angles = angles(&mut section, problems);
            lens::perspective_frustum(&mut section, problems).map(|frustum| OutputKind::Perspective { angles, frustum })
        }
    };
    let blend = blend::blend(section.section("blend", problems), kind, problems);
    let mask = blend::mask(section.section("mask", problems), directory, problems);
    section.finish(&KINDS_OF_KEYS, problems);
    output_kind.map(|kind| Output { name, kind, size, window, blend, mask })
}

/// A projector: the plain pinhole where the file says no more than its opening.
fn projector(section: &mut Section, position: DVec3, angles: [f64; 3], problems: &mut Problems) -> Option<OutputKind> {
    let special = ["fisheye", "distortion", "mirror", "even_light"].iter().any(|key| section.has(key));
    let lens = lens::projector_lens(section, problems);
    let mirror = section.section("mirror", problems).map(|section| mirror(section, problems));
    let allowed = Allowed::closed(0.0, 1.0, "how far the light is evened out");
    let even_light = section.number("even_light", &allowed, 0.0, problems);
    let plain = match lens? {
        Lens::Pinhole { frustum, .. } if !special => return Some(OutputKind::Projector { position, angles, frustum }),
        lens => lens,
    };
    let [yaw, pitch, roll] = angles;
    let optics = Optics { pose: Pose::new(position, yaw, pitch, roll), lens: plain, mirror };
    Some(OutputKind::Optics { optics, even_light })
}

/// A convex spherical mirror.
fn mirror(mut section: Section, problems: &mut Problems) -> Sphere {
    let center = section.vector("center", &METRES, problems);
    let radius = section.required_number("radius", &Allowed::above(0.0, 1e6, "a radius in metres"), problems);
    section.finish(&[], problems);
    Sphere { center, radius }
}
