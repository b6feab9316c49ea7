//! A projector with free numbers.

use crate::error::{Error, ErrorKind, Result};
use crate::geom::{Circle, Lens, Optics, Pose};
use crate::rig::{Flip, Output, OutputKind};
use glam::{DMat3, DVec2, DVec3};
use std::ops::Range;

/// A group of numbers of a projector that is free or not.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Place and orientation.
    Pose,
    /// Horizontal and vertical opening; of a fisheye, the size of its circle.
    Fov,
    /// Lens shift; of a fisheye, the centre of its circle.
    Shift,
    /// The first two radial coefficients of a pinhole's distortion.
    Radial,
    /// The tangential coefficients.
    Tangential,
    /// Centre and radius of the mirror.
    Mirror,
}

impl Part {
    /// All parts.
    pub const ALL: [Self; 6] = [Self::Pose, Self::Fov, Self::Shift, Self::Radial, Self::Tangential, Self::Mirror];

    /// Number of parameters of the part.
    pub fn parameters(self) -> usize {
        match self {
            Self::Pose => 6,
            Self::Mirror => 4,
            _ => 2,
        }
    }

    /// Name of the part in messages and options.
    pub fn word(self) -> &'static str {
        match self {
            Self::Pose => "pose",
            Self::Fov => "fov",
            Self::Shift => "shift",
            Self::Radial => "radial",
            Self::Tangential => "tangential",
            Self::Mirror => "mirror",
        }
    }
}

/// A projector that starts from the numbers of the rig. Parameters are differences from the start,
/// where all are 0.
#[derive(Clone, Debug)]
pub struct Projector {
    start: Optics,
    size: (u32, u32),
    flip: Flip,
    parts: Vec<Part>,
    /// Unit of lengths, metres.
    unit: f64,
}

impl Projector {
    /// Takes an output of a rig with a picture of `size` pixels, of which `parts` are free. The
    /// unit of lengths is `unit` metres: the size of the screen.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidArgument`] if the output is no projector, or has no such parts.
    pub fn new(output: &Output, size: (u32, u32), parts: &[Part], unit: f64) -> Result<Self> {
        let invalid = |why: String| Error::new(ErrorKind::InvalidArgument, format!("output \"{}\" {why}", output.name));
        let start = match &output.kind {
            OutputKind::Projector { position, angles: [yaw, pitch, roll], frustum } => {
                Optics { pose: Pose::new(*position, *yaw, *pitch, *roll), lens: Lens::pinhole(*frustum), mirror: None }
            }
            OutputKind::Optics { optics, .. } => optics.as_ref().clone(),
            _ => return Err(invalid("is no projector; only those of kind = \"projector\" can be calibrated".into())),
        };
        for part in parts {
            let lacks = match part {
                Part::Radial | Part::Tangential if matches!(start.lens, Lens::Fisheye { .. }) => {
                    "has a fisheye, whose distortion is its projection"
                }
                Part::Mirror if start.mirror.is_none() => "has no mirror",
                _ => continue,
            };
            return Err(invalid(format!("{lacks}; {} cannot be free", part.word())));
        }
        Ok(Self { start, size, flip: output.flip, parts: parts.to_vec(), unit })
    }

    /// The same projector with another start and other free parts.
    pub fn with(&self, start: Optics, parts: &[Part]) -> Self {
        Self { start, parts: parts.to_vec(), ..self.clone() }
    }

    /// Number of parameters.
    pub fn parameters(&self) -> usize {
        self.parts.iter().map(|part| part.parameters()).sum()
    }

    /// Free parts, in the order of their parameters.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// Indices of the parameters of a part.
    pub fn range(&self, part: Part) -> Option<Range<usize>> {
        let place = self.parts.iter().position(|own| *own == part)?;
        let start = self.parts[..place].iter().map(|part| part.parameters()).sum();
        Some(start..start + part.parameters())
    }

    /// Unit of lengths of the parameters, in metres.
    pub fn unit(&self) -> f64 {
        self.unit
    }

    /// Width and height of the picture in pixels.
    pub fn size(&self) -> (u32, u32) {
        self.size
    }

