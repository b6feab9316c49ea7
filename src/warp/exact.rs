//! The exact map of an output, ray by ray.

mod calibrated;

use crate::error::{Error, ErrorKind, Result};
use crate::geom;
use crate::geom::lenses::panorama::STRIP_FACES;
use crate::geom::{Circle, Fisheye, Frustum, Lens, Panorama, Pose, Screen, pose};
use crate::rig::{Flip, OutputKind, Rig};
use calibrated::Calibrated;
use glam::{DMat3, DVec2, DVec3};
use std::f64::consts::FRAC_PI_2;

/// Exact map between the pixels of one output, the screen and the directions of the viewer.
///
/// Pixels are measured from the top left corner of the output, so the centre of the first one is
/// (½, ½); positions between centres are valid too. Everything is f64, without approximations.
#[derive(Clone, Debug, PartialEq)]
pub struct WarpMap {
    size: (u32, u32),
    flip: Flip,
    optics: Optics,
    viewer: Pose,
    screen: Screen,
}

/// Function from an output's pixels to rays.
#[derive(Clone, Debug, PartialEq)]
enum Optics {
    /// A fisheye picture; the rotation takes lens axes to dome axes.
    Domemaster { lens: Fisheye, rotation: DMat3 },
    /// Any other picture of directions; the rotation takes its axes to dome axes.
    Panorama { panorama: Panorama, rotation: DMat3 },
    /// A pinhole in the dome's axes.
    Projector { pose: Pose, frustum: Frustum },
    /// A projector with another lens, or before a mirror, in the dome's axes.
    Special(geom::Optics),
    /// Calibration from a file.
    Calibrated(Box<Calibrated>),
    /// A window in front of the viewer; the rotation takes its axes to viewer axes.
    Perspective { rotation: DMat3, frustum: Frustum },
}

/// Distance, as a part of the screen's size, below which two points of the screen count as the
/// same: grazing light is found again only to the square root of rounding.
const ALIKE: f64 = 1e-6;

impl WarpMap {
    /// Makes the map of output number `output` of `rig` at `size` (width, height in pixels).
    ///
    /// `lens` is the program's own opening, used by a perspective output that has none of its own.
    /// Fails with [`ErrorKind::InvalidArgument`] if there is no such output, the size is zero, or
    /// that lens is needed and not given.
    pub fn new(rig: &Rig, output: usize, size: (u32, u32), lens: Option<Frustum>) -> Result<Self> {
        let invalid = |message: String| Error::new(ErrorKind::InvalidArgument, message);
        let described = rig.outputs.get(output).ok_or_else(|| {
            invalid(format!(
                "rig \"{}\" has {} outputs, number {output} is not one of them",
                rig.name,
                rig.outputs.len()
            ))
        })?;
        if size.0 == 0 || size.1 == 0 {
            return Err(invalid(format!("output \"{}\" cannot be {} × {} pixels", described.name, size.0, size.1)));
        }
        let viewer = rig.eye(described);
        let optics = match &described.kind {
            OutputKind::Domemaster { aperture, tilt } => Optics::Domemaster {
                lens: Fisheye { aperture: *aperture },
                rotation: viewer.rotation * pose::rotation(0.0, FRAC_PI_2 - tilt, 0.0),
            },
            OutputKind::Panorama { panorama, angles: [yaw, pitch, roll] } => Optics::Panorama {
                panorama: panorama.clone(),
                rotation: viewer.rotation * pose::rotation(*yaw, *pitch, *roll),
            },
            OutputKind::Projector { position, angles: [yaw, pitch, roll], frustum } => {
                Optics::Projector { pose: Pose::new(*position, *yaw, *pitch, *roll), frustum: *frustum }
            }
            OutputKind::Optics { optics, .. } => Optics::Special(optics.as_ref().clone()),
            OutputKind::Mesh(calibration) => {
                Optics::Calibrated(Box::new(Calibrated::new(calibration, viewer, &rig.surface(), size)))
            }
            OutputKind::Perspective { angles: [yaw, pitch, roll], frustum } => Optics::Perspective {
                rotation: pose::rotation(*yaw, *pitch, *roll),
                frustum: frustum.or(lens).ok_or_else(|| {
                    invalid(format!(
                        "output \"{}\" has the program's own lens, which is not known here",
                        described.name
                    ))
                })?,
            },
        };
        Ok(Self { size, flip: described.flip, optics, viewer, screen: rig.surface() })
    }

