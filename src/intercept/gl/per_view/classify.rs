//! Classification of draws.

use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::matrices::refresh;
use crate::intercept::gl::shader::program_pipelines;
use crate::intercept::gl::state::draw::DrawClass;
use crate::intercept::gl::state::programs::Lens;
use crate::intercept::scene::viewport;
use crate::runtime::session::MatrixClass;

/// Where a draw with the present state belongs.
pub fn classify(ctx: &mut Context) -> DrawClass {
    if main_viewport(ctx) { classify_by_projection(ctx) } else { DrawClass::Flat }
}

/// Where a draw belongs by its lens alone.
pub fn classify_by_projection(ctx: &mut Context) -> DrawClass {
    if let Some(program) = ctx.program.clone().filter(|p| p.draws_vertices()) {
        return match program_pipelines::lens(ctx, &program) {
            Lens::Perspective(intrinsics, how) => {
                ctx.counts.found.count(how);
                ctx.lens = Some(intrinsics);
                let Some(session) = Context::session_of(&ctx.target, &ctx.lent) else { return DrawClass::Flat };
                DrawClass::Scene(ctx.cameras.index(&intrinsics, session))
            }
            Lens::Flat => DrawClass::Flat,
        };
    }
    if !ctx.profile.compatibility() {
        return DrawClass::Flat;
    }
    refresh(ctx);
    match ctx.projection.class {
        MatrixClass::Perspective(intrinsics) => {
            ctx.lens = Some(intrinsics);
            ctx.counts.found.count("fixed-function matrix");
            DrawClass::FixedScene
        }
        _ => DrawClass::Flat,
    }
}

/// Whether the viewport is the program's main one; pictures within the picture are flat.
pub fn main_viewport(ctx: &Context) -> bool {
    // In the first frame the first viewport counts: the window may just have got another size.
    let reference = if ctx.viewport_area[1] > 0 { ctx.viewport_area[1] } else { ctx.viewport_area[0] };
    let [_, _, width, height] = ctx.app.viewport.map(f64::from);
    viewport::is_main(width, height, reference as f64)
}
