//! Program pipelines: separable programs, of which the last before rasterisation draws the view.

use crate::backend::gl::api;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::shader::programs::{self, Lens, Program};
use std::collections::HashMap;
use std::sync::Arc;

/// The pipelines of a context.
#[derive(Default)]
pub struct Pipelines {
    pipelines: HashMap<u32, Stages>,
    bound: u32,
    /// `glUseProgram`, which goes before any pipeline; 0 = none.
    pub used: u32,
}

/// The programs of a pipeline that Cupola follows, by their names; 0 = none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Stages {
    vertex: u32,
    evaluation: u32,
    geometry: u32,
    /// `glActiveShaderProgram`.
    active: u32,
}

impl Stages {
    /// The programs before rasterisation, the last one first.
    fn last_first(&self) -> [u32; 3] {
        [self.geometry, self.evaluation, self.vertex]
    }

    /// `glUseProgramStages` with a program that has the stages `present`.
    fn set(&mut self, stages: u32, program: u32, present: u32) {
        let slots = [
            (api::GL_VERTEX_SHADER_BIT, &mut self.vertex),
            (api::GL_TESS_EVALUATION_SHADER_BIT, &mut self.evaluation),
            (api::GL_GEOMETRY_SHADER_BIT, &mut self.geometry),
        ];
        for (bit, slot) in slots {
            if stages & bit != 0 {
                *slot = if present & bit != 0 { program } else { 0 };
            }
        }
    }
}

impl Pipelines {
    fn stages(&self) -> Stages {
        self.pipelines.get(&self.bound).copied().unwrap_or_default()
    }
}

/// What now draws: the program in use, or else the pipeline's last program before rasterisation.
pub fn choose(ctx: &mut Context) {
    if ctx.pipelines.used != 0 {
        ctx.program = programs::record(ctx, ctx.pipelines.used);
        return;
    }
    let names = ctx.pipelines.stages().last_first();
    let last = names.into_iter().find(|name| *name != 0).unwrap_or(0);
    ctx.program = programs::record(ctx, last);
    for earlier in names.into_iter().filter(|name| *name != 0 && *name != last) {
        if let Some(program) = programs::record(ctx, earlier) {
            programs::send(ctx, &program, &programs::IDENTITY);
        }
    }
}

/// The program that `glUniform` sets where none is in use.
pub fn active(ctx: &Context) -> Option<Arc<Program>> {
    programs::record(ctx, ctx.pipelines.stages().active)
}

/// The lens of what draws: in a pipeline, of the last program that holds one.
pub fn lens(ctx: &mut Context, program: &Program) -> Lens {
    let lens = program.lens(ctx);
    if ctx.pipelines.used != 0 || lens != Lens::Flat {
        return lens;
    }
    for name in ctx.pipelines.stages().last_first() {
        let lens = programs::record(ctx, name).filter(|p| p.name != program.name).map(|p| p.lens(ctx));
        if let Some(lens) = lens.filter(|lens| *lens != Lens::Flat) {
            return lens;
        }
    }
    Lens::Flat
}

hooks! {
    "glBindProgramPipeline" bind_program_pipeline(pipeline: u32) = |ctx, gl| {
        gl.bind_program_pipeline(pipeline);
        ctx.pipelines.bound = pipeline;
        choose(ctx);
    };
    "glUseProgramStages" use_program_stages(pipeline: u32, stages: u32, program: u32) = |ctx, gl| {
        gl.use_program_stages(pipeline, stages, program);
        let present = programs::record(ctx, program).map_or(0, |p| p.stages());
        ctx.pipelines.pipelines.entry(pipeline).or_default().set(stages, program, present);
        choose(ctx);
    };
    "glActiveShaderProgram" active_shader_program(pipeline: u32, program: u32) = |ctx, gl| {
        gl.active_shader_program(pipeline, program);
        ctx.pipelines.pipelines.entry(pipeline).or_default().active = program;
    };
    "glDeleteProgramPipelines" delete_program_pipelines(count: i32, names: *const u32) = |ctx, gl| {
        gl.delete_program_pipelines(count, names);
        if !names.is_null() {
            for name in std::slice::from_raw_parts(names, usize::try_from(count).unwrap_or(0)) {
                ctx.pipelines.pipelines.remove(name);
                if ctx.pipelines.bound == *name {
                    ctx.pipelines.bound = 0;
                }
            }
        }
        choose(ctx);
    };
}

#[cfg(test)]
mod tests {
    use super::{Stages, api};

    #[test]
    fn a_stage_that_a_program_lacks_becomes_empty() {
        let mut stages = Stages::default();
        stages.set(api::GL_GEOMETRY_SHADER_BIT, 7, api::GL_GEOMETRY_SHADER_BIT);
        stages.set(api::GL_VERTEX_SHADER_BIT | api::GL_FRAGMENT_SHADER_BIT, 3, api::GL_VERTEX_SHADER_BIT);
        assert_eq!(stages.last_first(), [7, 0, 3]);
        stages.set(api::GL_ALL_SHADER_BITS, 5, api::GL_VERTEX_SHADER_BIT);
        assert_eq!(stages.last_first(), [0, 0, 5]);
    }
}
