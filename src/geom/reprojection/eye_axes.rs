//! Eye coordinates of a view, for shaders that rely on their z axis being the axis of the eye.
//!
//! A shader that computes a direction from a pixel often takes the inverse of the projection, sets
//! z to −1, and turns the direction by the inverse of the view matrix. For such a shader, the eye
//! of a view has to look along the view's axis. Let T be the turn from the program's eye
//! coordinates to those of the view. Then the projection is R·P·T⁻¹, which is a bare projection,
//! and the view matrix is T·V.

use super::Intrinsics;
use super::camera_function::{CameraFunction, Direction, inverse};
use glam::{DMat3, DMat4, DVec3};

/// Greatest relative deviation that rounding explains.
const TOLERANCE: f64 = 1e-4;

/// Direction in which a matrix of rotation and translation maps coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ViewMatrix {
    /// From the world to the eye.
    ToEye,
    /// From the eye to the world.
    FromEye,
}

/// Returns the turn from the program's eye coordinates to those of a view with the reprojection
/// `view`; `None` if the view has no axis.
pub fn turn(view: &DMat4, lens: &Intrinsics) -> Option<DMat4> {
    // F changes only the fourth column, which directions do not use.
    turn_of_rows(*view * lens.projection(lens.f.unwrap_or(-1.0)))
}

/// Returns the turn after which `rows`, to clip coordinates, are those of an eye that looks along
/// its axis.
fn turn_of_rows(rows: DMat4) -> Option<DMat4> {
    let [x, y, w] = [0, 1, 3].map(|row| rows.row(row).truncate());
    let back = (-w).try_normalize()?;
    let aside = |row: DVec3| row - row.dot(back) * back;
    let right = aside(x).try_normalize()?;
    let up = aside(y);
    let up = (up - up.dot(right) * right).try_normalize()?;
    // If y of clip coordinates points down, these axes would be a reflection, not a turn.
    let up = if right.cross(up).dot(back) < 0.0 { -up } else { up };
    Some(DMat4::from_mat3(DMat3::from_cols(right, up, back).transpose()))
}

/// True if a matrix only turns, scales evenly and moves, and is not the identity.
pub fn is_rigid(matrix: &DMat4, transposed: bool) -> bool {
    let matrix = if transposed { matrix.transpose() } else { *matrix };
    let [x, y, z] = [0, 1, 2].map(|column| matrix.col(column).truncate());
    let scale = z.length();
    let near =
        |value: f64, expected: f64| (value - expected).abs() <= TOLERANCE * expected.abs().max(f64::MIN_POSITIVE);
    let perpendicular = |a: DVec3, b: DVec3| a.dot(b).abs() <= TOLERANCE * scale * scale;
    matrix.row(3) == glam::DVec4::W
        && near(x.length(), scale)
        && near(y.length(), scale)
        && perpendicular(x, y)
        && perpendicular(y, z)
        && perpendicular(z, x)
        && matrix != DMat4::IDENTITY
}

impl ViewMatrix {
    /// Returns a view matrix, or its inverse, for an eye that is turned.
    pub fn turned(self, matrix: &DMat4, transposed: bool, turn: DMat4) -> DMat4 {
        let oriented = |matrix: DMat4| if transposed { matrix.transpose() } else { matrix };
        let matrix = oriented(*matrix);
        let matrix = match self {
            Self::ToEye => turn * matrix,
            // A turn's inverse is its transpose.
            Self::FromEye => matrix * turn.transpose(),
        };
        oriented(matrix)
    }
}

impl CameraFunction {
    /// True if `matrix`, which has this dependence, depends on the projection alone. Its y may
    /// point up or down.
    pub fn is_of_projection(&self, matrix: &DMat4, lens: &Intrinsics) -> bool {
        let projection = lens.projection(lens.f.unwrap_or(-1.0));
        let left = || Some(inverse(projection)? * self.to_clip(matrix)?);
        left().is_some_and(|left| {
            let scale = left.x_axis.x;
            let rest = (left.x_axis - glam::DVec4::X * scale).length()
                + (left.y_axis - glam::DVec4::Y * scale.copysign(left.y_axis.y)).length()
                + (left.z_axis.truncate() - DVec3::Z * scale).length()
                + left.w_axis.truncate().length();
            rest <= TOLERANCE * scale.abs() && scale != 0.0
        })
    }

    /// Returns the turn from the program's eye coordinates to those of a view with the reprojection
    /// `view`. `matrix` depends on the projection alone. Returns `None` if the view has no axis.
    pub fn turn(&self, matrix: &DMat4, view: &DMat4) -> Option<DMat4> {
        turn_of_rows(*view * self.to_clip(matrix)?)
    }

    /// Returns `matrix`, which depends on the projection alone, for a view whose eye is turned.
    pub fn for_turned_view(&self, matrix: &DMat4, view: &DMat4, turn: DMat4) -> Option<DMat4> {
        let matrix = self.oriented(self.for_view(matrix, view)?);
        let matrix = match self.direction() {
            Direction::ToClip => matrix * turn.transpose(),
            Direction::FromClip => turn * matrix,
        };
        Some(self.oriented(matrix))
    }
}

