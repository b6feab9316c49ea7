//! Reprojection matrices and lenses as patched shaders take them.

use crate::correct::single;
use crate::geom::division::rule::EDGE_SHARE;
use crate::geom::picture_map::LEAST_AHEAD;
use crate::geom::reprojection::ClipRows;
use crate::geom::{PictureLens, PictureMap};
use glam::{DVec2, DVec4};

/// The rows of a re-projection as patched shaders take them: x, y, w, and (E, depth factor, depth offset, 1 for rows to
/// the axes of a curved picture's lens, otherwise 0).
pub fn clip_rows(rows: &ClipRows) -> [f32; 16] {
    let last = [rows.e, rows.depth[0], rows.depth[1], f64::from(u8::from(rows.curved))];
    let exact = [rows.x, rows.y, rows.w, last];
    single::values(std::array::from_fn(|i| exact[i / 4][i % 4]))
}

/// The lens of an output's own picture as patched shaders take it: (viewer, 1 − |viewer|²), (lens, 1 for a fisheye),
/// (scale, offset, of a fisheye half the aperture), (limit, error, half of the width, half of the height). The last three are in pixels: what the middle of
/// an edge may be off before it is cut (0: nothing is divided), and the picture's size. A fisheye's point is its direction in the picture times the angle from the axis
/// times scale; its limit is the angle from which on there is no picture. A pinhole's is tangent times scale minus offset;
/// its limit is the least part of a direction along the axis.
pub fn picture_lens(map: &PictureMap, pixels: DVec2, max_error: f64) -> [f32; 16] {
    let (fisheye, scale, offset, limit) = match map.lens {
        PictureLens::Fisheye { aperture, circle, .. } => {
            // A fisheye's picture is not moved: there is room for half of its aperture.
            (1.0, circle * 2.0 / aperture, DVec2::new(0.5 * aperture, 0.0), map.limit())
        }
        PictureLens::Pinhole(frustum) => {
            let ((half_x, half_y), (middle_x, middle_y)) = (frustum.half_size(), frustum.middle());
            let half = DVec2::new(half_x, half_y);
            (0.0, 1.0 / half, DVec2::new(middle_x, middle_y) / half, LEAST_AHEAD)
        }
    };
    let inside = (1.0 - map.viewer.length_squared()).max(0.0);
    let vectors = [
        map.viewer.extend(inside),
        map.position.extend(fisheye),
        DVec4::new(scale.x, scale.y, offset.x, offset.y),
        DVec4::new(limit, EDGE_SHARE * max_error, 0.5 * pixels.x, 0.5 * pixels.y),
    ];
    single::values(std::array::from_fn(|i| vectors[i / 4][i % 4]))
}
