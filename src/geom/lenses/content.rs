//! Picture of directions in a part of a window, for programs that project the scene themselves.

use crate::geom::lenses::panorama::Panorama;
use glam::{DMat3, DVec2, DVec3};

/// Projection of a content picture.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub enum ContentPicture {
    /// Directions around the dome's centre. A fisheye's circle touches all four sides.
    Directions(Panorama),
    /// A plane in front of the viewer.
    Flat {
        /// Half its width and height at distance 1: tangents to the right and upwards.
        half: DVec2,
    },
}

/// Rectangle of a window, in parts of the window's width and height from the bottom left.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Region {
    /// Lower left corner.
    pub origin: DVec2,
    /// Width and height.
    pub size: DVec2,
}

/// Map from directions to positions in a window.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct ContentMap {
    /// Projection of the picture.
    pub picture: ContentPicture,
    /// Viewer axes → picture axes: x right, y up, −z through the middle.
    pub rotation: DMat3,
    /// Rectangle of the picture in the window.
    pub region: Region,
}

impl ContentPicture {
    /// Width divided by height of a picture with square pixels; `None` if any ratio is possible.
    pub fn aspect(&self) -> Option<f64> {
        match self {
            Self::Directions(Panorama::Fisheye(_)) => Some(1.0),
            Self::Directions(Panorama::Equirectangular(span)) => Some(span.width / (span.top - span.bottom)),
            Self::Directions(Panorama::Cylindrical(span)) => Some(0.5 * span.width / span.heights().1),
            Self::Directions(Panorama::CubeStrip) => Some(6.0),
            Self::Flat { .. } => None,
        }
    }

    /// Returns the position of a direction (any length, picture axes) in the picture, −1…1 from the
    /// left and from the bottom; `None` if the picture does not show it.
    pub fn place(&self, direction: DVec3) -> Option<DVec2> {
        match self {
            Self::Directions(panorama) => panorama.picture(direction, 1.0),
            Self::Flat { half } => {
                let place = direction.truncate() / (-direction.z * *half);
                (direction.z < 0.0 && place.abs().cmple(DVec2::ONE).all()).then_some(place)
            }
        }
    }
}

/// Tolerance, in pixels, for a border that is at a whole pixel except for rounding.
const ROUNDING: f64 = 1e-6;

impl Region {
    /// The whole window.
    pub const WHOLE: Self = Self { origin: DVec2::ZERO, size: DVec2::ONE };

    /// Returns the largest centred rectangle with the ratio `aspect` of width to height, in a
    /// window with the ratio `window`.
    pub fn fitting(aspect: f64, window: f64) -> Self {
        let size = DVec2::new((aspect / window).min(1.0), (window / aspect).min(1.0));
        Self { origin: 0.5 * (1.0 - size), size }
    }

    /// Returns the nearest rectangle of whole pixels, at least one, in a window of this size in
    /// pixels. If two are equally near, it is the left or upper one, as in media players.
    pub fn of_whole_pixels(&self, window: DVec2) -> Self {
        let size = (self.size * window).round().max(DVec2::ONE);
        let corner = self.origin * window;
        let origin = DVec2::new((corner.x - 0.5 - ROUNDING).ceil(), (corner.y + 0.5 + ROUNDING).floor());
        Self { origin: origin.clamp(DVec2::ZERO, window - size) / window, size: size / window }
    }

    /// Returns the rectangle whose position and size in this rectangle are those of `part` in the
    /// whole window.
    pub fn part(&self, part: &Self) -> Self {
        Self { origin: self.origin + part.origin * self.size, size: self.size * part.size }
    }
}

impl ContentMap {
    /// Returns the position of a direction (any length, viewer axes) in the window, as parts of its
    /// width and height from the bottom left; `None` if the window does not show it.
    pub fn place(&self, direction: DVec3) -> Option<DVec2> {
        let place = self.picture.place(self.rotation * direction)?;
        Some(self.region.origin + (0.5 + 0.5 * place) * self.region.size)
    }

