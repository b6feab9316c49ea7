//! Names for objects of Cupola.
//!
//! In the compatibility profile and in OpenGL ES a program may use names that it has not generated,
//! mostly from 1 on. There, names of Cupola are far above these.

use crate::backend::gl::driver::api::{self, Gl};

/// Number of names left free for programs that use names without generating them.
const PROGRAM_NAMES: usize = 4096;

/// A command that generates names, and one that deletes them.
type Commands = (unsafe fn(&Gl, i32, *mut u32), unsafe fn(&Gl, i32, *const u32));

/// Generates the name of a texture. The caller deletes it; the same holds for the next functions.
pub fn texture(gl: &Gl) -> u32 {
    name(gl, (Gl::gen_textures, Gl::delete_textures))
}

/// Generates the name of a buffer.
pub fn buffer(gl: &Gl) -> u32 {
    name(gl, (Gl::gen_buffers, Gl::delete_buffers))
}

/// Generates the name of a framebuffer.
pub fn framebuffer(gl: &Gl) -> u32 {
    name(gl, (Gl::gen_framebuffers, Gl::delete_framebuffers))
}

/// Generates the name of a renderbuffer.
pub fn renderbuffer(gl: &Gl) -> u32 {
    name(gl, (Gl::gen_renderbuffers, Gl::delete_renderbuffers))
}

fn name(gl: &Gl, (generate, delete): Commands) -> u32 {
    let mut names = [0; PROGRAM_NAMES];
    // SAFETY: writes at most as many names as the array holds, and deletes all but the last.
    unsafe {
        if !takes_any_name(gl) {
            generate(gl, 1, names.as_mut_ptr());
            return names[0];
        }
        generate(gl, PROGRAM_NAMES as i32, names.as_mut_ptr());
        delete(gl, PROGRAM_NAMES as i32 - 1, names.as_ptr());
    }
    names[PROGRAM_NAMES - 1]
}

/// True if programs may use names that they have not generated.
fn takes_any_name(gl: &Gl) -> bool {
    if gl.is_es() {
        return true;
    }
    let mut profile = 0;
    // SAFETY: writes one integer.
    unsafe { gl.get_integerv(api::GL_CONTEXT_PROFILE_MASK, &mut profile) };
    profile as u32 & api::GL_CONTEXT_COMPATIBILITY_PROFILE_BIT != 0
}
