//! OpenGL: a program draws each view itself, between calls of ours.

use super::rig::cupola_rig;
use super::status::{call, check_size, cupola_status, name_of, null};
use crate::backend::gl::api::Gl;
use crate::correct::uniforms;
use crate::rig::{Rig, Viewer};
use crate::runtime::embedded::Embedded;
use glam::DVec3;
use std::ffi::{c_char, c_void};

/// Finds an OpenGL function by its name, like `glXGetProcAddressARB`, `eglGetProcAddress` or
/// `glfwGetProcAddress`; must find core functions too.
pub type cupola_gl_get_proc_address = Option<unsafe extern "C" fn(name: *const c_char) -> cupola_gl_function>;

/// A function of OpenGL, to be cast to its own type.
pub type cupola_gl_function = Option<unsafe extern "C" fn()>;

/// Draws the program's scene into the view that is begun. `user` is the program's own.
pub type cupola_gl_draw = Option<unsafe extern "C" fn(view: *const cupola_gl_view, user: *mut c_void)>;

/// Cupola on an OpenGL context. Free it with `cupola_gl_destroy`, with the same context current.
pub struct cupola_gl {
    pub(super) embedded: Embedded,
    pending_error: u32,
}

/// What to make a `cupola_gl` from.
#[repr(C)]
pub struct cupola_gl_options {
    /// `sizeof(cupola_gl_options)`.
    pub struct_size: usize,
    /// Finds the OpenGL functions of the current context.
    pub get_proc_address: cupola_gl_get_proc_address,
    /// Width of the picture that all outputs share (the window's), pixels, 1…16384.
    pub width: u32,
    /// Height of the picture, pixels, 1…16384.
    pub height: u32,
}

/// A view: what to draw, and where.
#[repr(C)]
pub struct cupola_gl_view {
    /// `sizeof(cupola_gl_view)`.
    pub struct_size: usize,
    /// Its number, from 0.
    pub index: u32,
    /// Left edge of its tile in the atlas, pixels from the left.
    pub x: i32,
    /// Bottom edge of its tile, pixels from the bottom.
    pub y: i32,
    /// Width of its tile, pixels.
    pub width: i32,
    /// Height of its tile, pixels.
    pub height: i32,
    /// The program's camera axes → clip space of this view, column by column: use it in place of the
    /// program's own projection. The program's view matrix, and so its lighting, stays as it is.
    /// It is `frustum_matrix` · `rotation_matrix`.
    pub projection_matrix: [f32; 16],
    /// The program's camera axes → axes of the view, for programs that cull or draw a sky by view. It moves, too, where
    /// the rig moves the camera or the view is for one of two eyes.
    pub rotation_matrix: [f32; 16],
    /// Axes of the view → its clip space: a perspective matrix of the usual form, off-centre.
    pub frustum_matrix: [f32; 16],
    /// `projection_matrix` in double precision.
    pub projection_matrix_f64: [f64; 16],
    /// `rotation_matrix` in double precision.
    pub rotation_matrix_f64: [f64; 16],
    /// `frustum_matrix` in double precision.
    pub frustum_matrix_f64: [f64; 16],
    /// Its name (`front`, `left`, …), NUL-terminated, cut to 31 bytes.
    pub name: [c_char; 32],
}

/// Counts since a `cupola_gl` was made.
#[repr(C)]
pub struct cupola_gl_statistics {
    /// `sizeof(cupola_gl_statistics)`.
    pub struct_size: usize,
    /// Frames ended.
    pub frames: u64,
    /// Views begun.
    pub views: u64,
    /// OpenGL errors that Cupola's own calls caused; 0 unless something is wrong.
    pub errors: u64,
}

/// The handle behind a pointer.
///
/// # Safety
/// `gl` is null or a live handle that no other thread uses now.
pub(super) unsafe fn handle<'a>(gl: *mut cupola_gl) -> crate::Result<&'a mut cupola_gl> {
    // SAFETY: as promised above.
    unsafe { gl.as_mut() }.ok_or_else(|| null("gl"))
}

/// Plans `rig` and makes what it needs on the current context: OpenGL 3.3 or OpenGL ES 3.0 at least,
/// with a window or without (surfaceless). The rig may be freed afterwards.
///
/// # Safety
/// `rig` is a live handle; `options` points at a struct of `struct_size` bytes; `gl` is writable; a
/// context is current whose functions `get_proc_address` finds.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_create(
    rig: *const cupola_rig,
    options: *const cupola_gl_options,
    gl: *mut *mut cupola_gl,
) -> cupola_status {
    // SAFETY: as promised above.
    call(|| unsafe { create(rig, options, gl, Embedded::new) })
}

