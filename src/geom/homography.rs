//! Homographies (projective maps of the plane), for keystone correction.

use glam::{DMat3, DVec2, DVec3};

/// Returns the homography that maps the corners (−1, −1), (1, −1), (1, 1), (−1, 1) of a picture to
/// `corners`, in this order. It maps `(x, y, 1)` to homogeneous coordinates whose last component is
/// positive everywhere in the picture. Returns `None` unless `corners` are those of a convex
/// quadrilateral, counter-clockwise.
///
/// Uses the closed form of Heckbert (*Fundamentals of Texture Mapping and Image Warping*, 1989,
/// §2.2.3).
pub fn from_corners(corners: [DVec2; 4]) -> Option<DMat3> {
    let convex = (0..4).all(|i| {
        let (a, b, c) = (corners[i], corners[(i + 1) % 4], corners[(i + 2) % 4]);
        (b - a).perp_dot(c - b) > 0.0
    });
    if !convex {
        return None;
    }
    let [p0, p1, p2, p3] = corners;
    let (d1, d2, sum) = (p1 - p2, p3 - p2, p0 - p1 + p2 - p3);
    let determinant = d1.perp_dot(d2);
    let (g, h) = (sum.perp_dot(d2) / determinant, d1.perp_dot(sum) / determinant);
    let of_unit_square = DMat3::from_cols((p1 - p0 + g * p1).extend(g), (p3 - p0 + h * p3).extend(h), p0.extend(1.0));
    let to_unit_square = DMat3::from_cols(DVec3::X * 0.5, DVec3::Y * 0.5, DVec3::new(0.5, 0.5, 1.0));
    Some(of_unit_square * to_unit_square)
}

/// Maps a point by a homography. Returns `None` if the last component of the result is not
/// positive: then the point goes to infinity or beyond.
pub fn apply(homography: &DMat3, point: DVec2) -> Option<DVec2> {
    let image = *homography * point.extend(1.0);
    (image.z > 0.0).then(|| image.truncate() / image.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::random::Random;

    #[test]
    fn corners_go_to_corners_and_lines_stay_lines() {
        let square = [DVec2::NEG_ONE, DVec2::new(1.0, -1.0), DVec2::ONE, DVec2::new(-1.0, 1.0)];
        assert!(from_corners(square).is_some_and(|h| h.abs_diff_eq(DMat3::IDENTITY, 1e-15)));
        let mut random = Random::new(61);
        for _ in 0..500 {
            let corners = square.map(|corner| corner + DVec2::new(random.range(-0.4, 0.4), random.range(-0.4, 0.4)));
            let homography = from_corners(corners).expect("convex");
            let inverse = homography.inverse();
            for (from, to) in square.iter().zip(corners) {
                assert!(apply(&homography, *from).is_some_and(|found| found.distance(to) < 1e-12));
            }
            let [a, b] = [0, 1].map(|_| DVec2::new(random.range(-1.0, 1.0), random.range(-1.0, 1.0)));
            let seen = [a, a.lerp(b, 0.37), b].map(|p| apply(&homography, p).expect("in the picture"));
            assert!((seen[1] - seen[0]).perp_dot(seen[2] - seen[0]).abs() < 1e-12);
            assert!(apply(&inverse, seen[0]).is_some_and(|back| back.distance(a) < 1e-11));
        }
    }

    #[test]
    fn what_is_not_convex_or_is_mirrored_is_refused() {
        let dent = [DVec2::NEG_ONE, DVec2::new(1.0, -1.0), DVec2::new(-0.5, -0.5), DVec2::new(-1.0, 1.0)];
        assert_eq!(from_corners(dent), None);
        assert_eq!(from_corners([DVec2::NEG_ONE, DVec2::new(-1.0, 1.0), DVec2::ONE, DVec2::new(1.0, -1.0)]), None);
        assert_eq!(from_corners([DVec2::ZERO; 4]), None);
        assert_eq!(from_corners([DVec2::NAN; 4]), None);
    }
}
