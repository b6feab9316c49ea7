//! Images and buffers that a compute shader of the program uses.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::shader::source::text::tokens;
use crate::intercept::gl::state::shader::programs::{BufferWrites, ComputeStage, WrittenImage};
use std::ffi::{CStr, c_char};
use std::ops::Range;

/// Returns the compute stage of a linked program with this text. `loses_cameras`: the text has no
/// choices for its matrices.
pub fn of_program(gl: &Gl, program: u32, source: &str, loses_cameras: bool) -> ComputeStage {
    let bare = tokens::bare(source);
    let words = all_words(&bare);
    let (images, other_images) = images(gl, program, &words);
    let image_atomics = words.iter().any(|word| word.starts_with("imageAtomic"));
    ComputeStage { images, other_images, image_atomics, buffers: writes(&bare, &words), loses_cameras }
}

/// Returns the words of a text without comments, including the words of its directives.
fn all_words(bare: &str) -> Vec<&str> {
    let mut words = Vec::new();
    bare.lines().for_each(|line| tokens::words(line, &mut words));
    words
}

/// True if a text uses a 4×4 matrix that the program sets. A matrix that is only declared, as in
/// the common header of an engine, is not used.
pub fn has_matrices(source: &str) -> bool {
    let bare = tokens::bare(source);
    let words = all_words(&bare);
    words.contains(&"uniform")
        && words.iter().enumerate().filter(|(_, word)| matches!(**word, "mat4" | "mat4x4")).any(|(at, _)| {
            // The names that follow, with sizes of arrays. A cast or a macro has no name here.
            let declared = words[at + 1..].iter().take_while(|word| **word != ";" && **word != "(");
            let mut names = declared.filter(|word| tokens::is_name(word)).peekable();
            names.peek().is_none() || names.any(|name| words.iter().filter(|word| *word == name).count() > 1)
        })
}

/// Types of images that are two-dimensional pictures.
const PICTURES: [u32; 3] = [api::GL_IMAGE_2D, api::GL_INT_IMAGE_2D, api::GL_UNSIGNED_INT_IMAGE_2D];

/// Returns the locations of the uniforms that are two-dimensional images, and of the other images
/// that the text may write.
fn images(gl: &Gl, program: u32, words: &[&str]) -> (Vec<i32>, Vec<i32>) {
    let (mut pictures, mut others) = (Vec::new(), Vec::new());
    for ImageUniform { locations, kind, name } in image_uniforms(gl, program) {
        if PICTURES.contains(&kind) {
            pictures.extend(locations);
        } else if !is_read_only(words, &name) {
            others.extend(locations);
        }
    }
    (pictures, others)
}

/// A uniform that is an image, or an array of images.
struct ImageUniform {
    /// Locations of the elements.
    locations: Range<i32>,
    /// Type.
    kind: u32,
    /// Name without an index.
    name: String,
}

/// Returns the image uniforms of a linked program.
fn image_uniforms(gl: &Gl, program: u32) -> impl Iterator<Item = ImageUniform> {
    let mut count = 0;
    // SAFETY: writes one integer.
    unsafe { gl.get_programiv(program, api::GL_ACTIVE_UNIFORMS, &mut count) };
    (0..u32::try_from(count).unwrap_or(0)).filter_map(move |index| {
        let mut text: [c_char; 256] = [0; 256];
        let (mut length, mut size, mut kind) = (0, 0, 0);
        // SAFETY: writes at most 256 characters with their NUL, which are the name for the
        // location.
        let (location, name) = unsafe {
            gl.get_active_uniform(program, index, 256, &mut length, &mut size, &mut kind, text.as_mut_ptr());
            let name = CStr::from_ptr(text.as_ptr());
            (gl.get_uniform_location(program, name.as_ptr()), name.to_string_lossy())
        };
        // The elements of an array have consecutive locations.
        let locations = location..location + size.max(1);
        // In OpenGL's registry these types have consecutive numbers.
        let is_image = (api::GL_IMAGE_1D..=api::GL_UNSIGNED_INT_IMAGE_2D_MULTISAMPLE_ARRAY).contains(&kind);
        let name = name.split('[').next().unwrap_or_default().to_owned();
        (location >= 0 && is_image).then_some(ImageUniform { locations, kind, name })
    })
}

/// Returns the images that a linked program has.
pub fn images_of(gl: &Gl, program: u32) -> impl Iterator<Item = WrittenImage> {
    let images = image_uniforms(gl, program);
    images.flat_map(move |image| {
        image.locations.map(move |location| WrittenImage { program, location, kind: image.kind })
    })
}

/// True if the declaration of an image, which is its first mention, has `readonly`.
fn is_read_only(words: &[&str], name: &str) -> bool {
    let Some(at) = words.iter().position(|word| *word == name) else { return false };
    words[..at].iter().rev().take_while(|word| !matches!(**word, ";" | "{" | "}")).any(|word| *word == "readonly")
}