/// Makes a handle by `make`.
///
/// # Safety
/// As for `cupola_gl_create`.
pub(super) unsafe fn create(
    rig: *const cupola_rig,
    options: *const cupola_gl_options,
    gl: *mut *mut cupola_gl,
    make: fn(Gl, &Rig, (u32, u32)) -> crate::Result<Embedded>,
) -> crate::Result<()> {
    // SAFETY: as promised above.
    let rig = unsafe { &rig.as_ref().ok_or_else(|| null("rig"))?.rig };
    if options.is_null() || gl.is_null() {
        return Err(null(if options.is_null() { "options" } else { "gl" }));
    }
    // SAFETY: the size comes first; the rest is read only if it is there.
    check_size(unsafe { (*options).struct_size }, size_of::<cupola_gl_options>(), "options")?;
    // SAFETY: as large as it must be.
    let options = unsafe { &*options };
    let find = options.get_proc_address.ok_or_else(|| null("options.get_proc_address"))?;
    // SAFETY: the program's own function, with a NUL-terminated name.
    let table = Gl::load(|name| unsafe { find(name.as_ptr()) }.map_or(std::ptr::null(), |f| f as *const c_void));
    let embedded = make(table, rig, (options.width, options.height))?;
    // SAFETY: writable, as promised above.
    unsafe { *gl = Box::into_raw(Box::new(cupola_gl { embedded, pending_error: 0 })) };
    Ok(())
}

/// Plans anew for pictures of another size; between frames. On an error the old size stays.
///
/// # Safety
/// `gl` is a live handle whose context is current.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_resize(gl: *mut cupola_gl, width: u32, height: u32) -> cupola_status {
    // SAFETY: as promised above.
    call(|| unsafe { handle(gl) }?.embedded.resize((width, height)))
}

/// Moves and turns the viewer, whose correct point of view the pictures have; between frames. `position`: metres
/// from the dome's centre, x right, y up, z backward; degrees, to the right, up, clockwise. As `cupola_gl_resize` this
/// plans anew and may change number and place of views; it takes about as long as making a `cupola_gl`, so
/// that it is for a viewer who sits down elsewhere, not for one who is tracked. On an error the old viewer stays.
///
/// # Safety
/// `gl` is a live handle whose context is current; `position` points at three numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_set_viewer(
    gl: *mut cupola_gl,
    position: *const f64,
    yaw: f64,
    pitch: f64,
    roll: f64,
) -> cupola_status {
    call(|| {
        if position.is_null() {
            return Err(null("position"));
        }
        // SAFETY: as promised above.
        let (gl, [x, y, z]) = unsafe { (handle(gl)?, *position.cast::<[f64; 3]>()) };
        let [yaw, pitch, roll] = [yaw, pitch, roll].map(f64::to_radians);
        gl.embedded.set_viewer(Viewer { position: DVec3::new(x, y, z), yaw, pitch, roll })
    })
}

/// How many views there are. It changes only with `cupola_gl_resize` and `cupola_gl_set_viewer`.
///
/// # Safety
/// `gl` is a live handle; `count` is writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_view_count(gl: *mut cupola_gl, count: *mut u32) -> cupola_status {
    call(|| {
        // SAFETY: as promised above.
        let (gl, count) = unsafe { (handle(gl)?, count.as_mut().ok_or_else(|| null("count"))?) };
        *count = gl.embedded.view_count() as u32;
        Ok(())
    })
}

/// Describes a view for a camera with these planes (0 < near < far; far may be infinite), in the
/// program's own units. Set `view->struct_size` before.
///
/// # Safety
/// `gl` is a live handle; `view` points at a struct of `view->struct_size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_get_view(
    gl: *mut cupola_gl,
    index: u32,
    near: f64,
    far: f64,
    view: *mut cupola_gl_view,
) -> cupola_status {
    call(|| {
        // SAFETY: as promised above.
        let gl = unsafe { handle(gl) }?;
        if view.is_null() {
            return Err(null("view"));
        }
        // SAFETY: the size comes first; the rest is written only if it is there.
        check_size(unsafe { (*view).struct_size }, size_of::<cupola_gl_view>(), "view")?;
        let described = describe(gl, index, near, far)?;
        // SAFETY: as large as it must be.
        unsafe { *view = described };
        Ok(())
    })
}

fn describe(gl: &cupola_gl, index: u32, near: f64, far: f64) -> crate::Result<cupola_gl_view> {
    let view = gl.embedded.view(index as usize, near, far)?;
    let [x, y, width, height] = view.tile;
    let projection = view.frustum * view.rotation;
    Ok(cupola_gl_view {
        struct_size: size_of::<cupola_gl_view>(),
        index,
        x,
        y,
        width,
        height,
        projection_matrix: uniforms::matrix(&projection),
        rotation_matrix: uniforms::matrix(&view.rotation),
        frustum_matrix: uniforms::matrix(&view.frustum),
        projection_matrix_f64: projection.to_cols_array(),
        rotation_matrix_f64: view.rotation.to_cols_array(),
        frustum_matrix_f64: view.frustum.to_cols_array(),
        name: name_of(view.name),
    })
}

