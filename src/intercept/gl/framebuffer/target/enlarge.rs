//! More tiles in the atlas: the panel and the program's own picture, at their first use.

use crate::backend::gl::driver::api::{self, Gl};
use crate::backend::gl::objects::framebuffers::blit;
use crate::correct::LowerLeftRect;
use crate::intercept::gl::context::errors::take_own_errors;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::own_calls::OwnCalls;
use crate::intercept::gl::framebuffer::target::attach::{adopt, clear_everything};
use crate::intercept::gl::state::drawable::default_framebuffer::DefaultFramebuffer;
use crate::intercept::process::log;
use crate::runtime::session::Extras;

/// Adds the flat panel at its first use.
pub fn want_panel(ctx: &mut Context) {
    ctx.frame.panel_use().note_used();
    let needed = ctx
        .drawable
        .target()
        .is_some_and(|t| t.session.panel().is_none() && t.session.views().iter().any(|v| !v.program_lens));
    if needed {
        enlarge(ctx, |extras| extras.panel = true);
    }
}

/// Adds the program's own picture, for reads of the window and for what shaders write in it.
pub fn want_own_picture(ctx: &mut Context) {
    if ctx.drawable.target().is_some_and(|target| target.own_picture().is_none()) {
        enlarge(ctx, |extras| extras.primary = true);
    }
}

/// Makes a new plan with more tiles. Earlier drawing moves to its new tiles.
pub fn enlarge(ctx: &mut Context, add: impl FnOnce(&mut Extras)) {
    enlarge_now(&mut OwnCalls::begin(ctx), add);
}

fn enlarge_now(ctx: &mut Context, add: impl FnOnce(&mut Extras)) {
    let Some(old) = ctx.drawable.take_target() else { return };
    ctx.driver.take_errors();
    let mut extras = old.extras();
    add(&mut extras);
    match old.enlarged(ctx, extras) {
        Ok(new) => {
            ctx.frame.note_linked(new.backend.linked());
            ctx.drawable.put_target(Box::new(new));
            let gl = ctx.driver.gl;
            adopt(ctx);
            ctx.set_scissor(None);
            if let Some(new) = ctx.drawable.target() {
                // SAFETY: copies between two framebuffers of Cupola; the bindings are put back by
                // `adopt`.
                unsafe {
                    gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, new.surface.framebuffer());
                    clear_everything(gl);
                    copy_tiles(gl, &old, new);
                    gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, ctx.app.read_framebuffer());
                    gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, ctx.app.draw_framebuffer());
                }
            }
            adopt(ctx);
            old.destroy(gl);
        }
        Err(error) => {
            log::once(&format!("the flat panel, or the program's own picture, cannot be made: {error}"));
            ctx.drawable.put_target(old);
        }
    }
    take_own_errors(&mut ctx.driver);
}

/// # Safety
/// Both framebuffers must exist. The caller restores the bindings.
unsafe fn copy_tiles(gl: &Gl, old: &DefaultFramebuffer, new: &DefaultFramebuffer) {
    if old.surface.samples() > 0 && gl.is_es() {
        // Multisampled pictures cannot be copied to another position. The next frame draws them.
        return;
    }
    let tiles = |t: &DefaultFramebuffer| {
        let views = (0..t.session.views().len()).map(|i| Some(t.session.tile(i).0));
        views.chain([t.session.panel(), t.session.primary()]).collect::<Vec<_>>()
    };
    let (from, mut to) = (tiles(old), tiles(new));
    if from.len() > 2 && new.session.primary().is_some() && old.session.primary().is_none() {
        // The primary view is new: it begins with the content of the panel.
        let last = to.len() - 1;
        to[last] = None;
    }
    let mask = api::GL_COLOR_BUFFER_BIT | api::GL_DEPTH_BUFFER_BIT | api::GL_STENCIL_BUFFER_BIT;
    // SAFETY: as promised.
    unsafe { gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, old.surface.framebuffer()) };
    let copy = |from: LowerLeftRect, to: LowerLeftRect| {
        let to = LowerLeftRect::new(to.x, to.y, from.width, from.height);
        // SAFETY: both rectangles lie in their framebuffers.
        unsafe { blit(gl, from.corners(), to.corners(), mask, api::GL_NEAREST) };
    };
    for (from, to) in from.into_iter().zip(to) {
        if let (Some(from), Some(to)) = (from, to) {
            copy(from, to);
        }
    }
    if let (Some(from), Some(to), None) = (old.session.panel(), new.session.primary(), old.session.primary()) {
        copy(from, to);
    }
}
