//! The fixed-function projection: the program's `GL_PROJECTION`, and the projection of each view.

use crate::backend::gl::driver::api;
use crate::backend::gl::driver::values::integer;
use crate::intercept::gl::compat::display_lists;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::list_recording::{self, Command};
use crate::intercept::gl::state::app::AppState;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::process::call_sum;
use glam::DMat4;

/// Runs a matrix command of the program, or records it into the list that is being compiled.
fn matrix_command(ctx: &mut Context, command: Command, run: impl FnOnce()) {
    if ctx.compiling() {
        list_recording::record(&ctx.share, &ctx.driver, &mut ctx.lists, command);
        return;
    }
    run();
    ctx.compat.projection.touch(ctx.app.matrix_mode());
}

/// `glMatrixMode`.
pub(super) fn set_mode(driver: &Driver, app: &mut AppState, mode: u32) {
    // SAFETY: the program's own command.
    unsafe { driver.gl.matrix_mode(mode) };
    app.set_matrix_mode(match mode {
        api::GL_MODELVIEW | api::GL_PROJECTION | api::GL_TEXTURE => mode,
        // The driver may refuse other matrices.
        _ => integer(driver.gl, api::GL_MATRIX_MODE) as u32,
    });
}

/// Runs a command on the matrix of `mode` (GL_EXT_direct_state_access), or records it like
/// [`matrix_command`].
fn named(ctx: &mut Context, mode: u32, command: Command, run: impl FnOnce()) {
    let followed = matches!(mode, api::GL_PROJECTION | api::GL_MODELVIEW);
    if !ctx.compiling() || !followed {
        run();
        ctx.compat.projection.touch(mode);
        return;
    }
    list_recording::now_or_later(ctx, move |ctx| {
        let before = ctx.app.matrix_mode();
        ctx.app.set_matrix_mode(mode);
        // SAFETY: one of the two matrices that every context with lists has; the mode is put back.
        unsafe { ctx.driver.gl.matrix_mode(mode) };
        display_lists::run(ctx, &command, 0);
        ctx.app.set_matrix_mode(before);
        // SAFETY: as above.
        unsafe { ctx.driver.gl.matrix_mode(before) };
    });
}

/// Reads a matrix of the program.
fn read<T: Copy + Into<f64>>(pointer: *const T) -> DMat4 {
    // SAFETY: the program passes sixteen numbers to a matrix command.
    unsafe { call_sum::add_values(pointer, 16) };
    // SAFETY: as above.
    DMat4::from_cols_array(&std::array::from_fn(|i| unsafe { (*pointer.add(i)).into() }))
}

