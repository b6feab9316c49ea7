//! A draw of the program → one draw per view.

use crate::backend::gl::api::Gl;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::list_recording;
use crate::intercept::gl::context::matrices::load_projection;
use crate::intercept::gl::draw::fallback;
use crate::intercept::gl::framebuffer::default_framebuffer;
use crate::intercept::gl::offscreen::displayed::{self, Shows};
use crate::intercept::gl::offscreen::{coverage, draws};
use crate::intercept::gl::per_view::classify::{self, main_viewport, place};
use crate::intercept::gl::per_view::culling::select;
use crate::intercept::gl::per_view::issue::{Repeats, plain_program, restore_projection};
use crate::intercept::gl::per_view::panel::PanelBlend;
use crate::intercept::gl::per_view::window_space::own_window_space;
use crate::intercept::gl::per_view::{background, wide_primitives};
use crate::intercept::gl::projected_vertices::fixed_function::substitute;
use crate::intercept::gl::projected_vertices::lens;
use crate::intercept::gl::queries::scaling;
use crate::intercept::gl::shader::programs;
use crate::intercept::gl::state::bounds::Bounds;
use crate::intercept::gl::state::draw::{Changes, Place};
use crate::intercept::gl::state::offscreen::coverage::Measure;
use crate::intercept::gl::state::primitives::Shape;
use crate::intercept::gl::state::views::Views;
use crate::intercept::scene::query_weights::QueryWeights;
use std::ffi::c_void;

/// Issues a draw of the program: once per view that shows it. `bounds`: around its vertices, asked for where it matters.
pub fn draw(
    ctx: &mut Context,
    changes: Changes,
    bounds: impl FnOnce(&mut Context) -> Bounds,
    issue: impl FnMut(&mut Context, &Gl),
) {
    wide_primitives::look(ctx);
    fallback::look(ctx);
    draw_to_views(ctx, changes, bounds, issue);
    substitute::end(ctx);
}

fn draw_to_views(
    ctx: &mut Context,
    changes: Changes,
    bounds: impl FnOnce(&mut Context) -> Bounds,
    mut issue: impl FnMut(&mut Context, &Gl),
) {
    let gl = ctx.gl;
    if !ctx.redirected() {
        if !draws::draw(ctx, changes, bounds, &mut issue) {
            scaling::weigh(ctx, QueryWeights::ONCE);
            plain_program(ctx);
            issue(ctx, gl);
        }
        return;
    }
    ctx.counts.draws_seen += u64::from(!ctx.picking);
    if ctx.picking || ctx.discard {
        // Picking and feedback answer in the program's own window coordinates and draw nothing. Where nothing reaches
        // the window, what the draw computes (transform feedback, say) it computes once.
        scaling::weigh(ctx, QueryWeights::ONCE);
        ctx.set_viewport(ctx.believed.viewport);
        plain_program(ctx);
        issue(ctx, gl);
        return;
    }
    ctx.frame_begun = true;
    let mut place = place(ctx);
    if place == Place::Flat {
        let main = main_viewport(ctx);
        let measure = match displayed::look(ctx, main) {
            Shows::Pictures(sampled) => {
                displayed::show(ctx, changes, sampled, &mut issue);
                return;
            }
            Shows::Unknown(measure) => Some(measure),
            Shows::Nothing => None,
        };
        ctx.background.note_flat();
        if measure.is_some() || !background::is_behind(ctx) {
            flat(ctx, changes, measure, issue);
            return;
        }
        place = Place::Background;
    } else {
        ctx.background.note_scene();
    }
    if fallback::look_divided(ctx, place) {
        place = classify::place(ctx);
    }
    let shown = match ctx.counting.primitives() {
        true => Views::ALL,
        false => select::views(ctx, place, bounds, changes),
    };
    let Some(mut target) = ctx.target.take() else { return };
    if place != Place::Background {
        let area = i64::from(ctx.believed.viewport[2]) * i64::from(ctx.believed.viewport[3]);
        ctx.viewport_area[0] = ctx.viewport_area[0].max(area);
    }
    let views = target.session.views().len();
    let primary = target.primary();
    if ctx.counting.any() {
        let primitives = 1.0 / (views + usize::from(primary.is_some())) as f64;
        let samples = scaling::scene_samples(ctx, &target.session, false);
        scaling::weigh(ctx, QueryWeights { samples, primitives });
    }
    let repeats = Repeats::new(changes, ctx, 0);
    let mut projection_loaded = false;
    let mut number = 0;
    let last_shown = shown.last(views);
    for index in 0..views {
        if !shown.contain(index) {
            target.culled(index);
            continue;
        }
        let last = Some(index) == last_shown && primary.is_none();
        let mut divided = None;
        let (tile, own_lens) = target.session.tile(index);
        if own_lens {
            own_window_space(ctx, tile);
            plain_program(ctx);
            restore_projection(ctx, &mut projection_loaded);
        } else {
            ctx.set_scissor(ctx.outlines.cut.then_some(tile));
            ctx.set_viewport(tile);
            match place {
                Place::FixedScene => {
                    plain_program(ctx);
                    if let Some(matrix) = ctx.projection.per_view.get(index) {
                        load_projection(ctx, matrix);
                        projection_loaded = true;
                    }
                }
                Place::Scene(camera) => {
                    if let Some(rows) = ctx.cameras.get(camera).and_then(|c| c.rows.get(index)).copied() {
                        programs::upload_view(ctx, &rows, target.lenses.get(index));
                        divided = lens::begin(ctx, &rows, target.lenses.get(index), target.session.division(index));
                    }
                }
                Place::Background if ctx.program.as_ref().is_some_and(|p| p.draws_vertices()) => {
                    if let Some(rows) = ctx.background.shader_rows(index).copied() {
                        programs::upload_view(ctx, &rows, target.lenses.get(index));
                        divided = lens::begin(ctx, &rows, target.lenses.get(index), target.session.division(index));
                    }
                }
                Place::Background => {
                    plain_program(ctx);
                    if let Some(matrix) = ctx.background.projection(index) {
                        load_projection(ctx, matrix);
                        projection_loaded = true;
                    }
                }
                Place::Flat => {}
            }
        }
        repeats.around(gl, number, last, || issue(ctx, gl));
        if let Some((variant, in_use)) = divided {
            variant.end(ctx, &in_use);
        }
        match ctx.areas.get(index).filter(|_| shown.bounded()) {
            Some(area) => target.issued_within(index, *area),
            None => target.issued(index),
        }
        number += 1;
    }
    restore_projection(ctx, &mut projection_loaded);
    if let Some(tile) = primary {
        if ctx.counting.any() {
            scaling::weigh(ctx, QueryWeights { samples: 0.0, primitives: 1.0 / (views + 1) as f64 });
        }
        own_window_space(ctx, tile);
        plain_program(ctx);
        repeats.around(gl, number, true, || issue(ctx, gl));
        ctx.counts.primary_draws += 1;
    }
    ctx.target = Some(target);
}

