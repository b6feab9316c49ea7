//! Programs that are linked again while they are in use.
//!
//! If such a link fails, OpenGL goes on drawing with the executable, but refuses to use the program
//! again. Cupola puts programs of its own in use at the end of a frame, and so could not go back.
//! Therefore the link is tried with another program object. If it fails, that object answers the
//! questions about the program, which itself stays as it is:
//!
//! ```text
//! glLinkProgram(p) ─ p in use ─ trial fails ── p: executable, uniforms, shaders, settings
//!                                          └─ trial: status, log, what is active, locations, use
//! ```

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::context::errors;
use crate::intercept::gl::context::gl_context::{Context, ShareGroup};
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::shader::programs::{self, asked};
use crate::lock::Lock;
use std::ffi::{CStr, CString, c_char};
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Returns another program object with the same shaders and settings, if the program must keep its
/// executable should the link fail.
pub(super) fn begin(ctx: &mut Context, program: u32, shaders: &[(u32, u32)]) -> Option<u32> {
    programs::record(&ctx.share, program)?;
    let settings = {
        let programs = ctx.share.programs.locked();
        if !programs.uses.contain(program) {
            return None;
        }
        programs.link_settings.get(&program).cloned().unwrap_or_default()
    };
    // While it is recorded, OpenGL refuses to link it.
    if ctx.app.feedback() {
        return None;
    }
    let gl = ctx.driver.gl;
    ctx.driver.take_errors();
    // SAFETY: a program of Cupola, with shaders of the program; one integer is written.
    let trial = unsafe {
        let trial = gl.create_program();
        for (shader, _) in shaders {
            gl.attach_shader(trial, *shader);
        }
        let mut separable = 0;
        gl.get_programiv(program, api::GL_PROGRAM_SEPARABLE, &mut separable);
        gl.program_parameteri(trial, api::GL_PROGRAM_SEPARABLE, separable);
        trial
    };
    for set in settings.values() {
        set(gl, trial);
    }
    // The driver refuses wrong settings, as it did before.
    errors::drop_errors(gl);
    Some(trial)
}

/// Links the program if the `trial` is `linked`. Else the program keeps its executable, and the
/// trial answers questions. Returns true if the program was linked.
pub(super) fn end(ctx: &Context, program: u32, trial: u32, shaders: &[(u32, u32)], linked: bool) -> bool {
    let gl = ctx.driver.gl;
    for (shader, _) in shaders {
        // SAFETY: attached in `begin`.
        unsafe { gl.detach_shader(trial, *shader) };
    }
    let record = programs::record(&ctx.share, program);
    if let Some(record) = record.filter(|_| !linked) {
        let earlier = record.failed.swap(trial, Ordering::Relaxed);
        // SAFETY: a program of Cupola; 0 is ignored.
        unsafe { gl.delete_program(earlier) };
        return false;
    }
    // SAFETY: a program of Cupola, and the application's own call.
    unsafe {
        gl.delete_program(trial);
        gl.link_program(program);
    }
    true
}

/// Notes a setting for the next link of a program.
fn note(
    share: &ShareGroup,
    gl: &Gl,
    program: u32,
    kind: Kind,
    name: CString,
    set: impl Fn(&Gl, u32) + Send + Sync + 'static,
) {
    // SAFETY: asks for a name.
    if unsafe { gl.is_program(program) } != 0 {
        let settings = &mut share.programs.locked().link_settings;
        settings.entry(program).or_default().insert((kind as u8, name), Arc::new(set));
    }
}

/// Kinds of settings.
#[derive(Clone, Copy)]
enum Kind {
    Attribute,
    Output,
    Feedback,
}

/// Returns a copy of a name. `None`: the program passes none.
///
/// # Safety
/// `name` must be null or a text that ends with NUL.
unsafe fn copied(name: *const c_char) -> Option<CString> {
    // SAFETY: as promised.
    (!name.is_null()).then(|| unsafe { CStr::from_ptr(name) }.to_owned())
}

/// Returns copies of names. `None`: the program passes none.
///
/// # Safety
/// `names` must be null or point at `count` texts that end with NUL.
unsafe fn all_copied(count: i32, names: *const *const c_char) -> Option<Vec<CString>> {
    let count = usize::try_from(count).ok().filter(|count| *count == 0 || !names.is_null())?;
    // SAFETY: as promised.
    (0..count).map(|index| unsafe { copied(*names.add(index)) }).collect()
}

/// Hooks of questions that the trial answers after it failed.
macro_rules! questions {
    ($( $name:literal $method:ident ( $($p:ident : $t:ty),* ) $(-> $r:ty)?; )* more: $($hooks:tt)*) => {
        hooks! {
            $( $name $method(program: u32 $(, $p: $t)*) $(-> $r)? = |ctx, gl| gl.$method(asked(&ctx.share, program) $(, $p)*); )*
            $($hooks)*
        }
    };
}

