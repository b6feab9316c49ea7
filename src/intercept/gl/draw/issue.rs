//! A draw of the program → one draw per view.

use crate::backend::gl::KnownState;
use crate::backend::gl::api::{self, Gl};
use crate::intercept::gl::compat::matrices::{load_projection, refresh};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::draw::culling::bounds::Bounds;
use crate::intercept::gl::draw::culling::select;
use crate::intercept::gl::draw::wide_primitives::Shape;
use crate::intercept::gl::offscreen::displayed::{self, Shows};
use crate::intercept::gl::queries::scaling;
use crate::intercept::gl::shader::programs::Lens;
use crate::intercept::scene::query_weights::QueryWeights;
use crate::intercept::scene::viewport;
use crate::runtime::session::MatrixClass;
use std::ffi::c_void;

/// What of the program's state a draw changes that the next view's draw must see unchanged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Changes {
    /// Nothing.
    Nothing,
    /// State, in the same way each time and before the first vertex: nothing has to be put back.
    Alike,
    /// Current vertex attributes and material (Begin/End).
    Attributes,
    /// Anything that a display list may set.
    Anything,
}

/// Where a draw belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The scene, with the fixed-function projection.
    FixedScene,
    /// The scene, with the camera of this index.
    Scene(usize),
    /// The flat panel.
    Flat,
    /// Flat, behind the scene.
    Background,
}

/// Issues a draw of the program: once per view that shows it. `bounds`: around its vertices, asked for where it matters.
pub fn draw(
    ctx: &mut Context,
    changes: Changes,
    bounds: impl FnOnce(&mut Context) -> Bounds,
    issue: impl FnMut(&mut Context, &Gl),
) {
    crate::intercept::gl::draw::wide_primitives::look(ctx);
    crate::intercept::gl::projected_vertices::fallback::look(ctx);
    draw_to_views(ctx, changes, bounds, issue);
    crate::intercept::gl::projected_vertices::fixed_function::substitute::end(ctx);
}

fn draw_to_views(
    ctx: &mut Context,
    changes: Changes,
    bounds: impl FnOnce(&mut Context) -> Bounds,
    mut issue: impl FnMut(&mut Context, &Gl),
) {
    let gl = ctx.gl;
    if !ctx.redirected() {
        if !crate::intercept::gl::offscreen::view_copies::draw(ctx, changes, bounds, &mut issue) {
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
        if measure.is_some() || !crate::intercept::gl::draw::background::is_behind(ctx) {
            flat(ctx, changes, measure, issue);
            return;
        }
        place = Place::Background;
    } else {
        ctx.background.note_scene();
    }
    if crate::intercept::gl::projected_vertices::fallback::look_divided(ctx, place) {
        place = crate::intercept::gl::draw::issue::place(ctx);
    }
    let shown = match ctx.counting.primitives() {
        true => select::Views::ALL,
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
                        crate::intercept::gl::shader::programs::upload_view(ctx, &rows, target.lenses.get(index));
                        divided = crate::intercept::gl::projected_vertices::lens::begin(
                            ctx,
                            &rows,
                            target.lenses.get(index),
                            target.session.division(index),
                        );
                    }
                }
                Place::Background if ctx.program.as_ref().is_some_and(|p| p.draws_vertices()) => {
                    if let Some(rows) = ctx.background.shader_rows(index).copied() {
                        crate::intercept::gl::shader::programs::upload_view(ctx, &rows, target.lenses.get(index));
                        divided = crate::intercept::gl::projected_vertices::lens::begin(
                            ctx,
                            &rows,
                            target.lenses.get(index),
                            target.session.division(index),
                        );
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

/// Issues a draw for each of `views` that is `shown` it; `prepare` sets the window space and says where the draw belongs.
/// What is beyond the number of views is the program's own picture, which gets all draws.
pub fn each_view(
    ctx: &mut Context,
    changes: Changes,
    views: usize,
    shown: select::Views,
    issue: &mut dyn FnMut(&mut Context, &Gl),
    prepare: impl Fn(&mut Context, usize) -> Place,
) {
    let gl = ctx.gl;
    let share = 1.0 / views.max(1) as f64;
    let session = ctx.target.as_ref().map(|target| target.session.clone()).or_else(|| ctx.lent.clone());
    let own = session.as_ref().map_or(0, |session| session.views().len());
    let repeats = Repeats::new(changes, ctx, 0);
    let mut projection_loaded = false;
    let gets = |view: usize| view >= own || shown.contain(view);
    let last_shown = (0..views).rev().find(|view| gets(*view));
    for (number, view) in (0..views).filter(|view| gets(*view)).enumerate() {
        let place = prepare(ctx, view);
        if ctx.counting.any() {
            let samples = match (place, &session) {
                (Place::FixedScene | Place::Scene(_), Some(_)) if view >= own => 0.0,
                (Place::FixedScene | Place::Scene(_), Some(session)) => scaling::scene_samples(ctx, session, true),
                _ => share,
            };
            scaling::weigh(ctx, QueryWeights { samples, primitives: share });
        }
        let mut divided = None;
        match place {
            _ if view >= own => {
                plain_program(ctx);
                restore_projection(ctx, &mut projection_loaded);
            }
            Place::FixedScene => {
                plain_program(ctx);
                if let Some(matrix) = ctx.projection.per_view.get(view) {
                    load_projection(ctx, matrix);
                    projection_loaded = true;
                }
            }
            Place::Scene(camera) => {
                if let Some(rows) = ctx.cameras.get(camera).and_then(|c| c.rows.get(view)).copied() {
                    let lens = ctx.target.as_ref().and_then(|target| target.lenses.get(view)).copied();
                    crate::intercept::gl::shader::programs::upload_view(ctx, &rows, lens.as_ref());
                    let division = ctx.session().and_then(|session| session.division(view));
                    divided =
                        crate::intercept::gl::projected_vertices::lens::begin(ctx, &rows, lens.as_ref(), division);
                }
            }
            Place::Flat | Place::Background => plain_program(ctx),
        }
        repeats.around(gl, number, Some(view) == last_shown, || issue(ctx, gl));
        if let Some((variant, in_use)) = divided {
            variant.end(ctx, &in_use);
        }
    }
    restore_projection(ctx, &mut projection_loaded);
}

/// A draw that belongs to the flat panel, with the program's own matrices and window space.
fn flat(
    ctx: &mut Context,
    changes: Changes,
    measure: Option<crate::intercept::gl::offscreen::view_copies::Measure>,
    mut issue: impl FnMut(&mut Context, &Gl),
) {
    let gl = ctx.gl;
    crate::intercept::gl::framebuffer::default_framebuffer::want_panel(ctx);
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
            Some(measure) if number == 0 => {
                crate::intercept::gl::offscreen::view_copies::measure(ctx, measure, |ctx| issue(ctx, gl))
            }
            _ => issue(ctx, gl),
        });
        if let Some(blending) = blending.flatten() {
            blending.end(gl);
        }
    }
    ctx.counts.panel_draws += 1;
}

