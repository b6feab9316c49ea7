//! Framebuffers: the program's 0 is ours; clears, draw and read buffers, copies into the window.

use crate::backend::gl::api::{self, Gl};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::list_recording::{self, Command};
use crate::intercept::gl::framebuffer::unsampled_areas::{self, Cleared};
use crate::intercept::gl::framebuffer::{accumulation, default_framebuffer, read_back, replan};
use crate::intercept::gl::offscreen::{blits, displayed, view_copies};
use crate::intercept::gl::per_view::culling::cleared_views;
use crate::intercept::gl::per_view::panel::clear_panel;
use crate::intercept::gl::per_view::window_space::{intersect, own_window_space};

/// Binds what the program's framebuffer `name` stands for.
pub fn bind(ctx: &mut Context, target: u32, name: u32) {
    let was_redirected = ctx.redirected();
    let ours = ctx.drawable.target.as_ref().map_or(0, |t| t.framebuffer());
    let real = if name == 0 { ours } else { name };
    let draws = matches!(target, api::GL_FRAMEBUFFER | api::GL_DRAW_FRAMEBUFFER);
    let was_redirected = was_redirected || (draws && view_copies::rebound(&mut ctx.view_copies));
    let reads = matches!(target, api::GL_FRAMEBUFFER | api::GL_READ_FRAMEBUFFER);
    // SAFETY: the program's own call, with our framebuffer in place of its window's.
    unsafe {
        ctx.driver.gl.bind_framebuffer(target, real);
        if reads && name == 0 && ctx.drawable.reads_elsewhere {
            ctx.driver.gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, 0);
        }
    }
    if draws {
        ctx.app.draw_framebuffer = name;
    }
    if reads {
        ctx.app.read_framebuffer = name;
    }
    if was_redirected && !ctx.redirected() {
        ctx.restore_window_space();
    }
}

/// Whether `target` is the window, to which nothing can be attached; the program then has its error.
fn refuses_attachments(ctx: &mut Context, target: u32) -> bool {
    let reads = target == api::GL_READ_FRAMEBUFFER;
    let window = if reads { ctx.reads_redirected() } else { ctx.redirected() };
    let changed = if reads { ctx.app.read_framebuffer } else { ctx.app.draw_framebuffer };
    view_copies::forget(ctx, changed);
    if window {
        ctx.driver.note_error(api::GL_INVALID_OPERATION);
    }
    window
}