    /// Viewer, or the eye for which the output is made, in dome axes.
    pub fn viewer(&self) -> &Pose {
        &self.viewer
    }

    /// Width and height in pixels.
    pub fn size(&self) -> (u32, u32) {
        self.size
    }

    /// Direction in which the viewer sees a pixel: unit vector in viewer axes. `None` where the
    /// output shows nothing: outside its picture or its circle, and for projectors where the ray
    /// lights no screen. (Domemasters and panoramas are pictures of directions and are not cut at
    /// the screen's boundary curve, but show nothing where the surface ends.)
    pub fn direction(&self, pixel: DVec2) -> Option<DVec3> {
        match &self.optics {
            Optics::Perspective { rotation, frustum } => {
                Some((*rotation * tangents(frustum, self.picture(pixel)?).extend(-1.0)).normalize())
            }
            _ => self.viewer.point_to_local(self.hit(pixel)?).try_normalize(),
        }
    }

    /// Point of the screen (metres, dome axes) where a pixel appears; `None` as for
    /// [`Self::direction`], and for perspective outputs, which have no place on the screen.
    pub fn hit(&self, pixel: DVec2) -> Option<DVec3> {
        match &self.optics {
            Optics::Domemaster { lens, rotation } => {
                let point = Circle::Inscribed.to_disc(self.normalised(pixel)?, self.aspect());
                self.seen_from_the_centre(*rotation * lens.direction(point.x, point.y)?)
            }
            Optics::Panorama { panorama, rotation } => {
                self.seen_from_the_centre(*rotation * panorama.direction(self.normalised(pixel)?, self.aspect())?)
            }
            Optics::Projector { pose, frustum } => {
                let ray = tangents(frustum, self.picture(pixel)?).extend(-1.0);
                Some(self.screen.hit(pose.position, pose.direction_to_parent(ray))?.point)
            }
            Optics::Special(optics) => {
                let (origin, direction) = optics.ray(self.normalised(pixel)?, self.aspect())?;
                Some(self.screen.hit(origin, direction)?.point)
            }
            Optics::Calibrated(map) => map.hit(self.flip.pixel(pixel, self.size), self.size, &self.screen),
            Optics::Perspective { .. } => None,
        }
    }

    /// Factor on the displayed value of a pixel, from a calibration file; 1 for other outputs, 0
    /// where nothing is shown.
    pub fn intensity(&self, pixel: DVec2) -> f64 {
        match &self.optics {
            Optics::Calibrated(map) => {
                let pixel = self.flip.pixel(pixel, self.size);
                map.sample(pixel, self.size).map_or(0.0, |sample| sample.intensity)
            }
            _ => 1.0,
        }
    }

