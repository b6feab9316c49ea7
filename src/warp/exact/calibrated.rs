//! Outputs with a measured map, and its inverse.

use crate::formats::{Mesh, Node, Sample};
use crate::geom::{Fisheye, Pose, Screen, pose};
use crate::rig::{Calibration, CalibrationValues};
use glam::{DMat2, DMat3, DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, TAU};
use std::sync::Arc;

/// Number of cells across the output. The inverse starts from their corners.
const CELLS: u32 = 128;
/// Number of steps of the inverse. Each step is exact where the map is linear.
const STEPS: usize = 8;

/// Map of a calibrated output.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Calibrated {
    calibration: Arc<Calibration>,
    /// Rotation from the axes of the values (those of the picture's lens, of the viewer, or the
    /// dome's) to dome axes.
    rotation: DMat3,
    viewer: Pose,
    /// Approximate map from directions to pixels.
    inverse: Inverse,
}

/// A mesh over a fisheye picture of the viewer's directions, around the middle of the shown area;
/// its values are pixels.
#[derive(Clone, Debug, PartialEq)]
struct Inverse {
    /// Axes of the picture → dome axes.
    axes: DMat3,
    mesh: Option<Mesh>,
}

/// Lens of a picture of all directions.
const EVERYTHING: Fisheye = Fisheye { aperture: TAU };

impl Calibrated {
    pub(super) fn new(calibration: &Arc<Calibration>, viewer: Pose, screen: &Screen, size: (u32, u32)) -> Self {
        let rotation = match calibration.values {
            CalibrationValues::Domemaster { tilt, .. } => viewer.rotation * pose::rotation(0.0, FRAC_PI_2 - tilt, 0.0),
            CalibrationValues::Perspective { angles: [yaw, pitch, roll], .. } => {
                viewer.rotation * pose::rotation(yaw, pitch, roll)
            }
            CalibrationValues::Points => DMat3::IDENTITY,
            CalibrationValues::Directions => viewer.rotation,
        };
        let inverse = Inverse { axes: DMat3::IDENTITY, mesh: None };
        let mut map = Self { calibration: calibration.clone(), rotation, viewer, inverse };
        map.inverse = map.inverted(screen, size);
        map
    }

    /// Returns the value of the file for a pixel (from the top left).
    pub(super) fn sample(&self, pixel: DVec2, size: (u32, u32)) -> Option<Sample> {
        self.calibration.grid.sample(pixel, size)
    }

    /// Point of the screen (dome axes) where a pixel appears.
    pub(super) fn hit(&self, pixel: DVec2, size: (u32, u32), screen: &Screen) -> Option<DVec3> {
        let value = self.sample(pixel, size)?.value;
        // The picture may extend beyond the screen's boundary curve, as a domemaster's does.
        let seen_from =
            |eye: DVec3, direction: DVec3| Some(screen.unbounded_hit(eye, self.rotation * direction)?.point);
        match self.calibration.values {
            CalibrationValues::Points => Some(value),
            CalibrationValues::Directions => seen_from(self.viewer.position, value),
            CalibrationValues::Perspective { frustum, .. } => {
                let tangents = DVec2::new(frustum.left, frustum.bottom)
                    + value.truncate() * DVec2::new(frustum.width(), frustum.height());
                seen_from(self.viewer.position, tangents.extend(-1.0))
            }
            CalibrationValues::Domemaster { aperture, .. } => {
                let at = 2.0 * value.truncate() - 1.0;
                seen_from(DVec3::ZERO, Fisheye { aperture }.direction(at.x, at.y)?)
            }
        }
    }

    /// Point from which the picture is made; `None` if the file gives points.
    pub(super) fn origin(&self) -> Option<DVec3> {
        match self.calibration.values {
            CalibrationValues::Points => None,
            CalibrationValues::Directions | CalibrationValues::Perspective { .. } => Some(self.viewer.position),
            CalibrationValues::Domemaster { .. } => Some(DVec3::ZERO),
        }
    }

    /// Pixel that appears at a point of the screen, by Newton's steps from the nearest cell; `None`
    /// if there is none.
    pub(super) fn pixel(&self, point: DVec3, size: (u32, u32), screen: &Screen) -> Option<DVec2> {
        let wanted = self.inverse.place(point - self.viewer.position);
        let mut pixel = self.inverse.mesh.as_ref()?.sample(wanted)?.value.truncate();
        for _ in 0..STEPS {
            let at = |pixel: DVec2| Some(self.inverse.place(self.hit(pixel, size, screen)? - self.viewer.position));
            let here = at(pixel)?;
            // A difference towards the middle of the output always stays inside.
            let middle = 0.5 * DVec2::new(f64::from(size.0), f64::from(size.1));
            let step = DVec2::select(pixel.cmplt(middle), DVec2::splat(0.25), DVec2::splat(-0.25));
            let across = (at(pixel + DVec2::new(step.x, 0.0))? - here) / step.x;
            let down = (at(pixel + DVec2::new(0.0, step.y))? - here) / step.y;
            let jacobian = DMat2::from_cols(across, down);
            let change = jacobian.inverse() * (wanted - here);
            if !change.is_finite() {
                return None;
            }
            let end = 2.0 * middle;
            pixel = (pixel + change).clamp(DVec2::ZERO, end);
            if change.length() < 1e-9 {
                break;
            }
        }
        Some(pixel)
    }

    /// Computes the inverse from the map at the corners of a grid of cells.
    fn inverted(&self, screen: &Screen, size: (u32, u32)) -> Inverse {
        let extent = DVec2::new(f64::from(size.0), f64::from(size.1));
        let corner = |x: u32, y: u32| extent * DVec2::new(f64::from(x), f64::from(y)) / f64::from(CELLS);
        let corners = (0..=CELLS).flat_map(|y| (0..=CELLS).map(move |x| corner(x, y)));
        let seen: Vec<Option<(DVec2, DVec3)>> = corners
            .map(|pixel| Some((pixel, (self.hit(pixel, size, screen)? - self.viewer.position).try_normalize()?)))
            .collect();
        let middle: DVec3 = seen.iter().flatten().map(|(_, direction)| *direction).sum();
        let forward = middle.try_normalize().unwrap_or(DVec3::NEG_Z);
        let (right, up) = forward.any_orthonormal_pair();
        let mut inverse = Inverse { axes: DMat3::from_cols(right, up, -forward), mesh: None };
        let node = |seen: &Option<(DVec2, DVec3)>| {
            let (pixel, direction) = (*seen)?;
            Some(Node { position: inverse.place(direction), value: pixel.extend(0.0), intensity: 1.0 })
        };
        let nodes: Vec<_> = seen.iter().map(node).collect();
        let side = CELLS as usize + 1;
        // Without a mesh no point has a pixel: simulations stay dark, and the map itself is
        // unaffected.
        inverse.mesh = Mesh::from_grid("the inverse of a calibration", side, side, &nodes, false).ok();
        inverse
    }
}

impl Inverse {
    /// Position of a direction (dome axes, any length) in the mesh's picture.
    fn place(&self, direction: DVec3) -> DVec2 {
        EVERYTHING.point(self.axes.transpose() * direction)
    }
}
