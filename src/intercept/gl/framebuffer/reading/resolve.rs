//! Resolves the samples of the atlas for reads, and sets its alpha for windows without alpha.

use crate::backend::gl::driver::api;
use crate::backend::gl::objects::framebuffers::blit;
use crate::correct::LowerLeftRect;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::own_calls::OwnCalls;
use crate::intercept::gl::state::app::AppState;
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::gl::state::drawable::default_framebuffer::{DefaultFramebuffer, Ready};
use crate::intercept::gl::state::driver::Driver;

/// Resolves the samples of `part` and, if the window has no alpha, sets alpha to 1. Does each only
/// if it is needed and not yet done.
pub fn make_ready(ctx: &mut Context, part: LowerLeftRect, alpha: bool) {
    let Some(target) = ctx.drawable.target() else { return };
    let opaque = alpha && target.config.alpha_bits == 0;
    let needed = opaque || target.resolved.is_some();
    let holds = |ready: Ready| ready.part.contains(part) && (ready.opaque || !opaque);
    if !needed || part.width == 0 || part.height == 0 || target.ready.get().is_some_and(holds) {
        return;
    }
    let ctx: &mut Context = &mut OwnCalls::begin(ctx);
    if let Some(target) = ctx.drawable.target() {
        target.resolve(&ctx.driver, &ctx.app, &ctx.drawable, Some(part));
    }
    if opaque {
        make_opaque(ctx, part);
    }
    if let Some(target) = ctx.drawable.target() {
        target.ready.set(Some(Ready { part, opaque }));
    }
}

/// Sets alpha to 1 in the stand-in image, as reads of a window without alpha return. The drawing of
/// the program may have left other values there. The correction takes only the colours of the
/// program's own picture, so alpha may change.
fn make_opaque(ctx: &mut Context, part: LowerLeftRect) {
    let gl = ctx.driver.gl;
    let Some(target) = ctx.drawable.target() else { return };
    let framebuffer = target.readable().framebuffer();
    ctx.set_scissor(Some(part));
    let mut bound = 0;
    let mut mask = [0u8; 4];
    // SAFETY: clears a part of a framebuffer of Cupola; binding and mask are put back.
    unsafe {
        gl.get_integerv(api::GL_DRAW_FRAMEBUFFER_BINDING, &mut bound);
        gl.get_booleanv(api::GL_COLOR_WRITEMASK, mask.as_mut_ptr());
        gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, framebuffer);
        gl.color_mask(0, 0, 0, 1);
        gl.clear_bufferfv(api::GL_COLOR, 0, [0.0f32, 0.0, 0.0, 1.0].as_ptr());
        let [red, green, blue, alpha] = mask;
        gl.color_mask(red, green, blue, alpha);
        gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, bound as u32);
    }
    if !ctx.redirected() {
        ctx.restore_window_space();
    }
}

impl DefaultFramebuffer {
    /// Resolves the samples of `part`, or of the whole atlas. Restores the program's bindings.
    pub fn resolve(&self, driver: &Driver, app: &AppState, drawable: &Drawable, part: Option<LowerLeftRect>) {
        let Some(resolved) = &self.resolved else { return };
        self.ready.set(None);
        let gl = driver.gl;
        let (width, height) = self.surface.size();
        let rect = part.unwrap_or(LowerLeftRect::new(0, 0, width, height)).corners();
        let real = |name: u32| if name == 0 { self.framebuffer() } else { name };
        let reads = if drawable.reads_elsewhere() { app.read_framebuffer() } else { real(app.read_framebuffer()) };
        // SAFETY: copies between framebuffers of Cupola; scissor and bindings are put back.
        unsafe {
            let scissor = gl.is_enabled(api::GL_SCISSOR_TEST) != 0;
            if scissor {
                gl.disable(api::GL_SCISSOR_TEST);
            }
            gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, self.surface.framebuffer());
            gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, resolved.framebuffer());
            blit(gl, rect, rect, api::GL_COLOR_BUFFER_BIT, api::GL_NEAREST);
            if part.is_some() {
                let depth = api::GL_DEPTH_BUFFER_BIT | api::GL_STENCIL_BUFFER_BIT;
                blit(gl, rect, rect, depth, api::GL_NEAREST);
            }
            gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, reads);
            gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, real(app.draw_framebuffer()));
            if scissor {
                gl.enable(api::GL_SCISSOR_TEST);
            }
        }
    }
}
