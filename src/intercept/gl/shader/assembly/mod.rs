//! Vertex programs in assembly language (`GL_ARB_vertex_program`) that get their matrix in
//! parameters.
//!
//! `text` changes these programs like `patch` changes shaders. `parameters` finds the parameters
//! that may be their matrix. Programs that use the fixed-function matrices are not changed: for
//! each view Cupola replaces these matrices.

mod parameters;
mod text;

use crate::backend::gl::driver::api;
use crate::backend::gl::driver::values::integer;
use crate::correct::projected::matrices::ReprojectionMatrix;
use crate::intercept::gl::context::errors;
use crate::intercept::gl::context::gl_context::ShareGroup;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::state::app::AppState;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::shader::Shaders;
use crate::intercept::gl::state::shader::assembly::{AssemblyProgram, Parameter, Uploaded};
use crate::intercept::gl::state::shader::programs::{IDENTITY, ProgramLens};
use crate::intercept::scene::lens::{self, Candidate};
use crate::lock::Lock;
use glam::Mat4;
use std::ffi::c_void;
use std::sync::{Arc, Mutex};

const TARGET: u32 = api::GL_VERTEX_PROGRAM_ARB;

/// Notes which of these programs the next draw uses.
pub fn look(share: &ShareGroup, driver: &Driver, app: &AppState, shaders: &mut Shaders) {
    let in_shader = || shaders.program().is_some_and(|program| program.draws_vertices());
    if !app.assembly() || in_shader() {
        return;
    }
    // SAFETY: asks for a switch that the program has used.
    if unsafe { driver.gl.is_enabled(TARGET) } != 0 {
        let name = bound(driver);
        let program = share.programs.locked().assembly.get(&name).cloned();
        shaders.use_assembly(program);
    }
}

/// Returns the name of the bound program.
fn bound(driver: &Driver) -> u32 {
    ask(driver, api::GL_PROGRAM_BINDING_ARB)
}

fn ask(driver: &Driver, what: u32) -> u32 {
    let mut value = 0;
    // SAFETY: writes one integer.
    unsafe { driver.gl.get_programiv_arb(TARGET, what, &mut value) };
    u32::try_from(value).unwrap_or(0)
}

/// Returns the lens in the present parameters.
pub fn lens(driver: &Driver, program: &AssemblyProgram) -> ProgramLens {
    let mut values = program.values.locked();
    values.clear();
    for matrix in &program.matrices {
        let mut value = Mat4::ZERO;
        for (number, vector) in (0..).zip(value.as_mut().chunks_mut(4)) {
            // SAFETY: four floats; the parameter is one that the program text names.
            unsafe {
                match matrix.first {
                    Parameter::Environment(first) => {
                        driver.gl.get_program_env_parameterfv_arb(TARGET, first + number, vector.as_mut_ptr());
                    }
                    Parameter::Local(first) => {
                        driver.gl.get_program_local_parameterfv_arb(TARGET, first + number, vector.as_mut_ptr());
                    }
                }
            }
        }
        values.push(value.as_dmat4());
    }
    let candidates = program.matrices.iter().zip(values.iter());
    let candidates = candidates.map(|(matrix, value)| Candidate { rank: 0, value, order: matrix.order });
    match lens::find(candidates) {
        Some((told, _)) => ProgramLens::Perspective(told, "parameters of a vertex program"),
        None => ProgramLens::Flat,
    }
}

/// Sends `reprojection` to the bound program.
pub fn upload(driver: &Driver, program: &AssemblyProgram, reprojection: &ReprojectionMatrix) {
    let mut uploaded = program.uploaded.locked();
    if uploaded.as_ref() != Some(reprojection) {
        for (number, row) in (0..).zip(reprojection.to_array().chunks(4)) {
            // SAFETY: four floats; the program has these parameters.
            unsafe { driver.gl.program_local_parameter4fv_arb(TARGET, program.first_local + number, row.as_ptr()) };
        }
        *uploaded = Some(*reprojection);
    }
}