/// True if a shader with this text may write to an image.
pub fn may_write_images(source: &str) -> bool {
    // Most shaders have none, and need not be read.
    (source.contains("imageStore") || source.contains("imageAtomic"))
        && all_words(&tokens::bare(source))
            .iter()
            .any(|word| word.starts_with("imageStore") || word.starts_with("imageAtomic"))
}

/// True if a shader with this text may write to a storage buffer.
pub fn may_write_buffers(source: &str) -> bool {
    // Most shaders have none, and need not be read.
    if !source.contains("buffer") {
        return false;
    }
    let bare = tokens::bare(source);
    let words = all_words(&bare);
    words.contains(&"buffer") && ways_to_write(&bare, &words).is_some_and(|ways| ways.atomics || ways.others)
}

/// Returns the kind of writes to buffers that a text may perform.
fn writes(bare: &str, words: &[&str]) -> BufferWrites {
    match ways_to_write(bare, words) {
        None if words.contains(&"atomic_uint") => BufferWrites::Sums,
        None => BufferWrites::Nothing,
        Some(Ways { atomics: true, others: false }) => BufferWrites::Sums,
        Some(_) => BufferWrites::Places,
    }
}

/// Ways in which a text may write to storage buffers.
struct Ways {
    /// By atomic functions.
    atomics: bool,
    /// By assignments, functions or macros.
    others: bool,
}

/// Returns the ways in which a text may write to storage buffers; `None` if it has none that it may
/// write.
fn ways_to_write(bare: &str, words: &[&str]) -> Option<Ways> {
    let mut buffers = words.iter().enumerate().filter(|(_, word)| **word == "buffer").map(|(at, _)| at).filter(|at| {
        let before = words[..*at].iter().rev().take_while(|word| !matches!(**word, ";" | "{" | "}"));
        let behind = words[*at..].iter().take_while(|word| !matches!(**word, ";" | "{"));
        !before.chain(behind).any(|word| *word == "readonly")
    });
    let first = buffers.next()?;
    let mut members = Vec::new();
    std::iter::once(first).chain(buffers).for_each(|at| block_members(&words[at..], &mut members));
    let shared = shared_names(words);
    let atomics = words.windows(3).any(|part| {
        let is_atomic = part[0].starts_with("atomic") && part[0] != "atomic_uint";
        is_atomic && part[1] == "(" && !shared.contains(&part[2])
    });
    // A member in a macro may be used in any way.
    let in_macros = bare.lines().filter(|line| line.trim_start().starts_with('#')).any(|line| {
        let body = all_words(line);
        body.iter().any(|word| members.contains(word))
    });
    Some(Ways { atomics, others: in_macros || assigns(words, &members) })
}

/// Adds the names by which the text uses the members of a block: the name of the block's instance,
/// or the members' own names. `words` begins with `buffer`.
fn block_members<'a>(words: &[&'a str], members: &mut Vec<&'a str>) {
    let Some(open) = words.iter().position(|word| matches!(*word, "{" | ";")).filter(|at| words[*at] == "{") else {
        return;
    };
    let Some(length) = words[open..].iter().position(|word| *word == "}") else { return };
    if let Some(instance) = words.get(open + length + 1).filter(|word| tokens::is_name(word)) {
        return members.push(instance);
    }
    let mut depth = 0;
    for pair in words[open..=open + length].windows(2) {
        match pair[0] {
            "[" | "(" => depth += 1,
            "]" | ")" => depth -= 1,
            name if depth == 0 && tokens::is_name(name) && matches!(pair[1], ";" | "," | "[") => members.push(name),
            _ => {}
        }
    }
}

/// Returns the names in declarations of variables that a work group shares.
fn shared_names<'a>(words: &[&'a str]) -> Vec<&'a str> {
    let declared = words.iter().enumerate().filter(|(_, word)| **word == "shared");
    declared.flat_map(|(at, _)| words[at..].iter().take_while(|word| **word != ";").copied()).collect()
}

/// True if a text may write one of `names`, or a part of it, by other means than an atomic
/// function.
fn assigns(words: &[&str], names: &[&str]) -> bool {
    const ASSIGNMENTS: [&str; 13] = ["=", "+=", "-=", "*=", "/=", "%=", "&=", "|=", "^=", "<<=", ">>=", "++", "--"];
    let gives_back = words.iter().any(|word| matches!(*word, "out" | "inout"));
    words.iter().enumerate().filter(|(_, word)| names.contains(word)).any(|(at, _)| {
        let before = if at > 0 { words[at - 1] } else { "" };
        let behind = words.get(end_of_access(words, at)).copied().unwrap_or_default();
        let is_argument = matches!(before, "(" | ",") && matches!(behind, ")" | ",");
        let by_atomic = at > 1 && words[at - 2].starts_with("atomic");
        let changes = ASSIGNMENTS.contains(&behind) || matches!(before, "++" | "--");
        before != "." && (changes || gives_back && is_argument && !by_atomic)
    })
}

