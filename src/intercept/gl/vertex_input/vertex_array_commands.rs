//! Calls that change vertex arrays.
//!
//! The rows come from the registry (`build/gl_arrays.rs`). Each row marks the state that the call
//! may change as unknown. Calls whose arguments are noted have hooks below. Some are allowed
//! between Begin and End, with an undefined result.

use crate::backend::gl::driver::api;
use crate::backend::gl::driver::values::integer;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::gl_context::ShareGroup;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::vertex_input::VertexInput;
use crate::intercept::gl::state::vertex_input::vertex_arrays::{Format, Pointer, Source, packed};
use crate::intercept::gl::vertex_input::buffer_bindings;
use crate::intercept::gl::vertex_input::vertex_arrays::has_bindings;
use std::ffi::c_void;

/// True if the vertex array in use can be changed: core profiles have no vertex array 0.
fn is_changeable(driver: &Driver, vertex_input: &mut VertexInput) -> bool {
    let core = driver.profile.core;
    vertex_input.vertex_arrays.current().is_some_and(|object| object.name != 0 || !core)
}

/// Smallest value that OpenGL allows as the greatest stride.
const STRIDE: i32 = 2048;

/// Returns the number of attributes that every context has.
fn attributes(driver: &Driver) -> u32 {
    if driver.profile.es { 8 } else { 16 }
}

/// Returns the source that `pointer` describes. `None`: OpenGL refuses the call.
fn source(
    share: &ShareGroup,
    driver: &Driver,
    vertex_input: &mut VertexInput,
    stride: usize,
    pointer: *const c_void,
) -> Option<Source> {
    let name = vertex_input.vertex_arrays.current()?.name;
    let buffer = buffer_bindings::buffer(share, driver, vertex_input, api::GL_ARRAY_BUFFER)?;
    // Vertex array objects cannot refer to arrays in the program's memory.
    (buffer != 0 || name == 0).then_some(Source { buffer, start: pointer as usize, stride })
}

/// `glVertexPointer`.
fn note_conventional(ctx: &mut Context, components: i32, kind: u32, stride: i32, pointer: *const c_void) {
    let legal = ctx.driver.profile.compatibility()
        && ctx.takes_calls()
        && (2..=4).contains(&components)
        && (0..=STRIDE).contains(&stride)
        && matches!(kind, api::GL_SHORT | api::GL_INT | api::GL_FLOAT | api::GL_DOUBLE);
    let components = components as usize;
    let source = if legal {
        source(&ctx.share, &ctx.driver, &mut ctx.vertex_input, packed(stride as usize, components, kind), pointer)
    } else {
        None
    };
    if let Some(object) = ctx.vertex_input.vertex_arrays.current() {
        object.conventional = source.map(|source| Pointer { components, kind, source });
    }
}

/// Returns the layout of positions in `glInterleavedArrays`: number of components, number of bytes
/// before them, number of bytes of an element.
fn interleaved(format: u32) -> Option<(i32, usize, i32)> {
    Some(match format {
        api::GL_V2F => (2, 0, 8),
        api::GL_V3F => (3, 0, 12),
        api::GL_C4UB_V2F => (2, 4, 12),
        api::GL_C4UB_V3F => (3, 4, 16),
        api::GL_C3F_V3F | api::GL_N3F_V3F => (3, 12, 24),
        api::GL_C4F_N3F_V3F => (3, 28, 40),
        api::GL_T2F_V3F => (3, 8, 20),
        api::GL_T4F_V4F => (4, 16, 32),
        api::GL_T2F_C4UB_V3F => (3, 12, 24),
        api::GL_T2F_C3F_V3F | api::GL_T2F_N3F_V3F => (3, 20, 32),
        api::GL_T2F_C4F_N3F_V3F => (3, 36, 48),
        api::GL_T4F_C4F_N3F_V4F => (4, 44, 60),
        _ => return None,
    })
}

/// `glInterleavedArrays`, which switches some arrays on and others off.
fn note_interleaved(ctx: &mut Context, format: u32, stride: i32, pointer: *const c_void) {
    let Some((components, before, whole)) = interleaved(format) else {
        ctx.vertex_input.vertex_arrays.forget();
        return;
    };
    let stride = if stride == 0 { whole } else { stride };
    note_conventional(ctx, components, api::GL_FLOAT, stride, pointer.cast::<u8>().wrapping_add(before).cast());
    if let Some(object) = ctx.vertex_input.vertex_arrays.current() {
        object.conventional_on = object.conventional.map(|_| true);
    }
}

