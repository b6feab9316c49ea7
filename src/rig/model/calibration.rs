//! Calibration of an output's pixels, read from a file.

use crate::error::{Error, ErrorKind, Result};
use crate::formats::pictures::pfm;
use crate::formats::{Grid, bourke, read_file};
use crate::geom::Frustum;
use std::path::{Path, PathBuf};

/// A calibration that another program made, read from its file.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Calibration {
    /// The file.
    pub file: PathBuf,
    /// A value for each place of the output.
    pub grid: Grid,
    /// Meaning of the values.
    pub values: CalibrationValues,
}

/// Meaning of a calibration's values.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub enum CalibrationValues {
    /// Places (0…1 from the bottom left) in an equidistant fisheye picture of the dome.
    Domemaster {
        /// Opening angle of the picture, radians.
        aperture: f64,
        /// Angle from straight up to the picture's centre, towards the front, radians.
        tilt: f64,
    },
    /// Places (0…1 from the bottom left) in a flat picture as the viewer sees it.
    Perspective {
        /// Aim of the picture relative to the viewer, radians: right-positive, up-positive,
        /// clockwise-positive.
        angles: [f64; 3],
        /// Opening of the picture.
        frustum: Frustum,
    },
    /// Points of the screen, metres, dome axes.
    Points,
    /// Directions from the viewer, viewer axes, of any length.
    Directions,
}

impl CalibrationValues {
    /// True if the values are places in a picture.
    pub fn are_places(&self) -> bool {
        matches!(self, Self::Domemaster { .. } | Self::Perspective { .. })
    }
}

/// Reads a calibration file: a warp mesh (`.data`, `.map`) or a float map (`.pfm`).
///
/// # Errors
/// [`ErrorKind::Io`] if the file cannot be read, [`ErrorKind::InvalidRig`] with place and reason if
/// it is damaged, of another kind, or a warp mesh whose values are not places in a picture.
pub(in crate::rig) fn read(file: &Path, values: CalibrationValues) -> Result<Calibration> {
    let name = file.display().to_string();
    let invalid = |why: &str| Error::new(ErrorKind::InvalidRig, format!("{name} {why}"));
    let ending = file.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let grid = match ending.as_str() {
        "data" | "map" if !values.are_places() => {
            return Err(invalid("is a warp mesh, which has places in a picture; expected values = \"picture\""));
        }
        "data" | "map" => Grid::Mesh(bourke::read(&name, &read_file(file)?)?.value.mesh(&name)?),
        "pfm" => Grid::Raster(pfm::read(&name, &read_file(file)?)?),
        _ => {
            return Err(invalid(
                "is not read by programs; expected a file .data, .map or .pfm (`cupola convert` makes one of others)",
            ));
        }
    };
    Ok(Calibration { file: file.to_owned(), grid, values })
}