/// Returns the end of the indices and members that follow the name at `at`.
fn end_of_access(words: &[&str], at: usize) -> usize {
    let (mut end, mut depth) = (at + 1, 0);
    while let Some(word) = words.get(end) {
        match *word {
            "[" => depth += 1,
            "]" => depth -= 1,
            "." if depth == 0 => end += 1,
            _ if depth == 0 => break,
            _ => {}
        }
        end += 1;
    }
    end
}

#[cfg(test)]
mod tests {
    use super::{all_words, has_matrices, is_read_only};
    use crate::intercept::gl::state::shader::programs::BufferWrites;

    fn writes(text: &str) -> BufferWrites {
        let bare = super::tokens::bare(text);
        super::writes(&bare, &all_words(&bare))
    }

    #[test]
    fn lists_of_each_place_are_no_sums() {
        let shared = "shared uint nearest; buffer Lights { uint list[]; };
            void main() { atomicMin(nearest, 3u); barrier(); list[gl_WorkGroupID.x * 4u] = nearest; }";
        let counted = "buffer Lights { uint n; uint list[]; };
            void main() { uint i = atomicAdd(n, 1u); list[i] = 7u; }";
        let instance = "buffer Lights { uint n; uint list[]; } lights;
            void main() { lights.list[atomicAdd(lights.n, 1u)].x += 7u; }";
        let only_shared = "shared uint n; buffer B { uint b[]; }; void main() { atomicAdd(n, 1u); }";
        let by_macro = "buffer B { uint n, b[]; };\n#define PUT b[2]\nvoid main() { PUT = atomicAdd(n, 1u); }";
        let by_function = "buffer B { uint n, b[]; }; void put(out uint x) { x = 1u; }
            void main() { atomicAdd(n, 1u); put(b[2]); }";
        for text in [shared, counted, instance, only_shared, by_macro, by_function] {
            assert_eq!(writes(text), BufferWrites::Places, "{text}");
        }
        let histogram = "shared uint own[256]; buffer Histogram { uint bins[256]; } all; buffer S { uint total; };
            void main() { own[3] = 0u; atomicAdd(own[3], 1u); uint bins = 1u; atomicAdd(all.bins[3], own[3]);
                if (total == 0u) atomicAdd(total, 1u); }";
        assert_eq!(writes(histogram), BufferWrites::Sums);
    }

    #[test]
    fn images_that_are_only_read() {
        let words =
            all_words("layout(r8) uniform readonly image3D table; layout(r8) uniform image3D fog; void main() {}");
        assert!(is_read_only(&words, "table") && !is_read_only(&words, "fog") && !is_read_only(&words, "none"));
    }

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
    }

    #[test]
    fn buffers_that_are_only_read_are_not_written() {
        for (text, expected) in [
            ("buffer B { mat4 b[]; } all; void main() { gl_Position = all.b[gl_InstanceID] * p; }", false),
            ("buffer B { uint n, b[]; }; void main() { if (b[2] == n) discard; }", false),
            ("buffer B { uint b[]; } all; void main() { all.b[3] = 1u; }", true),
            ("buffer B { uint n; }; void main() { atomicAdd(n, 1u); }", true),
            ("buffer B { uint n; };\n#define PUT n\nvoid main() { PUT = 1u; }", true),
            ("layout(binding = 0) uniform atomic_uint c; void main() { atomicCounterIncrement(c); }", false),
        ] {
            assert_eq!(super::may_write_buffers(text), expected, "{text}");
        }
    }

    #[test]
    fn matrices_that_are_only_declared_are_not_used() {
        for unused in [
            "void main() { mat4 m; }",
            "uniform mat4 m; void main() {}",
            "layout(std140) uniform Matrices { mat4 view; mat4 shadows[4]; vec2 screen; }; void main() { screen; }",
        ] {
            assert!(!has_matrices(unused), "{unused}");
        }
        for used in [
            "uniform mat4 m; void main() { m; }",
            "uniform Matrices { mat4 view, other[N]; } all; void main() { all.other[2]; }",
            "uniform mat4 m;\n#define M m\nvoid main() { M; }",
            "#define MATRIX mat4\nuniform MATRIX m; void main() { m; }",
            "uniform vec4 v[4]; void main() { mat4(v[0], v[1], v[2], v[3]); }",
        ] {
            assert!(has_matrices(used), "{used}");
        }
    }
}