questions! {
    "glGetUniformLocation" get_uniform_location(name: *const c_char) -> i32;
    "glGetAttribLocation" get_attrib_location(name: *const c_char) -> i32;
    "glGetFragDataLocation" get_frag_data_location(name: *const c_char) -> i32;
    "glGetFragDataIndex" get_frag_data_index(name: *const c_char) -> i32;
    "glGetProgramResourceLocation" get_program_resource_location(interface: u32, name: *const c_char) -> i32;
    "glGetProgramResourceLocationIndex" get_program_resource_location_index(interface: u32, name: *const c_char) -> i32;
    "glGetUniformBlockIndex" get_uniform_block_index(name: *const c_char) -> u32;
    "glGetSubroutineIndex" get_subroutine_index(stage: u32, name: *const c_char) -> u32;
    "glGetSubroutineUniformLocation" get_subroutine_uniform_location(stage: u32, name: *const c_char) -> i32;
    "glGetActiveAttrib" get_active_attrib(index: u32, room: i32, length: *mut i32, size: *mut i32, kind: *mut u32, name: *mut c_char);
    "glGetTransformFeedbackVarying" get_transform_feedback_varying(index: u32, room: i32, length: *mut i32, size: *mut i32, kind: *mut u32, name: *mut c_char);
    "glGetActiveUniformBlockName" get_active_uniform_block_name(index: u32, room: i32, length: *mut i32, name: *mut c_char);
    "glGetActiveSubroutineName" get_active_subroutine_name(stage: u32, index: u32, room: i32, length: *mut i32, name: *mut c_char);
    "glGetActiveSubroutineUniformName" get_active_subroutine_uniform_name(stage: u32, index: u32, room: i32, length: *mut i32, name: *mut c_char);
    "glGetActiveSubroutineUniformiv" get_active_subroutine_uniformiv(stage: u32, index: u32, what: u32, values: *mut i32);
    "glGetActiveAtomicCounterBufferiv" get_active_atomic_counter_bufferiv(index: u32, what: u32, values: *mut i32);
    "glGetProgramStageiv" get_program_stageiv(stage: u32, what: u32, values: *mut i32);
    "glGetProgramInfoLog" get_program_info_log(room: i32, length: *mut i32, log: *mut c_char);
    "glGetInfoLogARB" get_info_log_arb(room: i32, length: *mut i32, log: *mut c_char);
    "glValidateProgram" validate_program();
    more:
    "glBindAttribLocation" bind_attrib_location(program: u32, index: u32, name: *const c_char) = |ctx, gl| {
        gl.bind_attrib_location(program, index, name);
        if let Some(name) = copied(name) {
            let text = name.clone();
            // SAFETY: a text that ends with NUL; the same holds for the other settings.
            let set = move |gl: &Gl, program| unsafe { gl.bind_attrib_location(program, index, text.as_ptr()) };
            note(&ctx.share, gl, program, Kind::Attribute, name, set);
        }
    };
    "glBindFragDataLocation" bind_frag_data_location(program: u32, color: u32, name: *const c_char) = |ctx, gl| {
        gl.bind_frag_data_location(program, color, name);
        if let Some(name) = copied(name) {
            let text = name.clone();
            let set = move |gl: &Gl, program| unsafe { gl.bind_frag_data_location(program, color, text.as_ptr()) };
            note(&ctx.share, gl, program, Kind::Output, name, set);
        }
    };
    "glBindFragDataLocationIndexed" bind_frag_data_location_indexed(program: u32, color: u32, index: u32, name: *const c_char) = |ctx, gl| {
        gl.bind_frag_data_location_indexed(program, color, index, name);
        if let Some(name) = copied(name) {
            let text = name.clone();
            let set = move |gl: &Gl, program| unsafe { gl.bind_frag_data_location_indexed(program, color, index, text.as_ptr()) };
            note(&ctx.share, gl, program, Kind::Output, name, set);
        }
    };
    "glTransformFeedbackVaryings" transform_feedback_varyings(program: u32, count: i32, names: *const *const c_char, mode: u32) = |ctx, gl| {
        gl.transform_feedback_varyings(program, count, names, mode);
        if let Some(texts) = all_copied(count, names) {
            let set = move |gl: &Gl, program| {
                let names: Vec<_> = texts.iter().map(|text| text.as_ptr()).collect();
                unsafe { gl.transform_feedback_varyings(program, count, names.as_ptr(), mode) };
            };
            note(&ctx.share, gl, program, Kind::Feedback, CString::default(), set);
        }
    };
}
