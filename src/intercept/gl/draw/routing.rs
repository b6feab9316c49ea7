//! Route of one draw of the program.
//!
//! ```text
//! draw ── to a framebuffer of the program ──────────────── offscreen::draws
//!    │                                                         │
//!    └─ to the window ─ classify ─┬─ flat: panel ─────────── flat
//!                                 ├─ shows an image ──────── offscreen::displayed
//!                                 └─ scene, screen, behind    │
//!                                        │                    │
//!                                   select views         select views
//!                                        └──── per_view::issue ┘
//! ```

use crate::backend::gl::driver::api::Gl;
use crate::correct::LowerLeftRect;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::draw::fallback;
use crate::intercept::gl::framebuffer::target::enlarge::{want_own_picture, want_panel};
use crate::intercept::gl::offscreen::displayed;
use crate::intercept::gl::offscreen::inspected::{self, Seen};
use crate::intercept::gl::offscreen::{coverage, draws, sampling};
use crate::intercept::gl::per_view::classify::{classify, main_viewport, several_viewports};
use crate::intercept::gl::per_view::culling::select;
use crate::intercept::gl::per_view::issue::{Copies, CopyTarget, Repeats, plain_program};
use crate::intercept::gl::per_view::panel::{self, PanelBlend};
use crate::intercept::gl::per_view::window_space::{own_window_space, program_window_space, view_window_space};
use crate::intercept::gl::per_view::{self, backdrop, background, wide_primitives};
use crate::intercept::gl::projected_vertices;
use crate::intercept::gl::queries::scaling;
use crate::intercept::gl::shader::camera_matrices::upload;
use crate::intercept::gl::shader::source::frag_coord;
use crate::intercept::gl::shader::{assembly, changed};
use crate::intercept::gl::state::draw::bounds::Bounds;
use crate::intercept::gl::state::draw::draw_class::{Changes, DrawClass};
use crate::intercept::gl::state::draw::views::Views;
use crate::intercept::gl::state::offscreen::coverage::Measure;
use crate::intercept::gl::state::offscreen::displayed::Shows;
use crate::intercept::inspection;
use crate::intercept::scene::query_scaling::QueryScaling;
use crate::runtime::session::Session;
use std::sync::Arc;

/// Number of a frame's first flat draws behind the scene that may fill its background.
const BACKDROPS: u32 = 4;

/// Issues a draw of the program once per view that shows it. `bounds` returns a box around its
/// vertices and is called only if the box is needed.
pub fn draw(
    ctx: &mut Context,
    changes: Changes,
    bounds: impl FnOnce(&mut Context) -> Bounds,
    mut issue: impl FnMut(&mut Context, &Gl),
) {
    wide_primitives::look(&ctx.driver, &mut ctx.draw, &ctx.shaders);
    assembly::look(&ctx.share, &ctx.driver, &ctx.app, &mut ctx.shaders);
    fallback::look(ctx);
    if ctx.redirected() {
        draw_to_window(ctx, changes, bounds, &mut issue);
    } else if !draws::draw(ctx, changes, bounds, &mut issue) {
        once(ctx, &mut issue);
    }
    projected_vertices::end_stand_in(&ctx.driver, &mut ctx.shaders, &mut ctx.projected);
    ctx.shaders.end_draw();
}

/// Issues a draw once, with the program's own state.
fn once(ctx: &mut Context, issue: &mut dyn FnMut(&mut Context, &Gl)) {
    let gl = ctx.driver.gl;
    scaling::scale(ctx.driver.gl, &mut ctx.queries, QueryScaling::ONCE);
    program_window_space(&mut ctx.draw);
    plain_program(ctx);
    issue(ctx, gl);
}

