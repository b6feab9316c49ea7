//! Buffers that the program draws to and reads from. Front and back buffer of the window are one
//! image.

use crate::backend::gl::driver::api;
use crate::backend::gl::driver::values::integer;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::list_recording::{self, Command};
use crate::intercept::gl::framebuffer::commands::bindings;
use crate::intercept::gl::offscreen::view_copies;
use crate::intercept::gl::state::app::attribute_stack::Pushed;
use crate::intercept::gl::state::app::window_buffers;

/// True if `buffer` is a name of the window's colour buffers.
fn is_window_buffer(buffer: u32) -> bool {
    matches!(
        buffer,
        api::GL_FRONT | api::GL_BACK | api::GL_LEFT | api::GL_FRONT_LEFT | api::GL_BACK_LEFT | api::GL_FRONT_AND_BACK
    )
}

/// Returns the attachment of the stand-in framebuffer for a buffer of the window. A wrong name
/// gives another wrong name.
fn attachment(buffer: u32) -> u32 {
    match buffer {
        api::GL_NONE => buffer,
        _ if is_window_buffer(buffer) => api::GL_COLOR_ATTACHMENT0,
        // This window does not have these buffers. `GL_BACK` is not valid for the stand-in
        // framebuffer, so the driver reports the same error.
        api::GL_RIGHT
        | api::GL_FRONT_RIGHT
        | api::GL_BACK_RIGHT
        | api::GL_AUX0..=api::GL_AUX3
        | api::GL_COLOR_ATTACHMENT0..=api::GL_COLOR_ATTACHMENT31 => api::GL_BACK,
        // The driver reports the error of an unknown name.
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
                ctx.app.buffers_mut().set_draw(window_buffers::only(buffer));
            }
        } else {
            view_copies::forget(ctx, ctx.app.draw_framebuffer());
            gl.draw_buffer(buffer);
        }
    }
}

/// `glReadBuffer`.
pub fn select_read_buffer(ctx: &mut Context, buffer: u32) {
    let gl = ctx.driver.gl;
    // SAFETY: the program's own call, translated.
    unsafe {
        // OpenGL ES has no other names; the driver reports the error.
        let of_es =
            matches!(buffer, api::GL_NONE | api::GL_BACK | api::GL_COLOR_ATTACHMENT0..=api::GL_COLOR_ATTACHMENT31);
        if ctx.reads_redirected() && (of_es || !ctx.driver.profile.es) {
            gl.read_buffer(attachment(buffer));
            if is_window_buffer(buffer) || buffer == api::GL_NONE {
                ctx.app.buffers_mut().set_read(buffer);
            }
        } else {
            gl.read_buffer(buffer);
        }
    }
}

