//! Pictures of all directions around a point: fisheyes, equirectangular and cylindrical pictures,
//! the faces of a cube.

use crate::geom::FisheyeLens;

use crate::geom::lenses::lens::Circle;
use glam::{DVec2, DVec3};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Projection of directions to a picture. Its axes: x right, y up, −z the middle of the picture.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub enum Panorama {
    /// A circle, inscribed and centred, black around it.
    Fisheye(FisheyeLens),
    /// Longitude across and latitude up, in equal steps.
    Equirectangular(Span),
    /// Longitude across in equal steps; heights as on the wall of a cylinder.
    Cylindrical(Span),
    /// The six faces of a cube, side by side: right, left, up, down, front, back. Each face is the
    /// picture of a viewer who turns to it by the shortest way from the front (to the back by way
    /// of the right).
    CubeStrip,
}

/// The part of the directions that an unrolled picture shows.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Span {
    /// Longitude from side to side, radians, 0 < width ≤ 2π.
    pub width: f64,
    /// Latitude of the lower border, radians.
    pub bottom: f64,
    /// Latitude of the upper border, radians, above `bottom`.
    pub top: f64,
}

/// Right, up and backward axes of the faces of a [`Panorama::CubeStrip`], from the left.
pub const STRIP_FACES: [[DVec3; 3]; 6] = [
    [DVec3::Z, DVec3::Y, DVec3::NEG_X],
    [DVec3::NEG_Z, DVec3::Y, DVec3::X],
    [DVec3::X, DVec3::Z, DVec3::NEG_Y],
    [DVec3::X, DVec3::NEG_Z, DVec3::Y],
    [DVec3::X, DVec3::Y, DVec3::Z],
    [DVec3::NEG_X, DVec3::Y, DVec3::NEG_Z],
];

impl Span {
    /// Latitude of the middle and half of the height.
    pub fn latitudes(&self) -> (f64, f64) {
        (0.5 * (self.bottom + self.top), 0.5 * (self.top - self.bottom))
    }

    /// Height of the middle and half of the height on a cylinder of radius 1.
    pub fn heights(&self) -> (f64, f64) {
        let (bottom, top) = (self.bottom.tan(), self.top.tan());
        (0.5 * (bottom + top), 0.5 * (top - bottom))
    }
}

impl Panorama {
    /// Returns the unit direction at a point of a picture (−1…1 both ways) whose width is `aspect`
    /// times its height; `None` if nothing is shown there.
    pub fn direction(&self, picture: DVec2, aspect: f64) -> Option<DVec3> {
        if !(picture.abs().cmple(DVec2::ONE).all() && aspect > 0.0) {
            return None;
        }
        match self {
            Self::Fisheye(lens) => lens.direction(Circle::Inscribed.to_disc(picture, aspect)),
            Self::Equirectangular(span) => {
                let (middle, half) = span.latitudes();
                let (sine, cosine) = (middle + half * picture.y).sin_cos();
                let (x, z) = (0.5 * span.width * picture.x).sin_cos();
                Some(DVec3::new(x * cosine, sine, -z * cosine))
            }
            Self::Cylindrical(span) => {
                let (middle, half) = span.heights();
                let (x, z) = (0.5 * span.width * picture.x).sin_cos();
                Some(DVec3::new(x, middle + half * picture.y, -z).normalize())
            }
            Self::CubeStrip => {
                let along = 3.0 * (picture.x + 1.0);
                let face = along.floor().min(5.0);
                let [right, up, back] = STRIP_FACES[face as usize];
                let across = 2.0 * (along - face) - 1.0;
                Some((right * across + up * picture.y - back).normalize())
            }
        }
    }

    /// Returns the position of a direction of any length; `None` if the picture does not show it. A
    /// direction on a seam of the picture gets a position on one of the sides.
    pub fn picture(&self, direction: DVec3, aspect: f64) -> Option<DVec2> {
        match self {
            Self::Fisheye(lens) => Some(Circle::Inscribed.to_picture(lens.point(direction)?, aspect)),
            Self::Equirectangular(span) => {
                let (middle, half) = span.latitudes();
                let latitude = direction.y.atan2(direction.x.hypot(direction.z));
                within(DVec2::new(longitude(direction, span), (latitude - middle) / half))
            }
            Self::Cylindrical(span) => {
                let (middle, half) = span.heights();
                let height = direction.y / direction.x.hypot(direction.z);
                within(DVec2::new(longitude(direction, span), (height - middle) / half))
            }
            Self::CubeStrip => {
                // The face whose axis is nearest.
                let ahead = |face: usize| -direction.dot(STRIP_FACES[face][2]);
                let face = (0..6).max_by(|&a, &b| ahead(a).total_cmp(&ahead(b)))?;
                let [right, up, _] = STRIP_FACES[face];
                let depth = ahead(face);
                let along = 0.5 * (direction.dot(right) / depth + 1.0) + face as f64;
                (depth > 0.0).then(|| DVec2::new(along / 3.0 - 1.0, direction.dot(up) / depth))
            }
        }
    }

    /// Returns the nominal angle of a pixel of a picture of `size` pixels, radians: of its width or
    /// its height, whichever is less.
    pub fn pixel(&self, size: (u32, u32)) -> f64 {
        let (width, height) = (f64::from(size.0.max(1)), f64::from(size.1.max(1)));
        match self {
            Self::Fisheye(lens) => lens.aperture / width.min(height),
            Self::Equirectangular(span) | Self::Cylindrical(span) => {
                (span.width / width).min((span.top - span.bottom) / height)
            }
            Self::CubeStrip => FRAC_PI_2 / (width / STRIP_FACES.len() as f64).max(height),
        }
    }

