//! Map of each output: pixel → direction from the viewer, and the extent of a pixel.
//!
//! This is the planner's own map. Where passes use closed forms, it is plain ray tracing. So it is
//! independent of them, and the tests compare the two. For everything else it uses the exact map.

use crate::error::{Error, ErrorKind, Result};
use crate::geom::{Fisheye, Frustum, Pose, Sphere, pose};
use crate::rig::{Output, OutputKind, Resolution, Rig};
use crate::views::sampling::pixel_width;
use crate::views::sampling::projector_map::ProjectorMap;
use crate::views::sampling::sample::{Sample, of_unit_length, outer};
use crate::views::view_plan::Request;
use crate::warp::WarpMap;
use glam::{DMat3, DVec2, DVec3};

/// The map of one output.
#[derive(Clone, Debug)]
pub(crate) struct OutputMap {
    /// Resolution in pixels; (0, 0) for an output that is not shown.
    pub size: (u32, u32),
    /// Distance of the outermost sampled places from the picture's sides, in pixels.
    pub inset: f64,
    pub(super) map: Map,
}

#[derive(Clone, Debug)]
pub(super) enum Map {
    Fisheye {
        aperture: f64,
        rotation: DMat3,
        offset: DVec3,
        full: bool,
    },
    Projector(Box<ProjectorMap>),
    /// `least`: squared width below which pixels count as wider, squared radians.
    Traced {
        map: Box<WarpMap>,
        eye: Pose,
        least: f64,
    },
    Perspective {
        rays: DMat3,
        picture: DMat3,
    },
}

/// Width of a pixel none of whose neighbours shows anything, radians.
const ALONE: f64 = 1e-3;

/// Least width of a domemaster's pixels, as a part of their nominal width.
const LEAST_WIDTH: f64 = 1e-3;

/// The opening whose picture coordinates are the tangents themselves. It replaces the program's own
/// lens, which is known only when the program draws.
pub(crate) const UNIT_FRUSTUM: Frustum = Frustum { left: -1.0, right: 1.0, bottom: -1.0, top: 1.0 };

/// Returns the rotation viewer axes → dome axes.
pub(crate) fn viewer_rotation(rig: &Rig) -> DMat3 {
    pose::rotation(rig.viewer.yaw, rig.viewer.pitch, rig.viewer.roll)
}

/// Returns the dome's pole in dome axes.
pub(crate) fn pole(rig: &Rig) -> DVec3 {
    DVec3::new(0.0, rig.dome.tilt.cos(), -rig.dome.tilt.sin())
}

/// Returns the rotation from a domemaster's lens axes to viewer axes: its centre lies `tilt`
/// radians from straight up.
pub(crate) fn lens_rotation(tilt: f64) -> DMat3 {
    pose::rotation(0.0, std::f64::consts::FRAC_PI_2 - tilt, 0.0)
}

/// Returns the matrix from normalised picture coordinates to a ray in viewer axes, for a
/// perspective output.
pub(crate) fn perspective_rays([yaw, pitch, roll]: [f64; 3], frustum: Option<&Frustum>) -> DMat3 {
    match frustum {
        Some(frustum) => pose::rotation(yaw, pitch, roll) * frustum.rays(),
        None => UNIT_FRUSTUM.rays(),
    }
}

/// Returns the maps of the first `outputs` outputs.
pub(in crate::views) fn all(rig: &Rig, outputs: usize, request: &Request) -> Result<Vec<OutputMap>> {
    let sizes = request.output_sizes.iter().take(outputs).enumerate();
    sizes.map(|(index, &size)| OutputMap::new(rig, index, size)).collect()
}