    /// True if all directions within `reach` radians of any of `directions` are in the picture.
    /// Also false if this is not certain.
    pub fn surely_shows(&self, directions: &[DVec3], reach: f64) -> bool {
        let ContentPicture::Directions(panorama) = &self.picture else { return false };
        let Some(half) = panorama.half_of_cap() else { return false };
        directions.iter().all(|direction| {
            let local = self.rotation * *direction;
            local.truncate().length().atan2(-local.z) + reach < half
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geom::lenses::panorama::Span;
    use crate::geom::{FisheyeLens, Projection, pose};
    use crate::testing::random::Random;
    use std::f64::consts::{FRAC_PI_2, PI, TAU};

    #[test]
    fn a_region_fits_into_the_window() {
        let wide = Region::fitting(1.0, 16.0 / 9.0);
        assert!(wide.size.distance(DVec2::new(9.0 / 16.0, 1.0)) < 1e-15 && wide.origin.y == 0.0);
        let high = Region::fitting(6.0, 3.0);
        assert!(high.size.distance(DVec2::new(1.0, 0.5)) < 1e-15 && (high.origin.y - 0.25).abs() < 1e-15);
        let odd = Region::fitting(1.0, 161.0 / 100.0).of_whole_pixels(DVec2::new(161.0, 100.0));
        let placed = Region { origin: DVec2::new(30.0, 0.0), size: DVec2::splat(100.0) };
        let pixels = |part: DVec2| (part * DVec2::new(161.0, 100.0)).round();
        assert_eq!((pixels(odd.origin), pixels(odd.size)), (placed.origin, placed.size));
        let right = Region { origin: DVec2::new(0.5, 0.0), size: DVec2::new(0.5, 1.0) };
        assert_eq!(high.part(&right), Region { origin: DVec2::new(0.5, 0.25), size: DVec2::new(0.5, 0.5) });
    }

    #[test]
    fn places_are_where_the_definition_says() {
        let fisheye = |aperture| {
            let lens = FisheyeLens { projection: Projection::Equidistant, aperture };
            ContentPicture::Directions(Panorama::Fisheye(lens))
        };
        // The picture's middle is the zenith; its lower side is the front.
        let up = pose::rotation(0.0, FRAC_PI_2, 0.0).transpose();
        let region = Region { origin: DVec2::new(0.25, 0.0), size: DVec2::new(0.5, 1.0) };
        let map = ContentMap { picture: fisheye(PI), rotation: up, region };
        let near = |found: Option<DVec2>, x: f64, y: f64| {
            assert!(found.is_some_and(|found| found.distance(DVec2::new(x, y)) < 1e-14), "{found:?} {x} {y}");
        };
        near(map.place(DVec3::Y * 7.0), 0.5, 0.5);
        near(map.place(DVec3::NEG_Z), 0.5, 0.0);
        near(map.place(DVec3::X), 0.75, 0.5);
        near(map.place(DVec3::new(0.0, 1.0, -1.0)), 0.5, 0.25);
        assert_eq!(map.place(DVec3::new(0.0, -0.01, -1.0)), None);
        let plane = ContentPicture::Flat { half: DVec2::new(0.5, 0.25) };
        let map = ContentMap { picture: plane, rotation: DMat3::IDENTITY, region: Region::WHOLE };
        near(map.place(DVec3::new(0.5, -0.25, -1.0)), 1.0, 0.0);
        assert_eq!((map.place(DVec3::Z), map.place(DVec3::new(0.6, 0.0, -1.0))), (None, None));
    }

    #[test]
    fn what_surely_is_shown_is_shown() {
        let mut random = Random::new(7);
        let whole = Span { width: TAU, bottom: -FRAC_PI_2, top: FRAC_PI_2 };
        let lens = FisheyeLens { projection: Projection::Equisolid, aperture: 4.0 };
        let (mut sure, mut unsure) = (0, 0);
        for panorama in [Panorama::Fisheye(lens), Panorama::Equirectangular(whole), Panorama::CubeStrip] {
            let rotation = pose::rotation(random.range(-3.0, 3.0), random.range(-1.5, 1.5), 0.3);
            let picture = ContentPicture::Directions(panorama);
            let map = ContentMap { picture, rotation, region: Region::WHOLE };
            for _ in 0..2_000 {
                let direction = random.vector(-1.0, 1.0).normalize_or(DVec3::X);
                let reach = random.range(0.0, 0.2);
                if !map.surely_shows(&[direction], reach) {
                    unsure += 1;
                    continue;
                }
                sure += 1;
                let beside = direction + 0.99 * reach.sin() * random.vector(-1.0, 1.0).normalize_or(DVec3::X);
                assert!(map.place(beside).is_some(), "{map:?} {direction}");
            }
        }
        assert!(sure > 4_000 && unsure > 300, "{sure} {unsure}");
    }
}