fn draw_to_window(
    ctx: &mut Context,
    changes: Changes,
    bounds: impl FnOnce(&mut Context) -> Bounds,
    issue: &mut dyn FnMut(&mut Context, &Gl),
) {
    if !ctx.app.picking() {
        ctx.frame.note_draw();
    }
    if ctx.app.picking() || ctx.app.discard() {
        // Picking and feedback answer in the program's own window coordinates and draw nothing.
        // With rasterizer discard nothing reaches the window, and results such as transform
        // feedback must be computed once.
        ctx.set_viewport(ctx.app.viewport());
        inspect(ctx, DrawClass::Flat, None);
        once(ctx, issue);
        return;
    }
    ctx.note_drawn();
    // A new tile makes a new plan, for which the draw has to be classified.
    if changed::any(&ctx.share, &ctx.shaders) {
        want_own_picture(ctx);
    }
    let Some(class) = perspective_or_flat(ctx, changes, issue) else { return };
    inspect(ctx, class, None);
    let shown = match ctx.session().and_then(Session::turn) {
        Some(view) => Views::only(view),
        None if ctx.queries.primitives() => Views::ALL,
        None => select::views(ctx, class, bounds, changes),
    };
    let Some(target) = ctx.drawable.target() else { return };
    let (session, primary, panel) = (target.session.clone(), target.primary(), target.panel());
    let counts = changes != Changes::Nothing || ctx.app.feedback() || ctx.queries.have_counted();
    let shown = if counts || !select::enabled() { shown } else { shown.within(session.needed()) };
    if !matches!(class, DrawClass::Behind | DrawClass::Flat) {
        ctx.frame.note_viewport(ctx.app.viewport());
    }
    let views = session.views().len();
    let picture = if class == DrawClass::Flat { backdrop::tile_in_window(ctx) } else { None };
    let own = primary.or(picture.filter(|tile| Some(*tile) == panel));
    let mut window = WindowCopies { session, own, class, shown };
    let count = views + usize::from(window.own.is_some());
    if let Some(picture) = picture {
        backdrop::begin_in_window(ctx, picture);
    }
    per_view::issue::issue(ctx, &Copies { changes, views, count, shown }, &mut window, issue);
    if let Some(picture) = picture {
        backdrop::spread_in_window(ctx, picture);
        // It covers earlier flat drawing there.
        panel::clear_part(ctx, ctx.app.viewport());
    }
}

/// Returns the class of a draw that goes to the views: [`DrawClass::Flat`] for a background that
/// fills the picture. `None`: the draw is flat and was issued here.
fn perspective_or_flat(
    ctx: &mut Context,
    changes: Changes,
    issue: &mut dyn FnMut(&mut Context, &Gl),
) -> Option<DrawClass> {
    let mut class = classify(ctx);
    if class == DrawClass::Flat {
        let main = main_viewport(&ctx.app, &ctx.frame);
        let measure = match displayed::look(ctx, main) {
            Shows::Pictures(sampled, part) => {
                let why = Some("it shows images of the scene in the window");
                inspected::note(ctx, &Seen { class: DrawClass::Screen, sampled, why });
                displayed::show(ctx, changes, (sampled, part), issue);
                return None;
            }
            Shows::Unknown(measure) => Some(measure),
            Shows::Nothing => None,
        };
        if main && measure.is_none() && is_screen_pass(ctx) {
            fallback::look_screen(ctx);
            ctx.frame.note_scene();
            ctx.frame.note_found("inverse of a camera matrix");
            return Some(DrawClass::Screen);
        }
        ctx.frame.note_flat();
        let is_behind = measure.is_none()
            && !several_viewports(&ctx.app, &ctx.shaders)
            && background::is_behind(&ctx.app, &ctx.drawable, &mut ctx.frame, &ctx.compat);
        let fills = if is_behind { fills_picture(ctx) } else { Ok(false) };
        let measure = measure.or(fills.err());
        if !is_behind || measure.is_some() {
            if inspection::is_recording() {
                let differ = several_viewports(&ctx.app, &ctx.shaders).then_some("its viewports differ");
                let small = (!main).then_some("its viewport is smaller than that of the scene");
                inspect(ctx, DrawClass::Flat, differ.or(small));
            }
            flat(ctx, changes, measure, issue);
            return None;
        }
        if fills == Ok(true) {
            return Some(DrawClass::Flat);
        }
        class = DrawClass::Behind;
    } else {
        ctx.frame.note_scene();
    }
    Some(if fallback::look_divided(ctx, class) { classify(ctx) } else { class })
}

/// Returns whether the next draw, which comes before the scene, fills the program's picture. `Err`:
/// not known yet, the draw must be measured.
fn fills_picture(ctx: &mut Context) -> Result<bool, Measure> {
    let number = ctx.frame.background_mut().count();
    if number > BACKDROPS || backdrop::tile_in_window(ctx).is_none() {
        return Ok(false);
    }
    coverage::fills_window(ctx, number)
}

