//! `kind = "mesh"`: an output whose map is read from a file.

use super::{OPENING, TILT, angles, lens};
use crate::rig::model::calibration;
use crate::rig::model::calibration::CalibrationValues;
use crate::rig::reading::problems::Problems;
use crate::rig::reading::reader::Section;
use crate::rig::{Dome, OutputKind};
use std::path::Path;
use std::sync::Arc;

/// Picture to which the places belong.
#[derive(Clone, Copy, PartialEq)]
enum Picture {
    Domemaster,
    Perspective,
}

/// Meaning of the values.
#[derive(Clone, Copy, PartialEq)]
enum Values {
    Picture,
    Points,
    Directions,
}

/// Reads the keys of a mesh, and its file, whose path is relative to `directory`.
pub(super) fn mesh(
    section: &mut Section,
    dome: &Dome,
    directory: &Path,
    problems: &mut Problems,
) -> Option<OutputKind> {
    let words = [("picture", Values::Picture), ("points", Values::Points), ("directions", Values::Directions)];
    let meaning = section.checked_choice("values", &words, Values::Picture, problems)?;
    let pictures = [("domemaster", Picture::Domemaster), ("perspective", Picture::Perspective)];
    let picture = section.checked_choice("picture", &pictures, Picture::Domemaster, problems)?;
    if section.has("picture") && meaning != Values::Picture {
        problems.add(&section.path("picture"), "needs values = \"picture\"");
        return None;
    }
    let values = match (meaning, picture) {
        (Values::Points, _) => CalibrationValues::Points,
        (Values::Directions, _) => CalibrationValues::Directions,
        (Values::Picture, Picture::Domemaster) => CalibrationValues::Domemaster {
            aperture: section.number("aperture", &OPENING, dome.coverage.to_degrees(), problems).to_radians(),
            tilt: section.number("tilt", &TILT, dome.tilt.to_degrees(), problems).to_radians(),
        },
        (Values::Picture, Picture::Perspective) => CalibrationValues::Perspective {
            angles: angles(section, problems),
            frustum: lens::frustum(section, problems)?,
        },
    };
    let path = section.path("file");
    let Some(file) = section.text("file", "the calibration's path", problems) else {
        problems.add(
            &path,
            "is missing; expected a warp mesh (.data, .map) or a float map (.pfm), relative to the rig file",
        );
        return None;
    };
    match calibration::read(&directory.join(file), values) {
        Ok(calibration) => Some(OutputKind::Mesh(Arc::new(calibration))),
        Err(error) => {
            problems.add(&path, error.message);
            None
        }
    }
}
