//! Window-space state: the values that the program set, and those of the driver while a view is
//! drawn.

use crate::backend::gl::driver::api;
use crate::correct::LowerLeftRect;
use crate::intercept::gl::app_state::known_state;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::list_recording::ListState;
use crate::intercept::gl::context::list_recording::{self, Command};
use crate::intercept::gl::framebuffer::commands::draw_buffers;
use crate::intercept::gl::framebuffer::target::attach::follow_size;
use crate::intercept::gl::projected_vertices;
use crate::intercept::gl::state::app::AppState;
use crate::intercept::gl::state::app::attribute_stack::Pushed;
use crate::intercept::gl::state::compat::Compat;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::projected_vertices::fixed_pipeline::Pipeline;

/// `glPushAttrib`.
pub fn push_attributes(driver: &Driver, app: &mut AppState, compat: &Compat, lists: &ListState, mask: u32) {
    // SAFETY: the program's own call.
    unsafe { driver.gl.push_attrib(mask) };
    // The stack is as deep as OpenGL's own, which ignores a push beyond its depth.
    if app.can_push(0) {
        let raster = (mask & api::GL_CURRENT_BIT != 0).then(|| compat.saved_raster());
        let (saved, list_base, known) = (app.saved(), lists.base(), driver.known_state.clone());
        app.push(Pushed { mask, saved, list_base, known, raster });
    }
}

/// `glPopAttrib`. The driver restores the viewport and scissor of a tile. The values that the
/// program has set come from Cupola's own stack.
pub fn pop_attributes(ctx: &mut Context) {
    let pushed = ctx.app.pop();
    draw_buffers::pop(ctx, pushed.as_ref());
    ctx.projected.note_switch();
    let Some(Pushed { mask, saved, list_base, known, raster }) = pushed else {
        ctx.driver.known_state.forget();
        return;
    };
    ctx.driver.known_state.restored(&known);
    if let Some(raster) = raster {
        ctx.compat.restore_raster(raster);
    }
    ctx.app.restore(mask, &saved);
    ctx.driver.forget_window_space(mask);
    if mask & api::GL_ENABLE_BIT != 0 && ctx.driver.profile.version >= 30 {
        let discard = ctx.driver.known_state.is_on(ctx.driver.gl, api::GL_RASTERIZER_DISCARD);
        ctx.app.note_switch(api::GL_RASTERIZER_DISCARD, discard);
    }
    if mask & api::GL_LIST_BIT != 0 {
        ctx.lists.set_base(list_base);
    }
    if ctx.session().is_some() && !ctx.redirected() {
        ctx.restore_window_space();
    }
}

/// Follows a new size of the window, of which the program's viewport is the first sign.
pub(super) fn follow_viewport(ctx: &mut Context) {
    let LowerLeftRect { width, height, .. } = ctx.app.viewport();
    let new_size = ctx.drawable.target().is_some_and(|t| t.size() != (width as u32, height as u32));
    if new_size && !ctx.frame.begun() && ctx.redirected() {
        follow_size(ctx);
    }
}

/// `glViewport` of the program.
fn set_program_viewport(ctx: &mut Context, rect: LowerLeftRect) {
    ctx.app.set_viewport(rect);
    follow_viewport(ctx);
    if !ctx.redirected() {
        ctx.driver.issue_viewport(rect);
    }
}

/// `glScissor` of the program.
fn set_program_scissor(ctx: &mut Context, rect: LowerLeftRect) {
    ctx.app.set_scissor(rect);
    if !ctx.redirected() {
        ctx.driver.issue_scissor(rect);
    }
}

/// Sets the program's scissor test.
fn set_scissor_test(ctx: &mut Context, on: bool) {
    if ctx.compiling() {
        list_recording::record(&ctx.share, &ctx.driver, &mut ctx.lists, Command::ScissorTest(on));
    } else {
        ctx.app.set_scissor_test(on);
        if !ctx.redirected() {
            ctx.driver.issue_scissor_test(on);
        }
    }
}

hooks! {
    "glViewport" viewport(x: i32, y: i32, width: i32, height: i32) = |ctx, gl| {
        if width < 0 || height < 0 {
            // The driver reports the error.
            gl.viewport(x, y, width, height);
        } else if ctx.compiling() {
            list_recording::record(&ctx.share, &ctx.driver, &mut ctx.lists, Command::Viewport(LowerLeftRect::new(x, y, width, height)));
        } else {
            set_program_viewport(ctx, LowerLeftRect::new(x, y, width, height));
        }
    };
    "glScissor" scissor(x: i32, y: i32, width: i32, height: i32) = |ctx, gl| {
        if width < 0 || height < 0 {
            gl.scissor(x, y, width, height);
        } else if ctx.compiling() {
            list_recording::record(&ctx.share, &ctx.driver, &mut ctx.lists, Command::Scissor(LowerLeftRect::new(x, y, width, height)));
        } else {
            set_program_scissor(ctx, LowerLeftRect::new(x, y, width, height));
        }
    };
    "glEnable" enable(cap: u32) = |ctx, gl| {
        match cap {
            api::GL_SCISSOR_TEST => set_scissor_test(ctx, true),
            _ => {
                ctx.app.note_switch(cap, true);
                if cap == api::GL_STENCIL_TEST {
                    ctx.frame.note_stencil();
                }
                if matches!(cap, api::GL_POINT_SPRITE | api::GL_VERTEX_PROGRAM_POINT_SIZE) {
                    ctx.draw.note_unknown_width();
                }
                if Pipeline::has(cap) { projected_vertices::switch(ctx, move |gl| gl.enable(cap)) } else { gl.enable(cap) }
                known_state::note(ctx, |known| known.note(cap, true));
            }
        }
    };
    "glDisable" disable(cap: u32) = |ctx, gl| {
        match cap {
            api::GL_SCISSOR_TEST => set_scissor_test(ctx, false),
            _ => {
                ctx.app.note_switch(cap, false);
                if Pipeline::has(cap) { projected_vertices::switch(ctx, move |gl| gl.disable(cap)) } else { gl.disable(cap) }
                known_state::note(ctx, |known| known.note(cap, false));
            }
        }
    };
    "glRenderMode" render_mode(mode: u32) -> i32 = |ctx, _gl| {
        let mut result = 0;
        // Without a buffer for feedback or selection, for example, the mode stays.
        if ctx.driver.accepts(|gl| result = gl.render_mode(mode)) {
            ctx.app.set_render_mode(mode);
            if ctx.app.picking() && ctx.redirected() {
                ctx.set_viewport(ctx.app.viewport());
            }
        }
        result
    };
    "glPushAttrib" push_attrib(mask: u32) = |ctx, _gl| {
        if ctx.compiling() { list_recording::record(&ctx.share, &ctx.driver, &mut ctx.lists, Command::PushAttributes(mask)) } else { push_attributes(&ctx.driver, &mut ctx.app, &ctx.compat, &ctx.lists, mask) }
    };
    "glPopAttrib" pop_attrib() = |ctx, _gl| {
        if ctx.compiling() { list_recording::record(&ctx.share, &ctx.driver, &mut ctx.lists, Command::PopAttributes) } else { pop_attributes(ctx) }
    };
}