impl OutputMap {
    /// Makes the map of output `index` of `rig` at `size` pixels.
    ///
    /// # Errors
    /// Those of [`WarpMap::new`].
    pub fn new(rig: &Rig, index: usize, size: (u32, u32)) -> Result<Self> {
        let to_viewer = viewer_rotation(rig).transpose();
        let traced = |output: &Output| -> Result<Map> {
            // Maps that need the program's lens are not traced, so any lens will do.
            let map = WarpMap::new(rig, index, (size.0.max(1), size.1.max(1)), Some(UNIT_FRUSTUM))?;
            let width = |pixel| calibrated_sample(&map, pixel).map(|sample| pixel_width::squared_width(&sample.spread));
            let least = match output.kind {
                OutputKind::Mesh(_) => pixel_width::least(pixel_width::places(size).filter_map(width)),
                _ => 0.0,
            };
            Ok(Map::Traced { map: Box::new(map), eye: rig.eye(output), least })
        };
        let Some(output) = rig.outputs.get(index) else {
            return Err(Error::new(ErrorKind::InvalidArgument, format!("the rig has no output number {index}")));
        };
        let eye = rig.eye(output).position;
        let map = match &output.kind {
            OutputKind::Perspective { angles, frustum } => {
                let rays = perspective_rays(*angles, frustum.as_ref());
                Map::Perspective { rays, picture: rays.inverse() }
            }
            _ if rig.screen.is_some() => traced(output)?,
            OutputKind::Domemaster { aperture, tilt } => Map::Fisheye {
                aperture: *aperture,
                rotation: lens_rotation(*tilt),
                offset: -(to_viewer * eye) / rig.dome.radius,
                full: rig.views.resolution == Resolution::Full,
            },
            OutputKind::Projector { position, angles: [yaw, pitch, roll], frustum } => {
                Map::Projector(Box::new(ProjectorMap {
                    origin: *position,
                    rays: pose::rotation(*yaw, *pitch, *roll) * frustum.rays(),
                    picture: frustum.picture() * pose::rotation(*yaw, *pitch, *roll).transpose(),
                    radius: rig.dome.radius,
                    pole: pole(rig),
                    least_cosine: (rig.dome.coverage < std::f64::consts::TAU).then(|| (0.5 * rig.dome.coverage).cos()),
                    eye,
                    to_viewer,
                }))
            }
            OutputKind::Optics { .. } | OutputKind::Panorama { .. } | OutputKind::Mesh(_) => traced(output)?,
        };
        // The pixels' centres, or the outermost of four places in each.
        let inset = if rig.views.filter.has_four_places() { 0.125 } else { 0.5 };
        Ok(Self { size, inset, map })
    }

    /// True if the pixel of a sample is so much narrower than others of a calibration that it
    /// counts as wider.
    pub fn is_widened(&self, sample: &Sample) -> bool {
        matches!(self.map, Map::Traced { least, .. } if least > 0.0 && pixel_width::is_narrowest(&sample.spread, least))
    }

    /// True if the picture is a circle.
    pub fn is_circular(&self) -> bool {
        match &self.map {
            Map::Fisheye { .. } => true,
            Map::Traced { map, .. } => map.circle().is_some(),
            _ => false,
        }
    }

    /// True if directions change smoothly over the picture, except at rims.
    pub fn is_smooth(&self) -> bool {
        !matches!(&self.map, Map::Traced { map, .. } if !map.screen().is_smooth())
    }

    /// True if the output has a calibration, whose pixels alone tell where its picture ends.
    pub fn is_calibration(&self) -> bool {
        matches!(&self.map, Map::Traced { least, .. } if *least > 0.0)
    }

    /// Returns the parts of the picture without discontinuities, by their outermost sampled places,
    /// top left and bottom right.
    pub fn pieces(&self) -> Vec<[DVec2; 2]> {
        let count = match &self.map {
            Map::Traced { map, .. } => map.cubemap_faces(),
            _ => 1,
        };
        let bottom = f64::from(self.size.1) - 0.5;
        let piece = |face: u32| {
            let [left, right] = face_columns(self.size.0, count, face);
            [DVec2::new(left, 0.5), DVec2::new(right, bottom)]
        };
        let beside = 0.5 - self.inset;
        let pieces = (0..count).map(piece).filter(|[low, high]| high.x >= low.x);
        pieces.map(|[low, high]| [low - beside, high + beside]).collect()
    }

    /// Returns the centre and half the extent of the area that normalised coordinates −1…1 span:
    /// the circle, or the whole picture.
    fn frame(&self) -> (DVec2, DVec2) {
        let half = 0.5 * DVec2::new(f64::from(self.size.0), f64::from(self.size.1));
        match &self.map {
            Map::Fisheye { .. } => (half, DVec2::splat(half.min_element())),
            Map::Traced { map, .. } => map.circle().unwrap_or((half, half)),
            _ => (half, half),
        }
    }

    /// Converts a pixel position (from the top left, centres at +½) to normalised picture
    /// coordinates.
    pub fn normalised(&self, pixel: DVec2) -> DVec2 {
        let (center, half) = self.frame();
        (pixel - center) / half * DVec2::new(1.0, -1.0)
    }

    /// Converts normalised picture coordinates to a pixel position: the inverse of
    /// [`OutputMap::normalised`].
    pub fn pixel(&self, normalised: DVec2) -> DVec2 {
        let (center, half) = self.frame();
        center + normalised * half * DVec2::new(1.0, -1.0)
    }

