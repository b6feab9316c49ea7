//! Use and deletion of programs.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::list_recording::{self, Command};
use crate::intercept::gl::shader::{program_pipelines, programs};
use crate::lock::Lock;

/// `glUseProgram`.
pub fn select(ctx: &mut Context, name: u32) {
    // SAFETY: the program's own call.
    unsafe { ctx.driver.gl.use_program(name) };
    let old = ctx.shaders.used();
    if old != name {
        let name = if name == 0 || programs::record(&ctx.share, name).is_some() { name } else { used(ctx) };
        ctx.shaders.use_program(name);
        ctx.share.programs.locked().uses.change(old, name);
        delete_unused(ctx);
    }
    program_pipelines::choose(ctx);
}

/// Returns the program that the driver uses. It does not change if the driver refuses another one.
fn used(ctx: &Context) -> u32 {
    let mut name = 0;
    // SAFETY: writes one integer.
    unsafe { ctx.driver.gl.get_integerv(api::GL_CURRENT_PROGRAM, &mut name) };
    name as u32
}

/// Deletes the programs whose deletion was delayed until they are out of use.
fn delete_unused(ctx: &Context) {
    loop {
        let Some(name) = ctx.share.programs.locked().uses.take_unused() else { return };
        // SAFETY: the program's own call, which was delayed.
        unsafe { ctx.driver.gl.delete_program(name) };
        programs::forget_program(ctx, name);
    }
}

/// Deletes an object by `issue`, or notes that it must be deleted when it is out of use.
fn delete(ctx: &Context, name: u32, issue: impl FnOnce(&Gl)) {
    if !ctx.share.programs.locked().uses.delete(name) {
        issue(ctx.driver.gl);
        programs::forget_program(ctx, name);
    }
}

hooks! {
    "glUseProgram" use_program(program: u32) = |ctx, _gl| {
        if ctx.compiling() { list_recording::record(ctx, Command::UseProgram(program)) } else { select(ctx, program) }
    };
    "glUniformSubroutinesuiv" uniform_subroutinesuiv(stage: u32, count: i32, indices: *const u32) = |ctx, gl| {
        ctx.driver.known_state.note_subroutines();
        gl.uniform_subroutinesuiv(stage, count, indices);
    };
    "glDeleteObjectARB" delete_object_arb(object: u32) = |ctx, _gl| {
        // Programs and shaders share one set of names.
        delete(ctx, object, |gl| gl.delete_object_arb(object));
    };
    "glDeleteProgram" delete_program(program: u32) = |ctx, _gl| {
        delete(ctx, program, |gl| gl.delete_program(program));
    };
}