/// A draw that belongs to the flat panel, with the program's own matrices and window space.
fn flat(ctx: &mut Context, changes: Changes, measure: Option<Measure>, mut issue: impl FnMut(&mut Context, &Gl)) {
    let gl = ctx.gl;
    default_framebuffer::want_panel(ctx);
    let Some(target) = &ctx.target else { return };
    let tiles = target.flat_tiles();
    let repeats = Repeats::new(changes, ctx, 0);
    plain_program(ctx);
    let pictures = tiles.iter().flatten().count();
    for (number, (tile, panel)) in tiles.iter().flatten().enumerate() {
        own_window_space(ctx, *tile);
        let last = pictures == number + 1;
        let samples = if number == 0 { 1.0 } else { 0.0 };
        scaling::weigh(ctx, QueryWeights { samples, primitives: 1.0 / pictures as f64 });
        let blending = panel.then(|| PanelBlend::begin(gl, &ctx.known_state));
        repeats.around(gl, number, last, || match &measure {
            Some(measure) if number == 0 => coverage::measure(ctx, measure, |ctx| issue(ctx, gl)),
            _ => issue(ctx, gl),
        });
        if let Some(blending) = blending.flatten() {
            blending.end(gl);
        }
    }
    ctx.counts.panel_draws += 1;
}

/// A draw command of outlines of `shape` whose vertices are within `bounds`: a part of the list that is compiled, or
/// issued once per view.
pub fn draw_command(
    ctx: &mut Context,
    shape: Shape,
    bounds: impl FnOnce(&mut Context) -> Bounds,
    mut issue: impl FnMut(&mut Context, &Gl),
) {
    if ctx.compiling() {
        let bounds = if select::enabled() { bounds(ctx) } else { Bounds::UNKNOWN };
        list_recording::will_draw(ctx, false);
        if let Some(recording) = &mut ctx.recording {
            recording.bounds.join(&bounds);
        }
        let gl = ctx.gl;
        issue(ctx, gl);
    } else {
        ctx.outlines.shape = shape;
        draw(ctx, Changes::Nothing, bounds, issue);
    }
}

/// Draw commands whose vertices are anywhere.
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