/// Records a draw to the window for `cupola inspect`.
fn inspect(ctx: &mut Context, class: DrawClass, why: Option<&str>) {
    inspected::note(ctx, &Seen { class, sampled: 0, why });
}

/// Returns true if a flat draw computes points of the scene from its pixels and samples no image of
/// the scene.
fn is_screen_pass(ctx: &Context) -> bool {
    !several_viewports(&ctx.app, &ctx.shaders)
        && upload::holds_inverse(ctx)
        && sampling::sampled(&ctx.driver, &ctx.shaders, &ctx.view_copies) == 0
}

/// Target of draws to the window: the tiles of the views, and the program's own picture if it has a
/// tile of its own.
struct WindowCopies {
    session: Arc<Session>,
    own: Option<LowerLeftRect>,
    class: DrawClass,
    shown: Views,
}

impl CopyTarget for WindowCopies {
    fn prepare(&mut self, ctx: &mut Context, view: usize) -> Option<DrawClass> {
        let (tile, own_lens) = match self.own {
            Some(tile) if view >= self.session.views().len() => (tile, true),
            _ => self.session.tile(view),
        };
        if own_lens {
            own_window_space(ctx, tile);
            return self.session.turn().map(|_| self.class);
        }
        view_window_space(ctx, tile, ctx.draw.is_cut().then_some(tile));
        Some(self.class)
    }

    fn factors(&self, ctx: &mut Context, view: usize, _class: Option<DrawClass>) -> QueryScaling {
        let views = self.session.views().len();
        let primitives = 1.0 / (views + usize::from(self.own.is_some())) as f64;
        if self.session.turns().is_some() {
            return QueryScaling::ONCE;
        }
        let samples = if view >= views {
            0.0
        } else {
            scaling::scene_samples(&ctx.app, &mut ctx.frame, &mut ctx.queries, &self.session, false)
        };
        QueryScaling { samples, primitives }
    }

    fn issued(&mut self, ctx: &mut Context, view: usize) {
        if view >= self.session.views().len() {
            ctx.frame.note_primary_draw();
            return;
        }
        let Some(target) = ctx.drawable.target_mut() else { return };
        match ctx.draw.area(view).filter(|_| self.shown.bounded()) {
            Some(area) => target.issued_within(view, area),
            None => target.issued(view),
        }
    }

    fn left_out(&mut self, ctx: &mut Context, view: usize) {
        if let Some(target) = ctx.drawable.target_mut() {
            target.culled(view);
        }
    }
}

/// Issues a draw to the flat panel, with the program's own matrices and window space.
fn flat(ctx: &mut Context, changes: Changes, measure: Option<Measure>, mut issue: impl FnMut(&mut Context, &Gl)) {
    let gl = ctx.driver.gl;
    want_panel(ctx);
    let Some(target) = ctx.drawable.target() else { return };
    let tiles = target.flat_tiles();
    let mut repeats =
        Repeats::new(changes, &ctx.driver, &ctx.app, 0).counting(&ctx.share, &mut ctx.driver, &ctx.shaders);
    plain_program(ctx);
    let pictures = tiles.iter().flatten().count();
    if let (Some(measure), Some((tile, _))) = (measure, tiles.iter().flatten().next()) {
        own_window_space(ctx, *tile);
        coverage::measure_parts(ctx, measure, *tile, |ctx| repeats.unchanged(gl, false, || issue(ctx, gl)));
    }
    for (number, (tile, panel)) in tiles.iter().flatten().enumerate() {
        own_window_space(ctx, *tile);
        frag_coord::upload(&ctx.share, &ctx.driver, &ctx.draw, &ctx.shaders);
        let last = pictures == number + 1;
        let samples = if number == 0 { 1.0 } else { 0.0 };
        scaling::scale(ctx.driver.gl, &mut ctx.queries, QueryScaling { samples, primitives: 1.0 / pictures as f64 });
        let blending = panel.then(|| PanelBlend::begin(gl, &ctx.driver.known_state));
        repeats.around(gl, number, last, || match measure {
            Some(measure) if number == 0 => coverage::measure(ctx, measure, |ctx| issue(ctx, gl)),
            _ => issue(ctx, gl),
        });
        if let Some(blending) = blending.flatten() {
            blending.end(gl);
        }
    }
    ctx.frame.note_panel_draw();
}
