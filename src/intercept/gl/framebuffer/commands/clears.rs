//! Clears of the window: of all views, or of the program's own pictures.

use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::LowerLeftRect;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::list_recording::{self, Command};
use crate::intercept::gl::framebuffer::commands::accumulation;
use crate::intercept::gl::framebuffer::target::enlarge::want_panel;
use crate::intercept::gl::framebuffer::target::replan;
use crate::intercept::gl::framebuffer::target::unsampled_areas::{self, Cleared};
use crate::intercept::gl::offscreen::view_copies;
use crate::intercept::gl::per_view::culling::cleared_views;
use crate::intercept::gl::per_view::panel::clear_panel;
use crate::intercept::gl::per_view::window_space::own_window_space;
use crate::intercept::process::call_sum;

/// Runs a clear of the program in all tiles that it affects. Returns true if it affects every view.
pub fn clear_with(ctx: &mut Context, cleared: Cleared, issue: impl Fn(&Gl)) -> bool {
    let gl = ctx.driver.gl;
    if let Some(target) = ctx.drawable.target_mut().filter(|_| cleared.color) {
        target.content.forget();
    }
    if !ctx.redirected() || ctx.app.picking() {
        if !view_copies::clear_with(ctx, cleared.color, &issue) {
            issue(gl);
        }
        return false;
    }
    ctx.note_drawn();
    ctx.view_copies.window_changed();
    let Some(target) = ctx.drawable.target() else { return false };
    let window = target.size();
    let part = ctx.app.scissor_test().then(|| ctx.app.scissor().moved_into(LowerLeftRect::of_size(window)));
    // Many programs set a scissor around (most of) the window and mean the whole viewport.
    let whole = part.is_none_or(|part| part.is_most_of(window));
    let own_pictures = target.flat_tiles().into_iter().flatten().any(|(_, panel)| !panel);
    if whole && (part.is_none() || !own_pictures) {
        ctx.set_scissor(None);
        issue(gl);
        if let Some(depth) = cleared.depth {
            unsampled_areas::close(&mut ctx.driver, &ctx.app, &ctx.drawable, &mut ctx.frame, depth);
        }
        if cleared.color {
            clear_panel(ctx);
        }
        return true;
    }
    if whole {
        // The views are cleared completely, the program's own pictures exactly within the scissor.
        clear_views(ctx, gl, &issue);
        if cleared.color {
            clear_panel(ctx);
        }
    }
    if !whole {
        want_panel(ctx);
    }
    let Some(target) = ctx.drawable.target() else { return false };
    for (tile, panel) in target.flat_tiles().into_iter().flatten() {
        if !(panel && whole) {
            own_window_space(ctx, tile);
            issue(gl);
        }
    }
    false
}

/// `glClearBuffer`, which may be a part of a display list.
///
/// # Safety
/// `value` must be null or point at as many numbers as the buffer has, as the program promises
/// OpenGL.
unsafe fn clear_by<T: Copy + Default + Send + Sync + 'static>(
    ctx: &mut Context,
    cleared: Cleared,
    buffer: u32,
    value: *const T,
    issue: impl Fn(&Gl, *const T) + Send + Sync + 'static,
) {
    if value.is_null() {
        return;
    }
    let count = if buffer == api::GL_COLOR { 4 } else { 1 };
    // SAFETY: as promised.
    let value: [T; 4] = std::array::from_fn(|i| if i < count { unsafe { *value.add(i) } } else { T::default() });
    list_recording::now_or_later(ctx, move |ctx| {
        clear_with(ctx, cleared, |gl| issue(gl, value.as_ptr()));
    });
}

/// Runs a clear in all views except those with the program's own lens.
fn clear_views(ctx: &mut Context, gl: &Gl, issue: impl Fn(&Gl)) {
    let views = ctx.drawable.target().map_or(0, |t| t.session.views().len());
    for view in 0..views {
        let Some((tile, own_lens)) = ctx.drawable.target().map(|t| t.session.tile(view)) else { return };
        if !own_lens {
            ctx.set_scissor(Some(tile));
            issue(gl);
        }
    }
}

/// `glClear`.
pub fn clear_window(ctx: &mut Context, mask: u32) {
    if mask & api::GL_ACCUM_BUFFER_BIT != 0 {
        accumulation::clear(ctx);
    }
    let cleared = Cleared::by_mask(ctx, mask);
    let color = cleared.color;
    replan::look(ctx, cleared, mask & api::GL_STENCIL_BUFFER_BIT != 0);
    // SAFETY: the program's own call.
    if clear_with(ctx, cleared, |gl| unsafe { gl.clear(mask) }) && color {
        cleared_views::note_clear(&ctx.driver, &ctx.app, &mut ctx.drawable, &ctx.queries);
    }
}

/// Number of values that clear a buffer.
fn values(buffer: u32) -> usize {
    if buffer == api::GL_COLOR { 4 } else { 1 }
}

hooks! {
    "glClear" clear(mask: u32) = |ctx, _gl| {
        if ctx.compiling() { list_recording::record(&ctx.share, &ctx.driver, &mut ctx.lists, Command::Clear(mask)) } else { clear_window(ctx, mask) }
    };
    "glClearBufferfv" clear_bufferfv(buffer: u32, index: i32, value: *const f32) = |ctx, _gl| {
        call_sum::add_values(value, values(buffer));
        clear_by(ctx, Cleared::by_floats(buffer, index, value), buffer, value, move |gl, value| gl.clear_bufferfv(buffer, index, value));
    };
    "glClearBufferiv" clear_bufferiv(buffer: u32, index: i32, value: *const i32) = |ctx, _gl| {
        call_sum::add_values(value, values(buffer));
        clear_by(ctx, Cleared::by_integers(buffer, index, value), buffer, value, move |gl, value| gl.clear_bufferiv(buffer, index, value));
    };
    "glClearBufferuiv" clear_bufferuiv(buffer: u32, index: i32, value: *const u32) = |ctx, _gl| {
        call_sum::add_values(value, values(buffer));
        clear_by(ctx, Cleared::by_integers(buffer, index, value), buffer, value, move |gl, value| gl.clear_bufferuiv(buffer, index, value));
    };
    "glClearBufferfi" clear_bufferfi(buffer: u32, index: i32, depth: f32, stencil: i32) = |ctx, _gl|
        list_recording::now_or_later(ctx, move |ctx| {
            let cleared = Cleared::by_pair(buffer, index, depth, stencil);
            // SAFETY: the program's own call.
            clear_with(ctx, cleared, |gl| unsafe { gl.clear_bufferfi(buffer, index, depth, stencil) });
        });
}
