//! What each output looks at: pixel → direction from the viewer, and how far a pixel reaches.
//!
//! The planner's own map. It is written as plain ray tracing, so that it is independent of the
//! closed forms that the passes use; the tests compare the two.

use crate::geom::{Fisheye, Frustum, pose};
use crate::rig::{Output, OutputKind, Rig};
use glam::{DMat3, DVec2, DVec3};

/// A direction that an output shows, and how densely its pixels sample around it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    /// Direction from the viewer, viewer axes, unit length.
    pub direction: DVec3,
    /// `J·Jᵀ`, where J holds the change of the direction over one pixel to the right and over one
    /// pixel down: the shape of a pixel's disc on the sphere of directions, in squared radians.
    pub spread: DMat3,
}

/// The map of one output.
#[derive(Clone, Debug)]
pub(crate) struct Sight {
    /// Resolution in pixels.
    pub size: (u32, u32),
    map: Map,
}

#[derive(Clone, Debug)]
enum Map {
    Fisheye { aperture: f64, rotation: DMat3, offset: DVec3 },
    Projector(Box<ProjectorMap>),
    Perspective { rays: DMat3 },
}

/// Everything in dome axes, but for `to_viewer`.
#[derive(Clone, Debug)]
struct ProjectorMap {
    origin: DVec3,
    rays: DMat3,
    radius: f64,
    pole: DVec3,
    /// Least cosine of the angle from the pole; `None` = the whole sphere is screen.
    least_cosine: Option<f64>,
    eye: DVec3,
    to_viewer: DMat3,
}

/// The opening whose picture coordinates are the tangents themselves; it stands for the program's
/// own lens, which is known only when the program draws.
pub(crate) const UNIT_FRUSTUM: Frustum = Frustum { left: -1.0, right: 1.0, bottom: -1.0, top: 1.0 };

/// Axes of the viewer → axes of the dome.
pub(crate) fn viewer_rotation(rig: &Rig) -> DMat3 {
    pose::rotation(rig.viewer.yaw, rig.viewer.pitch, rig.viewer.roll)
}

/// The dome's pole in dome axes.
pub(crate) fn pole(rig: &Rig) -> DVec3 {
    DVec3::new(0.0, rig.dome.tilt.cos(), -rig.dome.tilt.sin())
}

/// Lens axes of a domemaster → viewer axes: its centre lies `tilt` radians from straight up.
pub(crate) fn lens_rotation(tilt: f64) -> DMat3 {
    pose::rotation(0.0, std::f64::consts::FRAC_PI_2 - tilt, 0.0)
}

/// Normalised picture coordinates → ray in viewer axes, for a perspective output.
pub(crate) fn perspective_rays(angles: [f64; 3], frustum: Option<&Frustum>) -> DMat3 {
    match frustum {
        Some(frustum) => pose::rotation(angles[0], angles[1], angles[2]) * frustum.rays(),
        None => UNIT_FRUSTUM.rays(),
    }
}

impl Sight {
    /// The map of `output` at `size` pixels.
    pub fn new(rig: &Rig, output: &Output, size: (u32, u32)) -> Self {
        let to_viewer = viewer_rotation(rig).transpose();
        let map = match &output.kind {
            OutputKind::Domemaster { aperture, tilt } => Map::Fisheye {
                aperture: *aperture,
                rotation: lens_rotation(*tilt),
                offset: -(to_viewer * rig.viewer.position) / rig.dome.radius,
            },
            OutputKind::Projector { position, angles, frustum } => Map::Projector(Box::new(ProjectorMap {
                origin: *position,
                rays: pose::rotation(angles[0], angles[1], angles[2]) * frustum.rays(),
                radius: rig.dome.radius,
                pole: pole(rig),
                least_cosine: (rig.dome.coverage < std::f64::consts::TAU).then(|| (0.5 * rig.dome.coverage).cos()),
                eye: rig.viewer.position,
                to_viewer,
            })),
            OutputKind::Perspective { angles, frustum } => {
                Map::Perspective { rays: perspective_rays(*angles, frustum.as_ref()) }
            }
        };
        Self { size, map }
    }

    /// Whether the picture is a circle inscribed in the output.
    pub fn is_circular(&self) -> bool {
        matches!(self.map, Map::Fisheye { .. })
    }