    /// Returns the direction at a pixel position, and the spread of a pixel there; `None` where the
    /// output shows nothing, or the viewer is at the very point that is shown.
    ///
    /// A domemaster's pixel counts as a circle of its nominal size, aperture over diameter, on the
    /// dome. A higher tangential resolution is an artefact of the lens and shows no more detail; it
    /// counts only with `resolution = "full"`.
    pub fn sample(&self, pixel: DVec2) -> Option<Sample> {
        let at = self.normalised(pixel);
        match &self.map {
            Map::Fisheye { aperture, rotation, offset, full } => {
                let lens = *rotation * Fisheye { aperture: *aperture }.direction(at.x, at.y)?;
                let pitch = aperture / f64::from(self.size.0.min(self.size.1));
                let mut spread = DMat3::IDENTITY - outer(lens, lens);
                if *full {
                    let angle = 0.5 * aperture * at.length();
                    let around = -rotation.z_axis.cross(lens).normalize_or_zero();
                    // Around the point opposite to the centre pixels have no width at all.
                    let narrower = (angle.sin() / angle.max(1e-9)).max(LEAST_WIDTH);
                    spread -= outer(around, around) * if angle > 1e-9 { 1.0 - narrower * narrower } else { 0.0 };
                }
                of_unit_length(lens + *offset, spread * (pitch * pitch))
            }
            Map::Projector(map) => map.sample(&map.hit(at)?, self.per_pixel()),
            Map::Traced { map, least, .. } if *least > 0.0 => {
                let Sample { direction, spread } = calibrated_sample(map, pixel)?;
                let width = |sample: Sample| pixel_width::squared_width(&sample.spread);
                let beside = |apart: DVec2| calibrated_sample(map, pixel + apart).map(width);
                let least = pixel_width::least_beside(pixel_width::squared_width(&spread), *least, beside);
                Some(Sample { direction, spread: pixel_width::widened(direction, spread, least) })
            }
            Map::Traced { map, .. } => traced_sample(map, pixel),
            Map::Perspective { rays, .. } => {
                let per_pixel = self.per_pixel();
                let (across, down) = (rays.x_axis * per_pixel.x, rays.y_axis * per_pixel.y);
                of_unit_length(*rays * at.extend(1.0), outer(across, across) + outer(down, down))
            }
        }
    }

    /// As [`OutputMap::sample`]; where nothing is shown around the position, its pixel counts as
    /// [`ALONE`] wide.
    pub fn sample_or_disc(&self, pixel: DVec2) -> Option<Sample> {
        self.sample(pixel).or_else(|| {
            let direction = self.direction(pixel)?;
            Some(Sample { direction, spread: (DMat3::IDENTITY - outer(direction, direction)) * (ALONE * ALONE) })
        })
    }

    /// Returns the direction at a pixel position, as [`OutputMap::sample`] does, with less work.
    pub fn direction(&self, pixel: DVec2) -> Option<DVec3> {
        let at = self.normalised(pixel);
        let seen = match &self.map {
            Map::Fisheye { aperture, rotation, offset, .. } => {
                *rotation * Fisheye { aperture: *aperture }.direction(at.x, at.y)? + *offset
            }
            Map::Projector(map) => map.to_viewer * (map.hit(at)?.point - map.eye),
            Map::Traced { map, .. } => return map.direction(pixel),
            Map::Perspective { rays, .. } => *rays * at.extend(1.0),
        };
        let squared = seen.length_squared();
        (squared > 0.0 && squared.is_finite()).then(|| seen / squared.sqrt())
    }

    /// Returns the sample in a direction from the viewer (viewer axes, any length), if the output
    /// shows it.
    pub fn sample_towards(&self, direction: DVec3) -> Option<Sample> {
        let at = match &self.map {
            Map::Fisheye { aperture, rotation, offset, .. } => {
                let point = Sphere { center: DVec3::ZERO, radius: 1.0 }.far_hit(-*offset, direction)?;
                Fisheye { aperture: *aperture }.point(rotation.transpose() * point)
            }
            Map::Projector(map) => {
                let towards = map.to_viewer.transpose() * direction;
                let point = Sphere { center: DVec3::ZERO, radius: map.radius }.far_hit(map.eye, towards)?;
                let at = self.within_picture(map.picture * (point - map.origin))?;
                // From outside, the near side of the dome is in the picture too, but not lit.
                (map.hit(at)?.point.distance_squared(point) < 1e-6 * map.radius * map.radius).then_some(at)?
            }
            Map::Traced { map, eye, .. } => {
                let towards = eye.direction_to_parent(direction);
                let point = map.screen().unbounded_hit(eye.position, towards)?.point;
                return self.sample(traced_pixel(map, point)?);
            }
            Map::Perspective { picture, .. } => self.within_picture(*picture * direction)?,
        };
        self.sample(self.pixel(at))
    }