    /// Returns the place in this output of a point of the screen (metres, dome axes): the inverse
    /// of [`Self::hit`], for perspective outputs of [`Self::direction`]. `None` if the output does
    /// not show it.
    pub fn pixel(&self, point: DVec3) -> Option<DVec2> {
        match &self.optics {
            Optics::Domemaster { lens, rotation } => {
                let disc = lens.point(rotation.transpose() * point);
                let inside = disc.length_squared() <= 1.0;
                inside.then(|| self.at(Circle::Inscribed.to_picture(disc, self.aspect())))
            }
            Optics::Panorama { panorama, rotation } => {
                Some(self.at(panorama.picture(rotation.transpose() * point, self.aspect())?))
            }
            Optics::Projector { pose, frustum } => {
                let pixel = self.pixel_of_ray(frustum, pose.direction_to_local(point - pose.position))?;
                self.lights(pixel, point).then_some(pixel)
            }
            Optics::Special(optics) => {
                let pixel = self.at(optics.picture(point, self.aspect())?);
                self.lights(pixel, point).then_some(pixel)
            }
            Optics::Calibrated(map) => {
                let pixel = self.flip.pixel(map.pixel(point, self.size, &self.screen)?, self.size);
                self.lights(pixel, point).then_some(pixel)
            }
            Optics::Perspective { rotation, frustum } => {
                self.pixel_of_ray(frustum, rotation.transpose() * self.viewer.point_to_local(point))
            }
        }
    }

    /// The screen.
    pub fn screen(&self) -> &Screen {
        &self.screen
    }

    /// Point of the surface in a direction from the dome's centre.
    fn seen_from_the_centre(&self, direction: DVec3) -> Option<DVec3> {
        Some(self.screen.unbounded_hit(DVec3::ZERO, direction)?.point)
    }

    /// Point (dome axes) from which all light of the output comes, or from which its picture is
    /// made; `None` if that differs from pixel to pixel or is not known.
    pub fn origin(&self) -> Option<DVec3> {
        match &self.optics {
            Optics::Domemaster { .. } | Optics::Panorama { .. } => Some(DVec3::ZERO),
            Optics::Projector { pose, .. } => Some(pose.position),
            Optics::Special(optics) => optics.mirror.is_none().then_some(optics.pose.position),
            Optics::Calibrated(map) => map.origin(),
            Optics::Perspective { .. } => None,
        }
    }

    /// True if the light of a pixel, whose ray goes through `point`, ends there and not at another
    /// point on the way.
    fn lights(&self, pixel: DVec2, point: DVec3) -> bool {
        self.hit(pixel).is_some_and(|hit| hit.distance(point) <= ALIKE * self.screen.size())
    }

    /// Nominal angle, in radians, of a pixel of a picture that shows all directions at the same
    /// scale: a domemaster, a fisheye, an equirectangular picture. Where such a picture is
    /// stretched around a pole, it shows no more detail.
    pub fn nominal_pitch(&self) -> Option<f64> {
        let extent = match &self.optics {
            Optics::Domemaster { lens, .. } => DVec2::splat(lens.aperture) / self.circle()?.1,
            Optics::Panorama { panorama: Panorama::Fisheye(lens), .. } => {
                DVec2::splat(lens.aperture) / self.circle()?.1
            }
            Optics::Panorama { panorama: Panorama::Equirectangular(span), .. } => {
                DVec2::new(span.width, span.top - span.bottom) / self.middle()
            }
            _ => return None,
        };
        Some(0.5 * extent.min_element())
    }

    /// Number of cube-map faces side by side in the output, each of the same width. The map is
    /// discontinuous between them.
    pub fn cubemap_faces(&self) -> u32 {
        match &self.optics {
            Optics::Panorama { panorama: Panorama::CubeStrip, .. } => STRIP_FACES.len() as u32,
            _ => 1,
        }
    }

    /// Returns the circle of a circular picture: its centre and half its width and height, pixels.
    pub fn circle(&self) -> Option<(DVec2, DVec2)> {
        let circle = match &self.optics {
            Optics::Domemaster { .. } => Circle::Inscribed,
            Optics::Panorama { panorama, .. } if panorama.is_circular() => Circle::Inscribed,
            Optics::Special(geom::Optics { lens: Lens::Fisheye { circle, .. }, .. }) => *circle,
            _ => return None,
        };
        let center = self.at(circle.to_picture(DVec2::ZERO, self.aspect()));
        Some((center, (self.at(circle.to_picture(DVec2::ONE, self.aspect())) - center).abs()))
    }