/// Begins a frame.
///
/// # Safety
/// `gl` is a live handle whose context is current.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_begin_frame(gl: *mut cupola_gl) -> cupola_status {
    // SAFETY: as promised above.
    call(|| unsafe { handle(gl) }?.embedded.begin_frame())
}

/// Begins a view: its tile is bound for drawing, with viewport and scissor on it. Clear it and draw
/// the scene with the view's matrices; to draw into a framebuffer of your own in between, bind what
/// was bound again.
///
/// # Safety
/// `gl` is a live handle whose context is current.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_begin_view(gl: *mut cupola_gl, index: u32) -> cupola_status {
    // SAFETY: as promised above.
    call(|| unsafe { handle(gl) }?.embedded.begin_view(index as usize))
}

/// Ends a view: framebuffer bindings, viewport and scissor are as before it.
///
/// # Safety
/// `gl` is a live handle whose context is current.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_end_view(gl: *mut cupola_gl) -> cupola_status {
    // SAFETY: as promised above.
    call(|| unsafe { handle(gl) }?.embedded.end_view())
}

/// Ends a frame: corrects the views into `framebuffer` (0 = the window) with its lower left corner at
/// (x, y). All other state of the context is left as it was; an error that was pending before is kept
/// for `cupola_gl_take_error`, since asking OpenGL for errors takes them away.
///
/// # Safety
/// `gl` is a live handle whose context is current; `framebuffer` is complete.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_end_frame(gl: *mut cupola_gl, framebuffer: u32, x: i32, y: i32) -> cupola_status {
    call(|| {
        // SAFETY: as promised above.
        let gl = unsafe { handle(gl) }?;
        let pending = gl.embedded.end_frame(framebuffer, x, y)?;
        if gl.pending_error == 0 {
            gl.pending_error = pending;
        }
        Ok(())
    })
}

/// A whole frame: begins it, begins each view, has the program draw it, ends it.
///
/// # Safety
/// As for the functions that it stands for; `draw` may use the pointer to the view only while it runs,
/// and must not call functions of the same `cupola_gl`.
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
        // SAFETY: as promised above.
        let gl = unsafe { handle(gl) }?;
        let draw = draw.ok_or_else(|| null("draw"))?;
        let views = gl.embedded.view_count() as u32;
        if views > 0 {
            // Planes that are no planes are refused before anything begins.
            describe(gl, 0, near, far)?;
        }
        gl.embedded.begin_frame()?;
        for index in 0..views {
            let view = describe(gl, index, near, far)?;
            gl.embedded.begin_view(index as usize)?;
            // SAFETY: the program's own function; the view lives while it runs.
            unsafe { draw(&view, user) };
            gl.embedded.end_view()?;
        }
        let pending = gl.embedded.end_frame(framebuffer, x, y)?;
        if gl.pending_error == 0 {
            gl.pending_error = pending;
        }
        Ok(())
    })
}

/// The OpenGL error that the program had pending at the end of a frame (0 = none), once.
///
/// # Safety
/// `gl` is a live handle; `error` is writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_take_error(gl: *mut cupola_gl, error: *mut u32) -> cupola_status {
    call(|| {
        // SAFETY: as promised above.
        let (gl, error) = unsafe { (handle(gl)?, error.as_mut().ok_or_else(|| null("error"))?) };
        *error = std::mem::take(&mut gl.pending_error);
        Ok(())
    })
}

/// Counts so far. Set `statistics->struct_size` before.
///
/// # Safety
/// `gl` is a live handle; `statistics` points at a struct of its `struct_size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_get_statistics(
    gl: *mut cupola_gl,
    statistics: *mut cupola_gl_statistics,
) -> cupola_status {
    call(|| {
        // SAFETY: as promised above.
        let gl = unsafe { handle(gl) }?;
        if statistics.is_null() {
            return Err(null("statistics"));
        }
        let size = size_of::<cupola_gl_statistics>();
        // SAFETY: the size comes first; the rest is written only if it is there.
        check_size(unsafe { (*statistics).struct_size }, size, "statistics")?;
        let counts = gl.embedded.counts();
        // SAFETY: as large as it must be.
        unsafe {
            *statistics = cupola_gl_statistics {
                struct_size: size,
                frames: counts.frames,
                views: counts.views,
                errors: counts.errors,
            };
        }
        Ok(())
    })
}

/// Deletes everything, on the context and off it; null is allowed.
///
/// # Safety
/// `gl` is a live handle whose context is current, or null; it must not be used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_gl_destroy(gl: *mut cupola_gl) -> cupola_status {
    call(|| {
        if !gl.is_null() {
            // SAFETY: the handle came from Box::into_raw in `cupola_gl_create`.
            unsafe { Box::from_raw(gl) }.embedded.destroy();
        }
        Ok(())
    })
}
