//! Clip-space reprojection: from the program's own clip coordinates to a view's.

use super::Frustum;
use glam::{DMat3, DMat4, DVec3, DVec4};

mod camera_function;
mod classification;
pub mod eye_axes;
#[cfg(test)]
mod tests;

pub use camera_function::{CameraFunction, Direction};
pub use classification::classify;

/// The part of a program's perspective matrix that reprojection needs:
/// `P = [A 0 B 0; 0 C D 0; 0 0 E F; 0 0 −1 0]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intrinsics {
    /// Horizontal scale, 1/tan of half the horizontal field of view.
    pub a: f64,
    /// Horizontal off-centre term.
    pub b: f64,
    /// Vertical scale.
    pub c: f64,
    /// Vertical off-centre term.
    pub d: f64,
    /// Depth scale.
    pub e: f64,
    /// Depth offset; `None` if unknown, as often for a model-view-projection matrix.
    pub f: Option<f64>,
}

/// Adaptation of a program's camera to the dome (`[camera]` of a rig).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraAdjustment {
    /// Factor on the tangents of every direction; > 1 enlarges the program's picture.
    pub zoom: f64,
    /// Motion of the eye along the camera axes, in the program's own units.
    pub shift: DVec3,
    /// Camera axes of the program → axes of the viewer (orthonormal).
    pub rotation: DMat3,
}

/// Class of a program's 4×4 matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MatrixClass {
    /// A perspective projection, alone or times a similarity.
    Perspective(Intrinsics),
    /// Keeps w constant: a model, view or orthographic matrix.
    Affine,
    /// A perspective projection times an affine matrix that is not a similarity: only E and F of
    /// the lens are known, as in [`Intrinsics`].
    Stretched {
        /// E, with the same error as that of a perspective projection.
        e: f64,
        /// F; `None` if it is lost in rounding.
        f: Option<f64>,
    },
    /// None of these (singular, not finite, or with an oblique near plane).
    Other,
}

/// Rows that convert a program's clip coordinates to those of a view, in ratio form: `x' = rx·(cx,
/// cy, cw) + rx[3]·q`, and likewise for y and w, with `q = cz + E·cw`. Depth is `z' = depth[0]·(q −
/// E·w') + depth[1]·w'`, but `z' = w'` where `cz = cw`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipRows {
    /// Row for x'.
    pub x: [f64; 4],
    /// Row for y'.
    pub y: [f64; 4],
    /// Row for w'.
    pub w: [f64; 4],
    /// E of the program's matrix.
    pub e: f64,
    /// True if the picture is no perspective one. Then (x', y', −w') is the direction in the axes
    /// of its lens, in the program's units.
    pub curved: bool,
    /// Factor and offset, in normalised device coordinates, from the program's depth as measured
    /// along the view's axis to the depth of the view. (1, 0) = the program's own planes.
    pub depth: [f64; 2],
}

impl Intrinsics {
    /// The matrix of a projection with this lens and this F.
    pub fn projection(&self, f: f64) -> DMat4 {
        DMat4::from_cols(DVec4::X * self.a, DVec4::Y * self.c, DVec4::new(self.b, self.d, self.e, -1.0), DVec4::Z * f)
    }

    /// The program's own lens as tangents of its sides.
    pub fn frustum(&self) -> Frustum {
        Frustum {
            left: (self.b - 1.0) / self.a,
            right: (self.b + 1.0) / self.a,
            bottom: (self.d - 1.0) / self.c,
            top: (self.d + 1.0) / self.c,
        }
    }
}

impl CameraAdjustment {
    /// No adjustment.
    pub const NONE: Self = Self { zoom: 1.0, shift: DVec3::ZERO, rotation: DMat3::IDENTITY };
}

impl Default for CameraAdjustment {
    fn default() -> Self {
        Self::NONE
    }
}

/// Returns the rows for a view with axes `rotation` (viewer → view) and opening `frustum`.
///
/// The program's eye coordinates follow from its clip coordinates as `x = (cx + B·cw)/A`,
/// `y = (cy + D·cw)/C`, `z = −cw`. The eye is moved by `camera.shift` (only if F is known and not
/// 0: `w = q/F`), the tangents are multiplied by `camera.zoom`, `camera.rotation` and `rotation`
/// are applied, and the view's own lens with the program's E and F gives `c'`. Depth needs neither
/// F nor a division: `E·z' + F·w = cz + E·(z' − z)`.
///
/// Scales appear only as ratios of the two lenses, so a view with [`Intrinsics::frustum`], no
/// rotation and [`CameraAdjustment::NONE`] has exactly the rows (1,0,0,0), (0,1,0,0), (0,0,1,0).
pub fn clip_rows(p: &Intrinsics, camera: &CameraAdjustment, rotation: DMat3, frustum: &Frustum) -> ClipRows {
    let own = p.frustum();
    let ((own_half_x, own_half_y), (own_middle_x, own_middle_y)) = (own.half_size(), own.middle());
    let ((half_x, half_y), (middle_x, middle_y)) = (frustum.half_size(), frustum.middle());
    let turned = rotation * camera.rotation * DMat3::from_diagonal(DVec3::new(camera.zoom, camera.zoom, 1.0));
    let unit_shift = match p.f {
        Some(f) if f != 0.0 && camera.shift != DVec3::ZERO => turned * (camera.shift / -f),
        _ => DVec3::ZERO,
    };
    let rows = turned.transpose();
    let [right, up, back] = [rows.x_axis, rows.y_axis, rows.z_axis];
    // Row over (cx, cy, cw, q) of a component of the turned eye position plus `middle` times its z
    // component, divided by the half size of the view. The program's half size enters as a ratio to
    // it.
    let row = |axis: DVec3, shift: f64, middle: f64, half: f64| {
        let mixed = axis + middle * back;
        // In this order the two middles cancel exactly where they are equal.
        let off_centre = own_middle_x * mixed.x + own_middle_y * mixed.y - mixed.z;
        let entries = [
            mixed.x * (own_half_x / half),
            mixed.y * (own_half_y / half),
            off_centre / half,
            (shift + middle * unit_shift.z) / half,
        ];
        entries.map(positive_zero)
    };
    let w = [
        -back.x * own_half_x,
        -back.y * own_half_y,
        back.z - (back.x * own_middle_x + back.y * own_middle_y),
        -unit_shift.z,
    ];
    ClipRows {
        x: row(right, unit_shift.x, middle_x, half_x),
        y: row(up, unit_shift.y, middle_y, half_y),
        w: w.map(positive_zero),
        e: p.e,
        curved: false,
        depth: [1.0, 0.0],
    }
}

