//! Use and deletion of programs.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::context::gl_context::ShareGroup;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::list_recording::{self, Command};
use crate::intercept::gl::shader::{program_pipelines, programs};
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::shader::Shaders;
use crate::lock::Lock;

/// `glUseProgram`.
pub fn select(share: &ShareGroup, driver: &mut Driver, shaders: &mut Shaders, name: u32) {
    let asked = programs::asked(share, name);
    // SAFETY: the program's own call.
    unsafe { driver.gl.use_program(asked) };
    let old = shaders.used();
    // A program without an executable is refused.
    if old != name && asked == name {
        let name = if name == 0 || programs::record(share, name).is_some() { name } else { used(driver) };
        shaders.use_program(name);
        share.programs.locked().uses.change(old, name);
        delete_unused(share, driver);
    }
    program_pipelines::choose(share, driver, shaders);
}

/// Returns the program that the driver uses. It does not change if the driver refuses another one.
fn used(driver: &Driver) -> u32 {
    let mut name = 0;
    // SAFETY: writes one integer.
    unsafe { driver.gl.get_integerv(api::GL_CURRENT_PROGRAM, &mut name) };
    name as u32
}

/// Deletes the programs whose deletion was delayed until they are out of use.
fn delete_unused(share: &ShareGroup, driver: &Driver) {
    loop {
        let Some(name) = share.programs.locked().uses.take_unused() else { return };
        // SAFETY: the program's own call, which was delayed.
        unsafe { driver.gl.delete_program(name) };
        forget(share, driver, name);
    }
}

/// Forgets a program that is deleted.
fn forget(share: &ShareGroup, driver: &Driver, name: u32) {
    programs::forget_program(share, driver, name);
    share.programs.locked().link_settings.remove(&name);
}

/// Deletes an object by `issue`, or notes that it must be deleted when it is out of use.
fn delete(share: &ShareGroup, driver: &Driver, name: u32, issue: impl FnOnce(&Gl)) {
    if !share.programs.locked().uses.delete(name) {
        issue(driver.gl);
        forget(share, driver, name);
    }
}

hooks! {
    "glUseProgram" use_program(program: u32) = |ctx, _gl| {
        if ctx.compiling() { list_recording::record(&ctx.share, &ctx.driver, &mut ctx.lists, Command::UseProgram(program)) } else { select(&ctx.share, &mut ctx.driver, &mut ctx.shaders, program) }
    };
    "glUniformSubroutinesuiv" uniform_subroutinesuiv(stage: u32, count: i32, indices: *const u32) = |ctx, gl| {
        ctx.driver.known_state.note_subroutines();
        gl.uniform_subroutinesuiv(stage, count, indices);
    };
    "glDeleteObjectARB" delete_object_arb(object: u32) = |ctx, _gl| {
        // Programs and shaders share one set of names.
        delete(&ctx.share, &ctx.driver, object, |gl| gl.delete_object_arb(object));
    };
    "glDeleteProgram" delete_program(program: u32) = |ctx, _gl| {
        delete(&ctx.share, &ctx.driver, program, |gl| gl.delete_program(program));
    };
}