    /// Area of the screen that a pixel lights, square metres, from differences over half a pixel to
    /// each side; `None` where the output shows nothing, at the edge of the shown area, or if the
    /// output has no place on the dome.
    pub fn area(&self, pixel: DVec2) -> Option<f64> {
        let step = |axis: DVec2| Some(self.hit(pixel + 0.5 * axis)? - self.hit(pixel - 0.5 * axis)?);
        Some(step(DVec2::X)?.cross(step(DVec2::Y)?).length())
    }

    /// Width divided by height.
    fn aspect(&self) -> f64 {
        f64::from(self.size.0) / f64::from(self.size.1)
    }

    /// The middle of the output in pixels.
    fn middle(&self) -> DVec2 {
        DVec2::new(0.5 * f64::from(self.size.0), 0.5 * f64::from(self.size.1))
    }

    /// Position of a pixel as parts of width and height of the picture before mirroring, 0…1 from
    /// the left and from the bottom; `None` outside.
    fn picture(&self, pixel: DVec2) -> Option<DVec2> {
        let part = self.flip.pixel(pixel, self.size) / (2.0 * self.middle());
        let inside = part.cmpge(DVec2::ZERO).all() && part.cmple(DVec2::ONE).all();
        inside.then(|| DVec2::new(part.x, 1.0 - part.y))
    }

    /// Position of a pixel in −1…1 from the left and from the bottom; `None` outside.
    fn normalised(&self, pixel: DVec2) -> Option<DVec2> {
        Some(2.0 * self.picture(pixel)? - 1.0)
    }

    /// Pixel at a position in −1…1.
    fn at(&self, picture: DVec2) -> DVec2 {
        self.flip.pixel((1.0 + picture * DVec2::new(1.0, -1.0)) * self.middle(), self.size)
    }

    /// Pixel of a ray in the axes of a pinhole; `None` behind it or outside the picture.
    fn pixel_of_ray(&self, frustum: &Frustum, ray: DVec3) -> Option<DVec2> {
        let (x, y) = (ray.x / -ray.z, ray.y / -ray.z);
        let part = DVec2::new((x - frustum.left) / frustum.width(), (frustum.top - y) / frustum.height());
        (ray.z < 0.0 && frustum.contains(x, y)).then(|| self.flip.pixel(part * 2.0 * self.middle(), self.size))
    }
}

/// Tangents of a picture position (parts of width and height from the bottom left).
fn tangents(frustum: &Frustum, part: DVec2) -> DVec2 {
    DVec2::new(frustum.left, frustum.bottom) + part * DVec2::new(frustum.width(), frustum.height())
}

/// Returns [`WarpMap::direction`] of a single pixel; `None` also where [`WarpMap::new`] fails
/// without the program's lens.
pub fn exact_direction(rig: &Rig, output: usize, size: (u32, u32), pixel: DVec2) -> Option<DVec3> {
    WarpMap::new(rig, output, size, None).ok()?.direction(pixel)
}

/// Returns [`WarpMap::direction`] of all pixel centres, row by row from the top, NaN where the
/// output shows nothing. Fails as [`WarpMap::new`] does without the program's lens.
pub fn exact_map(rig: &Rig, output: usize, size: (u32, u32)) -> Result<Vec<[f64; 3]>> {
    let map = WarpMap::new(rig, output, size, None)?;
    let centres =
        (0..size.1).flat_map(|y| (0..size.0).map(move |x| DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)));
    Ok(centres.map(|pixel| map.direction(pixel).unwrap_or(DVec3::NAN).to_array()).collect())
}

/// Converts a viewer direction to the eye axes of the program's camera, which the rig may have
/// turned. The camera's zoom and shift are no rotations and are not undone.
pub fn camera_direction(rig: &Rig, direction: DVec3) -> DVec3 {
    pose::rotation(rig.camera.yaw, rig.camera.pitch, rig.camera.roll).transpose() * direction
}

#[cfg(test)]
mod tests;
