//! Classification of draws.

use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::shader::{assembly, program_pipelines, programs};
use crate::intercept::gl::state::app::AppState;
use crate::intercept::gl::state::app::window_arrays::WindowArrays;
use crate::intercept::gl::state::draw::draw_class::DrawClass;
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::gl::state::frame::Frame;
use crate::intercept::gl::state::shader::Shaders;
use crate::intercept::gl::state::shader::programs::ProgramLens;
use crate::intercept::scene::flat_program::MissingLens;
use crate::intercept::scene::viewport;
use crate::lock::Lock;
use crate::runtime::session::MatrixClass;
use glam::DVec2;

/// Returns the class of a draw with the present state.
pub fn classify(ctx: &mut Context) -> DrawClass {
    let main = main_viewport(&ctx.app, &ctx.frame);
    let class = if main { classify_by_projection(ctx) } else { DrawClass::Flat };
    if class == DrawClass::Flat {
        let reason = if main { missing_lens(&ctx.shaders) } else { MissingLens::PartOfWindow };
        ctx.frame.note_missing_lens(reason);
    }
    class
}

/// Returns the reason why a flat draw has no lens.
fn missing_lens(shaders: &Shaders) -> MissingLens {
    match shaders.program().filter(|program| program.draws_vertices()) {
        Some(program) if program.attribute_matrices.locked().iter().any(|matrix| matrix.declared) => {
            MissingLens::Attribute
        }
        Some(program) if !program.uniforms.locked().any() => MissingLens::NoMatrix,
        _ => MissingLens::NoPerspective,
    }
}

/// True if the primitives of a draw may go to different viewports.
pub fn several_viewports(app: &AppState, shaders: &Shaders) -> bool {
    let chooses = || shaders.program().is_some_and(|program| program.chooses_viewport);
    app.arrays().is_some_and(WindowArrays::differ) && chooses()
}

/// Returns the class of a draw by its lens alone.
pub fn classify_by_projection(ctx: &mut Context) -> DrawClass {
    if several_viewports(&ctx.app, &ctx.shaders) {
        return DrawClass::Flat;
    }
    if let Some(program) = ctx.shaders.program().cloned().filter(|p| p.draws_vertices()) {
        let lens = program_pipelines::lens(ctx, &program);
        return of_lens(&ctx.app, &ctx.drawable, &mut ctx.frame, lens);
    }
    if let Some(program) = ctx.shaders.assembly().cloned() {
        let has_matrices = !program.matrices.is_empty();
        let lens = if has_matrices {
            assembly::lens(&ctx.driver, &program)
        } else {
            programs::given(&ctx.driver, &ctx.drawable)
        };
        return of_lens(&ctx.app, &ctx.drawable, &mut ctx.frame, lens);
    }
    if !ctx.driver.profile.compatibility() {
        return DrawClass::Flat;
    }
    ctx.compat.projection.refresh(ctx.driver.gl, ctx.drawable.session());
    match *ctx.compat.projection.class() {
        MatrixClass::Perspective(intrinsics) => {
            ctx.frame.note_lens(intrinsics, "fixed-function matrix");
            DrawClass::FixedScene
        }
        _ => DrawClass::Flat,
    }
}

/// Returns the class of a draw with `lens`.
fn of_lens(app: &AppState, drawable: &Drawable, frame: &mut Frame, lens: ProgramLens) -> DrawClass {
    let (ProgramLens::Perspective(told, how), Some(session)) = (lens, drawable.session()) else {
        return DrawClass::Flat;
    };
    let DVec2 { x: width, y: height } = app.viewport().size().to_vector();
    let Some(intrinsics) = told.settled(frame.cameras().lenses(), width / height) else { return DrawClass::Flat };
    frame.note_lens(intrinsics, how);
    DrawClass::Scene(frame.camera(&intrinsics, session))
}

/// True if the viewport is the program's main one. Drawing to smaller viewports is flat.
pub fn main_viewport(app: &AppState, frame: &Frame) -> bool {
    let DVec2 { x: width, y: height } = app.viewport().size().to_vector();
    viewport::is_main(width, height, frame.main_area() as f64)
}
