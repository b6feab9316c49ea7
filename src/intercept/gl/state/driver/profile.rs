//! Version and profile of a context.

use crate::backend::gl::driver::api::{self, Gl, Outside};
use std::ffi::CStr;

/// Version and profile of OpenGL in a context.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Profile {
    /// True for OpenGL ES.
    pub es: bool,
    /// True for desktop OpenGL without the fixed-function pipeline.
    pub core: bool,
    /// Version: major · 10 + minor.
    pub version: u32,
    /// True if viewports and scissors have indices.
    pub viewport_arrays: bool,
    /// Limits that the driver applies to viewports with an index.
    pub viewport_limits: ViewportLimits,
    /// Number of generic attributes of a vertex.
    pub generic_attributes: u32,
}

/// Limits of viewports.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ViewportLimits {
    /// Least and greatest position of a left or lower edge.
    pub edge: [f32; 2],
    /// Greatest width and height.
    pub size: [f32; 2],
}

impl Profile {
    /// True for desktop OpenGL with the fixed-function pipeline.
    pub fn compatibility(&self) -> bool {
        !self.es && !self.core
    }

    /// True if a program can choose the buffers that it draws to and reads from.
    pub fn has_buffers(&self) -> bool {
        self.version >= if self.es { 30 } else { 20 }
    }

    /// True if contexts of this kind do not have a command.
    pub fn is_outside(&self, command: Outside) -> bool {
        (self.core && command.core) || (self.es && self.version >= 20 && command.es)
    }
}

pub(in crate::intercept::gl) fn profile(gl: &Gl) -> Profile {
    let text = gl.text(api::GL_VERSION);
    let (es, numbers) = match text.strip_prefix("OpenGL ES") {
        Some(rest) => (true, rest.trim_start_matches(|c: char| !c.is_ascii_digit())),
        None => (false, text.as_str()),
    };
    let mut parts = numbers.split(|c: char| !c.is_ascii_digit()).map(|n| n.parse::<u32>().unwrap_or(0));
    let version = parts.next().unwrap_or(0) * 10 + parts.next().unwrap_or(0);
    let (mut mask, mut flags) = (0, 0);
    if !es && version >= 30 {
        // SAFETY: the query exists since OpenGL 3.0 and writes one integer.
        unsafe { gl.get_integerv(api::GL_CONTEXT_FLAGS, &mut flags) };
    }
    let forward = flags as u32 & api::GL_CONTEXT_FLAG_FORWARD_COMPATIBLE_BIT != 0;
    if !es && version >= 32 {
        // SAFETY: the query exists since OpenGL 3.2 and writes one integer.
        unsafe { gl.get_integerv(api::GL_CONTEXT_PROFILE_MASK, &mut mask) };
    }
    let core = forward || mask as u32 & api::GL_CONTEXT_CORE_PROFILE_BIT != 0;
    let arrays = if es { "GL_OES_viewport_array" } else { "GL_ARB_viewport_array" };
    let viewport_arrays = (!es && version >= 41) || (version >= 30 && has_extension(gl, arrays));
    let mut viewport_limits = ViewportLimits::default();
    if viewport_arrays {
        // SAFETY: viewports with an index bring these queries; each writes two numbers.
        unsafe {
            gl.get_floatv(api::GL_VIEWPORT_BOUNDS_RANGE, viewport_limits.edge.as_mut_ptr());
            gl.get_floatv(api::GL_MAX_VIEWPORT_DIMS, viewport_limits.size.as_mut_ptr());
        }
    }
    let mut generic_attributes = 16;
    if version >= 20 {
        // SAFETY: the query exists since OpenGL 2.0 and OpenGL ES 2.0 and writes one integer.
        unsafe { gl.get_integerv(api::GL_MAX_VERTEX_ATTRIBS, &mut generic_attributes) };
    }
    let generic_attributes = generic_attributes as u32;
    Profile { es, core, version, viewport_arrays, viewport_limits, generic_attributes }
}

/// True if a context of version 3.0 or later has an extension.
fn has_extension(gl: &Gl, name: &str) -> bool {
    let mut count = 0;
    // SAFETY: writes one integer; the driver's strings end with a zero and live as long as it.
    unsafe {
        gl.get_integerv(api::GL_NUM_EXTENSIONS, &mut count);
        (0..count as u32).any(|index| {
            let text = gl.get_stringi(api::GL_EXTENSIONS, index);
            !text.is_null() && CStr::from_ptr(text.cast()).to_bytes() == name.as_bytes()
        })
    }
}

/// True if the driver is llvmpipe, whose anisotropic filtering may never end.
pub fn is_endless(gl: &Gl) -> bool {
    gl.text(api::GL_RENDERER).starts_with("llvmpipe")
}

/// True if the driver draws on the processor and can write rows from the top: it reads pixels with one copy to memory,
/// and a pixel buffer would only add a second one.
pub fn reads_to_memory(gl: &Gl, profile: &Profile) -> bool {
    let renderer = gl.text(api::GL_RENDERER);
    !profile.es
        && profile.version >= 30
        && ["llvmpipe", "softpipe"].iter().any(|name| renderer.starts_with(name))
        && has_extension(gl, "GL_MESA_pack_invert")
}
