//! Vertex arrays that the program has set. The driver is asked once for each value, which is kept
//! until a call changes it. So draws need no questions to the driver.
//!
//! Values that common calls set are noted from their arguments if OpenGL cannot have refused the
//! call. Every other call that may change an array makes it unknown again
//! (`vertex_array_commands`). Only attributes that a draw has needed are kept.

use crate::backend::gl::driver::api::{self, Gl};
use crate::backend::gl::driver::values::integer;
use crate::intercept::gl::context::gl_context::ShareGroup;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::driver::profile::Profile;
use crate::intercept::gl::state::vertex_input::VertexInput;
use crate::intercept::gl::state::vertex_input::vertex_arrays::{Format, Object, Pointer, Source, packed};
use crate::intercept::gl::vertex_input::buffer_bindings;
use std::ffi::c_void;

/// Returns the vertex array in use.
fn object<'a>(driver: &Driver, vertex_input: &'a mut VertexInput) -> &'a mut Object {
    if vertex_input.vertex_arrays.current.is_none() {
        // A context without vertex array objects must not be asked for this binding.
        let name =
            if vertex_input.vertex_arrays.used { integer(driver.gl, api::GL_VERTEX_ARRAY_BINDING) as u32 } else { 0 };
        vertex_input.vertex_arrays.select(name);
    }
    let arrays = &mut vertex_input.vertex_arrays;
    let place = arrays.current.unwrap_or_default();
    &mut arrays.objects[place]
}

/// Returns the index buffer; 0 = none.
pub fn elements(share: &ShareGroup, driver: &Driver, vertex_input: &mut VertexInput) -> u32 {
    if let Some(name) = object(driver, vertex_input).elements {
        return name;
    }
    let name = buffer_bindings::ask(driver, share, api::GL_ELEMENT_ARRAY_BUFFER_BINDING);
    object(driver, vertex_input).elements = Some(name);
    name
}

/// Notes that the program has bound an index buffer; `None`: OpenGL may have refused the call.
pub fn note_elements(vertex_input: &mut VertexInput, name: Option<u32>) {
    if let Some(object) = vertex_input.vertex_arrays.current() {
        object.elements = name;
    }
}

/// Returns the array of `glVertexPointer`, if it is enabled.
pub fn conventional(driver: &Driver, vertex_input: &mut VertexInput) -> Option<Pointer> {
    let gl = driver.gl;
    let object = object(driver, vertex_input);
    // SAFETY: asks for a switch; the context has a fixed-function pipeline.
    if !*object.conventional_on.get_or_insert_with(|| unsafe { gl.is_enabled(api::GL_VERTEX_ARRAY) } != 0) {
        return None;
    }
    if object.conventional.is_none() {
        object.conventional = ask_conventional(gl);
    }
    object.conventional
}

fn ask_conventional(gl: &Gl) -> Option<Pointer> {
    let mut start = std::ptr::null_mut::<c_void>();
    // SAFETY: writes one pointer; the context has a fixed-function pipeline.
    unsafe { gl.get_pointerv(api::GL_VERTEX_ARRAY_POINTER, &mut start) };
    let kind = integer(gl, api::GL_VERTEX_ARRAY_TYPE) as u32;
    let components = usize::try_from(integer(gl, api::GL_VERTEX_ARRAY_SIZE)).ok()?;
    let stride = usize::try_from(integer(gl, api::GL_VERTEX_ARRAY_STRIDE)).ok()?;
    let stride = packed(stride, components, kind);
    let buffer = integer(gl, api::GL_VERTEX_ARRAY_BUFFER_BINDING) as u32;
    Some(Pointer { components, kind, source: Source { buffer, start: start as usize, stride } })
}

/// True if the array of a generic attribute is enabled.
pub fn is_on(driver: &Driver, vertex_input: &mut VertexInput, location: u32) -> bool {
    let gl = driver.gl;
    let attribute = object(driver, vertex_input).asked_attribute(location);
    *attribute.on.get_or_insert_with(|| ask(gl, location, api::GL_VERTEX_ATTRIB_ARRAY_ENABLED) != 0)
}