    /// Returns half the opening, radians, of a cone around the middle whose directions are all in
    /// the picture. Infinite if the picture shows all directions, `None` if there is no simple
    /// cone.
    pub fn half_of_cap(&self) -> Option<f64> {
        let is_whole = |span: &Span| span.width >= TAU && span.top >= FRAC_PI_2 && span.bottom <= -FRAC_PI_2;
        match self {
            Self::Fisheye(lens) if lens.aperture < TAU => Some(0.5 * lens.aperture),
            Self::Fisheye(_) | Self::CubeStrip => Some(f64::INFINITY),
            Self::Equirectangular(span) => is_whole(span).then_some(f64::INFINITY),
            Self::Cylindrical(_) => None,
        }
    }

    /// True if the picture is a circle.
    pub fn is_circular(&self) -> bool {
        matches!(self, Self::Fisheye(_))
    }
}

fn longitude(direction: DVec3, span: &Span) -> f64 {
    direction.x.atan2(-direction.z) / (0.5 * span.width)
}

/// Returns a position if it is in the picture. The sides belong to the picture, also after
/// rounding.
fn within(picture: DVec2) -> Option<DVec2> {
    const ROUNDING: f64 = 1e-12;
    let inside = picture.abs().cmple(DVec2::splat(1.0 + ROUNDING)).all();
    inside.then(|| picture.clamp(DVec2::NEG_ONE, DVec2::ONE))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::Projection;
    use crate::testing::random::Random;
    use std::f64::consts::FRAC_PI_4;

    fn all() -> [Panorama; 4] {
        let whole = Span { width: TAU, bottom: -FRAC_PI_2, top: FRAC_PI_2 };
        let wall = Span { width: 4.0, bottom: -0.3, top: 0.9 };
        [
            Panorama::Fisheye(FisheyeLens { projection: Projection::Equisolid, aperture: 4.0 }),
            Panorama::Equirectangular(whole),
            Panorama::Cylindrical(wall),
            Panorama::CubeStrip,
        ]
    }

    #[test]
    fn directions_and_pictures_are_inverse() {
        let mut random = Random::new(51);
        for panorama in all() {
            let mut seen = 0;
            for _ in 0..5_000 {
                let picture = DVec2::new(random.range(-1.0, 1.0), random.range(-1.0, 1.0));
                let Some(direction) = panorama.direction(picture, 1.7) else { continue };
                assert!((direction.length() - 1.0).abs() < 1e-14);
                let back = panorama.picture(direction * random.range(1e-3, 1e3), 1.7).expect("shown");
                assert!(back.distance(picture) < 1e-11, "{panorama:?} {picture} {back}");
                seen += 1;
            }
            assert!(seen > 2_000, "{panorama:?}");
            assert_eq!(panorama.direction(DVec2::new(1.1, 0.0), 1.0), None);
            assert_eq!(panorama.direction(DVec2::NAN, 1.0), None);
        }
    }

    #[test]
    fn pixels_are_as_wide_as_the_picture_says() {
        let expected = [4.0 / 640.0, TAU / 1920.0, 1.2 / 640.0, FRAC_PI_2 / 640.0];
        for (panorama, expected) in all().into_iter().zip(expected) {
            assert!((panorama.pixel((1920, 640)) / expected - 1.0).abs() < 1e-12, "{panorama:?}");
        }
        let [_, equirectangular, ..] = all();
        // Two neighbouring pixels in the middle.
        let at = |x: f64| equirectangular.direction(DVec2::new(x, 0.0), 3.0).expect("shown");
        let apart = at(0.0).cross(at(2.0 / 1920.0)).length().asin();
        assert!((apart / equirectangular.pixel((1920, 640)) - 1.0).abs() < 1e-6, "{apart}");
    }

    #[test]
    fn known_places() {
        let [_, equirectangular, cylinder, strip] = all();
        let at = |panorama: &Panorama, x: f64, y: f64| panorama.direction(DVec2::new(x, y), 2.0).expect("shown");
        let near = |a: DVec3, b: DVec3| assert!(a.distance(b) < 1e-14, "{a} {b}");
        near(at(&equirectangular, 0.0, 0.0), DVec3::NEG_Z);
        near(at(&equirectangular, 0.5, 0.0), DVec3::X);
        near(at(&equirectangular, 0.25, 0.5), DVec3::new(0.5, FRAC_PI_4.sin(), -0.5));
        near(at(&equirectangular, 0.3, 1.0), DVec3::Y);
        // Heights are tangents: the middle of the picture is at their mean.
        let middle = 0.5 * ((-0.3f64).tan() + 0.9f64.tan());
        near(at(&cylinder, 0.0, 0.0), DVec3::new(0.0, middle, -1.0).normalize());
        for (face, towards) in
            [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::NEG_Z, DVec3::Z].iter().enumerate()
        {
            near(at(&strip, (face as f64 + 0.5) / 3.0 - 1.0, 0.0), *towards);
        }
        // The lower border of the upper face is the upper one of the front.
        near(at(&strip, 2.5 / 3.0 - 1.0, -1.0), at(&strip, 4.5 / 3.0 - 1.0, 1.0));
        near(at(&strip, 3.5 / 3.0 - 1.0, 1.0), at(&strip, 4.5 / 3.0 - 1.0, -1.0));
    }
}
