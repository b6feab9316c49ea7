//! `[output.blend]` and `[output.mask]`: how bright an output is where.

use super::output::Kind;
use crate::rig::problems::Problems;
use crate::rig::reader::{Allowed, Section};
use crate::rig::{AngleRamp, Blend, DomeAngle};
use std::path::{Path, PathBuf};

pub(super) fn blend(section: Option<Section>, kind: Kind, problems: &mut Problems) -> Blend {
    let overlap = kind == Kind::Projector;
    let mut blend = Blend { overlap, ramp: 0.25, ramps: Vec::new(), gamma: 2.2, black_level: 0.0 };
    let Some(mut section) = section else { return blend };
    blend.overlap = section.boolean("overlap", overlap, problems);
    if blend.overlap && kind != Kind::Projector {
        let path = section.path("overlap");
        problems.add(&path, "only projectors overlap on the screen; leave it out here, or use `ramps`");
    }
    let ramp = Allowed::above(0.0, 0.5, "a part of the picture's width and height");
    blend.ramp = section.number("ramp", &ramp, 0.25, problems);
    blend.gamma =
        section.number("gamma", &Allowed::closed(1.0, 4.0, "the exponent of the display's response"), 2.2, problems);
    let black = Allowed::below(0.0, 1.0, "light added to black, as a part of white");
    blend.black_level = section.number("black_level", &black, 0.0, problems);
    let example = "ramps = [{ angle = \"polar\", zero = 90, full = 80 }]";
    blend.ramps = section
        .sections("ramps", example, problems)
        .into_iter()
        .filter_map(|ramp| angle_ramp(ramp, problems))
        .collect();
    section.finish(&[("image", "[output.mask]")], problems);
    blend
}

fn angle_ramp(mut section: Section, problems: &mut Problems) -> Option<AngleRamp> {
    if !section.has("angle") {
        problems.add(&section.path("angle"), "is missing; expected angle = \"polar\" or \"azimuth\"");
    }
    let angle = section.choice("angle", &[("polar", DomeAngle::Polar), ("azimuth", DomeAngle::Azimuth)], problems)?;
    let allowed = match angle {
        DomeAngle::Polar => Allowed::closed(0.0, 180.0, "an angle in degrees from the dome's pole"),
        DomeAngle::Azimuth => {
            Allowed::closed(-180.0, 180.0, "an angle in degrees around the pole, 0 = front, to the right")
        }
    };
    let zero = section.required_number("zero", &allowed, problems);
    let full = section.required_number("full", &allowed, problems);
    if section.has("zero") && zero == full {
        problems.add(&section.path("full"), format!("{full} is also `zero`; the ramp needs a width"));
    }
    section.finish(&[], problems);
    Some(AngleRamp { angle, zero: zero.to_radians(), full: full.to_radians() })
}

pub(super) fn mask(section: Option<Section>, directory: &Path, problems: &mut Problems) -> Option<PathBuf> {
    let mut section = section?;
    if !section.has("image") {
        problems
            .add(&section.path("image"), "is missing; expected the name of a grey PNG file, relative to the rig file");
    }
    let image = section.text("image", "the name of a grey PNG file", problems);
    let path = image.and_then(|image| match std::path::absolute(directory.join(image)) {
        Ok(path) if !image.is_empty() => Some(path),
        _ => {
            problems.add(&section.path("image"), "the name is empty; expected that of a grey PNG file");
            None
        }
    });
    section.finish(&[], problems);
    path
}
