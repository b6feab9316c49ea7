//! OpenGL: a program draws each view itself, between calls of the library.

pub mod blend;
pub mod frame;
pub mod projection;
#[cfg(test)]
mod tests;
pub mod types;

use self::types::{cupola_gl_options, cupola_gl_statistics, cupola_gl_view};
use super::argument::{Place, array, null};
use super::handle::Handle;
use super::rig::cupola_rig;
use super::sized::{self, SizedPlace};
use super::status::{call, cupola_status};
use super::view::{Matrices, name_of};
use crate::backend::gl::driver::api::Gl;
use crate::correct::LowerLeftRect;
use crate::error::{Error, ErrorKind, Result};
use crate::rig::{Rig, Viewer};
use crate::runtime::embedded::Embedded;
use glam::DVec3;
use std::ffi::c_void;

/// A rig on an OpenGL context. Created by `cupola_gl_create` or `cupola_gl_create_projecting`,
/// destroyed by `cupola_gl_destroy`.
///
/// One thread at a time may use it. Functions that say "context current" need the context on which
/// the object was created, current in the calling thread.
pub struct cupola_gl {
    embedded: Embedded,
    pending_error: u32,
    /// True while `cupola_gl_draw_frame` calls the program.
    is_drawing: bool,
}

impl Handle for cupola_gl {
    const NAME: &'static str = "gl";
}

/// Plans the views of a rig and creates what they need on the current context, which must be OpenGL
/// 3.3 or OpenGL ES 3.0 at least, with a window or without one (surfaceless).
///
/// # Parameters
/// - `rig`: the rig. The library copies what it needs; the rig may be freed afterwards.
/// - `options`: size of the picture, and the function that finds OpenGL's functions. Not kept.
/// - `gl`: receives the new object, on success only.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: a null pointer, a size out of range, a field that this version does
///   not know, or a rig that corrects nothing (`identity`).
/// - `CUPOLA_INVALID_STATE`: no context is current in this thread.
/// - `CUPOLA_GRAPHICS`: the context is too old, lacks a function or has no memory left.
///
/// # Ownership
/// The caller owns `*gl` and destroys it with `cupola_gl_destroy`.
///
/// # Threads
/// Context current. Several objects, in several threads, are independent.
///
/// # Safety
/// `rig` is a live handle; `options` points to `options->struct_size` bytes; `gl` is writable; a
/// context is current whose functions `get_proc_address` finds.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_create(
    rig: *const cupola_rig,
    options: *const cupola_gl_options,
    gl: *mut *mut cupola_gl,
) -> cupola_status {
    // SAFETY: as this function's contract.
    call(|| unsafe { create(rig, options, gl, Embedded::new) })
}

/// Creates a handle; `plan` plans the views.
///
/// # Safety
/// As for `cupola_gl_create`.
unsafe fn create(
    rig: *const cupola_rig,
    options: *const cupola_gl_options,
    gl: *mut *mut cupola_gl,
    plan: fn(Gl, &Rig, (u32, u32)) -> Result<Embedded>,
) -> Result<()> {
    // SAFETY: as this function's contract.
    let (rig, options, gl) =
        unsafe { (cupola_rig::borrow(rig)?, sized::read(options, "options")?, Place::new(gl, "gl")?) };
    let find = options.get_proc_address.ok_or_else(|| null("options.get_proc_address"))?;
    // SAFETY: the program's own function, with a NUL-terminated name.
    let table = Gl::load(|name| unsafe { find(name.as_ptr()) }.map_or(std::ptr::null(), |f| f as *const c_void));
    let embedded = plan(table, &rig.rig, (options.width, options.height))?;
    cupola_gl { embedded, pending_error: 0, is_drawing: false }.give(gl);
    Ok(())
}

/// Plans the views again for a picture of another size. Number and tiles of the views may change.
/// On an error the old size stays.
///
/// # Parameters
/// - `gl`: the object, outside a frame.
/// - `width`, `height`: size of the picture in pixels, 1 to 16384.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: `gl` is null, or the size is out of range.
/// - `CUPOLA_INVALID_STATE`: a frame has begun and not ended, or the context is not current.
/// - `CUPOLA_GRAPHICS`: the driver refused a request.
///
/// # Threads
/// Context current.
///
/// # Safety
/// `gl` is a live handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_resize(gl: *mut cupola_gl, width: u32, height: u32) -> cupola_status {
    // SAFETY: as this function's contract.
    call(|| unsafe { cupola_gl::borrow_mut(gl) }?.embedded.resize((width, height)))
}

/// Moves and turns the viewer, for whose place the picture is correct, and plans the views again.
/// Number and tiles of the views may change. On an error the old viewer stays.
///
/// This takes about as long as `cupola_gl_create`: it is for a viewer who takes another seat, not
/// for a tracked one.
///
/// # Parameters
/// - `gl`: the object, outside a frame.
/// - `position`: 3 numbers, metres from the centre of the dome: x right, y up, z backward.
/// - `yaw`, `pitch`, `roll`: degrees to the right, up, and clockwise.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: a null pointer, or a viewer outside the screen or not finite.
/// - `CUPOLA_INVALID_STATE`: a frame has begun and not ended, or the context is not current.
/// - `CUPOLA_GRAPHICS`: the driver refused a request.
///
/// # Threads
/// Context current.
///
/// # Safety
/// `gl` is a live handle; `position` points to 3 numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_set_viewer(
    gl: *mut cupola_gl,
    position: *const f64,
    yaw: f64,
    pitch: f64,
    roll: f64,
) -> cupola_status {
    call(|| {
        // SAFETY: as this function's contract.
        let (gl, position) = unsafe { (cupola_gl::borrow_mut(gl)?, array(position, "position")?) };
        let [yaw, pitch, roll] = [yaw, pitch, roll].map(f64::to_radians);
        gl.embedded.set_viewer(Viewer { position: DVec3::from_array(position), yaw, pitch, roll })
    })
}