/// Returns the error of `glDrawBuffers` with these names, for a window without stereo.
fn error_of(es: bool, names: &[u32]) -> u32 {
    if es {
        let takes = matches!(names, [api::GL_NONE | api::GL_BACK]);
        return if takes { api::GL_NO_ERROR } else { api::GL_INVALID_OPERATION };
    }
    let error = |(place, name): (usize, &u32)| match *name {
        api::GL_NONE => api::GL_NO_ERROR,
        api::GL_BACK if names.len() == 1 => api::GL_NO_ERROR,
        api::GL_FRONT_LEFT | api::GL_BACK_LEFT if !names[..place].contains(name) => api::GL_NO_ERROR,
        api::GL_FRONT | api::GL_LEFT | api::GL_RIGHT | api::GL_FRONT_AND_BACK => api::GL_INVALID_ENUM,
        api::GL_BACK
        | api::GL_FRONT_LEFT..=api::GL_BACK_RIGHT
        | api::GL_AUX0..=api::GL_AUX3
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
    if !ctx.redirected() || buffers.is_null() || !(0..=16).contains(&count) {
        view_copies::forget(ctx, ctx.app.draw_framebuffer());
        // SAFETY: the program's own call.
        unsafe { gl.draw_buffers(count, buffers) };
        return;
    }
    // SAFETY: the program passes `count` names.
    let names = unsafe { std::slice::from_raw_parts(buffers, count as usize) };
    let error = error_of(ctx.driver.profile.es, names);
    if error != api::GL_NO_ERROR {
        let most = integer(gl, api::GL_MAX_DRAW_BUFFERS);
        ctx.driver.note_error(if count > most { api::GL_INVALID_VALUE } else { error });
        return;
    }
    let mut all = [api::GL_NONE; window_buffers::COUNT];
    all[..names.len()].copy_from_slice(names);
    ctx.app.buffers_mut().set_draw(all);
    // SAFETY: the array has at least `count` names.
    unsafe { gl.draw_buffers(count, window_buffers::of_stand_in(&all).as_ptr()) };
}

/// Returns the framebuffer that must be bound for drawing during a pop of the driver's attribute
/// stack; `None`: the one that is bound.
fn to_pop_draw_buffers(ctx: &Context, pushed: &Pushed) -> Option<u32> {
    let target = ctx.drawable.target().filter(|_| pushed.mask & api::GL_COLOR_BUFFER_BIT != 0)?;
    match &pushed.saved.draw_buffers {
        Some(_) if ctx.app.draw_framebuffer() == 0 => None,
        // Nothing is to be restored.
        Some(names) if names == ctx.app.buffers().draw() => Some(target.framebuffer()),
        None if ctx.app.draw_framebuffer() != 0 => None,
        _ => Some(0),
    }
}

/// Returns the framebuffer that must be bound for reading during a pop of the driver's attribute
/// stack; `None`: the one that is bound.
fn to_pop_read_buffer(ctx: &Context, pushed: &Pushed) -> Option<u32> {
    ctx.drawable.target().filter(|_| pushed.mask & api::GL_PIXEL_MODE_BIT != 0)?;
    (pushed.saved.read_buffer.is_some() != (ctx.app.read_framebuffer() == 0)).then_some(0)
}

/// Pops the driver's attribute stack, whose topmost entry is `pushed`. OpenGL selects the buffers
/// that were pushed in the framebuffer that is bound now, and refuses names of the window for a
/// framebuffer of the program, and the other way round. For the driver the stand-in is a
/// framebuffer of a program. So where the bindings differ, the window's own framebuffer is bound
/// for the pop, and the driver refuses the names there.
pub fn pop(ctx: &mut Context, pushed: Option<&Pushed>) {
    let gl = ctx.driver.gl;
    let draws = pushed.and_then(|pushed| to_pop_draw_buffers(ctx, pushed));
    let reads = pushed.and_then(|pushed| to_pop_read_buffer(ctx, pushed));
    // SAFETY: the program's own call. The bindings are put back.
    unsafe {
        for (target, framebuffer) in [(api::GL_DRAW_FRAMEBUFFER, draws), (api::GL_READ_FRAMEBUFFER, reads)] {
            if let Some(framebuffer) = framebuffer {
                gl.bind_framebuffer(target, framebuffer);
            }
        }
        gl.pop_attrib();
    }
    let own = match ctx.drawable.target() {
        Some(target) if target.config().double_buffered => api::GL_BACK,
        _ => api::GL_FRONT,
    };
    // The window's own framebuffer takes no other name than this.
    let takes_none = |popped: Option<u32>, name: u32| popped == Some(0) && integer(gl, name) as u32 == api::GL_NONE;
    let (draws_none, reads_none) = (takes_none(draws, api::GL_DRAW_BUFFER), takes_none(reads, api::GL_READ_BUFFER));
    if draws_none {
        // SAFETY: the buffer that Cupola draws the corrected picture to.
        unsafe { gl.draw_buffer(own) };
    }
    if reads_none {
        // SAFETY: a buffer of the window.
        unsafe { gl.read_buffer(own) };
    }
    if draws.is_some() {
        bindings::bind(ctx, api::GL_DRAW_FRAMEBUFFER, ctx.app.draw_framebuffer());
    }
    if reads.is_some() {
        bindings::bind(ctx, api::GL_READ_FRAMEBUFFER, ctx.app.read_framebuffer());
    }
    if draws_none {
        select_draw_buffer(ctx, api::GL_NONE);
    }
    if reads_none {
        select_read_buffer(ctx, api::GL_NONE);
    }
}

hooks! {
    "glDrawBuffer" draw_buffer(buffer: u32) = |ctx, _gl| {
        if ctx.compiling() { list_recording::record(&ctx.share, &ctx.driver, &mut ctx.lists, Command::DrawBuffer(buffer)) } else { select_draw_buffer(ctx, buffer) }
    };
    "glReadBuffer" read_buffer(buffer: u32) = |ctx, _gl| {
        if ctx.compiling() { list_recording::record(&ctx.share, &ctx.driver, &mut ctx.lists, Command::ReadBuffer(buffer)) } else { select_read_buffer(ctx, buffer) }
    };
    "glDrawBuffers" draw_buffers(count: i32, buffers: *const u32) = |ctx, _gl| {
        if buffers.is_null() || !(0..=16).contains(&count) {
            select_draw_buffers(ctx, count, buffers);
        } else {
            let mut names = [api::GL_NONE; 16];
            names[..count as usize].copy_from_slice(std::slice::from_raw_parts(buffers, count as usize));
            // SAFETY: the array has `count` names.
            list_recording::now_or_later(ctx, move |ctx| unsafe { select_draw_buffers(ctx, count, names.as_ptr()) });
        }
    };
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
            (true, &[], api::GL_INVALID_OPERATION),
            (true, &[api::GL_BACK], api::GL_NO_ERROR),
            (true, &[api::GL_BACK, api::GL_NONE], api::GL_INVALID_OPERATION),
            (true, &[api::GL_COLOR_ATTACHMENT0], api::GL_INVALID_OPERATION),
        ] {
            assert_eq!(error_of(es, names), error, "{names:x?}");
        }
    }
}