/// The program's own viewport and scissor, moved to a tile of the window's size and kept inside it.
pub fn own_window_space(ctx: &mut Context, tile: [i32; 4]) {
    let [x, y, width, height] = ctx.believed.viewport;
    ctx.set_viewport([tile[0] + x, tile[1] + y, width, height]);
    let inside = x >= 0 && y >= 0 && x + width <= tile[2] && y + height <= tile[3];
    let scissor = if ctx.believed.scissor_test {
        Some(intersect(ctx.believed.scissor, tile))
    } else if inside && !ctx.outlines.cut {
        None
    } else {
        Some(tile)
    };
    ctx.set_scissor(scissor);
}

/// A rectangle of the window, moved to `tile` and cut at its borders.
pub fn intersect(rect: [i32; 4], tile: [i32; 4]) -> [i32; 4] {
    let x0 = rect[0].max(0);
    let y0 = rect[1].max(0);
    let x1 = rect[0].saturating_add(rect[2]).min(tile[2]);
    let y1 = rect[1].saturating_add(rect[3]).min(tile[3]);
    [tile[0] + x0, tile[1] + y0, (x1 - x0).max(0), (y1 - y0).max(0)]
}

/// Where a draw with the present state belongs.
pub fn place(ctx: &mut Context) -> Place {
    if main_viewport(ctx) { place_by_lens(ctx) } else { Place::Flat }
}

