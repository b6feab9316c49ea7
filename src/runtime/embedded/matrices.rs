//! Matrices and view constants for a program that draws its own views.

use crate::correct::projected::matrices::{LensConstants, ReprojectionMatrix};
use crate::error::{Error, ErrorKind, Result};
use crate::runtime::session::{MatrixClass, Session, classify};
use crate::views::View;
use glam::{DMat4, DVec4};

/// Reprojection matrix and lens constants of a view, for a program with this matrix.
pub(super) fn vectors_of_view(
    session: &Session,
    index: usize,
    matrix: &DMat4,
) -> Result<(ReprojectionMatrix, LensConstants)> {
    let MatrixClass::Perspective(lens) = classify(matrix) else {
        let message = "the matrix is not a perspective matrix; expected one like that of glFrustum or gluPerspective";
        return Err(Error::new(ErrorKind::InvalidArgument, message));
    };
    let rows = session.rows(&lens).nth(index).ok_or_else(|| no_view(index, session.views().len()))?;
    Ok((ReprojectionMatrix::of(&rows), session.lenses().get(index).copied().unwrap_or_default()))
}

/// Joins the view constants.
pub(super) fn joined(rows: &ReprojectionMatrix, lens: &LensConstants) -> [f32; 32] {
    let (rows, lens) = (rows.to_array(), lens.to_array());
    std::array::from_fn(|i| if i < 16 { rows[i] } else { lens[i - 16] })
}

pub(super) fn check_planes(near: f64, far: f64) -> Result<()> {
    if near > 0.0 && near.is_finite() && far > near {
        return Ok(());
    }
    let message = format!("near = {near}, far = {far}; expected 0 < near < far");
    Err(Error::new(ErrorKind::InvalidArgument, message))
}

/// Camera axes of the program → axes of a view, from the view's eye.
pub(super) fn rotation(session: &Session, view: &View) -> DMat4 {
    let camera = session.camera(view);
    DMat4::from_mat3(view.rotation * camera.rotation) * DMat4::from_translation(-camera.shift)
}

/// OpenGL's perspective matrix for a frustum; `far` may be infinite.
pub(super) fn projection(frustum: &crate::geom::Frustum, near: f64, far: f64) -> DMat4 {
    if far.is_finite() {
        return frustum.projection_matrix(near, far);
    }
    let mut matrix = frustum.projection_matrix(near, 2.0 * near);
    matrix.z_axis.z = -1.0;
    matrix.w_axis = DVec4::new(0.0, 0.0, -2.0 * near, 0.0);
    matrix
}

pub(super) fn no_view(index: usize, count: usize) -> Error {
    Error::new(ErrorKind::InvalidArgument, format!("there is no view {index}; there are {count}, counted from 0"))
}

#[cfg(test)]
mod tests {
    use super::projection;
    use crate::geom::Frustum;

    #[test]
    fn an_infinite_far_plane_is_the_limit_of_distant_ones() {
        let frustum = Frustum { left: -1.0, right: 1.2, bottom: -0.7, top: 0.6 };
        let distant = frustum.projection_matrix(0.1, 1e9).to_cols_array();
        for (limit, distant) in projection(&frustum, 0.1, f64::INFINITY).to_cols_array().into_iter().zip(distant) {
            assert!((limit - distant).abs() < 1e-8, "{limit} {distant}");
        }
    }
}