/// Returns the array of a generic attribute: its format, its source, and the number of instances
/// after which it advances (0: never).
pub fn generic(driver: &Driver, vertex_input: &mut VertexInput, location: u32) -> Option<(Format, Source, i32)> {
    let (gl, profile) = (driver.gl, driver.profile);
    let object = object(driver, vertex_input);
    let attribute = object.asked_attribute(location);
    if attribute.format.is_none() {
        attribute.format = ask_format(gl, &profile, location);
    }
    let format = attribute.format?;
    let binding = object.asked_binding(format.binding);
    if binding.source.is_none() {
        binding.source = ask_source(gl, &profile, location, &format);
    }
    let source = binding.source?;
    let divisor = *binding.divisor.get_or_insert_with(|| ask_divisor(gl, &profile, location, format.binding));
    Some((format, Source { start: source.start.checked_add(format.offset)?, ..source }, divisor))
}

/// True if attributes have bindings. Then all calls set values of bindings.
pub fn has_bindings(profile: &Profile) -> bool {
    profile.version >= if profile.es { 31 } else { 43 }
}

fn ask_format(gl: &Gl, profile: &Profile, location: u32) -> Option<Format> {
    let ask = |name: u32| ask(gl, location, name);
    let bindings = has_bindings(profile);
    Some(Format {
        integer: profile.version >= 30 && ask(api::GL_VERTEX_ATTRIB_ARRAY_INTEGER) != 0,
        kind: ask(api::GL_VERTEX_ATTRIB_ARRAY_TYPE) as u32,
        components: usize::try_from(ask(api::GL_VERTEX_ATTRIB_ARRAY_SIZE)).ok()?,
        normalised: ask(api::GL_VERTEX_ATTRIB_ARRAY_NORMALIZED) != 0,
        binding: if bindings { ask(api::GL_VERTEX_ATTRIB_BINDING) as u32 } else { location },
        offset: if bindings { usize::try_from(ask(api::GL_VERTEX_ATTRIB_RELATIVE_OFFSET)).ok()? } else { 0 },
    })
}

fn ask_source(gl: &Gl, profile: &Profile, location: u32, format: &Format) -> Option<Source> {
    if has_bindings(profile) {
        let ask = |name: u32| ask_binding(gl, format.binding, name);
        return Some(Source {
            start: usize::try_from(ask(api::GL_VERTEX_BINDING_OFFSET)).ok()?,
            buffer: ask(api::GL_VERTEX_BINDING_BUFFER) as u32,
            stride: usize::try_from(ask(api::GL_VERTEX_BINDING_STRIDE)).ok()?,
        });
    }
    let mut start = std::ptr::null_mut::<c_void>();
    // SAFETY: writes one pointer.
    unsafe { gl.get_vertex_attrib_pointerv(location, api::GL_VERTEX_ATTRIB_ARRAY_POINTER, &mut start) };
    let stride = usize::try_from(ask(gl, location, api::GL_VERTEX_ATTRIB_ARRAY_STRIDE)).ok()?;
    let buffer = ask(gl, location, api::GL_VERTEX_ATTRIB_ARRAY_BUFFER_BINDING) as u32;
    Some(Source { buffer, start: start as usize, stride: packed(stride, format.components, format.kind) })
}

fn ask_divisor(gl: &Gl, profile: &Profile, location: u32, binding: u32) -> i32 {
    let divisors = profile.version >= if profile.es { 30 } else { 33 };
    match () {
        () if has_bindings(profile) => ask_binding(gl, binding, api::GL_VERTEX_BINDING_DIVISOR),
        () if divisors => ask(gl, location, api::GL_VERTEX_ATTRIB_ARRAY_DIVISOR),
        () => 0,
    }
}

/// Returns one integer of an attribute.
fn ask(gl: &Gl, location: u32, name: u32) -> i32 {
    let mut value = 0;
    // SAFETY: writes one integer; the location is one of a linked program's, or 0.
    unsafe { gl.get_vertex_attribiv(location, name, &mut value) };
    value
}

/// Returns one integer of a binding.
fn ask_binding(gl: &Gl, binding: u32, name: u32) -> i32 {
    let mut value = 0;
    // SAFETY: writes one integer; the binding is an attribute's.
    unsafe { gl.get_integeri_v(name, binding, &mut value) };
    value
}