/// Where a draw belongs by its lens alone.
pub fn place_by_lens(ctx: &mut Context) -> Place {
    if let Some(program) = ctx.program.clone().filter(|p| p.draws_vertices()) {
        return match crate::intercept::gl::shader::program_pipelines::lens(ctx, &program) {
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

/// Puts the program's own projection back, if a view's was loaded.
fn restore_projection(ctx: &Context, loaded: &mut bool) {
    if std::mem::take(loaded) {
        load_projection(ctx, &ctx.projection.matrix);
    }
}

/// Programs that we patched draw untouched where the picture is the program's own.
pub fn plain_program(ctx: &mut Context) {
    crate::intercept::gl::shader::programs::upload(ctx, &crate::intercept::gl::shader::programs::IDENTITY);
}

/// Keeps a draw that is issued several times one draw for the program: vertex attributes (and what
/// else it may set) are put back in between, and transform feedback records it once.
pub struct Repeats {
    mask: u32,
    /// The material follows the colour.
    follows: bool,
    feedback: bool,
}

impl Repeats {
    /// `pushed` are so many attributes of ours at that time, beside the program's.
    pub fn new(changes: Changes, ctx: &Context, pushed: usize) -> Self {
        let mask = match changes {
            _ if !ctx.profile.compatibility() => 0,
            // No place is left on the stack; a pop would take what is the program's.
            _ if ctx.attribute_stack.len() + pushed >= crate::intercept::gl::context::window_state::ATTRIBUTE_DEPTH => {
                0
            }
            Changes::Nothing | Changes::Alike => 0,
            Changes::Attributes => api::GL_CURRENT_BIT | api::GL_LIGHTING_BIT,
            Changes::Anything => api::GL_ALL_ATTRIB_BITS,
        };
        let follows = mask != 0 && ctx.known_state.is_on(ctx.gl, api::GL_COLOR_MATERIAL);
        // Without a pause (OpenGL before 4.0) there is no drawing without recording.
        Self { mask, follows, feedback: ctx.feedback && ctx.gl.has_pause_transform_feedback() }
    }

    /// Runs `issue` for the `number`-th time; unless it is the `last`, what it changes is put back.
    fn around(&self, gl: &Gl, number: usize, last: bool, issue: impl FnOnce()) {
        if self.feedback && number == 1 {
            // SAFETY: transform feedback is active and not paused.
            unsafe { gl.pause_transform_feedback() };
        }
        self.unchanged(gl, last, issue);
        if self.feedback && last && number > 0 {
            // SAFETY: paused above.
            unsafe { gl.resume_transform_feedback() };
        }
    }

    /// Runs `issue`; unless it is the `last`, what it changes is put back.
    pub fn unchanged(&self, gl: &Gl, last: bool, issue: impl FnOnce()) {
        if self.mask == 0 || last {
            issue();
            return;
        }
        // SAFETY: pushed and popped in pairs around one draw.
        unsafe { gl.push_attrib(self.mask) };
        issue();
        // SAFETY: as above; the material is made to follow the colour that is current again, which Mesa forgets to do.
        unsafe {
            gl.pop_attrib();
            if self.follows {
                gl.disable(api::GL_COLOR_MATERIAL);
                gl.enable(api::GL_COLOR_MATERIAL);
            }
        }
    }
}

/// While the panel is drawn, its alpha collects how much of it is covered, for the composition.
struct PanelBlend {
    factors: [u32; 4],
}

impl PanelBlend {
    fn begin(gl: &Gl, known: &KnownState) -> Option<Self> {
        if !known.is_on(gl, api::GL_BLEND) {
            return None;
        }
        let factors = known.blending(gl);
        let covers = factors[1] == api::GL_ONE_MINUS_SRC_ALPHA;
        let (source, destination) =
            if covers { (api::GL_ONE, api::GL_ONE_MINUS_SRC_ALPHA) } else { (api::GL_ZERO, api::GL_ONE) };
        // SAFETY: sets plain state; put back in `end`.
        unsafe { gl.blend_func_separate(factors[0], factors[1], source, destination) };
        Some(Self { factors })
    }

    fn end(self, gl: &Gl) {
        let [source, destination, source_alpha, destination_alpha] = self.factors;
        // SAFETY: puts back what `begin` found.
        unsafe { gl.blend_func_separate(source, destination, source_alpha, destination_alpha) };
    }
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
        crate::intercept::gl::compat::display_lists::will_draw(ctx, false);
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

#[cfg(test)]
mod tests {
    use super::intersect;

    #[test]
    fn rectangles_stay_in_their_tile() {
        assert_eq!(intersect([10, 20, 30, 40], [100, 200, 300, 300]), [110, 220, 30, 40]);
        assert_eq!(intersect([-10, -20, 30, 40], [100, 200, 300, 300]), [100, 200, 20, 20]);
        assert_eq!(intersect([290, 290, 30, 40], [100, 200, 300, 300]), [390, 490, 10, 10]);
        assert_eq!(intersect([400, 400, 30, 40], [100, 200, 300, 300])[2..], [0, 0]);
        assert_eq!(intersect([i32::MAX, 0, i32::MAX, 1], [0, 0, 300, 300])[2], 0);
    }
}