/// Least distance of the near plane after a motion of the eye, as a part of the program's distance.
const LEAST_NEAR: f64 = 0.05;

/// Replaces −0 by 0; other numbers do not change.
fn positive_zero(x: f64) -> f64 {
    x + 0.0
}

impl ClipRows {
    /// Returns the matrix from a position in the view (−1…1 to the right and up, 1) to its
    /// direction (to the right, up, ahead) in the camera's axes of a program with lens `p`. A
    /// motion of the eye is ignored: the direction is used for far objects only.
    pub fn directions(&self, p: &Intrinsics) -> DMat3 {
        let row = |[x, y, w, _]: [f64; 4]| DVec3::new(x, y, w);
        let to_view = DMat3::from_cols(row(self.x), row(self.y), row(self.w)).transpose();
        let eye = DMat3::from_cols(DVec3::X / p.a, DVec3::Y / p.c, DVec3::new(p.b / p.a, p.d / p.c, 1.0));
        eye * to_view.inverse()
    }

    /// Returns the same rows for a view with the opening `frustum`. Its near and far planes are so
    /// far apart that the view shows all that the program's own planes let through.
    ///
    /// Many programs fit their near and far planes tightly around their scene. A turned view
    /// measures depth along its own axis. A point at the near distance straight ahead of the
    /// program is nearer in the view, by the cosine of the angle between both axes. So the view's
    /// near plane is the program's times the cosine of the view's corner. The far plane is the
    /// program's times the secant of the lens's corner, at least √3 (that of a cube).
    ///
    /// Both follow from E alone. Depth in normalised device coordinates is `−E + F/d`, with `F/near
    /// = E − 1` and `F/far = E + 1` in OpenGL's default clip range; for a range of 0…1 the planes
    /// come out wider still. E ≥ 0 is a reversed depth: from 1 to 0 if E < 1, else from 1 to −1.
    /// The view's depth is `depth[0]·z + depth[1]` of this depth z, which is exactly the depth of a
    /// lens with the wider planes.
    pub fn widened(self, p: &Intrinsics, camera: &CameraAdjustment, frustum: &Frustum) -> Self {
        let corner = |f: &Frustum, zoom: f64| {
            let (x, y) = (f.left.abs().max(f.right.abs()), f.bottom.abs().max(f.top.abs()));
            (1.0 + zoom * zoom * (x * x + y * y)).sqrt()
        };
        let (at_near, at_far) = match p.e {
            e if e < 0.0 => (-1.0, 1.0),
            e if e < 1.0 => (1.0, 0.0),
            _ => (1.0, -1.0),
        };
        let mut near = 1.0 / corner(frustum, 1.0);
        if let (Some(f), true) = (p.f, camera.shift != DVec3::ZERO) {
            // The moved eye may be nearer to everything by the length of the shift.
            let distance = f / (at_near + p.e);
            near *= ((distance - camera.shift.length()) / distance).clamp(LEAST_NEAR, 1.0);
        }
        let far = corner(&p.frustum(), camera.zoom).max(3f64.sqrt());
        let nearest = -p.e + (at_near + p.e) / near;
        let farthest = -p.e + (at_far + p.e) / far;
        let scale = (at_near - at_far) / (nearest - farthest);
        if !scale.is_finite() || scale <= 0.0 {
            return self;
        }
        Self { depth: [scale, at_near - scale * nearest], ..self }
    }

    /// Converts a normalised depth in the view to that in the program's own picture. `farther` is
    /// the distance along the view's axis divided by that along the program's (w'/w). Valid only if
    /// the eye is not moved.
    pub fn own_depth(&self, depth: f64, farther: f64) -> f64 {
        let [factor, offset] = self.depth;
        ((depth - offset) / factor + self.e) * farther - self.e
    }

    /// Returns the rows as one 4×4 matrix, to be multiplied from the left to the program's
    /// projection. It lacks the rule `z' = w'` where `cz = cw`, which is not linear.
    pub fn matrix(&self) -> DMat4 {
        let e = self.e;
        let linear = |[x, y, w, q]: [f64; 4]| DVec4::new(x, y, q, w + e * q);
        let [x, y, w] = [self.x, self.y, self.w].map(linear);
        let z = DVec4::new(-e * w.x, -e * w.y, 1.0 - e * w.z, e * (1.0 - w.w));
        let [scale, offset] = self.depth;
        DMat4::from_rows(
            x.map(positive_zero),
            y.map(positive_zero),
            (scale * z + offset * w).map(positive_zero),
            w.map(positive_zero),
        )
    }
}