hooks! {
    "glMatrixLoadIdentityEXT" matrix_load_identity_ext(mode: u32) = |ctx, gl|
        named(ctx, mode, Command::LoadIdentity, || gl.matrix_load_identity_ext(mode));
    "glMatrixLoadfEXT" matrix_loadf_ext(mode: u32, m: *const f32) = |ctx, gl|
        named(ctx, mode, Command::LoadMatrix(read(m)), || gl.matrix_loadf_ext(mode, m));
    "glMatrixLoaddEXT" matrix_loadd_ext(mode: u32, m: *const f64) = |ctx, gl|
        named(ctx, mode, Command::LoadMatrix(read(m)), || gl.matrix_loadd_ext(mode, m));
    "glMatrixMultfEXT" matrix_multf_ext(mode: u32, m: *const f32) = |ctx, gl|
        named(ctx, mode, Command::MultMatrix(read(m)), || gl.matrix_multf_ext(mode, m));
    "glMatrixMultdEXT" matrix_multd_ext(mode: u32, m: *const f64) = |ctx, gl|
        named(ctx, mode, Command::MultMatrix(read(m)), || gl.matrix_multd_ext(mode, m));
    "glMatrixFrustumEXT" matrix_frustum_ext(mode: u32, l: f64, r: f64, b: f64, t: f64, n: f64, f: f64) = |ctx, gl|
        named(ctx, mode, Command::Frustum([l, r, b, t, n, f]), || gl.matrix_frustum_ext(mode, l, r, b, t, n, f));
    "glMatrixOrthoEXT" matrix_ortho_ext(mode: u32, l: f64, r: f64, b: f64, t: f64, n: f64, f: f64) = |ctx, gl|
        named(ctx, mode, Command::Ortho([l, r, b, t, n, f]), || gl.matrix_ortho_ext(mode, l, r, b, t, n, f));
    "glMatrixRotatefEXT" matrix_rotatef_ext(mode: u32, a: f32, x: f32, y: f32, z: f32) = |ctx, gl|
        named(ctx, mode, Command::Rotate([a, x, y, z].map(f64::from)), || gl.matrix_rotatef_ext(mode, a, x, y, z));
    "glMatrixRotatedEXT" matrix_rotated_ext(mode: u32, a: f64, x: f64, y: f64, z: f64) = |ctx, gl|
        named(ctx, mode, Command::Rotate([a, x, y, z]), || gl.matrix_rotated_ext(mode, a, x, y, z));
    "glMatrixScalefEXT" matrix_scalef_ext(mode: u32, x: f32, y: f32, z: f32) = |ctx, gl|
        named(ctx, mode, Command::Scale([x, y, z].map(f64::from)), || gl.matrix_scalef_ext(mode, x, y, z));
    "glMatrixScaledEXT" matrix_scaled_ext(mode: u32, x: f64, y: f64, z: f64) = |ctx, gl|
        named(ctx, mode, Command::Scale([x, y, z]), || gl.matrix_scaled_ext(mode, x, y, z));
    "glMatrixTranslatefEXT" matrix_translatef_ext(mode: u32, x: f32, y: f32, z: f32) = |ctx, gl|
        named(ctx, mode, Command::Translate([x, y, z].map(f64::from)), || gl.matrix_translatef_ext(mode, x, y, z));
    "glMatrixTranslatedEXT" matrix_translated_ext(mode: u32, x: f64, y: f64, z: f64) = |ctx, gl|
        named(ctx, mode, Command::Translate([x, y, z]), || gl.matrix_translated_ext(mode, x, y, z));
    "glMatrixPushEXT" matrix_push_ext(mode: u32) = |ctx, gl| named(ctx, mode, Command::PushMatrix, || gl.matrix_push_ext(mode));
    "glMatrixPopEXT" matrix_pop_ext(mode: u32) = |ctx, gl| named(ctx, mode, Command::PopMatrix, || gl.matrix_pop_ext(mode));
    "glMatrixMode" matrix_mode(mode: u32) = |ctx, gl| {
        if ctx.compiling() {
            list_recording::record(&ctx.share, &ctx.driver, &mut ctx.lists, Command::MatrixMode(mode));
        } else {
            set_mode(&ctx.driver, &mut ctx.app, mode);
        }
    };
    "glLoadIdentity" load_identity() = |ctx, gl| matrix_command(ctx, Command::LoadIdentity, || gl.load_identity());
    "glLoadMatrixf" load_matrixf(m: *const f32) = |ctx, gl| matrix_command(ctx, Command::LoadMatrix(read(m)), || gl.load_matrixf(m));
    "glLoadMatrixd" load_matrixd(m: *const f64) = |ctx, gl| matrix_command(ctx, Command::LoadMatrix(read(m)), || gl.load_matrixd(m));
    "glMultMatrixf" mult_matrixf(m: *const f32) = |ctx, gl| matrix_command(ctx, Command::MultMatrix(read(m)), || gl.mult_matrixf(m));
    "glMultMatrixd" mult_matrixd(m: *const f64) = |ctx, gl| matrix_command(ctx, Command::MultMatrix(read(m)), || gl.mult_matrixd(m));
    "glLoadTransposeMatrixf" load_transpose_matrixf(m: *const f32) = |ctx, gl|
        matrix_command(ctx, Command::LoadMatrix(read(m).transpose()), || gl.load_transpose_matrixf(m));
    "glLoadTransposeMatrixd" load_transpose_matrixd(m: *const f64) = |ctx, gl|
        matrix_command(ctx, Command::LoadMatrix(read(m).transpose()), || gl.load_transpose_matrixd(m));
    "glMultTransposeMatrixf" mult_transpose_matrixf(m: *const f32) = |ctx, gl|
        matrix_command(ctx, Command::MultMatrix(read(m).transpose()), || gl.mult_transpose_matrixf(m));
    "glMultTransposeMatrixd" mult_transpose_matrixd(m: *const f64) = |ctx, gl|
        matrix_command(ctx, Command::MultMatrix(read(m).transpose()), || gl.mult_transpose_matrixd(m));
    "glFrustum" frustum(l: f64, r: f64, b: f64, t: f64, n: f64, f: f64) = |ctx, gl|
        matrix_command(ctx, Command::Frustum([l, r, b, t, n, f]), || gl.frustum(l, r, b, t, n, f));
    "glOrtho" ortho(l: f64, r: f64, b: f64, t: f64, n: f64, f: f64) = |ctx, gl|
        matrix_command(ctx, Command::Ortho([l, r, b, t, n, f]), || gl.ortho(l, r, b, t, n, f));
    "glRotatef" rotatef(a: f32, x: f32, y: f32, z: f32) = |ctx, gl|
        matrix_command(ctx, Command::Rotate([a.into(), x.into(), y.into(), z.into()]), || gl.rotatef(a, x, y, z));
    "glRotated" rotated(a: f64, x: f64, y: f64, z: f64) = |ctx, gl|
        matrix_command(ctx, Command::Rotate([a, x, y, z]), || gl.rotated(a, x, y, z));
    "glScalef" scalef(x: f32, y: f32, z: f32) = |ctx, gl|
        matrix_command(ctx, Command::Scale([x.into(), y.into(), z.into()]), || gl.scalef(x, y, z));
    "glScaled" scaled(x: f64, y: f64, z: f64) = |ctx, gl|
        matrix_command(ctx, Command::Scale([x, y, z]), || gl.scaled(x, y, z));
    "glTranslatef" translatef(x: f32, y: f32, z: f32) = |ctx, gl|
        matrix_command(ctx, Command::Translate([x.into(), y.into(), z.into()]), || gl.translatef(x, y, z));
    "glTranslated" translated(x: f64, y: f64, z: f64) = |ctx, gl|
        matrix_command(ctx, Command::Translate([x, y, z]), || gl.translated(x, y, z));
    "glPushMatrix" push_matrix() = |ctx, gl| matrix_command(ctx, Command::PushMatrix, || gl.push_matrix());
    "glPopMatrix" pop_matrix() = |ctx, gl| matrix_command(ctx, Command::PopMatrix, || gl.pop_matrix());
}