#[cfg(test)]
mod tests {
    use super::{ViewMatrix, is_rigid, turn};
    use crate::geom::reprojection::{CameraAdjustment, CameraFunction, Intrinsics, clip_rows};
    use crate::geom::{Frustum, pose};
    use glam::{DMat3, DMat4, DVec3, DVec4};

    const LENS: Intrinsics = Intrinsics { a: 1.5, b: 0.0, c: 2.0, d: 0.0, e: -1.02, f: Some(-0.2) };

    /// The projection of a turned view is a bare projection, and both matrices together give the
    /// directions of the view's pixels.
    #[test]
    fn a_turned_eye_sees_the_same_directions() {
        let frustum = Frustum { left: -0.9, right: 0.7, bottom: -1.0, top: 0.6 };
        let rotation = pose::rotation(40.0, 25.0, 10.0);
        let rows = clip_rows(&LENS, &CameraAdjustment::NONE, rotation, &frustum);
        let view = rows.widened(&LENS, &CameraAdjustment::NONE, &frustum).matrix();
        let turn = turn(&view, &LENS).expect("a view");
        assert!((DMat3::from_mat4(turn) - rotation).to_cols_array().iter().all(|part| part.abs() < 1e-12), "{turn}");
        let scene =
            DMat4::from_mat3(pose::rotation(-20.0, 5.0, 0.0)) * DMat4::from_translation(DVec3::new(1.0, 2.0, 3.0));
        let projection = LENS.projection(-0.2);
        let unprojection = projection.inverse();
        let function = CameraFunction::of(&unprojection, &LENS).expect("an inverse");
        assert!(function.is_of_projection(&unprojection, &LENS));
        assert!(!function.is_of_projection(&(projection * scene).inverse(), &LENS));
        let unprojection = function.for_turned_view(&unprojection, &view, turn).expect("a matrix");
        let to_world = ViewMatrix::FromEye.turned(&scene.inverse(), false, turn);
        let to_eye = ViewMatrix::ToEye.turned(&scene, false, turn);
        assert!((to_world * to_eye).abs_diff_eq(DMat4::IDENTITY, 1e-12));
        // Computes the direction as a shader does.
        let eye = unprojection * DVec4::new(0.25, -0.5, -1.0, 1.0);
        let direction = to_world * (eye / -eye.z).truncate().truncate().extend(-1.0).extend(0.0);
        let expected = DVec3::new(-0.1 + 0.25 * 0.8, -0.2 - 0.5 * 0.8, -1.0);
        let expected = scene.inverse() * (rotation.transpose() * expected).extend(0.0);
        assert!((direction - expected).length() < 1e-9, "{direction} {expected}");
    }

    /// A projection whose y points down, as Vulkan has it, turns the eye in the same way.
    #[test]
    fn the_turn_is_the_same_where_y_points_down() {
        let frustum = Frustum { left: -0.9, right: 0.7, bottom: -1.0, top: 0.6 };
        let rotation = pose::rotation(40.0, 25.0, 10.0);
        let rows = clip_rows(&LENS, &CameraAdjustment::NONE, rotation, &frustum);
        let view = rows.widened(&LENS, &CameraAdjustment::NONE, &frustum).matrix();
        let down = DMat4::from_scale(DVec3::new(1.0, -1.0, 1.0));
        let projection = LENS.projection(-0.2);
        let expected = turn(&view, &LENS).expect("a view");
        for (projection, view) in [(projection, view), (down * projection, down * view * down)] {
            for matrix in [projection, projection.inverse()] {
                let function = CameraFunction::of(&matrix, &LENS).expect("a function");
                assert!(function.is_of_projection(&matrix, &LENS));
                let found = function.turn(&matrix, &view).expect("a view");
                assert!(found.abs_diff_eq(expected, 1e-9), "{found} {expected}");
            }
        }
    }

    #[test]
    fn matrices_that_turn_and_move_are_rigid() {
        let scene =
            DMat4::from_mat3(pose::rotation(-20.0, 5.0, 0.0)) * DMat4::from_translation(DVec3::new(1.0, 2.0, 3.0));
        let rounded = |matrix: DMat4| matrix.as_mat4().as_dmat4();
        assert!(is_rigid(&rounded(scene), false) && is_rigid(&rounded(scene.transpose()), true));
        assert!(!is_rigid(&rounded(scene), true) && !is_rigid(&rounded(LENS.projection(-0.2)), false));
        assert!(!is_rigid(&rounded(scene * DMat4::from_scale(DVec3::new(1.0, 1.1, 1.0))), false));
        assert!(!is_rigid(&DMat4::IDENTITY, false) && !is_rigid(&DMat4::ZERO, false));
        assert!(!is_rigid(&DMat4::NAN, false));
    }
}
