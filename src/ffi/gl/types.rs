//! Types of the OpenGL interface.

use crate::ffi::sized::{Growing, first_size};
use std::ffi::{c_char, c_void};

/// Function of OpenGL. Cast it to its own type before the call.
pub type cupola_gl_function = Option<unsafe extern "C" fn()>;

/// Returns the address of an OpenGL function, or NULL where the context has none of that name.
///
/// `name` is NUL-terminated and valid during the call. The function has to find functions of OpenGL
/// 1.0 too, as `glXGetProcAddressARB`, `eglGetProcAddress` and `glfwGetProcAddress` do.
pub type cupola_gl_get_proc_address = Option<unsafe extern "C" fn(name: *const c_char) -> cupola_gl_function>;

/// Draws the program's scene into the current view (see `cupola_gl_draw_frame`).
///
/// `view` is valid during the call; its `struct_size` is that of the library, which may be larger
/// or smaller than the program's. `user` is the pointer that was passed to `cupola_gl_draw_frame`.
pub type cupola_gl_draw = Option<unsafe extern "C" fn(view: *const cupola_gl_view, user: *mut c_void)>;

/// Parameters of `cupola_gl_create`.
#[repr(C)]
pub struct cupola_gl_options {
    /// `sizeof(cupola_gl_options)`.
    pub struct_size: usize,
    /// Function that finds the OpenGL functions of the current context. Required.
    pub get_proc_address: cupola_gl_get_proc_address,
    /// Width in pixels of the picture that all outputs share (the window's width), 1 to 16384.
    pub width: u32,
    /// Height of that picture in pixels, 1 to 16384.
    pub height: u32,
}

// SAFETY: `repr(C)` with the size first; zero is valid for numbers and for optional functions.
unsafe impl Growing for cupola_gl_options {
    const FIRST_SIZE: usize = first_size!(cupola_gl_options, height);
}

/// View: perspective image of the scene that the program draws. All matrices are stored column by
/// column.
#[repr(C)]
pub struct cupola_gl_view {
    /// `sizeof(cupola_gl_view)`.
    pub struct_size: usize,
    /// Index of the view, from 0.
    pub index: u32,
    /// Left edge of the view's tile, in pixels from the left of the atlas.
    pub x: i32,
    /// Bottom edge of the tile, in pixels from the bottom of the atlas.
    pub y: i32,
    /// Width of the tile in pixels.
    pub width: i32,
    /// Height of the tile in pixels.
    pub height: i32,
    /// Matrix from the program's camera axes (x right, y up, -z forward) to the clip space of the
    /// view: `frustum_matrix` times `rotation_matrix`. It replaces the program's projection matrix;
    /// the program's view matrix stays as it is, and with it the lighting.
    pub projection_matrix: [f32; 16],
    /// Matrix from the program's camera axes to the axes of the view, for programs that cull or
    /// draw a sky by view. It has a translation where the rig moves the camera and in the views of
    /// a stereo rig.
    pub rotation_matrix: [f32; 16],
    /// Matrix from the axes of the view to its clip space: an off-centre perspective matrix as that
    /// of `glFrustum`.
    pub frustum_matrix: [f32; 16],
    /// `projection_matrix` in double precision.
    pub projection_matrix_f64: [f64; 16],
    /// `rotation_matrix` in double precision.
    pub rotation_matrix_f64: [f64; 16],
    /// `frustum_matrix` in double precision.
    pub frustum_matrix_f64: [f64; 16],
    /// Name of the view (`front`, `left`, ...), UTF-8, NUL-terminated, cut to 31 bytes.
    pub name: [c_char; 32],
}

// SAFETY: `repr(C)` with the size first; numbers only.
unsafe impl Growing for cupola_gl_view {
    const FIRST_SIZE: usize = first_size!(cupola_gl_view, name);
}

/// Counts since the creation of a `cupola_gl`.
#[repr(C)]
pub struct cupola_gl_statistics {
    /// `sizeof(cupola_gl_statistics)`.
    pub struct_size: usize,
    /// Number of ended frames.
    pub frames: u64,
    /// Number of begun views.
    pub views: u64,
    /// Number of OpenGL errors that calls of the library caused. Anything but 0 is a defect.
    pub errors: u64,
}

// SAFETY: `repr(C)` with the size first; numbers only.
unsafe impl Growing for cupola_gl_statistics {
    const FIRST_SIZE: usize = first_size!(cupola_gl_statistics, errors);
}