/// `glVertexAttribPointer`.
fn note_generic(
    ctx: &mut Context,
    location: u32,
    [components, stride]: [i32; 2],
    kind: u32,
    normalised: bool,
    pointer: *const c_void,
) {
    let Some(object) = ctx.vertex_input.vertex_arrays.current() else { return };
    if object.attribute(location).is_none() && object.binding(location).is_none() {
        return;
    }
    let floats =
        matches!(kind, api::GL_BYTE | api::GL_UNSIGNED_BYTE | api::GL_SHORT | api::GL_UNSIGNED_SHORT | api::GL_FLOAT);
    let legal = location < attributes(&ctx.driver)
        && ctx.takes_calls()
        && is_changeable(&ctx.driver, &mut ctx.vertex_input)
        && (1..=4).contains(&components)
        && (0..=STRIDE).contains(&stride)
        && floats;
    let components = components as usize;
    let source = if legal {
        source(&ctx.share, &ctx.driver, &mut ctx.vertex_input, packed(stride as usize, components, kind), pointer)
    } else {
        None
    };
    let format = Format { components, kind, normalised, integer: false, binding: location, offset: 0 };
    let Some(object) = ctx.vertex_input.vertex_arrays.current() else { return };
    if let Some(attribute) = object.attribute(location) {
        attribute.format = source.map(|_| format);
    }
    if let Some(binding) = object.binding(location) {
        binding.source = source;
    }
}

/// `glEnableVertexAttribArray` and `glDisableVertexAttribArray`.
fn note_switch(ctx: &mut Context, location: u32, on: bool) {
    let certain =
        location < attributes(&ctx.driver) && ctx.takes_calls() && is_changeable(&ctx.driver, &mut ctx.vertex_input);
    if let Some(attribute) = ctx.vertex_input.vertex_arrays.current().and_then(|object| object.attribute(location)) {
        attribute.on = certain.then_some(on);
    }
}

/// `glEnableClientState` and `glDisableClientState`.
fn note_client_switch(ctx: &mut Context, array: u32, on: bool) {
    let certain = ctx.takes_calls();
    if array == api::GL_PRIMITIVE_RESTART_NV {
        ctx.driver.known_state.forget_switch(api::GL_PRIMITIVE_RESTART);
    }
    if array == api::GL_VERTEX_ARRAY
        && let Some(object) = ctx.vertex_input.vertex_arrays.current()
    {
        object.conventional_on = certain.then_some(on);
    }
}

/// `glBindVertexArray`.
fn note_object(ctx: &mut Context, name: u32) {
    let certain = ctx.takes_calls();
    let arrays = &mut ctx.vertex_input.vertex_arrays;
    arrays.used = true;
    if !certain {
        arrays.forget();
        return;
    }
    let known = name == 0 || arrays.places.contains_key(&name);
    // An unknown name may be wrong; then the binding does not change.
    let name = if known { name } else { integer(ctx.driver.gl, api::GL_VERTEX_ARRAY_BINDING) as u32 };
    ctx.vertex_input.vertex_arrays.select(name);
}

/// `glBindVertexBuffer` (`object` = `None`: the vertex array in use) and
/// `glVertexArrayVertexBuffer`.
fn note_buffer(ctx: &mut Context, object: Option<u32>, number: u32, buffer: u32, offset: isize, stride: i32) {
    let legal = has_bindings(&ctx.driver.profile)
        && ctx.takes_calls()
        && number < attributes(&ctx.driver)
        && (0..=STRIDE).contains(&stride);
    let named = ctx.vertex_input.vertex_arrays.current().is_some_and(|object| object.name != 0);
    let legal = legal && (object.is_some() || named || ctx.driver.profile.compatibility());
    let start = usize::try_from(offset).ok().filter(|_| legal && buffer_bindings::certain(ctx, buffer).is_some());
    let arrays = &mut ctx.vertex_input.vertex_arrays;
    let object = match object {
        Some(name) => arrays.places.get(&name).and_then(|place| arrays.objects.get_mut(*place)),
        None => arrays.current(),
    };
    if let Some(binding) = object.and_then(|object| object.binding(number)) {
        binding.source = start.map(|start| Source { buffer, start, stride: stride as usize });
    }
}

/// `glVertexAttribDivisor`, which makes the attribute use its own binding again.
fn note_divisor(vertex_input: &mut VertexInput, location: u32) {
    let Some(object) = vertex_input.vertex_arrays.current() else { return };
    if let Some(attribute) = object.attribute(location) {
        attribute.format = None;
    }
    if let Some(binding) = object.binding(location) {
        binding.divisor = None;
    }
}

