//! `[output.blend]`, `[output.mask]` and `[output.black]`: brightness of an output for each pixel.

use super::output::Kind;
use super::transfer;
use crate::rig::model::black;
use crate::rig::model::black::{Black, BlackValues};
use crate::rig::reading::allowed::Allowed;
use crate::rig::reading::problems::Problems;
use crate::rig::reading::reader::Section;
use crate::rig::{AngleRamp, Blend, DomeAngle, RampShape};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Power of a ramp that gives none.
const POWER: f64 = 2.0;

pub(super) fn blend(section: Option<Section>, kind: Kind, directory: &Path, problems: &mut Problems) -> Blend {
    let overlap = kind == Kind::Projector;
    let mut blend = Blend { overlap, ..Blend::default() };
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
    blend.shape = shape(&mut section, problems);
    let exponent = Allowed::closed(1.0, 2.0, "the exponent of the picture's raw weight");
    blend.exponent = section.number("exponent", &exponent, 1.0, problems);
    blend.transfer = transfer::transfer(&mut section, directory, problems);
    let contrast = Allowed::closed(10.0, 1e9, "the projector's white divided by its black");
    blend.contrast = section.optional_number("contrast", &contrast, problems);
    if blend.contrast.is_some() && !blend.overlap {
        problems.add(&section.path("contrast"), "needs overlap = true; otherwise no blacks add up");
    }
    let bits = Allowed::closed(6.0, 16.0, "bits per channel of the display");
    blend.dither = section.optional_number("dither", &bits, problems).map(|bits| bits.round() as u32);
    let black = Allowed::below(0.0, 1.0, "light added to black, as a part of white");
    blend.black_level = section.number("black_level", &black, 0.0, problems);
    let example = "ramps = [{ angle = \"polar\", zero = 90, full = 80 }]";
    section.note_value("ramps", &[], "[{ angle = \"polar\", zero = 90, full = 80 }, …]", problems);
    blend.ramps = section
        .sections("ramps", example, problems)
        .into_iter()
        .filter_map(|ramp| angle_ramp(ramp, problems))
        .collect();
    section.finish(&[("image", "[output.mask] or [output.black]")], problems);
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
    let shape = shape(&mut section, problems);
    section.finish(&[], problems);
    Some(AngleRamp { angle, zero: zero.to_radians(), full: full.to_radians(), shape })
}

/// Reads `shape` and `power` of a ramp.
fn shape(section: &mut Section, problems: &mut Problems) -> RampShape {
    let shapes =
        [("smoothstep", RampShape::Smoothstep), ("cosine", RampShape::Cosine), ("power", RampShape::Power(POWER))];
    let chosen = section.choice_or("shape", &shapes, RampShape::default(), problems);
    let power = section.checked_number("power", &Allowed::closed(0.5, 4.0, "the ramp's power"), POWER, problems);
    match (chosen, power) {
        (RampShape::Power(_), power) => RampShape::Power(power.unwrap_or(POWER)),
        (_, Some(_)) if section.has("power") => {
            problems.add(&section.path("power"), "needs shape = \"power\"");
            chosen
        }
        _ => chosen,
    }
}

pub(super) fn mask(section: Option<Section>, directory: &Path, problems: &mut Problems) -> Option<PathBuf> {
    let mut section = section?;
    let path = image(&mut section, "a grey PNG file", directory, problems);
    section.finish(&[], problems);
    path
}

/// Reads `black` of an output with the blending `blend`, and of `size` pixels if it has a size.
pub(super) fn black(
    section: Option<Section>,
    size: Option<(u32, u32)>,
    blend: &Blend,
    directory: &Path,
    problems: &mut Problems,
) -> Option<Arc<Black>> {
    let mut section = section?;
    let words = [("displayed", BlackValues::Displayed), ("light", BlackValues::Light)];
    let values = section.choice_or("values", &words, BlackValues::default(), problems);
    let file = image(&mut section, "a PNG or PFM file", directory, problems);
    if blend.black_level > 0.0 {
        problems.add(
            &section.path("image"),
            "excludes blend.black_level, which is the same everywhere; leave out one of them",
        );
    }
    let key = section.path("image");
    section.finish(&[], problems);
    match black::read(&file?, values) {
        Ok(black) => {
            let found = black.levels.size;
            if let Some((width, height)) = size.filter(|size| *size != found) {
                let name = black.file.display();
                problems.add(
                    &key,
                    format!(
                        "{name} has {} × {} pixels; expected those of the output, {width} × {height}",
                        found.0, found.1
                    ),
                );
            }
            Some(Arc::new(black))
        }
        Err(error) => {
            problems.add(&key, error.message);
            None
        }
    }
}

/// Reads the path in `image`, which is described by `what`.
fn image(section: &mut Section, what: &str, directory: &Path, problems: &mut Problems) -> Option<PathBuf> {
    if !section.has("image") {
        let why = format!("is missing; expected the name of {what}, relative to the rig file");
        problems.add(&section.path("image"), why);
    }
    let image = section.text("image", &format!("the name of {what}"), problems)?;
    match std::path::absolute(directory.join(image)) {
        Ok(path) if !image.is_empty() => Some(path),
        _ => {
            problems.add(&section.path("image"), format!("the name is empty; expected that of {what}"));
            None
        }
    }
}
