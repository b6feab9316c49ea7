//! Views in turn: each frame of the program draws one view. The frames of a round together make one
//! frame on the dome.

use crate::backend::gl::driver::api;
use crate::backend::gl::objects::framebuffers::{FramebufferBindings, blit};
use crate::correct::LowerLeftRect;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::own_calls::OwnCalls;
use crate::intercept::gl::state::drawable::default_framebuffer::DefaultFramebuffer;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::process::log;
use crate::runtime::Session;

/// Ends a frame of the program. Returns true if the window can be corrected: the views are not
/// drawn in turn, or all of them are drawn.
pub fn end_frame(ctx: &mut Context) -> bool {
    let Some(turns) = ctx.session().and_then(Session::turns) else { return true };
    let end = turns.end_frame();
    log::once(
        "views are drawn in turn: each frame on the dome takes a frame of the program for each view; what moves by the \
         clock has seams between views",
    );
    if let Some(view) = end.view {
        collect(&mut OwnCalls::begin(ctx), view, end.is_last);
    }
    end.is_last
}

/// Copies a view to the atlas, and after the last frame of a round the panel too.
fn collect(ctx: &mut Context, view: usize, is_last: bool) {
    let Some(target) = ctx.drawable.take_target() else { return };
    target.resolve(&ctx.driver, &ctx.app, &ctx.drawable, None);
    let session = &target.session;
    let panel = session.panel().zip(session.atlas_panel()).filter(|_| is_last);
    let tiles = [session.atlas_tile(view).map(|tile| (session.tile(view).0, tile)), panel];
    ctx.set_scissor(None);
    for (from, to) in tiles.into_iter().flatten() {
        copy(&ctx.driver, &target, from, to);
    }
    ctx.drawable.put_target(target);
    ctx.restore_window_space();
}

fn copy(driver: &Driver, target: &DefaultFramebuffer, from: LowerLeftRect, to: LowerLeftRect) {
    let gl = driver.gl;
    let filter = if from.size() == to.size() { api::GL_NEAREST } else { api::GL_LINEAR };
    // SAFETY: copies between framebuffers of Cupola; the bindings are put back.
    unsafe {
        let bindings = FramebufferBindings::save(gl);
        gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, target.readable_framebuffer());
        gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, target.atlas_framebuffer());
        blit(gl, from.corners(), to.corners(), api::GL_COLOR_BUFFER_BIT, filter);
        bindings.restore(gl);
    }
}
