//! Buffers that the program has bound. They are noted from its calls; if the calls do not tell the
//! buffer, the driver is asked once.
//!
//! `GL_ELEMENT_ARRAY_BUFFER` belongs to a vertex array object
//! ([`crate::intercept::gl::vertex_input::vertex_arrays`]).

use crate::backend::gl::driver::api;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::gl_context::ShareGroup;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::vertex_input::VertexInput;
use crate::intercept::gl::state::vertex_input::buffer_bindings::{TARGETS, place};
use crate::intercept::gl::vertex_input::{buffers, vertex_arrays};

/// Returns the buffer that is bound at `target`. `None`: bindings of this target are not followed.
pub fn buffer(share: &ShareGroup, driver: &Driver, vertex_input: &mut VertexInput, target: u32) -> Option<u32> {
    if target == api::GL_ELEMENT_ARRAY_BUFFER {
        return Some(vertex_arrays::elements(share, driver, vertex_input));
    }
    let place = place(target)?;
    if let Some(name) = vertex_input.buffer_bindings.names[place] {
        return Some(name);
    }
    let name = ask(driver, share, TARGETS[place].1);
    vertex_input.buffer_bindings.names[place] = Some(name);
    Some(name)
}

/// Returns the buffer that the driver has at a binding.
pub fn ask(driver: &Driver, share: &ShareGroup, binding: u32) -> u32 {
    let mut name = 0;
    // SAFETY: writes one integer.
    unsafe { driver.gl.get_integerv(binding, &mut name) };
    buffers::of(share).note_object(name as u32);
    name as u32
}

/// Returns the buffer that is bound after a call of the program. `None`: OpenGL may have refused
/// the call.
pub fn certain(ctx: &Context, name: u32) -> Option<u32> {
    (ctx.takes_calls() && (name == 0 || buffers::of(&ctx.share).is_object(name))).then_some(name)
}

/// Notes a call of `glBindBuffer`.
pub fn note(ctx: &mut Context, target: u32, name: u32) {
    let bound = certain(ctx, name);
    if target == api::GL_ELEMENT_ARRAY_BUFFER {
        vertex_arrays::note_elements(&mut ctx.vertex_input, bound);
    } else if let Some(place) = place(target) {
        ctx.vertex_input.buffer_bindings.names[place] = bound;
    }
}