/// A clear of the program: of everything that is its picture. `true`: of every view.
pub fn clear_with(ctx: &mut Context, cleared: Cleared, issue: impl Fn(&Gl)) -> bool {
    let gl = ctx.driver.gl;
    if let Some(target) = ctx.drawable.target.as_mut().filter(|_| cleared.color) {
        target.content.forget();
    }
    if !ctx.redirected() || ctx.app.picking {
        if !view_copies::clear_with(ctx, &issue) {
            issue(gl);
        }
        return false;
    }
    ctx.note_drawn();
    displayed::window_changed(&mut ctx.view_copies);
    let Some(target) = &ctx.drawable.target else { return false };
    let (width, height) = target.size();
    let window = [0, 0, width as i32, height as i32];
    let part = ctx.app.scissor_test.then(|| intersect(ctx.app.scissor, window));
    // A scissor around (most of) the window is how many programs say "my viewport".
    let whole = part.is_none_or(|[_, _, w, h]| 2 * i64::from(w) * i64::from(h) > i64::from(width) * i64::from(height));
    let own_pictures = target.flat_tiles().into_iter().flatten().any(|(_, panel)| !panel);
    if whole && (part.is_none() || !own_pictures) {
        ctx.set_scissor(None);
        issue(gl);
        if let Some(depth) = cleared.depth {
            unsampled_areas::close(ctx, depth);
        }
        if cleared.color {
            clear_panel(ctx);
        }
        return true;
    }
    if whole {
        // The views as a whole, the program's own pictures to the pixel.
        clear_views(ctx, gl, &issue);
        if cleared.color {
            clear_panel(ctx);
        }
    }
    if !whole {
        default_framebuffer::want_panel(ctx);
    }
    let Some(target) = &ctx.drawable.target else { return false };
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
/// `value` must be null or point at as many numbers as the buffer has, as the program promises OpenGL.
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

/// A clear of all views but those with the program's own lens.
fn clear_views(ctx: &mut Context, gl: &Gl, issue: impl Fn(&Gl)) {
    let views = ctx.drawable.target.as_ref().map_or(0, |t| t.session.views().len());
    for view in 0..views {
        let Some((tile, own_lens)) = ctx.drawable.target.as_ref().map(|t| t.session.tile(view)) else { return };
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
        cleared_views::note_clear(ctx);
    }
}

/// Whether `buffer` is a name of the window's colour buffers.
fn is_window_buffer(buffer: u32) -> bool {
    matches!(
        buffer,
        api::GL_FRONT | api::GL_BACK | api::GL_LEFT | api::GL_FRONT_LEFT | api::GL_BACK_LEFT | api::GL_FRONT_AND_BACK
    )
}

/// What stands for a buffer of the window in our framebuffer; names that are wrong stay wrong.
fn attachment(buffer: u32) -> u32 {
    match buffer {
        api::GL_NONE => buffer,
        _ if is_window_buffer(buffer) => api::GL_COLOR_ATTACHMENT0,
        // Names of buffers that this window has not: a window's buffer is none of ours, with the same error.
        api::GL_RIGHT
        | api::GL_FRONT_RIGHT
        | api::GL_BACK_RIGHT
        | api::GL_AUX0..=api::GL_AUX3
        | api::GL_COLOR_ATTACHMENT0..=api::GL_COLOR_ATTACHMENT31 => api::GL_BACK,
        // Let the driver say the error of an unknown name.
        _ => u32::MAX,
    }
}

/// `glDrawBuffer`.
pub fn select_draw_buffer(ctx: &mut Context, buffer: u32) {
    let gl = ctx.driver.gl;
    // SAFETY: the program's own call, translated.
    unsafe {
        if ctx.redirected() {
            gl.draw_buffer(attachment(buffer));
            if is_window_buffer(buffer) || buffer == api::GL_NONE {
                ctx.app.draw_buffer = buffer;
            }
        } else {
            view_copies::forget(ctx, ctx.app.draw_framebuffer);
            gl.draw_buffer(buffer);
        }
    }
}

/// `glReadBuffer`.
pub fn select_read_buffer(ctx: &mut Context, buffer: u32) {
    let gl = ctx.driver.gl;
    // SAFETY: the program's own call, translated.
    unsafe {
        if ctx.reads_redirected() {
            gl.read_buffer(attachment(buffer));
            if is_window_buffer(buffer) || buffer == api::GL_NONE {
                ctx.app.read_buffer = buffer;
            }
        } else {
            gl.read_buffer(buffer);
        }
    }
}

/// The error of `glDrawBuffers` with these names for a window with a left image only.
fn error_of(es: bool, names: &[u32]) -> u32 {
    let error = |(place, name): (usize, &u32)| match *name {
        _ if es && names.len() != 1 => api::GL_INVALID_OPERATION,
        api::GL_NONE => api::GL_NO_ERROR,
        api::GL_BACK if names.len() == 1 => api::GL_NO_ERROR,
        api::GL_FRONT_LEFT | api::GL_BACK_LEFT if !es && !names[..place].contains(name) => api::GL_NO_ERROR,
        api::GL_FRONT | api::GL_LEFT | api::GL_RIGHT | api::GL_FRONT_AND_BACK if !es => api::GL_INVALID_ENUM,
        api::GL_BACK
        | api::GL_FRONT_LEFT..=api::GL_BACK_RIGHT
        | api::GL_COLOR_ATTACHMENT0..=api::GL_COLOR_ATTACHMENT31 => api::GL_INVALID_OPERATION,
        _ => api::GL_INVALID_ENUM,
    };
    names.iter().enumerate().map(error).find(|error| *error != api::GL_NO_ERROR).unwrap_or(api::GL_NO_ERROR)
}

/// `glDrawBuffers`.
///
/// # Safety
/// `buffers` must be null or point at `count` names, as the program promises OpenGL.
pub unsafe fn select_draw_buffers(ctx: &mut Context, count: i32, buffers: *const u32) {
    let gl = ctx.driver.gl;
    if !ctx.redirected() || buffers.is_null() || !(1..=16).contains(&count) {
        view_copies::forget(ctx, ctx.app.draw_framebuffer);
        // SAFETY: the program's own call.
        unsafe { gl.draw_buffers(count, buffers) };
        return;
    }
    // SAFETY: the program passes `count` names.
    let names = unsafe { std::slice::from_raw_parts(buffers, count as usize) };
    let error = error_of(ctx.driver.profile.es, names);
    if error != api::GL_NO_ERROR {
        ctx.driver.note_error(error);
        return;
    }
    let mut translated = [api::GL_NONE; 16];
    // Front and back are one image here.
    if let Some(place) = names.iter().position(|name| *name != api::GL_NONE) {
        translated[place] = api::GL_COLOR_ATTACHMENT0;
    }
    if is_window_buffer(names[0]) || names[0] == api::GL_NONE {
        ctx.app.draw_buffer = names[0];
    }
    // SAFETY: as many names as it says.
    unsafe { gl.draw_buffers(count, translated.as_ptr()) };
}

/// A copy of a rectangle into the window: onto the flat panel and the program's own picture.
#[allow(clippy::too_many_arguments)] // glBlitFramebuffer's own.
pub fn blit(ctx: &mut Context, mut source: [i32; 4], destination: [i32; 4], mask: u32, filter: u32) {
    let gl = ctx.driver.gl;
    if blits::blit(ctx, source, destination, mask, filter) {
        if ctx.redirected() {
            ctx.note_drawn();
            ctx.frame.background.note_scene();
            if let Some(target) = &mut ctx.drawable.target {
                target.content.forget();
            }
            clear_panel(ctx);
        }
        return;
    }
    if ctx.reads_redirected() {
        let [x0, y0, x1, y1] = source;
        let part = [x0.min(x1), y0.min(y1), (x0 - x1).abs(), (y0 - y1).abs()];
        let origin = read_back::prepare(ctx, part, mask & api::GL_COLOR_BUFFER_BIT != 0);
        source = [source[0] + origin[0], source[1] + origin[1], source[2] + origin[0], source[3] + origin[1]];
    }
    let issue = |d: [i32; 4]| {
        // SAFETY: the program's own call, moved to a tile.
        unsafe {
            gl.blit_framebuffer(source[0], source[1], source[2], source[3], d[0], d[1], d[2], d[3], mask, filter)
        };
    };
    if !ctx.redirected() {
        view_copies::leave(ctx);
        issue(destination);
        read_back::finish(ctx);
        return;
    }
    ctx.note_drawn();
    default_framebuffer::want_panel(ctx);
    let Some(target) = &ctx.drawable.target else { return };
    for (tile, _) in target.flat_tiles().into_iter().flatten() {
        own_window_space(ctx, tile);
        let [x0, y0, x1, y1] = destination;
        issue([x0 + tile[0], y0 + tile[1], x1 + tile[0], y1 + tile[1]]);
    }
    read_back::finish(ctx);
}

hooks! {
    "glBindFramebuffer" bind_framebuffer(target: u32, name: u32) = |ctx, _gl| bind(ctx, target, name);
    // A window's buffers cannot be replaced; without us the driver would say so.
    "glFramebufferTexture" framebuffer_texture(target: u32, attachment: u32, texture: u32, level: i32) = |ctx, gl| {
        if !refuses_attachments(ctx, target) { gl.framebuffer_texture(target, attachment, texture, level) }
    };
    "glFramebufferTexture2D" framebuffer_texture2_d(target: u32, attachment: u32, kind: u32, texture: u32, level: i32) = |ctx, gl| {
        if !refuses_attachments(ctx, target) { gl.framebuffer_texture2_d(target, attachment, kind, texture, level) }
    };
    "glFramebufferTextureLayer" framebuffer_texture_layer(target: u32, attachment: u32, texture: u32, level: i32, layer: i32) = |ctx, gl| {
        if !refuses_attachments(ctx, target) { gl.framebuffer_texture_layer(target, attachment, texture, level, layer) }
    };
    "glFramebufferRenderbuffer" framebuffer_renderbuffer(target: u32, attachment: u32, kind: u32, name: u32) = |ctx, gl| {
        if !refuses_attachments(ctx, target) { gl.framebuffer_renderbuffer(target, attachment, kind, name) }
    };
    "glDeleteFramebuffers" delete_framebuffers(count: i32, names: *const u32) = |ctx, gl| {
        let deleted: Vec<u32> = if names.is_null() { Vec::new() } else {
            std::slice::from_raw_parts(names, usize::try_from(count).unwrap_or(0)).to_vec()
        };
        for name in &deleted {
            view_copies::delete(ctx, *name);
        }
        gl.delete_framebuffers(count, names);
        // Deleting the bound framebuffer binds the window's, which is ours.
        if ctx.app.draw_framebuffer != 0 && deleted.contains(&ctx.app.draw_framebuffer) {
            bind(ctx, api::GL_DRAW_FRAMEBUFFER, 0);
        }
        if ctx.app.read_framebuffer != 0 && deleted.contains(&ctx.app.read_framebuffer) {
            bind(ctx, api::GL_READ_FRAMEBUFFER, 0);
        }
    };
    "glIsFramebuffer" is_framebuffer(name: u32) -> u8 = |ctx, gl| {
        if ctx.drawable.target.as_ref().is_some_and(|t| t.is_ours(name)) { 0 } else { gl.is_framebuffer(name) }
    };
    "glClear" clear(mask: u32) = |ctx, _gl| {
        if ctx.compiling() { list_recording::record(ctx, Command::Clear(mask)) } else { clear_window(ctx, mask) }
    };
    "glClearBufferfv" clear_bufferfv(buffer: u32, index: i32, value: *const f32) = |ctx, _gl|
        clear_by(ctx, Cleared::by_floats(buffer, index, value), buffer, value, move |gl, value| gl.clear_bufferfv(buffer, index, value));
    "glClearBufferiv" clear_bufferiv(buffer: u32, index: i32, value: *const i32) = |ctx, _gl|
        clear_by(ctx, Cleared::by_integers(buffer, index, value), buffer, value, move |gl, value| gl.clear_bufferiv(buffer, index, value));
    "glClearBufferuiv" clear_bufferuiv(buffer: u32, index: i32, value: *const u32) = |ctx, _gl|
        clear_by(ctx, Cleared::by_integers(buffer, index, value), buffer, value, move |gl, value| gl.clear_bufferuiv(buffer, index, value));
    "glClearBufferfi" clear_bufferfi(buffer: u32, index: i32, depth: f32, stencil: i32) = |ctx, _gl|
        list_recording::now_or_later(ctx, move |ctx| {
            let cleared = Cleared::by_pair(buffer, index, depth, stencil);
            // SAFETY: the program's own call.
            clear_with(ctx, cleared, |gl| unsafe { gl.clear_bufferfi(buffer, index, depth, stencil) });
        });
    "glDrawBuffer" draw_buffer(buffer: u32) = |ctx, _gl| {
        if ctx.compiling() { list_recording::record(ctx, Command::DrawBuffer(buffer)) } else { select_draw_buffer(ctx, buffer) }
    };
    "glReadBuffer" read_buffer(buffer: u32) = |ctx, _gl| {
        if ctx.compiling() { list_recording::record(ctx, Command::ReadBuffer(buffer)) } else { select_read_buffer(ctx, buffer) }
    };
    "glDrawBuffers" draw_buffers(count: i32, buffers: *const u32) = |ctx, _gl| {
        if buffers.is_null() || !(1..=16).contains(&count) {
            select_draw_buffers(ctx, count, buffers);
        } else {
            let mut names = [api::GL_NONE; 16];
            names[..count as usize].copy_from_slice(std::slice::from_raw_parts(buffers, count as usize));
            // SAFETY: as many names as it says.
            list_recording::now_or_later(ctx, move |ctx| unsafe { select_draw_buffers(ctx, count, names.as_ptr()) });
        }
    };
    "glBlitFramebuffer" blit_framebuffer(x0: i32, y0: i32, x1: i32, y1: i32, u0: i32, v0: i32, u1: i32, v1: i32, mask: u32, filter: u32) =
        |ctx, _gl| list_recording::now_or_later(ctx, move |ctx| blit(ctx, [x0, y0, x1, y1], [u0, v0, u1, v1], mask, filter));
}

#[cfg(test)]
mod tests {
    use super::{api, error_of};

    #[test]
    fn wrong_names_of_buffers_are_errors_as_without_us() {
        for (es, names, error) in [
            (false, &[api::GL_BACK][..], api::GL_NO_ERROR),
            (false, &[api::GL_NONE, api::GL_BACK_LEFT], api::GL_NO_ERROR),
            (false, &[api::GL_BACK_LEFT, api::GL_BACK_LEFT], api::GL_INVALID_OPERATION),
            (false, &[api::GL_BACK_RIGHT], api::GL_INVALID_OPERATION),
            (false, &[api::GL_COLOR_ATTACHMENT0], api::GL_INVALID_OPERATION),
            (false, &[api::GL_FRONT_AND_BACK], api::GL_INVALID_ENUM),
            (false, &[7], api::GL_INVALID_ENUM),
            (true, &[api::GL_BACK], api::GL_NO_ERROR),
            (true, &[api::GL_BACK, api::GL_NONE], api::GL_INVALID_OPERATION),
            (true, &[api::GL_COLOR_ATTACHMENT0], api::GL_INVALID_OPERATION),
        ] {
            assert_eq!(error_of(es, names), error, "{names:x?}");
        }
    }
}
