//! Map from a pixel of an output to a direction: the coefficients, and their evaluation in f64.

use crate::blend::EdgeWeight;
use crate::correct::passes::optics::OpticsSource;
use crate::correct::passes::table::Table;
use crate::geom::lenses::pinhole_rays::RimForms;
use crate::geom::screen::Bounds;
use crate::geom::{Fisheye, Panorama, PinholeRays, QuadraticForm};
use glam::{DMat3, DVec2, DVec3};
use std::sync::Arc;

/// Map from a pixel of an output to a direction. `(x, y)` are the pixel's normalised coordinates:
/// −1…1 from left to right and from bottom to top, at pixel centres. For [`Source::Fisheye`] they
/// are scaled so that the inscribed circle is the unit circle.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub enum Source {
    /// `v = rotation·(q·S(|q|²), −C(|q|²)) + offset` with `q = (x, y)·aperture/2`, in viewer axes
    /// (metres per dome radius).
    Fisheye {
        /// Whole opening angle, radians.
        aperture: f64,
        /// Lens axes → viewer axes.
        rotation: DMat3,
        /// Minus the viewer's position over the dome's radius, in viewer axes.
        offset: DVec3,
    },
    /// Viewer direction by the closed form, in viewer axes.
    Projector(Box<ProjectorSource>),
    /// `v = matrix·(x, y, 1)`, in viewer axes.
    Perspective {
        /// Homogeneous pixel → direction.
        matrix: DMat3,
    },
    /// `v = rotation·u + offset`, in viewer axes (metres per dome radius), with u the panorama's
    /// unit direction. `(x, y)` are scaled as for [`Source::Fisheye`] if the panorama is a circle.
    Panorama {
        /// Projection of the picture.
        panorama: Panorama,
        /// Picture axes → viewer axes.
        rotation: DMat3,
        /// As for [`Source::Fisheye`].
        offset: DVec3,
    },
    /// Viewer direction by tracing the ray through a lens, and possibly over a mirror.
    Optics(Box<OpticsSource>),
    /// Viewer direction and weight of each pixel, computed beforehand. The weight includes
    /// everything except the mask: a pass with a table has no ramps and no neighbours.
    Table(Arc<Table>),
}

/// The forms of a projector.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct ProjectorSource {
    /// Rays of the projector and the surface that they light, in the axes of the surface.
    pub pinhole: PinholeRays,
    /// Viewer direction, viewer axes.
    pub direction: QuadraticForm,
    /// Part of the surface that is screen.
    pub bounds: Bounds,
    /// Test whether a pixel's point is on the screen; `None` = the whole surface is screen.
    pub rim: Option<RimForms>,
    /// From the dome's centre to the point, times a positive factor, dome axes turned so that the
    /// pole is +y and the front −z; for ramps in dome angles.
    pub dome_direction: QuadraticForm,
    /// For every projector that can overlap this one: its homogeneous picture coordinates (`x/z`,
    /// `y/z` in −1…1, `z > 0` in front) of this pixel's hit, and its ramp.
    pub neighbours: Vec<Neighbour>,
    /// Raw weight of this projector.
    pub edge_weight: EdgeWeight,
    /// Evaluation of the forms.
    pub evaluation: EvaluationMethod,
}

impl ProjectorSource {
    /// Returns the viewer direction at normalised coordinates, any length; `None` where the ray
    /// does not end on the screen.
    pub fn direction(&self, x: f64, y: f64) -> Option<DVec3> {
        let direction = self.pinhole.evaluate(&self.direction, x, y)?;
        self.rim.as_ref().is_none_or(|rim| rim.allow(&self.pinhole, x, y)).then_some(direction)
    }
}

/// Another projector that may light the same points.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Neighbour {
    /// Index of the output.
    pub output: usize,
    /// Its homogeneous picture coordinates of a pixel's hit on the screen.
    pub picture: QuadraticForm,
    /// Its raw weight.
    pub edge_weight: EdgeWeight,
}

/// Evaluation of a projector's forms in shaders.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub enum EvaluationMethod {
    /// With all terms of the forms.
    Forms,
    /// `linear`: before a plane.
    Linear,
    /// `offset·√D + linear'`: the fewest operations before a quadric.
    Root,
    /// `offset/t + linear`.
    Distance,
}

impl Source {
    /// Returns the rotation from the axes in which the source computes directions to viewer axes.
    pub(in crate::correct) fn axes(&self) -> DMat3 {
        match self {
            Self::Fisheye { rotation, .. } | Self::Panorama { rotation, .. } => *rotation,
            Self::Table(table) => table.axes(),
            Self::Projector(_) | Self::Optics(_) | Self::Perspective { .. } => DMat3::IDENTITY,
        }
    }

    /// Returns the direction from the viewer at normalised coordinates, viewer axes, any length;
    /// `None` where the output shows nothing. It is the shaders' computation in f64; for a table of
    /// all pixels, the direction of the nearest pixel.
    pub fn direction(&self, x: f64, y: f64) -> Option<DVec3> {
        match self {
            Self::Fisheye { aperture, rotation, offset } => {
                Fisheye { aperture: *aperture }.direction(x, y).map(|lens| *rotation * lens + *offset)
            }
            Self::Projector(projector) => projector.direction(x, y),
            Self::Optics(optics) => optics.direction(x, y),
            Self::Panorama { panorama, rotation, offset } => {
                let direction = match panorama {
                    Panorama::Fisheye(lens) => lens.direction(DVec2::new(x, y)),
                    _ => panorama.direction(DVec2::new(x, y), 1.0),
                };
                direction.map(|direction| *rotation * direction + *offset)
            }
            Self::Perspective { matrix } => Some(*matrix * DVec3::new(x, y, 1.0)),
            Self::Table(table) => table.at(0.5 * (1.0 + x), 0.5 * (1.0 - y)).map(|pixel| pixel.direction),
        }
    }

    /// Returns the normalised coordinates of the pixel position `(column, row)`, from the top left
    /// with pixel centres at +½, in an output of `size` pixels.
    pub fn normalised(&self, size: (u32, u32), column: f64, row: f64) -> (f64, f64) {
        let (width, height) = (f64::from(size.0), f64::from(size.1));
        let (across, up) = if self.is_circular() { (width.min(height), width.min(height)) } else { (width, height) };
        ((2.0 * column - width) / across, (height - 2.0 * row) / up)
    }

    /// True if the picture is a circle inscribed in the output, and normalised coordinates are
    /// units of its radius.
    pub fn is_circular(&self) -> bool {
        match self {
            Self::Fisheye { .. } => true,
            Self::Panorama { panorama, .. } => panorama.is_circular(),
            _ => false,
        }
    }
}
