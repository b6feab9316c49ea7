//! The state that uploading textures and vertices changes: read, set, restored.

use crate::backend::gl::driver::api::*;
use crate::backend::gl::driver::values::integer;
use crate::backend::gl::state::capabilities::Capabilities;
use crate::backend::gl::state::current_program::CurrentProgram;
use crate::backend::gl::state::saved::pause_feedback;

struct SavedUpload {
    program: CurrentProgram,
    vertex_array: u32,
    array_buffer: u32,
    unpack_buffer: u32,
    texture: u32,
    /// Values of `UNPACK`.
    unpack: [i32; 6],
    feedback: bool,
}

const UNPACK: [u32; 6] = [
    GL_UNPACK_ALIGNMENT,
    GL_UNPACK_ROW_LENGTH,
    GL_UNPACK_SKIP_ROWS,
    GL_UNPACK_SKIP_PIXELS,
    GL_UNPACK_SWAP_BYTES,
    GL_UNPACK_LSB_FIRST,
];

/// Returns how many names of `UNPACK` a context knows: OpenGL ES lacks the last two.
fn unpack_count(caps: &Capabilities) -> usize {
    if caps.gles { 4 } else { 6 }
}

/// Runs `work` with tightly packed rows. The state that uploading changes is restored.
pub(in crate::backend::gl) fn while_uploading<R>(gl: &Gl, caps: &Capabilities, work: impl FnOnce() -> R) -> R {
    let saved = save_upload(gl, caps);
    let result = work();
    restore_upload(gl, caps, &saved);
    result
}

fn save_upload(gl: &Gl, caps: &Capabilities) -> SavedUpload {
    let mut saved = SavedUpload {
        program: CurrentProgram::save(gl, caps.subroutines()),
        vertex_array: integer(gl, GL_VERTEX_ARRAY_BINDING) as u32,
        array_buffer: integer(gl, GL_ARRAY_BUFFER_BINDING) as u32,
        unpack_buffer: integer(gl, GL_PIXEL_UNPACK_BUFFER_BINDING) as u32,
        texture: integer(gl, GL_TEXTURE_BINDING_2D) as u32,
        unpack: [0; 6],
        feedback: pause_feedback(gl, caps),
    };
    // SAFETY: a context is current and knows the names.
    unsafe {
        for (i, &name) in UNPACK.iter().enumerate().take(unpack_count(caps)) {
            saved.unpack[i] = integer(gl, name);
            gl.pixel_storei(name, if name == GL_UNPACK_ALIGNMENT { 1 } else { 0 });
        }
        gl.bind_buffer(GL_PIXEL_UNPACK_BUFFER, 0);
    }
    saved
}

fn restore_upload(gl: &Gl, caps: &Capabilities, saved: &SavedUpload) {
    // SAFETY: a context is current; the values are those that it gave.
    unsafe {
        for (i, &name) in UNPACK.iter().enumerate().take(unpack_count(caps)) {
            gl.pixel_storei(name, saved.unpack[i]);
        }
        gl.bind_buffer(GL_PIXEL_UNPACK_BUFFER, saved.unpack_buffer);
        gl.bind_texture(GL_TEXTURE_2D, saved.texture);
        gl.bind_vertex_array(saved.vertex_array);
        gl.bind_buffer(GL_ARRAY_BUFFER, saved.array_buffer);
        saved.program.restore(gl);
        if saved.feedback {
            gl.resume_transform_feedback();
        }
    }
}