    /// Converts homogeneous to normalised picture coordinates, if they lie within the outermost
    /// pixel centres.
    pub(super) fn within_picture(&self, picture: DVec3) -> Option<DVec2> {
        let at = picture.truncate() / picture.z;
        let low = self.normalised(DVec2::new(0.5, f64::from(self.size.1) - 0.5));
        (picture.z > 0.0 && at.cmpge(low).all() && at.cmple(-low).all()).then_some(at)
    }

    /// Returns the change of normalised picture coordinates per pixel to the right and down.
    pub(super) fn per_pixel(&self) -> DVec2 {
        DVec2::new(2.0 / f64::from(self.size.0), -2.0 / f64::from(self.size.1))
    }
}

/// Distances at which a pixel's surroundings are sampled, pixels, in this order.
const STEPS: [f64; 4] = [0.5, 0.05, 0.005, 0.0005];
/// Returns the sample of a pixel. Its spread follows from differences over the shown part of its
/// surroundings.
///
/// In a picture with a nominal size of pixels, a pixel counts as a circle. Its diameter is the
/// pixel's height (away from the picture's pole), but at most the nominal size.
fn traced_sample(map: &WarpMap, pixel: DVec2) -> Option<Sample> {
    let direction = map.direction(pixel)?;
    // A pixel across the border of two pictures is no neighbour.
    let cubemap_faces = f64::from(map.cubemap_faces());
    let face = (pixel.x * cubemap_faces / f64::from(map.size().0)).floor();
    let beside = |x: f64| {
        let from_left = x * cubemap_faces / f64::from(map.size().0) - face;
        cubemap_faces == 1.0 || (from_left > 0.0 && from_left < 1.0)
    };
    let along = |axis: DVec2| {
        let there = |offset: f64| {
            let place = pixel + axis * offset;
            Some((map.direction(place).filter(|_| beside(place.x))?, offset))
        };
        // The shown part may be narrower than a pixel.
        let end = |side: f64| STEPS.iter().find_map(|step| there(side * step)).unwrap_or((direction, 0.0));
        let ((from, start), (to, stop)) = (end(-1.0), end(1.0));
        if stop > start { (to - from) / (stop - start) } else { DVec3::ZERO }
    };
    if let Some(nominal) = map.nominal_pitch() {
        let from_pole = map.circle().map_or(DVec2::Y, |(center, _)| (pixel - center).normalize_or(DVec2::Y));
        let height = along(from_pole).length();
        let pitch = if height > 0.0 { nominal.min(height) } else { nominal };
        return of_unit_length(direction, (DMat3::IDENTITY - outer(direction, direction)) * (pitch * pitch));
    }
    let (mut across, mut down) = (along(DVec2::X), along(DVec2::Y));
    // If a rim leaves a pixel no neighbours on one axis, it counts as wide as on the other.
    if across == DVec3::ZERO {
        across = direction.cross(down);
    } else if down == DVec3::ZERO {
        down = direction.cross(across);
    }
    (across != DVec3::ZERO).then(|| of_unit_length(direction, outer(across, across) + outer(down, down)))?
}

/// As [`traced_sample`], for a calibration, whose neighbouring pixels may show places far apart.
fn calibrated_sample(map: &WarpMap, pixel: DVec2) -> Option<Sample> {
    let Sample { direction, spread } = traced_sample(map, pixel)?;
    Some(Sample { direction, spread: pixel_width::across(direction, spread) })
}

/// Returns the pixel position, within the outermost pixel centres of a picture without
/// discontinuities, that shows a point of the screen.
///
/// On the border of two such pictures, rounding would decide in which of them the point is sampled.
pub(super) fn traced_pixel(map: &WarpMap, point: DVec3) -> Option<DVec2> {
    let pixel = map.pixel(point)?;
    let (width, height) = (f64::from(map.size().0), f64::from(map.size().1));
    let cubemap_faces = map.cubemap_faces();
    let face = (pixel.x * f64::from(cubemap_faces) / width).clamp(0.0, f64::from(cubemap_faces - 1)) as u32;
    let [left, right] = face_columns(map.size().0, cubemap_faces, face);
    ((left..=right).contains(&pixel.x) && (0.5..=height - 0.5).contains(&pixel.y)).then_some(pixel)
}

/// Returns the outermost pixel centres of one of `count` pictures side by side in an output of
/// `width` pixels. If the picture has no pixel centre, the first is beyond the second.
fn face_columns(width: u32, count: u32, face: u32) -> [f64; 2] {
    // Index of the first column whose centre is in a face.
    let first = |face: u32| (f64::from(face) * f64::from(width) / f64::from(count) - 0.5).ceil().max(0.0);
    [first(face) + 0.5, first(face + 1) - 0.5]
}
