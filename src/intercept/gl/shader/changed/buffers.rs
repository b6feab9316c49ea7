//! Atomic counters and storage buffers that shaders of a draw change.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::state::driver::profile::Profile;
use crate::intercept::gl::state::shader::programs::ChangedBuffer;
use crate::intercept::process::log;

/// Greatest storage buffer that is copied for each draw, in bytes.
const LARGEST: i64 = 1 << 20;

/// Returns the atomic counters of a linked program.
pub fn of_program(gl: &Gl, profile: &Profile, program: u32) -> Vec<ChangedBuffer> {
    if profile.version < if profile.es { 31 } else { 43 } {
        return Vec::new();
    }
    let counters = |index: u32| {
        let properties = [api::GL_BUFFER_BINDING, api::GL_BUFFER_DATA_SIZE];
        let [binding, size] = resource(gl, program, api::GL_ATOMIC_COUNTER_BUFFER, index, properties);
        Some(ChangedBuffer::Counters { binding: binding as u32, size: usize::try_from(size).ok()? })
    };
    (0..resources(gl, program, api::GL_ATOMIC_COUNTER_BUFFER)).filter_map(counters).collect()
}

/// Returns the storage buffers of a linked program. Its shaders have such buffers, so the driver has
/// the questions.
pub fn storage_of(gl: &Gl, program: u32) -> impl Iterator<Item = ChangedBuffer> {
    let blocks = 0..resources(gl, program, api::GL_SHADER_STORAGE_BLOCK);
    blocks.map(move |block| ChangedBuffer::Storage { program, block })
}

/// Returns the number of a program's resources of a kind.
fn resources(gl: &Gl, program: u32, kind: u32) -> u32 {
    let mut count = 0;
    // SAFETY: writes one integer.
    unsafe { gl.get_program_interfaceiv(program, kind, api::GL_ACTIVE_RESOURCES, &mut count) };
    u32::try_from(count).unwrap_or(0)
}

/// Returns properties of a program's resource, each one integer.
fn resource<const COUNT: usize>(gl: &Gl, program: u32, kind: u32, index: u32, names: [u32; COUNT]) -> [i32; COUNT] {
    let (mut answers, length) = ([0; COUNT], std::ptr::null_mut());
    let count = COUNT as i32;
    // SAFETY: so many properties in, at most so many integers out.
    unsafe {
        gl.get_program_resourceiv(program, kind, index, count, names.as_ptr(), count, length, answers.as_mut_ptr());
    }
    answers
}

/// A buffer of the program, and the buffer of Cupola with a copy of a part of it.
pub(super) struct KeptBuffer {
    buffer: u32,
    start: isize,
    size: isize,
    copy: u32,
}

impl KeptBuffer {
    /// Puts the values back.
    pub(super) fn put_back(&self, gl: &Gl) {
        let Self { buffer, start, size, copy } = *self;
        // SAFETY: both buffers have these bytes.
        unsafe {
            gl.bind_buffer(api::GL_COPY_READ_BUFFER, copy);
            gl.bind_buffer(api::GL_COPY_WRITE_BUFFER, buffer);
            gl.copy_buffer_sub_data(api::GL_COPY_READ_BUFFER, api::GL_COPY_WRITE_BUFFER, 0, start, size);
        }
    }

    /// Deletes the copy.
    pub(super) fn delete(self, gl: &Gl) {
        // SAFETY: a buffer of Cupola.
        unsafe { gl.delete_buffers(1, &self.copy) };
    }
}

/// The part of a buffer that is bound for shaders to change.
#[derive(Clone, Copy)]
pub(super) struct Bound {
    buffer: u32,
    start: i64,
    /// Bytes; `None`: up to the end of the buffer.
    length: Option<i64>,
    /// Greatest part that is kept. Nothing is kept of larger ones.
    largest: i64,
}

impl Bound {
    /// A part of a buffer that shaders use as an image. `length` in bytes; `None`: up to the end.
    pub(super) fn part(buffer: u32, start: i64, length: Option<i64>) -> Self {
        Self { buffer, start, length, largest: LARGEST }
    }

    /// Returns what is bound; `None` if nothing is.
    pub(super) fn of(gl: &Gl, changed: ChangedBuffer) -> Option<Self> {
        let (binding, names, size) = match changed {
            ChangedBuffer::Counters { binding, size } => (
                binding,
                [
                    api::GL_ATOMIC_COUNTER_BUFFER_BINDING,
                    api::GL_ATOMIC_COUNTER_BUFFER_START,
                    api::GL_ATOMIC_COUNTER_BUFFER_SIZE,
                ],
                i64::try_from(size).ok(),
            ),
            ChangedBuffer::Storage { program, block } => {
                let [binding] = resource(gl, program, api::GL_SHADER_STORAGE_BLOCK, block, [api::GL_BUFFER_BINDING]);
                let names = [
                    api::GL_SHADER_STORAGE_BUFFER_BINDING,
                    api::GL_SHADER_STORAGE_BUFFER_START,
                    api::GL_SHADER_STORAGE_BUFFER_SIZE,
                ];
                (binding as u32, names, None)
            }
        };
        let [name, start, length] = names;
        let (mut buffer, mut from, mut bytes) = (0, 0i64, 0i64);
        // SAFETY: writes one number each; the binding exists, since a linked program has it.
        unsafe {
            gl.get_integeri_v(name, binding, &mut buffer);
            gl.get_integer64i_v(start, binding, &mut from);
            gl.get_integer64i_v(length, binding, &mut bytes);
        }
        let length = [size, Some(bytes).filter(|bytes| *bytes > 0)].into_iter().flatten().min();
        let largest = if size.is_some() { i64::MAX } else { LARGEST };
        (buffer != 0).then_some(Self { buffer: buffer as u32, start: from, length, largest })
    }

    /// Copies the part; `None` if there is nothing, or too much.
    pub(super) fn keep(&self, gl: &Gl) -> Option<KeptBuffer> {
        let Self { buffer, start, length, largest } = *self;
        let mut whole = 0i64;
        // SAFETY: a buffer that is bound; the copy gets the bytes that lie in both.
        unsafe {
            gl.bind_buffer(api::GL_COPY_READ_BUFFER, buffer);
            gl.get_buffer_parameteri64v(api::GL_COPY_READ_BUFFER, api::GL_BUFFER_SIZE, &mut whole);
            let room = whole - start;
            let size = length.map_or(room, |length| length.min(room));
            if size > largest {
                log::once(
                    "shaders that draw the scene write to a buffer of more than 1 MiB: they write once for \
                     each view",
                );
            }
            if size <= 0 || size > largest {
                return None;
            }
            // The name lives for one draw only, so that the program cannot use it.
            let mut copy = 0;
            gl.gen_buffers(1, &mut copy);
            let (start, size) = (start as isize, size as isize);
            gl.bind_buffer(api::GL_COPY_WRITE_BUFFER, copy);
            gl.buffer_data(api::GL_COPY_WRITE_BUFFER, size, std::ptr::null(), api::GL_STREAM_COPY);
            gl.copy_buffer_sub_data(api::GL_COPY_READ_BUFFER, api::GL_COPY_WRITE_BUFFER, start, 0, size);
            Some(KeptBuffer { buffer, start, size, copy })
        }
    }
}
