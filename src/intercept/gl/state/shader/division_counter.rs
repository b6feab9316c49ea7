//! Counter of primitives that the dividing stage did not divide far enough, for the statistics.

use crate::backend::gl::driver::api::{self, Gl};
use crate::backend::gl::driver::own_names;

/// An atomic counter in a buffer of Cupola.
pub struct Counter {
    buffer: u32,
    binding: u32,
}

/// Buffer that was bound before the counter.
pub struct Before {
    generic: i32,
    buffer: i32,
    start: i64,
    size: i64,
}

impl Counter {
    /// Returns a counter at 0, for this binding.
    pub fn new(gl: &Gl, binding: u32) -> Self {
        let mut counter = Self { buffer: 0, binding };
        let zero = 0u32;
        // SAFETY: makes a buffer of Cupola of four bytes; the binding is put back.
        unsafe {
            let mut generic = 0;
            gl.get_integerv(api::GL_ATOMIC_COUNTER_BUFFER_BINDING, &mut generic);
            counter.buffer = own_names::buffer(gl);
            gl.bind_buffer(api::GL_ATOMIC_COUNTER_BUFFER, counter.buffer);
            gl.buffer_data(api::GL_ATOMIC_COUNTER_BUFFER, 4, (&raw const zero).cast(), api::GL_DYNAMIC_READ);
            gl.bind_buffer(api::GL_ATOMIC_COUNTER_BUFFER, generic as u32);
        }
        counter
    }

    /// Binds the counter for a draw. Returns the buffer that was bound before.
    pub fn begin(&self, gl: &Gl) -> Before {
        let mut before = Before { generic: 0, buffer: 0, start: 0, size: 0 };
        let binding = self.binding;
        // SAFETY: writes one number each; `end` puts back what was bound.
        unsafe {
            gl.get_integerv(api::GL_ATOMIC_COUNTER_BUFFER_BINDING, &mut before.generic);
            gl.get_integeri_v(api::GL_ATOMIC_COUNTER_BUFFER_BINDING, binding, &mut before.buffer);
            gl.get_integer64i_v(api::GL_ATOMIC_COUNTER_BUFFER_START, binding, &mut before.start);
            gl.get_integer64i_v(api::GL_ATOMIC_COUNTER_BUFFER_SIZE, binding, &mut before.size);
            gl.bind_buffer_base(api::GL_ATOMIC_COUNTER_BUFFER, binding, self.buffer);
        }
        before
    }

    /// Puts back what was bound before.
    pub fn end(&self, gl: &Gl, before: &Before) {
        let (target, buffer) = (api::GL_ATOMIC_COUNTER_BUFFER, before.buffer as u32);
        // SAFETY: puts back the bindings that `begin` read.
        unsafe {
            if before.size > 0 {
                gl.bind_buffer_range(target, self.binding, buffer, before.start as isize, before.size as isize);
            } else {
                gl.bind_buffer_base(target, self.binding, buffer);
            }
            gl.bind_buffer(target, before.generic as u32);
        }
    }

    /// Returns the count so far.
    pub fn read(&self, gl: &Gl) -> u32 {
        let mut count = 0u32;
        let before = self.begin(gl);
        // SAFETY: reads the four bytes of the buffer that `begin` bound. The barrier makes the
        // counts of draws visible.
        unsafe {
            if gl.has_memory_barrier() {
                gl.memory_barrier(api::GL_BUFFER_UPDATE_BARRIER_BIT);
            }
            gl.get_buffer_sub_data(api::GL_ATOMIC_COUNTER_BUFFER, 0, 4, (&raw mut count).cast());
        }
        self.end(gl, &before);
        count
    }
}
