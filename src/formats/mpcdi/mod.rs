//! MPCDI, VESA's exchange format for calibrated displays, versions 1.0 and 2.0: a zip archive with
//! a description in XML, a PFM for each region, and PNG pictures of weights.
//!
//! A description alone, without the archive, is read too: it gives the positions of projectors and
//! their lenses.
//!
//! Attributes are read regardless of their case, because writers differ. Files of the archive are
//! read by the names in the description, into memory, within limits that follow from the regions'
//! sizes.

mod archive;
mod document;
mod extension;
mod write;

pub use write::write;

use super::camera::Camera;
use super::grid::Raster;
use crate::error::Result;
use crate::formats::pictures::levels;
use crate::formats::pictures::levels::Levels;
use crate::formats::pictures::pfm;
use crate::formats::reading::input::{MOST_PIXELS_TOGETHER, Noted, invalid, png_luma};
use crate::geom::Optics;
use archive::Files;
use glam::{DMat3, DVec3};

/// Meaning of the maps' values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Profile {
    /// `2d`: positions in one flat picture.
    Flat,
    /// `3d`: positions in a perspective picture for each region.
    Perspective,
    /// `a3`: points of the screen.
    Screen,
    /// `sl`: points of the screen, which each region's projector lights from a known position.
    ShaderLamps,
}

impl Profile {
    /// All of them.
    const ALL: [Self; 4] = [Self::Flat, Self::Perspective, Self::Screen, Self::ShaderLamps];

    /// Word in the description.
    pub fn word(self) -> &'static str {
        match self {
            Self::Flat => "2d",
            Self::Perspective => "3d",
            Self::Screen => "a3",
            Self::ShaderLamps => "sl",
        }
    }

    /// True if each region needs a camera.
    fn has_cameras(self) -> bool {
        matches!(self, Self::Perspective | Self::ShaderLamps)
    }

    /// True if the values are points, not positions in a picture.
    pub fn has_points(self) -> bool {
        matches!(self, Self::Screen | Self::ShaderLamps)
    }
}

/// A version of the format, for writing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Version {
    /// Version 1.0, which all readers accept.
    One,
    /// Version 2.0.
    Two,
}

/// Content of an archive.
#[derive(Clone, Debug, PartialEq)]
pub struct Archive {
    /// Meaning of the values.
    pub profile: Profile,
    /// Regions, one for each projector.
    pub regions: Vec<Region>,
    /// Dome to which the values belong, if the file says it. Only archives of Cupola do, in an
    /// extension.
    pub dome: Option<Dome>,
}

/// A dome.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dome {
    /// Radius, metres.
    pub radius: f64,
    /// Angle from straight up to the pole, towards the front, radians.
    pub tilt: f64,
    /// Opening angle of the part that is screen, radians.
    pub coverage: f64,
}

/// Calibration of one projector.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// Name of the region.
    pub id: String,
    /// Resolution in pixels.
    pub size: (u32, u32),
    /// Position in the picture (0…1 from the bottom left) or point of the screen, NaN where nothing
    /// is shown, in any resolution. In profile `sl` it may be missing if the projector is known.
    pub warp: Option<Raster>,
    /// Weights, if there are any.
    pub alpha: Option<Alpha>,
    /// Black levels, if there are any: displayed values that are added after the weights, `x·(1 −
    /// level) + level`.
    pub beta: Option<Levels>,
    /// Camera to whose picture the positions refer (profile `3d`), or the projector if it is a
    /// pinhole (profile `sl`).
    pub camera: Option<Camera>,
    /// Projector in profile `sl`, if it has a fisheye lens.
    pub fisheye: Option<Optics>,
}

/// Weights of a region.
#[derive(Clone, Debug, PartialEq)]
pub struct Alpha {
    /// Width and height.
    pub size: (u32, u32),
    /// Weights 0…1, row by row from the top; weight^gamma is the part of linear light.
    pub weights: Vec<f32>,
    /// Exponent of the weights.
    pub gamma: f64,
}

/// Reads an archive, or a description alone. Points, positions and rotations are in the axes x
/// right, y up, z backward; if a frame gives the axes of the file, they are turned. `name` is the
/// file's, for messages.
///
/// # Errors
/// [`InvalidRig`](crate::ErrorKind::InvalidRig) with the file in the archive and the reason.
pub fn read(name: &str, bytes: &[u8]) -> Result<Noted<Archive>> {
    read_within(name, bytes, MOST_PIXELS_TOGETHER)
}

