//! What a compute shader of the program uses.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::shader::prover::tokens;
use crate::intercept::gl::state::shader::programs::{BufferWrites, ComputeStage};
use std::ffi::{CStr, c_char};

/// That of a linked program with this text, if it has one. `loses_cameras`: its matrices are not chosen.
pub fn of_program(gl: &Gl, program: u32, source: &str, loses_cameras: bool) -> ComputeStage {
    ComputeStage { images: images(gl, program), buffers: writes(source), loses_cameras }
}

/// Whether a text names a 4×4 matrix that the program gives it.
pub fn has_matrices(source: &str) -> bool {
    let bare = tokens::bare(source);
    let mut words = Vec::new();
    bare.lines().filter(|line| !line.trim_start().starts_with('#')).for_each(|line| tokens::words(line, &mut words));
    words.contains(&"uniform") && words.iter().any(|word| matches!(*word, "mat4" | "mat4x4"))
}

/// Locations of the uniforms that are images of two dimensions.
fn images(gl: &Gl, program: u32) -> Vec<i32> {
    let mut count = 0;
    // SAFETY: writes one integer.
    unsafe { gl.get_programiv(program, api::GL_ACTIVE_UNIFORMS, &mut count) };
    let mut found = Vec::new();
    for index in 0..u32::try_from(count).unwrap_or(0) {
        let mut text: [c_char; 256] = [0; 256];
        let (mut length, mut size, mut kind) = (0, 0, 0);
        // SAFETY: writes at most 256 characters with their NUL, which is what the location is asked by.
        let location = unsafe {
            gl.get_active_uniform(program, index, 256, &mut length, &mut size, &mut kind, text.as_mut_ptr());
            gl.get_uniform_location(program, CStr::from_ptr(text.as_ptr()).as_ptr())
        };
        let is_image = matches!(kind, api::GL_IMAGE_2D | api::GL_INT_IMAGE_2D | api::GL_UNSIGNED_INT_IMAGE_2D);
        if is_image && location >= 0 {
            // The elements of an array have locations that follow each other.
            found.extend(location..location + size.max(1));
        }
    }
    found
}

/// What a text may write to buffers.
fn writes(source: &str) -> BufferWrites {
    let bare = tokens::bare(source);
    let mut words = Vec::new();
    bare.lines().for_each(|line| tokens::words(line, &mut words));
    let counters = words.contains(&"atomic_uint");
    let written = (0..words.len()).filter(|at| words[*at] == "buffer").any(|at| {
        let before = words[..at].iter().rev().take_while(|word| !matches!(**word, ";" | "{" | "}"));
        let behind = words[at..].iter().take_while(|word| !matches!(**word, ";" | "{"));
        !before.chain(behind).any(|word| *word == "readonly")
    });
    let adds = words.iter().any(|word| word.starts_with("atomic") && *word != "atomic_uint");
    match (written, counters) {
        (true, _) if !adds => BufferWrites::Places,
        (true, _) | (_, true) => BufferWrites::Sums,
        (false, false) => BufferWrites::Nothing,
    }
}

#[cfg(test)]
mod tests {
    use super::{has_matrices, writes};
    use crate::intercept::gl::state::shader::programs::BufferWrites;

    #[test]
    fn buffers_that_a_text_may_write() {
        for (text, expected) in [
            ("uniform sampler2D s; void main() {}", BufferWrites::Nothing),
            ("layout(std430) readonly buffer B { float b[]; }; void main() {}", BufferWrites::Nothing),
            ("layout(std430) buffer B { float b[]; }; void main() { b[0] = 1.0; }", BufferWrites::Places),
            ("buffer B { uint b; }; void main() { atomicAdd(b, 1); }", BufferWrites::Sums),
            (
                "layout(binding = 0) uniform atomic_uint c; void main() { atomicCounterIncrement(c); }",
                BufferWrites::Sums,
            ),
            ("// buffer\nvoid main() {}", BufferWrites::Nothing),
        ] {
            assert_eq!(writes(text), expected, "{text}");
        }
        assert!(has_matrices("uniform mat4 m; void main() {}") && !has_matrices("void main() { mat4 m; }"));
    }
}
