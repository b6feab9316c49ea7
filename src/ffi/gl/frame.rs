//! OpenGL: one frame, in single calls or by a callback.

use super::types::cupola_gl_draw;
use super::{cupola_gl, describe};
use crate::error::Result;
use crate::ffi::argument::{Place, null};
use crate::ffi::handle::Handle;
use crate::ffi::status::{call, cupola_status};
use std::ffi::c_void;

/// Begins a frame.
///
/// # Parameters
/// - `gl`: the object, outside a frame.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: `gl` is null.
/// - `CUPOLA_INVALID_STATE`: a frame has begun and not ended, or the context is not current.
///
/// # Threads
/// Context current.
///
/// # Safety
/// `gl` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_begin_frame(gl: *mut cupola_gl) -> cupola_status {
    // SAFETY: as this function's contract.
    call(|| unsafe { cupola_gl::borrow_mut(gl) }?.embedded.begin_frame())
}

/// Begins a view: binds its tile for drawing and sets viewport and scissor to it. The program then
/// clears the tile and draws the scene with the view's matrices. A program that draws into a
/// framebuffer of its own in between binds the earlier one again.
///
/// # Parameters
/// - `gl`: the object, inside a frame and outside a view.
/// - `index`: index of the view, less than the number that `cupola_gl_view_count` returns. A view
///   may be drawn more than once in a frame.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: `gl` is null, or there is no such view.
/// - `CUPOLA_INVALID_STATE`: no frame has begun, a view has begun and not ended, or the context is
///   not current.
///
/// # Threads
/// Context current.
///
/// # Safety
/// `gl` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_begin_view(gl: *mut cupola_gl, index: u32) -> cupola_status {
    // SAFETY: as this function's contract.
    call(|| unsafe { cupola_gl::borrow_mut(gl) }?.embedded.begin_view(index as usize))
}

/// Ends a view: framebuffer bindings, viewport and scissor become what they were before it.
///
/// # Parameters
/// - `gl`: the object, inside a view.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: `gl` is null.
/// - `CUPOLA_INVALID_STATE`: no view has begun.
///
/// # Threads
/// Context current.
///
/// # Safety
/// `gl` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_end_view(gl: *mut cupola_gl) -> cupola_status {
    // SAFETY: as this function's contract.
    call(|| unsafe { cupola_gl::borrow_mut(gl) }?.embedded.end_view())
}

/// Ends a frame: corrects the views into a framebuffer. All state of the context is the same
/// afterwards. An OpenGL error that was pending is kept for `cupola_gl_take_error`.
///
/// # Parameters
/// - `gl`: the object, inside a frame and outside a view.
/// - `framebuffer`: name of a complete framebuffer, 0 for the window.
/// - `x`, `y`: lower left corner of the picture in the framebuffer, in pixels.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: `gl` is null, or the context has no such framebuffer, or it is not
///   complete. The frame has not ended then.
/// - `CUPOLA_INVALID_STATE`: no frame has begun, a view has not ended, or the context is not
///   current.
///
/// # Threads
/// Context current.
///
/// # Safety
/// `gl` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_end_frame(gl: *mut cupola_gl, framebuffer: u32, x: i32, y: i32) -> cupola_status {
    // SAFETY: as this function's contract.
    call(|| end(unsafe { cupola_gl::borrow_mut(gl) }?, framebuffer, x, y))
}

fn end(gl: &mut cupola_gl, framebuffer: u32, x: i32, y: i32) -> Result<()> {
    let pending = gl.embedded.end_frame(framebuffer, x, y)?;
    if gl.pending_error == 0 {
        gl.pending_error = pending;
    }
    Ok(())
}

/// Draws a whole frame: begins it, calls `draw` for each view between its begin and its end, and
/// ends it.
///
/// # Parameters
/// - `gl`: the object, outside a frame.
/// - `near`, `far`: as for `cupola_gl_get_view`.
/// - `draw`: draws the scene into one view. It must not call functions with the same `gl`, and it
///   returns normally: a `longjmp` or a C++ exception out of it is undefined behaviour.
/// - `user`: passed to `draw`; may be null.
/// - `framebuffer`, `x`, `y`: as for `cupola_gl_end_frame`.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: `gl` or `draw` is null, the planes are wrong, or the context has no
///   such framebuffer. `draw` was not called.
/// - `CUPOLA_INVALID_STATE`: a frame has begun and not ended, or the context is not current.
///
/// # Threads
/// Context current. `draw` is called in the calling thread, before this function returns.
///
/// # Safety
/// `gl` is a live handle; `draw` and `user` fit each other.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_draw_frame(
    gl: *mut cupola_gl,
    near: f64,
    far: f64,
    draw: cupola_gl_draw,
    user: *mut c_void,
    framebuffer: u32,
    x: i32,
    y: i32,
) -> cupola_status {
    call(|| {
        // SAFETY: as this function's contract.
        let gl = unsafe { cupola_gl::borrow_mut(gl) }?;
        let draw = draw.ok_or_else(|| null("draw"))?;
        let views = gl.embedded.view_count() as u32;
        if views > 0 {
            // Wrong planes are refused before anything begins.
            describe(gl, 0, near, far)?;
        }
        gl.embedded.begin_frame_into(framebuffer)?;
        for index in 0..views {
            let view = describe(gl, index, near, far)?;
            gl.embedded.begin_view(index as usize)?;
            gl.is_drawing = true;
            // SAFETY: the program's own function; the view lives during the call.
            unsafe { draw(&view, user) };
            gl.is_drawing = false;
            gl.embedded.end_view()?;
        }
        end(gl, framebuffer, x, y)
    })
}

/// Returns the OpenGL error that the program had pending at the end of a frame, and forgets it. Of
/// several frames the oldest error is kept.
///
/// # Parameters
/// - `gl`: the object.
/// - `error`: receives the error code, `GL_NO_ERROR` (0) where there is none.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: a null pointer.
///
/// # Threads
/// Any thread; no context is needed.
///
/// # Safety
/// `gl` is a live handle; `error` is writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_take_error(gl: *mut cupola_gl, error: *mut u32) -> cupola_status {
    call(|| {
        // SAFETY: as this function's contract.
        let (gl, error) = unsafe { (cupola_gl::borrow_mut(gl)?, Place::new(error, "error")?) };
        error.set(std::mem::take(&mut gl.pending_error));
        Ok(())
    })
}
