//! Classification of draws.

use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::matrices::refresh;
use crate::intercept::gl::shader::program_pipelines;
use crate::intercept::gl::state::draw::Place;
use crate::intercept::gl::state::programs::Lens;
use crate::intercept::scene::viewport;
use crate::runtime::session::MatrixClass;

/// Where a draw with the present state belongs.
pub fn place(ctx: &mut Context) -> Place {
    if main_viewport(ctx) { place_by_lens(ctx) } else { Place::Flat }
}

/// Where a draw belongs by its lens alone.
pub fn place_by_lens(ctx: &mut Context) -> Place {
    if let Some(program) = ctx.program.clone().filter(|p| p.draws_vertices()) {
        return match program_pipelines::lens(ctx, &program) {
            Lens::Perspective(intrinsics, how) => {
                ctx.counts.found.count(how);
                ctx.lens = Some(intrinsics);
                let Some(session) = Context::session_of(&ctx.target, &ctx.lent) else { return Place::Flat };
                Place::Scene(ctx.cameras.index(&intrinsics, session))
            }
            Lens::Flat => Place::Flat,
        };
    }
    if !ctx.profile.compatibility() {
        return Place::Flat;
    }
    refresh(ctx);
    match ctx.projection.class {
        MatrixClass::Perspective(intrinsics) => {
            ctx.lens = Some(intrinsics);
            ctx.counts.found.count("fixed-function matrix");
            Place::FixedScene
        }
        _ => Place::Flat,
    }
}

/// Whether the viewport is the program's main one; pictures within the picture are flat.
pub fn main_viewport(ctx: &Context) -> bool {
    // In the first frame the first viewport counts: the window may just have got another size.
    let reference = if ctx.viewport_area[1] > 0 { ctx.viewport_area[1] } else { ctx.viewport_area[0] };
    let [_, _, width, height] = ctx.believed.viewport.map(f64::from);
    viewport::is_main(width, height, reference as f64)
}
