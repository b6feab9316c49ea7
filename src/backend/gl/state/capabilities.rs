//! Capabilities of a context.

use crate::backend::gl::driver::api::*;
use crate::backend::gl::driver::values::integer;
use crate::backend::gl::state::known_state::MOST_DRAW_BUFFERS;
use std::ffi::CStr;

/// Capabilities of a context, found once.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::backend::gl) struct Capabilities {
    /// OpenGL ES.
    pub gles: bool,
    /// Version: 10·major + minor.
    pub version: i32,
    /// The context has the fixed-function state.
    pub(super) compatibility: bool,
    pub(super) clip_control: bool,
    pub(super) framebuffer_srgb: bool,
    /// A sampler can skip the decoding of sRGB textures.
    pub srgb_decode: bool,
    /// 16-bit normalised textures.
    pub norm16: bool,
    pub(super) depth_bounds: bool,
    pub(super) clip_distances: bool,
    pub(super) indexed_blend: bool,
    pub(super) viewport_array: bool,
    /// Transform feedback can be paused.
    pub(super) feedback_pauses: bool,
    /// The driver can return linked programs and load them again.
    pub program_binaries: bool,
    pub(super) draw_buffers: u32,
}

impl Capabilities {
    /// Returns the capabilities of the current context.
    pub fn of(gl: &Gl, gles: bool) -> Self {
        let version = 10 * integer(gl, GL_MAJOR_VERSION) + integer(gl, GL_MINOR_VERSION);
        // GL_CONTEXT_PROFILE_MASK exists from 3.2 on; older contexts have the fixed-function state.
        let compatibility = !gles
            && (version < 32
                || integer(gl, GL_CONTEXT_PROFILE_MASK) & GL_CONTEXT_COMPATIBILITY_PROFILE_BIT as i32 != 0);
        let mut found = Self {
            gles,
            version,
            compatibility,
            clip_control: !gles && version >= 45,
            framebuffer_srgb: !gles,
            srgb_decode: false,
            norm16: !gles,
            depth_bounds: false,
            clip_distances: !gles,
            indexed_blend: if gles { version >= 32 } else { version >= 30 },
            viewport_array: !gles && version >= 41,
            feedback_pauses: gles || version >= 40,
            program_binaries: version >= if gles { 30 } else { 41 },
            draw_buffers: integer(gl, GL_MAX_DRAW_BUFFERS).clamp(1, MOST_DRAW_BUFFERS as i32) as u32,
        };
        for i in 0..integer(gl, GL_NUM_EXTENSIONS).max(0) as u32 {
            // SAFETY: the index is below the number of extensions.
            let name = unsafe { gl.get_stringi(GL_EXTENSIONS, i) };
            if name.is_null() {
                break; // The driver lists fewer extensions than it counts.
            }
            // SAFETY: GL strings end with a zero.
            match unsafe { CStr::from_ptr(name.cast()) }.to_bytes() {
                b"GL_ARB_clip_control" | b"GL_EXT_clip_control" => found.clip_control = true,
                b"GL_EXT_sRGB_write_control" => found.framebuffer_srgb = true,
                b"GL_EXT_texture_sRGB_decode" => found.srgb_decode = true,
                b"GL_EXT_texture_norm16" => found.norm16 = true,
                b"GL_ARB_transform_feedback2" => found.feedback_pauses = true,
                b"GL_ARB_get_program_binary" => found.program_binaries = true,
                b"GL_EXT_depth_bounds_test" => found.depth_bounds = true,
                b"GL_EXT_clip_cull_distance" | b"GL_APPLE_clip_distance" => found.clip_distances = true,
                _ => {}
            }
        }
        found
    }

    /// Returns the version for [`CurrentProgram::save`].
    pub(super) fn subroutines(&self) -> i32 {
        if self.gles { 0 } else { self.version }
    }

    /// True if the context has the switch, by its version or an extension.
    pub(super) fn knows(&self, switch: u32) -> bool {
        let (desktop, version) = (!self.gles, self.version);
        match switch {
            GL_SAMPLE_MASK => version >= if desktop { 32 } else { 31 },
            GL_SAMPLE_SHADING => version >= if desktop { 40 } else { 32 },
            GL_COLOR_LOGIC_OP | GL_POLYGON_SMOOTH | GL_PRIMITIVE_RESTART => desktop,
            GL_ALPHA_TEST | GL_POLYGON_STIPPLE => self.compatibility,
            GL_FRAMEBUFFER_SRGB => self.framebuffer_srgb,
            GL_DEPTH_BOUNDS_TEST_EXT => self.depth_bounds,
            GL_CLIP_DISTANCE0..=GL_CLIP_DISTANCE7 => self.clip_distances,
            _ => true,
        }
    }
}