/// Returns the number of views. Only `cupola_gl_resize` and `cupola_gl_set_viewer` change it.
///
/// # Parameters
/// - `gl`: the object.
/// - `count`: receives the number, at least 1.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: a null pointer.
///
/// # Threads
/// Any thread; no context is needed.
///
/// # Safety
/// `gl` is a live handle; `count` is writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_view_count(gl: *mut cupola_gl, count: *mut u32) -> cupola_status {
    call(|| {
        // SAFETY: as this function's contract.
        let (gl, count) = unsafe { (cupola_gl::borrow(gl)?, Place::new(count, "count")?) };
        count.set(gl.embedded.view_count() as u32);
        Ok(())
    })
}

/// Describes a view, for a camera with the given near and far planes.
///
/// # Parameters
/// - `gl`: the object.
/// - `index`: index of the view, less than the number that `cupola_gl_view_count` returns.
/// - `near`, `far`: distances of the planes in the program's units, 0 < near < far. `far` may be
///   infinite.
/// - `view`: receives the description. The caller sets `view->struct_size` before.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: a null pointer, a wrong `struct_size`, an index without a view, or
///   wrong planes.
///
/// # Threads
/// Any thread; no context is needed.
///
/// # Safety
/// `gl` is a live handle; `view` points to `view->struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_get_view(
    gl: *mut cupola_gl,
    index: u32,
    near: f64,
    far: f64,
    view: *mut cupola_gl_view,
) -> cupola_status {
    call(|| {
        // SAFETY: as this function's contract.
        let (gl, view) = unsafe { (cupola_gl::borrow(gl)?, SizedPlace::new(view, "view")?) };
        view.set(&describe(gl, index, near, far)?);
        Ok(())
    })
}

fn describe(gl: &cupola_gl, index: u32, near: f64, far: f64) -> Result<cupola_gl_view> {
    let view = gl.embedded.view(index as usize, near, far)?;
    let LowerLeftRect { x, y, width, height } = view.tile;
    let matrices = Matrices::new(view.frustum, view.rotation);
    Ok(cupola_gl_view {
        struct_size: size_of::<cupola_gl_view>(),
        index,
        x,
        y,
        width,
        height,
        projection_matrix: matrices.projection,
        rotation_matrix: matrices.rotation,
        frustum_matrix: matrices.frustum,
        projection_matrix_f64: matrices.projection_f64,
        rotation_matrix_f64: matrices.rotation_f64,
        frustum_matrix_f64: matrices.frustum_f64,
        name: name_of(view.name),
    })
}

/// Returns counts since the creation of the object.
///
/// # Parameters
/// - `gl`: the object.
/// - `statistics`: receives the counts. The caller sets `statistics->struct_size` before.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: a null pointer, or a wrong `struct_size`.
///
/// # Threads
/// Any thread; no context is needed.
///
/// # Safety
/// `gl` is a live handle; `statistics` points to `statistics->struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_get_statistics(
    gl: *mut cupola_gl,
    statistics: *mut cupola_gl_statistics,
) -> cupola_status {
    call(|| {
        // SAFETY: as this function's contract.
        let (gl, statistics) = unsafe { (cupola_gl::borrow(gl)?, SizedPlace::new(statistics, "statistics")?) };
        let counts = gl.embedded.counts();
        statistics.set(&cupola_gl_statistics {
            struct_size: size_of::<cupola_gl_statistics>(),
            frames: counts.frames,
            views: counts.views,
            errors: counts.errors,
        });
        Ok(())
    })
}

/// Destroys an object and everything that it created on the context.
///
/// # Parameters
/// - `gl`: the object, or null, which does nothing.
///
/// # Returns
/// - `CUPOLA_INVALID_STATE`: called in `draw` of `cupola_gl_draw_frame`; the object lives on. Or
///   its context is not current; the object is destroyed, and what it made on the context is left
///   to the end of the context.
///
/// # Threads
/// Context current.
///
/// # Safety
/// `gl` is a live handle or null. It must not be used afterwards, unless it was refused in `draw`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_destroy(gl: *mut cupola_gl) -> cupola_status {
    call(|| {
        // SAFETY: as this function's contract; the object is borrowed for this question only.
        if !gl.is_null() && unsafe { cupola_gl::borrow(gl) }?.is_drawing {
            let message = "the object is in use: this is called in `draw` of cupola_gl_draw_frame";
            return Err(Error::new(ErrorKind::InvalidState, message));
        }
        // SAFETY: as this function's contract.
        unsafe { cupola_gl::take(gl) }.map_or(Ok(()), |gl| gl.embedded.destroy())
    })
}
