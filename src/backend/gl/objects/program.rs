//! Compiling the correction shaders.

use crate::backend::gl::driver::api::*;
use crate::backend::gl::objects::binaries::Binaries;
use crate::correct::shaders::glsl::Specialised;
use crate::error::{Error, ErrorKind, Result};
use std::ffi::CString;

/// Texture unit of the atlas.
pub(in crate::backend::gl) const ATLAS_UNIT: u32 = 0;
/// Texture unit of the mask.
pub(in crate::backend::gl) const MASK_UNIT: u32 = 1;
/// Texture unit of a table.
pub(in crate::backend::gl) const TABLE_UNIT: u32 = 2;
/// Texture unit of a picture of black.
pub(in crate::backend::gl) const BLACK_UNIT: u32 = 3;

/// Compiles and links a program, or takes it from the cache. The program is current afterwards. The
/// caller deletes it.
///
/// # Errors
/// [`ErrorKind::Graphics`] with the driver's log.
pub(in crate::backend::gl) fn build(gl: &Gl, text: &Specialised, binaries: &Binaries) -> Result<u32> {
    let (vertex, fragment) = (text.vertex, text.fragment.as_str());
    let program = binaries.program(gl, [vertex, fragment], || linked(gl, vertex, fragment, binaries.are_kept()))?;
    // SAFETY: a context is current; the program was linked.
    unsafe { gl.use_program(program) };
    for (uniform, texture) in text.samplers {
        let unit = match *texture {
            "mask" => MASK_UNIT,
            "table" => TABLE_UNIT,
            "black_picture" => BLACK_UNIT,
            _ => ATLAS_UNIT,
        };
        let Ok(name) = CString::new(*uniform) else { continue };
        // SAFETY: the program is current; the name ends with a zero; a uniform that the compiler
        // dropped has location −1, which is ignored.
        unsafe { gl.uniform1i(gl.get_uniform_location(program, name.as_ptr()), unit as i32) };
    }
    Ok(program)
}

/// Links the program of two texts and makes it current. The caller deletes it.
///
/// # Errors
/// As for [`build`].
pub(in crate::backend::gl) fn link(gl: &Gl, vertex: &str, fragment: &str) -> Result<u32> {
    let program = linked(gl, vertex, fragment, false)?;
    // SAFETY: a context is current; the program was linked.
    unsafe { gl.use_program(program) };
    Ok(program)
}

/// Links the program of two texts. `kept`: its binary will be read for the cache.
fn linked(gl: &Gl, vertex: &str, fragment: &str, kept: bool) -> Result<u32> {
    let vertex = compile(gl, GL_VERTEX_SHADER, vertex)?;
    let fragment = compile(gl, GL_FRAGMENT_SHADER, fragment).inspect_err(|_| delete(gl, vertex))?;
    // SAFETY: a context is current; the names are those it gave.
    let program = unsafe {
        let program = gl.create_program();
        gl.attach_shader(program, vertex);
        gl.attach_shader(program, fragment);
        if kept {
            gl.program_parameteri(program, GL_PROGRAM_BINARY_RETRIEVABLE_HINT, 1);
        }
        gl.link_program(program);
        program
    };
    delete(gl, vertex);
    delete(gl, fragment);
    let mut linked = 0;
    // SAFETY: as above; one value.
    unsafe { gl.get_programiv(program, GL_LINK_STATUS, &mut linked) };
    if linked == 0 {
        let log = log(|size, length, buffer| {
            // SAFETY: the buffer has `size` bytes.
            unsafe { gl.get_program_info_log(program, size, length, buffer) }
        });
        // SAFETY: as above.
        unsafe { gl.delete_program(program) };
        return Err(Error::new(ErrorKind::Graphics, format!("The driver cannot link a correction shader: {log}")));
    }
    Ok(program)
}

fn compile(gl: &Gl, kind: u32, text: &str) -> Result<u32> {
    let length = text.len() as i32;
    let start = text.as_ptr().cast();
    let mut compiled = 0;
    // SAFETY: a context is current; one string of the given length.
    let shader = unsafe {
        let shader = gl.create_shader(kind);
        gl.shader_source(shader, 1, &start, &length);
        gl.compile_shader(shader);
        gl.get_shaderiv(shader, GL_COMPILE_STATUS, &mut compiled);
        shader
    };
    if compiled != 0 {
        return Ok(shader);
    }
    let log = log(|size, length, buffer| {
        // SAFETY: the buffer has `size` bytes.
        unsafe { gl.get_shader_info_log(shader, size, length, buffer) }
    });
    delete(gl, shader);
    Err(Error::new(ErrorKind::Graphics, format!("The driver cannot compile a correction shader: {log}")))
}

fn delete(gl: &Gl, shader: u32) {
    // SAFETY: a context is current; the name is one that it gave.
    unsafe { gl.delete_shader(shader) };
}

fn log(fetch: impl FnOnce(i32, &mut i32, *mut std::ffi::c_char)) -> String {
    let mut buffer = [0u8; 2048];
    let mut length = 0;
    fetch(buffer.len() as i32, &mut length, buffer.as_mut_ptr().cast());
    let length = length.clamp(0, buffer.len() as i32) as usize;
    String::from_utf8_lossy(&buffer[..length]).trim().to_owned()
}
