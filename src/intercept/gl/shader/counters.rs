//! Atomic counters of shaders. A draw that is issued several times counts once: each time begins
//! with the same counts, so that those of the last time remain.

use crate::backend::gl::driver::api::{self, Gl};
use crate::backend::gl::driver::values::integer;
use crate::intercept::gl::context::gl_context::ShareGroup;
use crate::intercept::gl::shader::programs;
use crate::intercept::gl::state::driver::profile::Profile;
use crate::intercept::gl::state::shader::Shaders;

/// Returns the bindings of the atomic counters of a linked program, with their sizes in bytes.
pub(super) fn of_program(gl: &Gl, profile: &Profile, program: u32) -> Vec<(u32, usize)> {
    if profile.version < if profile.es { 31 } else { 43 } {
        return Vec::new();
    }
    let mut count = 0;
    // SAFETY: writes one integer.
    unsafe {
        let buffers = api::GL_ATOMIC_COUNTER_BUFFER;
        gl.get_program_interfaceiv(program, buffers, api::GL_ACTIVE_RESOURCES, &mut count);
    }
    let counters = |index: u32| {
        let properties = [api::GL_BUFFER_BINDING, api::GL_BUFFER_DATA_SIZE];
        let (mut answers, length) = ([0; 2], std::ptr::null_mut());
        // SAFETY: two properties in, at most two integers out.
        unsafe {
            let (buffers, answers) = (api::GL_ATOMIC_COUNTER_BUFFER, answers.as_mut_ptr());
            gl.get_program_resourceiv(program, buffers, index, 2, properties.as_ptr(), 2, length, answers);
        }
        Some((answers[0] as u32, usize::try_from(answers[1]).ok()?))
    };
    (0..u32::try_from(count).unwrap_or(0)).filter_map(counters).collect()
}

/// Returns the bindings of the atomic counters of the present shaders, with their sizes.
pub fn present(share: &ShareGroup, shaders: &Shaders) -> Vec<(u32, usize)> {
    if shaders.used() != 0 || shaders.bound_pipeline() == 0 {
        return shaders.program().map_or(Vec::new(), |program| program.counters.clone());
    }
    let stages = shaders.stages();
    let names = stages.last_first().into_iter().chain([stages.fragment()]);
    let mut all: Vec<(u32, usize)> =
        names.filter_map(|name| programs::record(share, name)).flat_map(|program| program.counters.clone()).collect();
    // Stages that share a buffer may need different parts of it.
    all.sort_unstable_by_key(|(binding, size)| (*binding, std::cmp::Reverse(*size)));
    all.dedup_by_key(|counter| counter.0);
    all
}

/// Counts before a draw.
pub struct KeptCounts(Vec<Kept>);

/// A buffer with counters, and the buffer of Cupola with a copy of the counts.
struct Kept {
    buffer: u32,
    start: isize,
    size: isize,
    copy: u32,
}

impl KeptCounts {
    /// Keeps the counts of these bindings.
    pub fn keep(gl: &Gl, bindings: &[(u32, usize)]) -> Self {
        let mut kept = Self(Vec::new());
        with_copies(gl, || {
            for (binding, size) in bindings {
                kept.0.extend(keep(gl, *binding, *size));
            }
        });
        kept
    }

    /// Puts the counts back.
    pub fn put_back(&self, gl: &Gl) {
        with_copies(gl, || {
            for Kept { buffer, start, size, copy } in &self.0 {
                // SAFETY: both buffers have these bytes.
                unsafe {
                    gl.bind_buffer(api::GL_COPY_READ_BUFFER, *copy);
                    gl.bind_buffer(api::GL_COPY_WRITE_BUFFER, *buffer);
                    gl.copy_buffer_sub_data(api::GL_COPY_READ_BUFFER, api::GL_COPY_WRITE_BUFFER, 0, *start, *size);
                }
            }
        });
    }

    /// Deletes the copies.
    pub fn delete(self, gl: &Gl) {
        for kept in self.0 {
            // SAFETY: a buffer of Cupola.
            unsafe { gl.delete_buffers(1, &kept.copy) };
        }
    }
}

/// Keeps the counts of one binding. `None`: no buffer with room for them is bound.
fn keep(gl: &Gl, binding: u32, size: usize) -> Option<Kept> {
    let (mut buffer, mut start, mut length, mut whole) = (0, 0i64, 0i64, 0);
    // SAFETY: writes one number each; the binding exists, since a linked program has it.
    unsafe {
        gl.get_integeri_v(api::GL_ATOMIC_COUNTER_BUFFER_BINDING, binding, &mut buffer);
        gl.get_integer64i_v(api::GL_ATOMIC_COUNTER_BUFFER_START, binding, &mut start);
        gl.get_integer64i_v(api::GL_ATOMIC_COUNTER_BUFFER_SIZE, binding, &mut length);
    }
    if buffer == 0 {
        return None;
    }
    let buffer = buffer as u32;
    // SAFETY: a buffer that is bound; the copy gets the bytes that lie in both.
    unsafe {
        gl.bind_buffer(api::GL_COPY_READ_BUFFER, buffer);
        gl.get_buffer_parameteriv(api::GL_COPY_READ_BUFFER, api::GL_BUFFER_SIZE, &mut whole);
        let room = i64::from(whole) - start;
        let size = i64::try_from(size).ok()?.min(if length > 0 { length.min(room) } else { room });
        if size <= 0 {
            return None;
        }
        // The name lives for one draw only, so that the program cannot use it.
        let mut copy = 0;
        gl.gen_buffers(1, &mut copy);
        let (start, size) = (start as isize, size as isize);
        gl.bind_buffer(api::GL_COPY_WRITE_BUFFER, copy);
        gl.buffer_data(api::GL_COPY_WRITE_BUFFER, size, std::ptr::null(), api::GL_STREAM_COPY);
        gl.copy_buffer_sub_data(api::GL_COPY_READ_BUFFER, api::GL_COPY_WRITE_BUFFER, start, 0, size);
        Some(Kept { buffer, start, size, copy })
    }
}

/// Runs `work`, which copies counts. The bindings for copies are restored.
fn with_copies(gl: &Gl, work: impl FnOnce()) {
    let before = [
        (api::GL_COPY_READ_BUFFER, integer(gl, api::GL_COPY_READ_BUFFER_BINDING)),
        (api::GL_COPY_WRITE_BUFFER, integer(gl, api::GL_COPY_WRITE_BUFFER_BINDING)),
    ];
    // SAFETY: the barrier makes the counts of earlier draws visible to the copies.
    unsafe { gl.memory_barrier(api::GL_BUFFER_UPDATE_BARRIER_BIT) };
    work();
    for (target, buffer) in before {
        // SAFETY: a buffer that was bound.
        unsafe { gl.bind_buffer(target, buffer as u32) };
    }
}
