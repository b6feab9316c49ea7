//! Draws of the fixed-function pipeline whose primitives the processor divides.

use crate::backend::gl::driver::api::Gl;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::list_recording;
use crate::intercept::gl::draw::commands::draw_command;
use crate::intercept::gl::draw::routing::draw;
use crate::intercept::gl::per_view::culling::select;
use crate::intercept::gl::projected_vertices::{Attribute, Vertices, draw_divided, draw_whole, reads_vertices};
use crate::intercept::gl::state::draw::bounds::Bounds;
use crate::intercept::gl::state::draw::draw_class::Changes;
use crate::intercept::gl::state::draw::primitives::Shape;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::projected_vertices::fixed_function::Processor;
use crate::intercept::scene::obstacle::Obstacle;

/// Issues a draw after an attempt to read its vertices on the processor. For views that need it,
/// the processor divides the primitives; for the other views `whole` issues the draw.
pub fn draw_read(
    ctx: &mut Context,
    changes: Changes,
    bounds: Bounds,
    vertices: &Result<Vertices, Obstacle>,
    mut whole: impl FnMut(&mut Context, &Gl),
) {
    let (processor, vertices) = match vertices {
        Ok(vertices) => (Processor::Divides, Some(vertices)),
        Err(why) => (Processor::Cannot(why.clone()), None),
    };
    ctx.projected.begin_draw(processor);
    draw(
        ctx,
        changes,
        |_| bounds,
        |ctx, gl| match (ctx.projected.take_view(), vertices) {
            (Some((division, reprojection)), Some(vertices)) => draw_divided(
                &ctx.driver,
                &ctx.draw,
                &mut ctx.compat,
                &mut ctx.projected,
                vertices,
                division,
                &reprojection,
            ),
            _ => whole(ctx, gl),
        },
    );
    ctx.projected.end_draw();
}

/// Issues a draw of arrays after an attempt to read its vertices on the processor. While a display
/// list is compiled, the draw becomes an item of its own in that list.
pub fn draw_arrays(
    ctx: &mut Context,
    mode: u32,
    vertices: Result<Vertices, Obstacle>,
    bounds: impl FnOnce(&mut Context) -> Bounds,
    issue: impl FnMut(&mut Context, &Gl),
) {
    let shape = Shape::of_mode(mode);
    if !ctx.compiling() {
        ctx.draw.note_shape(shape);
        let bounds = if select::enabled() { bounds(ctx) } else { Bounds::UNKNOWN };
        let current = current(&ctx.driver, &vertices);
        draw_read(ctx, Changes::Nothing, bounds, &vertices, issue);
        put_back(&ctx.driver, &current);
        return;
    }
    let Ok(kept) = vertices else {
        draw_command(ctx, shape, bounds, issue);
        return;
    };
    let vertices = Ok(kept);
    list_recording::now_or_later(ctx, move |ctx| {
        ctx.draw.note_shape(shape);
        let current = current(&ctx.driver, &vertices);
        let whole = |_: &mut Context, gl: &Gl| draw_whole(gl, &vertices);
        if reads_vertices(&ctx.app, &ctx.drawable, &ctx.shaders, mode) {
            draw_read(ctx, Changes::Nothing, Bounds::UNKNOWN, &vertices, whole);
        } else {
            draw(ctx, Changes::Nothing, |_| Bounds::UNKNOWN, whole);
        }
        put_back(&ctx.driver, &current);
    });
}

/// Returns the current values of the attributes that `vertices` have.
pub(in crate::intercept::gl) fn current(
    driver: &Driver,
    vertices: &Result<Vertices, Obstacle>,
) -> Vec<(Attribute, [f32; 4])> {
    let attributes = vertices.iter().flat_map(|vertices| &vertices.attributes);
    attributes.map(|attribute| (*attribute, attribute.current(driver.gl))).collect()
}

/// Restores the current values of attributes: a draw from arrays does not change them.
pub(in crate::intercept::gl) fn put_back(driver: &Driver, current: &[(Attribute, [f32; 4])]) {
    for (attribute, value) in current {
        // SAFETY: the values that `current` found, in the same context.
        unsafe { attribute.set(driver.gl, value) };
    }
}