/// As [`read`], with at most `most` pixels altogether.
fn read_within(name: &str, bytes: &[u8], most: u64) -> Result<Noted<Archive>> {
    let (files, file, text) = match description_alone(bytes) {
        Some(text) => (None, name.to_owned(), text.to_owned()),
        None => {
            let mut files = Files::open(name, bytes)?;
            let (file, text) = files.description()?;
            (Some(files), file, text)
        }
    };
    let document::Description { profile, regions: described, dome, notes } = document::read(name, &file, &text)?;
    let mut parts = Parts { name, files, left: most, most };
    let mut regions = Vec::new();
    for region in described {
        // A map may be finer than the region, but only to a limit: four values for each pixel.
        let longest = 48 * u64::from(region.size.0) * u64::from(region.size.1) + (1 << 16);
        let warp = region.warp.as_ref().map(|path| parts.warp(path, longest, profile, &region)).transpose()?;
        let alpha = region.alpha.as_ref().map(|(path, gamma)| parts.alpha(path, longest, *gamma)).transpose()?;
        let beta = region.beta.as_ref().map(|path| parts.beta(path, longest)).transpose()?;
        let (camera, fisheye) = (region.camera, region.fisheye);
        // If a fisheye is not understood, the points remain.
        if camera.is_none() && fisheye.is_none() && profile.has_cameras() && !region.unclear {
            let why = format!("region {} has no frustum, which profile {} needs", region.id, profile.word());
            return Err(invalid(name, why));
        }
        regions.push(Region { id: region.id, size: region.size, warp, alpha, beta, camera, fisheye });
    }
    Ok(Noted { value: Archive { profile, regions, dome }, notes })
}

/// Files of an archive, which are read as its regions name them.
struct Parts<'a> {
    /// Name of the archive.
    name: &'a str,
    /// Files of the archive; `None` for a description without one.
    files: Option<Files<'a>>,
    /// Number of pixels that may still be unpacked. Many regions may name the same file, which is
    /// unpacked for each.
    left: u64,
    most: u64,
}

impl Parts<'_> {
    /// Returns a file's name for messages, and its bytes.
    fn take(&mut self, path: &str, longest: u64) -> Result<(String, Vec<u8>)> {
        match &mut self.files {
            Some(files) => Ok((format!("{}/{path}", self.name), files.take(path, longest)?)),
            None => Err(invalid(
                self.name,
                format!("names the file {path}, but is a description without its archive; convert the archive"),
            )),
        }
    }

    fn count(&mut self, name: &str, (width, height): (u32, u32)) -> Result<()> {
        let most = self.most;
        let too_many = || invalid(name, format!("is too much: all maps and pictures have more than {most} pixels"));
        self.left = self.left.checked_sub(u64::from(width) * u64::from(height)).ok_or_else(too_many)?;
        Ok(())
    }

    fn warp(
        &mut self,
        path: &str,
        longest: u64,
        profile: Profile,
        region: &document::DescribedRegion,
    ) -> Result<Raster> {
        let (inner, bytes) = self.take(path, longest)?;
        let warp = pfm::read(&inner, &bytes)?;
        self.count(&inner, warp.size())?;
        match profile {
            Profile::Flat => placed(&inner, &warp, region.place),
            Profile::ShaderLamps => turned(&inner, warp, &region.axes),
            _ => Ok(warp),
        }
    }

    fn alpha(&mut self, path: &str, longest: u64, gamma: f64) -> Result<Alpha> {
        let (inner, bytes) = self.take(path, longest)?;
        let (size, weights) = png_luma(&inner, &bytes)?;
        self.count(&inner, size)?;
        Ok(Alpha { size, weights: weights.iter().map(|value| f32::from(*value) / 65535.0).collect(), gamma })
    }

    fn beta(&mut self, path: &str, longest: u64) -> Result<Levels> {
        let (inner, bytes) = self.take(path, longest)?;
        let levels = levels::read_png(&inner, &bytes)?;
        self.count(&inner, levels.size)?;
        Ok(levels)
    }
}

/// Text of a description without an archive, if the file is one.
fn description_alone(bytes: &[u8]) -> Option<&str> {
    let text = std::str::from_utf8(bytes).ok()?;
    text.trim_start_matches('\u{feff}').trim_start().starts_with('<').then_some(text)
}

/// Converts points from the axes of the file.
fn turned(name: &str, warp: Raster, axes: &DMat3) -> Result<Raster> {
    if *axes == DMat3::IDENTITY {
        return Ok(warp);
    }
    let turn = |point: &[f32; 3]| (axes.transpose() * DVec3::from_array(point.map(f64::from))).as_vec3().to_array();
    let values = warp.values().iter().map(turn).collect();
    Raster::new(warp.size(), values).ok_or_else(|| invalid(name, "has no pixels"))
}

/// Converts positions in a region's part (x, y, width, height) of the whole picture.
fn placed(name: &str, warp: &Raster, [x, y, width, height]: [f64; 4]) -> Result<Raster> {
    let part = |start: f64, extent: f64, at: f32| (start + extent * f64::from(at)) as f32;
    let values = warp.values().iter().map(|value| [part(x, width, value[0]), part(y, height, value[1]), 0.0]);
    Raster::new(warp.size(), values.collect()).ok_or_else(|| invalid(name, "has no pixels"))
}

#[cfg(test)]
mod tests;