/// Gives the driver the changed text of the bound program. Returns true if the driver accepts it.
fn define(share: &ShareGroup, driver: &mut Driver, name: u32, own_text: &[u8]) -> bool {
    let limit = ask(driver, api::GL_MAX_PROGRAM_LOCAL_PARAMETERS_ARB);
    let (Ok(source), Some(first_local)) = (std::str::from_utf8(own_text), limit.checked_sub(text::ROWS)) else {
        return false;
    };
    let Some((changed, matrices)) = text::patch(source, first_local) else { return false };
    let (Ok(length), gl) = (i32::try_from(changed.len()), driver.gl) else { return false };
    driver.take_errors();
    // SAFETY: a text with its length.
    unsafe { gl.program_string_arb(TARGET, api::GL_PROGRAM_FORMAT_ASCII_ARB, length, changed.as_ptr().cast()) };
    let taken = integer(gl, api::GL_PROGRAM_ERROR_POSITION_ARB) == -1;
    errors::drop_errors(gl);
    if taken {
        let uploaded: Uploaded = Mutex::default();
        let values = Mutex::default();
        let program = AssemblyProgram { own_text: own_text.into(), first_local, matrices, uploaded, values };
        upload(driver, &program, &IDENTITY);
        share.programs.locked().assembly.insert(name, Arc::new(program));
    }
    taken
}

/// Returns the record of the bound program.
fn record(share: &ShareGroup, driver: &Driver, target: u32) -> Option<Arc<AssemblyProgram>> {
    let name = if target == TARGET { bound(driver) } else { 0 };
    share.programs.locked().assembly.get(&name).cloned()
}

hooks! {
    "glProgramStringARB" program_string_arb(target: u32, format: u32, length: i32, string: *const c_void) = |ctx, gl| {
        // Program 0 belongs to the context, not to the group.
        let name = if target == TARGET { bound(&ctx.driver) } else { 0 };
        let readable = name != 0 && format == api::GL_PROGRAM_FORMAT_ASCII_ARB && !string.is_null();
        let text = usize::try_from(length).ok().filter(|_| readable);
        ctx.share.programs.locked().assembly.remove(&name);
        let own_text = text.map(|length| std::slice::from_raw_parts(string.cast::<u8>(), length));
        if !own_text.is_some_and(|own_text| define(&ctx.share, &mut ctx.driver, name, own_text)) {
            gl.program_string_arb(target, format, length, string);
        }
    };
    "glNamedProgramStringEXT" named_program_string_ext(program: u32, target: u32, format: u32, length: i32, string: *const c_void) = |ctx, gl| {
        ctx.share.programs.locked().assembly.remove(&program);
        gl.named_program_string_ext(program, target, format, length, string);
    };
    "glDeleteProgramsARB" delete_programs_arb(count: i32, names: *const u32) = |ctx, gl| {
        gl.delete_programs_arb(count, names);
        if !names.is_null() {
            let mut programs = ctx.share.programs.locked();
            for name in std::slice::from_raw_parts(names, usize::try_from(count).unwrap_or(0)) {
                programs.assembly.remove(name);
            }
        }
    };
    "glGetProgramStringARB" get_program_string_arb(target: u32, what: u32, string: *mut c_void) = |ctx, gl| {
        match record(&ctx.share, &ctx.driver, target).filter(|_| what == api::GL_PROGRAM_STRING_ARB && !string.is_null()) {
            Some(program) => string.cast::<u8>().copy_from_nonoverlapping(program.own_text.as_ptr(), program.own_text.len()),
            None => gl.get_program_string_arb(target, what, string),
        }
    };
    "glGetProgramivARB" get_programiv_arb(target: u32, what: u32, values: *mut i32) = |ctx, gl| {
        match record(&ctx.share, &ctx.driver, target).filter(|_| what == api::GL_PROGRAM_LENGTH_ARB && !values.is_null()) {
            Some(program) => *values = program.own_text.len() as i32,
            None => gl.get_programiv_arb(target, what, values),
        }
    };
}
