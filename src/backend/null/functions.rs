//! Functions of the null driver. A function that is not here does nothing and returns zero, as
//! [`Gl`](crate::backend::gl::driver::api::Gl) does for functions that a driver lacks.

use super::{DrawCall, Record, note};
use crate::backend::gl::driver::api::*;
use crate::correct::LowerLeftRect;
use std::ffi::{CStr, c_void};

/// Returns the driver's function of this name; null if there is none.
pub fn find(name: &CStr) -> *const c_void {
    let found = FUNCTIONS.iter().find(|(known, _)| *known == name);
    found.map_or(std::ptr::null(), |(_, function)| function.cast())
}

/// A function's name and address.
type Function = (&'static CStr, *const ());

/// The table of the functions.
struct Table(&'static [Function]);

// SAFETY: addresses of functions never change and may be read from any thread.
unsafe impl Sync for Table {}

impl std::ops::Deref for Table {
    type Target = [Function];

    fn deref(&self) -> &[Function] {
        self.0
    }
}

/// Defines functions that generate and delete objects of a kind, and the table of all functions.
macro_rules! functions {
    (objects { $($generate:literal $delete:literal $generator:ident $deleter:ident $kind:literal;)* }
     others { $($name:literal $function:ident;)* }) => {
        $(
            extern "system" fn $generator(count: i32, names: *mut u32) {
                // SAFETY: callers of OpenGL pass an array of `count` names.
                generated($kind, unsafe { array_mut(names, count) });
            }
            extern "system" fn $deleter(count: i32, names: *const u32) {
                // SAFETY: as above.
                deleted($kind, unsafe { array(names, count) });
            }
        )*
        static FUNCTIONS: Table = Table(&[
            $(($generate, $generator as *const ()), ($delete, $deleter as *const ()),)*
            $(($name, $function as *const ()),)*
        ]);
    };
}

functions! {
    objects {
        c"glGenTextures" c"glDeleteTextures" gen_textures delete_textures "textures";
        c"glGenBuffers" c"glDeleteBuffers" gen_buffers delete_buffers "buffers";
        c"glGenFramebuffers" c"glDeleteFramebuffers" gen_framebuffers delete_framebuffers "framebuffers";
        c"glGenRenderbuffers" c"glDeleteRenderbuffers" gen_renderbuffers delete_renderbuffers "renderbuffers";
        c"glGenVertexArrays" c"glDeleteVertexArrays" gen_vertex_arrays delete_vertex_arrays "vertex arrays";
        c"glGenSamplers" c"glDeleteSamplers" gen_samplers delete_samplers "samplers";
    }
    others {
        c"glGetString" get_string;
        c"glGetStringi" get_stringi;
        c"glGetIntegerv" get_integerv;
        c"glGetBooleanv" get_booleanv;
        c"glGetFloatv" get_floatv;
        c"glGetError" get_error;
        c"glCreateShader" create_shader;
        c"glDeleteShader" delete_shader;
        c"glGetShaderiv" get_object_iv;
        c"glCreateProgram" create_program;
        c"glDeleteProgram" delete_program;
        c"glLinkProgram" link_program;
        c"glGetProgramiv" get_object_iv;
        c"glUseProgram" use_program;
        c"glBindFramebuffer" bind_framebuffer;
        c"glCheckFramebufferStatus" check_framebuffer_status;
        c"glIsFramebuffer" is_object;
        c"glIsVertexArray" is_object;
        c"glViewport" viewport;
        c"glViewportIndexedf" viewport_indexed;
        c"glGetFloati_v" get_indexed_floats;
        c"glDrawElements" draw_elements;
        c"glDrawArrays" draw_arrays;
    }
}

/// # Safety
/// `pointer` is null, or points to `count` elements.
unsafe fn array<'a, T>(pointer: *const T, count: i32) -> &'a [T] {
    // SAFETY: as promised.
    if pointer.is_null() { &[] } else { unsafe { std::slice::from_raw_parts(pointer, count.max(0) as usize) } }
}

/// # Safety
/// `pointer` is null, or points to `count` elements that nothing else uses.
unsafe fn array_mut<'a, T>(pointer: *mut T, count: i32) -> &'a mut [T] {
    // SAFETY: as promised.
    if pointer.is_null() { &mut [] } else { unsafe { std::slice::from_raw_parts_mut(pointer, count.max(0) as usize) } }
}

fn generated(kind: &'static str, names: &mut [u32]) {
    note(|record| {
        for name in names {
            *name = new_name(record, kind);
        }
    });
}

fn new_name(record: &mut Record, kind: &'static str) -> u32 {
    record.names += 1;
    *record.alive.entry(kind).or_default() += 1;
    record.names
}

/// OpenGL ignores the name 0 in deletions.
fn deleted(kind: &'static str, names: &[u32]) {
    let count = names.iter().filter(|name| **name != 0).count() as i64;
    note(|record| *record.alive.entry(kind).or_default() -= count);
}

extern "system" fn get_string(name: u32) -> *const u8 {
    let text = if name == GL_VERSION { c"4.6 null driver" } else { c"null" };
    text.as_ptr().cast()
}

extern "system" fn get_stringi(_: u32, _: u32) -> *const u8 {
    c"".as_ptr().cast()
}

extern "system" fn get_integerv(name: u32, values: *mut i32) {
    let known = note(|record| match name {
        GL_MAJOR_VERSION => vec![4],
        GL_MINOR_VERSION => vec![6],
        GL_CONTEXT_PROFILE_MASK => vec![GL_CONTEXT_CORE_PROFILE_BIT as i32],
        GL_MAX_TEXTURE_SIZE | GL_MAX_RENDERBUFFER_SIZE => vec![16384],
        GL_MAX_DRAW_BUFFERS => vec![8],
        GL_MAX_VIEWPORT_DIMS => vec![32768; 2],
        GL_DRAW_FRAMEBUFFER_BINDING => vec![record.framebuffers[0] as i32],
        GL_READ_FRAMEBUFFER_BINDING => vec![record.framebuffers[1] as i32],
        GL_CURRENT_PROGRAM => vec![record.program as i32],
        GL_VIEWPORT | GL_SCISSOR_BOX => record.viewport.to_array().to_vec(),
        GL_POLYGON_MODE => vec![GL_FILL as i32; 2],
        _ => vec![0],
    });
    // SAFETY: callers of OpenGL pass room for all values of the name.
    unsafe { array_mut(values, known.len() as i32) }.copy_from_slice(&known);
}

extern "system" fn get_booleanv(name: u32, values: *mut u8) {
    let count = if name == GL_COLOR_WRITEMASK { 4 } else { 1 };
    // SAFETY: as above.
    note(|_| unsafe { array_mut(values, count) }.fill(1));
}

extern "system" fn get_floatv(name: u32, values: *mut f32) {
    let known = note(|record| match name {
        GL_VIEWPORT => record.viewport.to_array().map(|value| value as f32).to_vec(),
        GL_COLOR_CLEAR_VALUE | GL_BLEND_COLOR => vec![0.0; 4],
        GL_DEPTH_RANGE => vec![0.0, 1.0],
        _ => vec![0.0],
    });
    // SAFETY: as above.
    unsafe { array_mut(values, known.len() as i32) }.copy_from_slice(&known);
}

extern "system" fn get_error() -> u32 {
    note(|record| std::mem::take(&mut record.error))
}

extern "system" fn create_shader(_: u32) -> u32 {
    note(|record| new_name(record, "shaders"))
}

extern "system" fn delete_shader(name: u32) {
    deleted("shaders", &[name]);
}

extern "system" fn create_program() -> u32 {
    note(|record| new_name(record, "programs"))
}

extern "system" fn delete_program(name: u32) {
    deleted("programs", &[name]);
}

/// Shaders compile and programs link; their messages are empty.
extern "system" fn get_object_iv(_: u32, name: u32, value: *mut i32) {
    let success = [GL_COMPILE_STATUS, GL_LINK_STATUS].contains(&name);
    // SAFETY: as above.
    note(|_| unsafe { array_mut(value, 1) }.fill(success.into()));
}

extern "system" fn link_program(_: u32) {
    note(|record| record.linked += 1);
}

extern "system" fn use_program(name: u32) {
    note(|record| record.program = name);
}

extern "system" fn bind_framebuffer(target: u32, name: u32) {
    note(|record| {
        if target != GL_READ_FRAMEBUFFER {
            record.framebuffers[0] = name;
        }
        if target != GL_DRAW_FRAMEBUFFER {
            record.framebuffers[1] = name;
        }
    });
}

extern "system" fn check_framebuffer_status(_: u32) -> u32 {
    note(|_| GL_FRAMEBUFFER_COMPLETE)
}

/// Every name but 0 is that of an object.
extern "system" fn is_object(name: u32) -> u8 {
    note(|_| u8::from(name != 0))
}

extern "system" fn viewport(x: i32, y: i32, width: i32, height: i32) {
    note(|record| record.viewport = LowerLeftRect::new(x, y, width, height));
}

extern "system" fn viewport_indexed(index: u32, x: f32, y: f32, width: f32, height: f32) {
    if index == 0 {
        viewport(x as i32, y as i32, width as i32, height as i32);
    }
}

/// Viewports are the only indexed floats that Cupola queries.
extern "system" fn get_indexed_floats(name: u32, _: u32, values: *mut f32) {
    get_floatv(name, values);
}

extern "system" fn draw_elements(_: u32, count: i32, _: u32, _: *const c_void) {
    draw(count);
}

extern "system" fn draw_arrays(_: u32, _: i32, count: i32) {
    draw(count);
}

fn draw(count: i32) {
    note(|record| {
        let Record { framebuffers, viewport, program, .. } = *record;
        record.draws.push(DrawCall { framebuffer: framebuffers[0], viewport, program, count });
    });
}
