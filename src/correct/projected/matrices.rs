//! Reprojection matrices and lenses as patched shaders take them.

use crate::correct::single;
use crate::geom::division::rule::EDGE_SHARE;
use crate::geom::lenses::picture_map::LEAST_AHEAD;
use crate::geom::reprojection::ClipRows;
use crate::geom::{PictureLens, PictureMap};
use glam::{DMat4, DVec2};

/// Reprojection matrix: maps clip coordinates (x, y, z, w) of the program to those of a view.
///
/// The rows are applied to (x, y, w, q), with q = z + pole·w.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReprojectionMatrix {
    /// Row of the view's x.
    pub x: [f32; 4],
    /// Row of the view's y.
    pub y: [f32; 4],
    /// Row of the view's w.
    pub w: [f32; 4],
    /// Terms that give the view's depth from q and w.
    pub depth: DepthTerms,
}

/// Depth of a view: z = factor·(q − pole·w) + offset·w, with the view's w.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthTerms {
    /// E of the program's projection.
    pub pole: f32,
    /// Factor on the depth.
    pub factor: f32,
    /// Offset of the depth.
    pub offset: f32,
    /// 1 where the rows lead to the axes of an output's lens, otherwise 0.
    pub to_lens: f32,
}

impl ReprojectionMatrix {
    /// Number of values.
    pub const LENGTH: usize = 16;

    /// The matrix that changes no bit of any coordinate.
    pub const IDENTITY: Self =
        Self::from_array([1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0]);

    /// Rounds the rows of a reprojection.
    pub fn of(rows: &ClipRows) -> Self {
        let [factor, offset] = rows.depth;
        let [pole, factor, offset] = single::values([rows.e, factor, offset]);
        let depth = DepthTerms { pole, factor, offset, to_lens: f32::from(u8::from(rows.curved)) };
        Self { x: single::values(rows.x), y: single::values(rows.y), w: single::values(rows.w), depth }
    }

    /// Returns the linear part of the rounded numbers as one 4×4 matrix, as [`ClipRows::matrix`]
    /// does.
    pub fn matrix(&self) -> DMat4 {
        let double = |row: [f32; 4]| row.map(f64::from);
        let DepthTerms { pole, factor, offset, to_lens } = self.depth;
        let rows = ClipRows {
            x: double(self.x),
            y: double(self.y),
            w: double(self.w),
            e: pole.into(),
            curved: to_lens != 0.0,
            depth: [factor.into(), offset.into()],
        };
        rows.matrix()
    }

    /// Returns the matrix of the numbers that [`ReprojectionMatrix::to_array`] returns.
    pub const fn from_array([a, b, c, d, e, f, g, h, i, j, k, l, pole, factor, offset, to_lens]: [f32; 16]) -> Self {
        let depth = DepthTerms { pole, factor, offset, to_lens };
        Self { x: [a, b, c, d], y: [e, f, g, h], w: [i, j, k, l], depth }
    }

    /// Returns the numbers in the order in which patched shaders take them, row by row.
    pub fn to_array(&self) -> [f32; 16] {
        let DepthTerms { pole, factor, offset, to_lens } = self.depth;
        let rows = [self.x, self.y, self.w, [pole, factor, offset, to_lens]];
        std::array::from_fn(|i| rows[i / 4][i % 4])
    }
}

/// Lens of an output's own picture; all zeros for a perspective view.
///
/// For a fisheye, a point of the picture is its direction in the picture, times the angle from the
/// axis, times `scale`; the limit is the angle at which the picture ends. For a pinhole, a point is
/// the tangent times `scale`, minus `offset`; the limit is the least part of a direction along the
/// axis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LensConstants {
    /// Place of the viewer.
    pub viewer: [f32; 3],
    /// 1 − |viewer|².
    pub inside: f32,
    /// Place of the lens.
    pub position: [f32; 3],
    /// 1 for a fisheye, otherwise 0.
    pub fisheye: f32,
    /// Scale of the picture.
    pub scale: [f32; 2],
    /// Offset of the picture; for a fisheye half the aperture, and 0.
    pub offset: [f32; 2],
    /// Limit of the picture.
    pub limit: f32,
    /// Greatest error in the middle of an edge before it is cut, pixels; 0: primitives are not
    /// divided.
    pub max_error: f32,
    /// Half of the picture's width and height, pixels.
    pub half_size: [f32; 2],
}

impl LensConstants {
    /// Returns the constants for a picture of this size in pixels.
    pub fn of(map: &PictureMap, pixels: DVec2, max_error: f64) -> Self {
        let (fisheye, scale, offset, limit) = match map.lens {
            PictureLens::Fisheye { aperture, circle, .. } => {
                // A fisheye's picture has no offset, so half of its aperture is stored there.
                (1.0, circle * 2.0 / aperture, DVec2::new(0.5 * aperture, 0.0), map.limit())
            }
            PictureLens::Pinhole(frustum) => {
                let ((half_x, half_y), (middle_x, middle_y)) = (frustum.half_size(), frustum.middle());
                let half = DVec2::new(half_x, half_y);
                (0.0, 1.0 / half, DVec2::new(middle_x, middle_y) / half, LEAST_AHEAD)
            }
        };
        Self {
            viewer: single::values(map.viewer.to_array()),
            inside: single::value((1.0 - map.viewer.length_squared()).max(0.0)),
            position: single::values(map.position.to_array()),
            fisheye,
            scale: single::values(scale.to_array()),
            offset: single::values(offset.to_array()),
            limit: single::value(limit),
            max_error: single::value(EDGE_SHARE * max_error),
            half_size: single::values((0.5 * pixels).to_array()),
        }
    }

    /// True if primitives have to be divided for a view with this lens.
    pub fn divides(&self) -> bool {
        self.max_error > 0.0
    }

    /// Returns the numbers in the order in which patched shaders take them.
    pub fn to_array(&self) -> [f32; 16] {
        let ([a, b, c], [d, e, f], [g, h], [i, j]) = (self.viewer, self.position, self.scale, self.offset);
        let [width, height] = self.half_size;
        [a, b, c, self.inside, d, e, f, self.fisheye, g, h, i, j, self.limit, self.max_error, width, height]
    }
}