    /// Pixel position (from the top left, centres at +½) → normalised picture coordinates.
    pub fn normalised(&self, pixel: DVec2) -> DVec2 {
        let (width, height) = (f64::from(self.size.0), f64::from(self.size.1));
        let (across, down) = if self.is_circular() { (width.min(height), width.min(height)) } else { (width, height) };
        DVec2::new((2.0 * pixel.x - width) / across, (height - 2.0 * pixel.y) / down)
    }

    /// Normalised picture coordinates → pixel position: the inverse of [`Sight::normalised`].
    pub fn pixel(&self, normalised: DVec2) -> DVec2 {
        let (width, height) = (f64::from(self.size.0), f64::from(self.size.1));
        let (across, down) = if self.is_circular() { (width.min(height), width.min(height)) } else { (width, height) };
        DVec2::new(0.5 * (normalised.x * across + width), 0.5 * (height - normalised.y * down))
    }

    /// The direction seen at a pixel position, viewer axes, any length; `None` where the output shows nothing.
    pub fn direction(&self, pixel: DVec2) -> Option<DVec3> {
        let at = self.normalised(pixel);
        match &self.map {
            Map::Fisheye { aperture, rotation, offset } => {
                Fisheye { aperture: *aperture }.direction(at.x, at.y).map(|lens| *rotation * lens + *offset)
            }
            Map::Projector(map) => map.hit(at).map(|hit| map.to_viewer * (hit.point - map.eye)),
            Map::Perspective { rays } => Some(*rays * at.extend(1.0)),
        }
    }

    /// The direction seen at a pixel position and the spread of a pixel there; `None` where the
    /// output shows nothing or the viewer stands in the very point that is seen.
    ///
    /// A domemaster's pixel is a circle of its nominal size, aperture over diameter, on the dome:
    /// its own tangential resolution beyond that is an artefact of the lens and shows no more detail.
    pub fn sample(&self, pixel: DVec2) -> Option<Sample> {
        let at = self.normalised(pixel);
        let per_pixel = DVec2::new(2.0 / f64::from(self.size.0), -2.0 / f64::from(self.size.1));
        let (direction, spread) = match &self.map {
            Map::Fisheye { aperture, rotation, offset } => {
                let lens = *rotation * Fisheye { aperture: *aperture }.direction(at.x, at.y)?;
                let pitch = aperture / f64::from(self.size.0.min(self.size.1));
                (lens + *offset, (DMat3::IDENTITY - outer(lens, lens)) * (pitch * pitch))
            }
            Map::Projector(map) => {
                let hit = map.hit(at)?;
                let across = map.to_viewer * hit.moved_by(map.rays.x_axis * per_pixel.x);
                let down = map.to_viewer * hit.moved_by(map.rays.y_axis * per_pixel.y);
                (map.to_viewer * (hit.point - map.eye), outer(across, across) + outer(down, down))
            }
            Map::Perspective { rays } => {
                let (across, down) = (rays.x_axis * per_pixel.x, rays.y_axis * per_pixel.y);
                (*rays * at.extend(1.0), outer(across, across) + outer(down, down))
            }
        };
        let squared = direction.length_squared();
        let usable = squared > 0.0 && squared.is_finite() && spread.is_finite();
        usable.then(|| Sample { direction: direction / squared.sqrt(), spread: spread * (1.0 / squared) })
    }
}

/// `a·bᵀ`.
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// Where a projector's ray meets the dome.
struct Hit {
    point: DVec3,
    ray: DVec3,
    /// How many rays long the way is.
    distance: f64,
}

impl Hit {
    /// How the point moves on the dome when the ray changes by `change`.
    fn moved_by(&self, change: DVec3) -> DVec3 {
        // The point stays on the sphere: its motion is across its own radius.
        (change - self.ray * (self.point.dot(change) / self.point.dot(self.ray))) * self.distance
    }
}

impl ProjectorMap {
    /// The far meeting of the ray with the sphere, if it lies ahead and on the screen.
    fn hit(&self, at: DVec2) -> Option<Hit> {
        let ray = self.rays * at.extend(1.0);
        let squared = ray.length_squared();
        let along = ray.dot(self.origin) / squared;
        let foot = self.origin - ray * along;
        let rest = self.radius * self.radius - foot.length_squared();
        if rest < 0.0 {
            return None;
        }
        let distance = (rest / squared).sqrt() - along;
        let point = self.origin + ray * distance;
        let on_screen = self.least_cosine.is_none_or(|least| point.dot(self.pole) >= least * self.radius);
        (distance > 0.0 && on_screen).then_some(Hit { point, ray, distance })
    }
}
