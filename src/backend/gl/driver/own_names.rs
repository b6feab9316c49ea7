//! Names for objects of our own.
//!
//! Programs of the old profile and of OpenGL ES may use names that they never asked for, mostly
//! from 1 on. Ours are far from those there.

use crate::backend::gl::driver::api::{self, Gl};

/// Number of names that are left to programs that use names which they have not generated.
const PROGRAM_NAMES: usize = 4096;

/// A command that writes names, and one that deletes them.
type Commands = (unsafe fn(&Gl, i32, *mut u32), unsafe fn(&Gl, i32, *const u32));

/// A name of a texture. The caller deletes it, as those of the next functions.
pub fn texture(gl: &Gl) -> u32 {
    name(gl, (Gl::gen_textures, Gl::delete_textures))
}

/// A name of a buffer.
pub fn buffer(gl: &Gl) -> u32 {
    name(gl, (Gl::gen_buffers, Gl::delete_buffers))
}

/// A name of a framebuffer.
pub fn framebuffer(gl: &Gl) -> u32 {
    name(gl, (Gl::gen_framebuffers, Gl::delete_framebuffers))
}

/// A name of a renderbuffer.
pub fn renderbuffer(gl: &Gl) -> u32 {
    name(gl, (Gl::gen_renderbuffers, Gl::delete_renderbuffers))
}

fn name(gl: &Gl, (generate, delete): Commands) -> u32 {
    let mut names = [0; PROGRAM_NAMES];
    // SAFETY: writes as many names as there is room for, and gives back all but the last.
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

/// True if programs may use names that they did not ask for.
fn takes_any_name(gl: &Gl) -> bool {
    if gl.is_es() {
        return true;
    }
    let mut profile = 0;
    // SAFETY: writes one integer.
    unsafe { gl.get_integerv(api::GL_CONTEXT_PROFILE_MASK, &mut profile) };
    profile as u32 & api::GL_CONTEXT_COMPATIBILITY_PROFILE_BIT != 0
}
