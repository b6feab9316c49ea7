//! Wide answer to a program that reads its projection matrix in order to leave out objects beside
//! its picture (`camera.answer_wide` of a rig or a profile).
//!
//! The views together may show all directions, which no perspective matrix can. The answer is
//! therefore a box around the camera. Its sides are the six planes that programs compute from the
//! matrix. They are as far from the camera as the program's far plane.

use super::getters::is_answered;
use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::state::compat::Compat;
use crate::intercept::gl::state::drawable::Drawable;
use crate::runtime::session::{Intrinsics, MatrixClass};
use glam::DMat4;

/// Distance of the sides of the box if the matrix has no far plane, in distances of its near plane.
const WITHOUT_FAR_PLANE: f64 = 1e6;

/// Returns the answer to a `glGet` of the projection matrix; `None`: the driver answers.
pub fn answer(drawable: &Drawable, compat: &mut Compat, gl: &Gl, name: u32) -> Option<DMat4> {
    let transposed = match name {
        api::GL_PROJECTION_MATRIX => false,
        api::GL_TRANSPOSE_PROJECTION_MATRIX => true,
        _ => return None,
    };
    let session = drawable.session().filter(|session| session.program_camera().answer_wide)?;
    // Between Begin and End the driver gives no answer.
    // SAFETY: the room is larger than a matrix of doubles.
    if !is_answered(|room: *mut f64| unsafe { gl.get_doublev(name, room) }) {
        return None;
    }
    compat.projection.refresh(gl, Some(session));
    let MatrixClass::Perspective(lens) = compat.projection.class() else { return None };
    let wide = widened(compat.projection.matrix(), lens)?;
    Some(if transposed { wide.transpose() } else { wide })
}

/// Returns the matrix with a box instead of the lens. Other factors of the matrix stay. `None` if
/// the distances of its planes are not known.
fn widened(matrix: &DMat4, lens: &Intrinsics) -> Option<DMat4> {
    let Intrinsics { a, b, c, d, e, f } = *lens;
    let f = f.filter(|f| *f != 0.0)?;
    // The distances at which the depth is 1 and −1. With reversed depth the first one is the
    // nearer.
    let mut distances = [(f / (e + 1.0)).abs(), (f / (e - 1.0)).abs()];
    distances.sort_by(f64::total_cmp);
    let [near, far] = distances;
    let far = if far.is_finite() { far } else { near * WITHOUT_FAR_PLANE };
    // The coordinates in the space of the eye (w is the distance ahead) divided by half an edge of
    // the box, and 1.
    let wide = |[x, y, z, w]: [f64; 4]| [(x + b * w) / a / far, (y + d * w) / c / far, w / far, (z + e * w) / f];
    Some(DMat4::from_cols_array_2d(&matrix.to_cols_array_2d().map(wide)))
}

#[cfg(test)]
mod tests {
    use super::{WITHOUT_FAR_PLANE, widened};
    use crate::geom::Frustum;
    use crate::runtime::session::{Intrinsics, MatrixClass, classify};
    use glam::{DMat4, DQuat, DVec3};

    fn lens(matrix: &DMat4) -> Intrinsics {
        match classify(matrix) {
            MatrixClass::Perspective(lens) => lens,
            other => panic!("{other:?}"),
        }
    }

    /// True if a point is within the six planes.
    fn is_inside(matrix: &DMat4, point: DVec3) -> bool {
        let clip = *matrix * point.extend(1.0);
        clip.truncate().abs().max_element() <= clip.w
    }

    #[test]
    fn everything_up_to_the_far_plane_is_inside() {
        let projection = Frustum { left: -0.5, right: 0.7, bottom: -0.4, top: 0.3 }.projection_matrix(1.0, 100.0);
        let view = DMat4::from_rotation_translation(DQuat::from_rotation_y(1.0), DVec3::new(3.0, 4.0, 5.0));
        for (eye, matrix) in
            [(DVec3::ZERO, projection), (view.inverse().transform_point3(DVec3::ZERO), projection * view)]
        {
            let wide = widened(&matrix, &lens(&matrix)).expect("its planes are known");
            for direction in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z] {
                assert!(is_inside(&wide, eye + direction * 99.0), "{direction}");
                assert!(!is_inside(&wide, eye + direction * 174.0), "{direction}");
            }
            assert!(!is_inside(&matrix, eye + DVec3::X * 99.0) || !is_inside(&matrix, eye + DVec3::NEG_X * 99.0));
        }
    }

    #[test]
    fn reversed_depth_and_none_have_a_distance() {
        let frustum = Frustum::symmetric(1.4, 1.0);
        let reversed = frustum.projection_matrix(100.0, 1.0);
        let wide = widened(&reversed, &lens(&reversed)).expect("its planes are known");
        assert!(is_inside(&wide, DVec3::Z * 99.0) && !is_inside(&wide, DVec3::Z * 101.0));
        let endless = frustum.projection_matrix(0.5, f64::INFINITY);
        let wide = widened(&endless, &lens(&endless)).expect("its planes are known");
        assert!(
            is_inside(&wide, DVec3::X * 0.49 * WITHOUT_FAR_PLANE) && !is_inside(&wide, DVec3::X * WITHOUT_FAR_PLANE)
        );
    }
}