    /// Optics with these parameters.
    pub fn optics(&self, parameters: &[f64]) -> Optics {
        let mut optics = self.start.clone();
        let mut rest = parameters;
        for part in &self.parts {
            let (own, after) = rest.split_at(part.parameters().min(rest.len()));
            self.apply(*part, own, &mut optics);
            rest = after;
        }
        optics
    }

    fn apply(&self, part: Part, values: &[f64], optics: &mut Optics) {
        match (part, values, &mut optics.lens) {
            (Part::Pose, &[x, y, z, a, b, c], _) => {
                optics.pose.position += self.unit * DVec3::new(x, y, z);
                optics.pose.rotation *= DMat3::from_quat(glam::DQuat::from_scaled_axis(DVec3::new(a, b, c)));
            }
            (Part::Fov, &[x, y], Lens::Pinhole { frustum, .. }) => {
                for (side, factor) in [
                    (&mut frustum.left, 1.0 + x),
                    (&mut frustum.right, 1.0 + x),
                    (&mut frustum.bottom, 1.0 + y),
                    (&mut frustum.top, 1.0 + y),
                ] {
                    *side *= factor;
                }
            }
            (Part::Shift, &[x, y], Lens::Pinhole { frustum, .. }) => *frustum = frustum.shifted(x, y),
            (Part::Fov | Part::Shift, &[x, y], Lens::Fisheye { circle, .. }) => {
                let aspect = f64::from(self.size.0) / f64::from(self.size.1);
                let mut center = circle.to_picture(DVec2::ZERO, aspect);
                let mut half = circle.to_picture(DVec2::ONE, aspect) - center;
                if part == Part::Fov {
                    half *= 1.0 + DVec2::new(x, y);
                } else {
                    center += 2.0 * DVec2::new(x, y);
                }
                *circle = Circle::Placed { center, half };
            }
            (Part::Radial, &[k1, k2], Lens::Pinhole { distortion, .. }) => {
                distortion.radial[0] += k1;
                distortion.radial[1] += k2;
            }
            (Part::Tangential, &[p1, p2], Lens::Pinhole { distortion, .. }) => {
                distortion.tangential[0] += p1;
                distortion.tangential[1] += p2;
            }
            (Part::Mirror, &[x, y, z, radius], _) => {
                if let Some(mirror) = &mut optics.mirror {
                    mirror.center += self.unit * DVec3::new(x, y, z);
                    mirror.radius *= 1.0 + radius;
                }
            }
            // `new` refuses this part, or there are too few values.
            _ => {}
        }
    }

    fn aspect(&self) -> f64 {
        f64::from(self.size.0) / f64::from(self.size.1)
    }

    fn half(&self) -> DVec2 {
        0.5 * DVec2::new(f64::from(self.size.0), f64::from(self.size.1))
    }

    /// Pixel in which a point appears, perhaps beside the picture.
    pub fn pixel(&self, optics: &Optics, point: DVec3) -> Option<DVec2> {
        let picture = optics.picture(point, self.aspect())?;
        let pixel = (1.0 + picture * DVec2::new(1.0, -1.0)) * self.half();
        pixel.is_finite().then(|| self.flip.pixel(pixel, self.size))
    }

    /// Point from which the light of a pixel goes to the screen, and its direction.
    pub fn ray(&self, optics: &Optics, pixel: DVec2) -> Option<(DVec3, DVec3)> {
        let picture = self.flip.pixel(pixel, self.size) / self.half() - 1.0;
        optics.ray(picture * DVec2::new(1.0, -1.0), self.aspect())
    }

    /// Angle between a pixel's ray and the lens' axis, radians; `None` where the lens has no ray.
    pub fn off_axis(&self, optics: &Optics, pixel: DVec2) -> Option<f64> {
        let picture = self.flip.pixel(pixel, self.size) / self.half() - 1.0;
        let ray = optics.lens.ray(picture * DVec2::new(1.0, -1.0), self.aspect())?;
        Some(ray.x.hypot(ray.y).atan2(-ray.z))
    }

    /// True if a place is in the picture.
    pub fn shows(&self, pixel: DVec2) -> bool {
        pixel.cmpge(DVec2::ZERO).all() && pixel.cmple(2.0 * self.half()).all()
    }
}