macro_rules! array_commands {
    ($noted:tt $( $name:literal $method:ident ( $($p:ident : $t:ty),* ) of $object:ident; )*) => {
        #[cfg(test)]
        const NOTED: &[&str] = &$noted;

        hooks! {
            between;
            $( $name $method($($p: $t),*) = |ctx, gl| {
                gl.$method($($p),*);
                array_commands!(@changed ctx $object);
            }; )*
            "glVertexPointer" vertex_pointer(size: i32, kind: u32, stride: i32, pointer: *const c_void) = |ctx, gl| {
                gl.vertex_pointer(size, kind, stride, pointer);
                note_conventional(ctx, size, kind, stride, pointer);
            };
            "glVertexAttribPointer" vertex_attrib_pointer(index: u32, size: i32, kind: u32, normalised: u8, stride: i32, pointer: *const c_void) = |ctx, gl| {
                gl.vertex_attrib_pointer(index, size, kind, normalised, stride, pointer);
                note_generic(ctx, index, [size, stride], kind, normalised != 0, pointer);
            };
            "glEnableVertexAttribArray" enable_vertex_attrib_array(index: u32) = |ctx, gl| {
                gl.enable_vertex_attrib_array(index);
                note_switch(ctx, index, true);
            };
            "glDisableVertexAttribArray" disable_vertex_attrib_array(index: u32) = |ctx, gl| {
                gl.disable_vertex_attrib_array(index);
                note_switch(ctx, index, false);
            };
            "glEnableClientState" enable_client_state(array: u32) = |ctx, gl| {
                gl.enable_client_state(array);
                note_client_switch(ctx, array, true);
            };
            "glDisableClientState" disable_client_state(array: u32) = |ctx, gl| {
                gl.disable_client_state(array);
                note_client_switch(ctx, array, false);
            };
            "glInterleavedArrays" interleaved_arrays(format: u32, stride: i32, pointer: *const c_void) = |ctx, gl| {
                gl.interleaved_arrays(format, stride, pointer);
                note_interleaved(ctx, format, stride, pointer);
            };
            "glBindVertexArray" bind_vertex_array(array: u32) = |ctx, gl| {
                gl.bind_vertex_array(array);
                note_object(ctx, array);
            };
            "glBindVertexArrayAPPLE" bind_vertex_array_apple(array: u32) = |ctx, gl| {
                gl.bind_vertex_array_apple(array);
                note_object(ctx, array);
            };
            "glDeleteVertexArrays" delete_vertex_arrays(count: i32, names: *const u32) = |ctx, gl| {
                gl.delete_vertex_arrays(count, names);
                ctx.vertex_input.vertex_arrays.forget();
            };
            "glBindVertexBuffer" bind_vertex_buffer(binding: u32, buffer: u32, offset: isize, stride: i32) = |ctx, gl| {
                gl.bind_vertex_buffer(binding, buffer, offset, stride);
                note_buffer(ctx, None, binding, buffer, offset, stride);
            };
            "glVertexArrayVertexBuffer" vertex_array_vertex_buffer(object: u32, binding: u32, buffer: u32, offset: isize, stride: i32) = |ctx, gl| {
                gl.vertex_array_vertex_buffer(object, binding, buffer, offset, stride);
                note_buffer(ctx, Some(object), binding, buffer, offset, stride);
            };
            "glVertexAttribDivisor" vertex_attrib_divisor(index: u32, divisor: u32) = |ctx, gl| {
                gl.vertex_attrib_divisor(index, divisor);
                note_divisor(&mut ctx.vertex_input, index);
            };
            "glPopClientAttrib" pop_client_attrib() = |ctx, gl| {
                gl.pop_client_attrib();
                ctx.vertex_input.vertex_arrays.forget();
                ctx.vertex_input.buffer_bindings.forget();
                ctx.driver.known_state.forget_switch(api::GL_PRIMITIVE_RESTART);
            };
        }
    };
    (@changed $ctx:ident all) => {{
        $ctx.vertex_input.vertex_arrays.forget();
        $ctx.vertex_input.buffer_bindings.forget();
        $ctx.driver.known_state.forget_switch(api::GL_PRIMITIVE_RESTART);
    }};
    (@changed $ctx:ident $object:ident) => { $ctx.vertex_input.vertex_arrays.forget_object($object) };
}

include!(concat!(env!("OUT_DIR"), "/gl_arrays.rs"));

#[cfg(test)]
mod tests {
    use super::{HOOKS, NOTED};
    use crate::intercept::gl::entry::table::find;

    #[test]
    fn every_call_that_changes_arrays_has_a_hook() {
        for name in NOTED {
            assert!(HOOKS.iter().any(|hook| hook.name == *name), "{name}");
        }
        // One call of each kind, and names of extensions.
        for name in [
            "glBindVertexArrayOES",
            "glDeleteVertexArraysAPPLE",
            "glDisableVertexArrayAttribEXT",
            "glEnableClientStateiEXT",
            "glInterleavedArrays",
            "glPushClientAttribDefaultEXT",
            "glVertexArrayElementBuffer",
            "glVertexArrayVertexAttribOffsetEXT",
            "glVertexAttribDivisorANGLE",
            "glVertexAttribIPointerEXT",
            "glVertexAttribLFormat",
            "glVertexBindingDivisor",
            "glVertexPointerEXT",
        ] {
            assert!(find(name).is_some(), "{name}");
        }
        // Calls for current values of attributes and for queries have other hooks.
        for name in ["glVertexAttrib4fv", "glVertexAttribI4i", "glColorPointer", "glGetVertexAttribiv"] {
            assert!(HOOKS.iter().all(|hook| hook.name != name), "{name}");
        }
    }
}
