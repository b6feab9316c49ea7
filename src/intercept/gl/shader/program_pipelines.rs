//! Program pipelines: separable programs. The last program before rasterisation draws the view.

use crate::backend::gl::driver::api::Gl;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::gl_context::ShareGroup;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::shader::programs;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::shader::Shaders;
use crate::intercept::gl::state::shader::programs::{Program, ProgramLens};
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Chooses the program that draws: the program in use, or else the pipeline's last program before
/// rasterisation.
pub fn choose(share: &ShareGroup, driver: &Driver, shaders: &mut Shaders) {
    if shaders.used() != 0 {
        shaders.choose(programs::record(share, shaders.used()));
        return;
    }
    let names = shaders.stages().last_first();
    let last = names.into_iter().find(|name| *name != 0).unwrap_or(0);
    shaders.choose(programs::record(share, last));
    for earlier in names.into_iter().filter(|name| *name != 0 && *name != last) {
        if let Some(program) = programs::record(share, earlier) {
            programs::send(driver, shaders, &program, &crate::intercept::gl::state::shader::programs::IDENTITY);
        }
    }
}

/// Returns the program that `glUniform` sets if no program is in use.
pub fn active(share: &ShareGroup, shaders: &Shaders) -> Option<Arc<Program>> {
    programs::record(share, shaders.stages().active())
}

/// Returns the lens of the present draw. In a pipeline it is that of the last program that has one.
pub fn lens(ctx: &mut Context, program: &Program) -> ProgramLens {
    let lens = program.lens(ctx);
    if ctx.shaders.used() != 0 || lens != ProgramLens::Flat {
        return lens;
    }
    for name in ctx.shaders.stages().last_first() {
        let lens = programs::record(&ctx.share, name).filter(|p| p.name != program.name).map(|p| p.lens(ctx));
        if let Some(lens) = lens.filter(|lens| *lens != ProgramLens::Flat) {
            return lens;
        }
    }
    ProgramLens::Flat
}

/// Calls `note` with the program that `glUniform` sets.
pub(super) fn with_current<T>(share: &ShareGroup, shaders: &Shaders, note: impl FnOnce(Option<&Program>) -> T) -> T {
    if shaders.used() != 0 {
        note(shaders.program().map(|program| &**program))
    } else {
        note(active(share, shaders).as_deref())
    }
}

/// Makes a call with a program for a pipeline, and returns whether the driver accepts the program. It is asked once,
/// because programs choose stages for each draw, and a driver with a thread of its own waits for it to answer.
fn is_accepted(ctx: &mut Context, program: u32, call: impl FnOnce(&Gl)) -> bool {
    let record = programs::record(&ctx.share, program);
    if program == 0 || record.as_ref().is_some_and(|record| record.is_stage.load(Ordering::Relaxed)) {
        call(ctx.driver.gl);
        return true;
    }
    let is_accepted = ctx.driver.accepts(call);
    if let Some(record) = record {
        record.is_stage.store(is_accepted, Ordering::Relaxed);
    }
    is_accepted
}

hooks! {
    "glBindProgramPipeline" bind_program_pipeline(pipeline: u32) = |ctx, gl| {
        gl.bind_program_pipeline(pipeline);
        ctx.shaders.bind_pipeline(pipeline);
        choose(&ctx.share, &ctx.driver, &mut ctx.shaders);
    };
    "glUseProgramStages" use_program_stages(pipeline: u32, stages: u32, program: u32) = |ctx, _gl| {
        let asked = programs::asked(&ctx.share, program);
        // Refused are programs that are not separable. Those without an executable are asked for by another name.
        if !is_accepted(ctx, program, |gl| gl.use_program_stages(pipeline, stages, asked)) || asked != program {
            return;
        }
        let present = programs::record(&ctx.share, program).map_or(0, |p| p.stages());
        ctx.shaders.set_stages(pipeline, stages, program, present);
        choose(&ctx.share, &ctx.driver, &mut ctx.shaders);
    };
    "glActiveShaderProgram" active_shader_program(pipeline: u32, program: u32) = |ctx, _gl| {
        let asked = programs::asked(&ctx.share, program);
        if !is_accepted(ctx, program, |gl| gl.active_shader_program(pipeline, asked)) || asked != program {
            return;
        }
        ctx.shaders.set_active(pipeline, program);
    };
    "glDeleteProgramPipelines" delete_program_pipelines(count: i32, names: *const u32) = |ctx, gl| {
        gl.delete_program_pipelines(count, names);
        if !names.is_null() {
            for name in std::slice::from_raw_parts(names, usize::try_from(count).unwrap_or(0)) {
                ctx.shaders.delete_pipeline(*name);
            }
        }
        choose(&ctx.share, &ctx.driver, &mut ctx.shaders);
    };
}
