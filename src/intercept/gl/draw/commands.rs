//! Draw commands of the program.

use crate::backend::gl::driver::api::Gl;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::list_recording;
use crate::intercept::gl::draw::routing::draw;
use crate::intercept::gl::per_view::culling::select;
use crate::intercept::gl::state::draw::bounds::Bounds;
use crate::intercept::gl::state::draw::draw_class::Changes;
use crate::intercept::gl::state::draw::primitives::Shape;
use std::ffi::c_void;

/// Handles a draw command with primitives of `shape` and vertices within `bounds`. The command
/// becomes part of the display list that is being compiled, or is issued once per view.
pub fn draw_command(
    ctx: &mut Context,
    shape: Shape,
    bounds: impl FnOnce(&mut Context) -> Bounds,
    mut issue: impl FnMut(&mut Context, &Gl),
) {
    if ctx.compiling() {
        let bounds = if select::enabled() { bounds(ctx) } else { Bounds::UNKNOWN };
        list_recording::will_draw(&ctx.share, &ctx.driver, &mut ctx.lists, false);
        ctx.lists.note_bounds(&bounds);
        let gl = ctx.driver.gl;
        issue(ctx, gl);
    } else {
        ctx.draw.note_shape(shape);
        draw(ctx, Changes::Nothing, bounds, issue);
    }
}

/// Hooks of draw commands whose vertices are not known.
macro_rules! draw_hooks {
    ($( $name:literal $method:ident ( $($p:ident : $t:ty),* ) $shape:expr; )*) => {
        hooks! {
            $( $name $method($($p: $t),*) = |ctx, _gl| {
                draw_command(ctx, $shape, |_| Bounds::UNKNOWN, |_, gl| gl.$method($($p),*));
            }; )*
        }
    };
}

draw_hooks! {
    "glDrawArraysIndirect" draw_arrays_indirect(mode: u32, indirect: *const c_void) Shape::of_mode(mode);
    "glDrawElementsIndirect" draw_elements_indirect(mode: u32, kind: u32, indirect: *const c_void) Shape::of_mode(mode);
    "glDrawTransformFeedback" draw_transform_feedback(mode: u32, id: u32) Shape::of_mode(mode);
    "glDrawTransformFeedbackInstanced" draw_transform_feedback_instanced(mode: u32, id: u32, instances: i32) Shape::of_mode(mode);
    "glDrawTransformFeedbackStream" draw_transform_feedback_stream(mode: u32, id: u32, stream: u32) Shape::of_mode(mode);
    "glDrawTransformFeedbackStreamInstanced" draw_transform_feedback_stream_instanced(mode: u32, id: u32, stream: u32, instances: i32) Shape::of_mode(mode);
    "glMultiDrawArraysIndirect" multi_draw_arrays_indirect(mode: u32, indirect: *const c_void, draws: i32, stride: i32) Shape::of_mode(mode);
    "glMultiDrawArraysIndirectCount" multi_draw_arrays_indirect_count(mode: u32, indirect: *const c_void, draws: isize, greatest: i32, stride: i32) Shape::of_mode(mode);
    "glMultiDrawElementsBaseVertex" multi_draw_elements_base_vertex(mode: u32, count: *const i32, kind: u32, indices: *const *const c_void, draws: i32, base: *const i32) Shape::of_mode(mode);
    "glMultiDrawElementsIndirect" multi_draw_elements_indirect(mode: u32, kind: u32, indirect: *const c_void, draws: i32, stride: i32) Shape::of_mode(mode);
    "glMultiDrawElementsIndirectCount" multi_draw_elements_indirect_count(mode: u32, kind: u32, indirect: *const c_void, draws: isize, greatest: i32, stride: i32) Shape::of_mode(mode);
    "glRectd" rectd(x1: f64, y1: f64, x2: f64, y2: f64) Shape::Filled;
    "glRectf" rectf(x1: f32, y1: f32, x2: f32, y2: f32) Shape::Filled;
    "glRecti" recti(x1: i32, y1: i32, x2: i32, y2: i32) Shape::Filled;
    "glRects" rects(x1: i16, y1: i16, x2: i16, y2: i16) Shape::Filled;
    "glRectdv" rectdv(v1: *const f64, v2: *const f64) Shape::Filled;
    "glRectfv" rectfv(v1: *const f32, v2: *const f32) Shape::Filled;
    "glRectiv" rectiv(v1: *const i32, v2: *const i32) Shape::Filled;
    "glRectsv" rectsv(v1: *const i16, v2: *const i16) Shape::Filled;
    "glEvalMesh1" eval_mesh1(mode: u32, i1: i32, i2: i32) Shape::Unknown;
    "glEvalMesh2" eval_mesh2(mode: u32, i1: i32, i2: i32, j1: i32, j2: i32) Shape::Unknown;
}
