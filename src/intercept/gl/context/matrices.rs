//! Matrices of the fixed-function pipeline in the driver.

use crate::backend::gl::api;
use crate::intercept::gl::context::gl_context::Context;

/// Brings the shadow of `GL_PROJECTION` up to date; asks the driver only after a change.
pub fn refresh(ctx: &mut Context) {
    if !ctx.compat.projection.changed {
        return;
    }
    let Some(session) = ctx.drawable.session() else { return };
    let mut matrix = [0.0; 16];
    // SAFETY: writes sixteen doubles; the context has a fixed-function pipeline.
    unsafe { ctx.driver.gl.get_doublev(api::GL_PROJECTION_MATRIX, matrix.as_mut_ptr()) };
    ctx.compat.projection.update(matrix, session);
}

/// `GL_MODELVIEW`; asks the driver only after a change.
pub fn model_view(ctx: &mut Context) -> [f64; 16] {
    let gl = ctx.driver.gl;
    *ctx.compat.projection.model_view.get_or_insert_with(|| {
        let mut matrix = [0.0; 16];
        // SAFETY: writes sixteen doubles; the context has a fixed-function pipeline.
        unsafe { gl.get_doublev(api::GL_MODELVIEW_MATRIX, matrix.as_mut_ptr()) };
        matrix
    })
}

/// Loads `matrix` into `GL_PROJECTION`, whatever the matrix mode is.
pub fn load_projection(ctx: &Context, matrix: &[f64; 16]) {
    let mode = ctx.app.matrix_mode;
    // SAFETY: reads sixteen doubles; the matrix mode is put back.
    unsafe {
        if mode != api::GL_PROJECTION {
            ctx.driver.gl.matrix_mode(api::GL_PROJECTION);
        }
        ctx.driver.gl.load_matrixd(matrix.as_ptr());
        if mode != api::GL_PROJECTION {
            ctx.driver.gl.matrix_mode(mode);
        }
    }
}
