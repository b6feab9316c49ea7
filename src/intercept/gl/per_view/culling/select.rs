//! Selection of the views that a draw is issued to.
//!
//! A draw is left out of a view only if it is proven that the view cannot show it. The proof needs
//! known vertices and known matrices: those of the fixed-function pipeline, or those of a shader
//! whose text was analysed (`shader::source::prover`). All other draws go to every view. Views
//! without any draw are not corrected either
//! ([`cleared_views`](crate::intercept::gl::state::drawable::cleared_views)).

use crate::correct::{LowerLeftRect, Size, TexelSpan};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::per_view::culling::bounds::{PicturePart, PlacedBox, extent, outside};
use crate::intercept::gl::per_view::culling::position::{self, View};
use crate::intercept::gl::state::app::AppState;
use crate::intercept::gl::state::compat::Compat;
use crate::intercept::gl::state::draw::bounds::Bounds;
use crate::intercept::gl::state::draw::draw_class::{Changes, DrawClass};
use crate::intercept::gl::state::draw::views::Views;
use crate::intercept::gl::state::frame::Frame;
use crate::runtime::session::Session;
use glam::DVec2;

/// True if the settings allow to leave out draws.
pub fn enabled() -> bool {
    crate::intercept::process::settings::settings().is_some_and(|s| s.cull)
}

/// Returns the views of the window that can show a draw of `class` with vertices within `bounds`.
/// `bounds` is called only if the box may matter.
///
/// A draw that no view shows still goes to the last view if it `changes` state, or if it is
/// recorded by transform feedback.
pub fn views(
    ctx: &mut Context,
    class: DrawClass,
    bounds: impl FnOnce(&mut Context) -> Bounds,
    changes: Changes,
) -> Views {
    let Some(known) = KnownDraw::of(ctx, class, bounds) else { return Views::ALL };
    let mut areas = ctx.draw.take_areas();
    areas.clear();
    let Some(target) = ctx.drawable.target() else { return Views::ALL };
    let session = &target.session;
    let count = session.views().len().min(64);
    let mut seen = 0;
    for index in 0..count {
        let (tile, _) = session.tile(index);
        let look = known.look(&ctx.compat, &ctx.frame, session, index, tile.size());
        seen |= u64::from(!look.unseen) << index;
        let part = look.view.filter(|_| !look.unseen).and_then(|view| extent(&view, &known.placed));
        areas.push(match part {
            _ if look.unseen => TexelSpan::NOTHING,
            Some(part) => texels(part, tile, known.spread),
            None => texels(PicturePart::ALL, tile, known.spread),
        });
    }
    ctx.draw.put_areas(areas);
    Views { seen: at_least(&ctx.app, seen, count, changes), bounded: true }
}

/// Does the same as [`views`] for a draw to a framebuffer of the program. There each view's tile is
/// the viewport.
pub fn views_off_screen(
    ctx: &mut Context,
    class: DrawClass,
    bounds: impl FnOnce(&mut Context) -> Bounds,
    changes: Changes,
) -> Views {
    let Some(known) = KnownDraw::of(ctx, class, bounds) else { return Views::ALL };
    let Some(session) = ctx.session() else { return Views::ALL };
    let count = session.views().len().min(64);
    let shows = |index: usize| !known.look(&ctx.compat, &ctx.frame, session, index, ctx.app.viewport().size()).unseen;
    let seen = (0..count).fold(0, |seen, index| seen | u64::from(shows(index)) << index);
    Views { seen: at_least(&ctx.app, seen, count, changes), bounded: false }
}

/// Returns the views that show a draw. If there are none but the draw must be issued, returns the
/// last view.
fn at_least(app: &AppState, seen: u64, count: usize, changes: Changes) -> u64 {
    let needed = seen == 0 && (changes != Changes::Nothing || app.feedback());
    if needed { 1 << (count.max(1) - 1) } else { seen }
}

/// Draw whose position is known.
struct KnownDraw {
    class: DrawClass,
    /// Box around the vertices, in the coordinates from which the views' own transformations start.
    placed: PlacedBox,
    /// Width, in pixels, of the border around a view in which drawing still affects the view.
    spread: f64,
}

/// What a view shows of a draw.
struct ViewLook {
    /// Transformation of the vertices to the view; `None`: not known.
    view: Option<View>,
    /// True if the view shows nothing of the draw.
    unseen: bool,
}

impl KnownDraw {
    fn of(ctx: &mut Context, class: DrawClass, bounds: impl FnOnce(&mut Context) -> Bounds) -> Option<Self> {
        let spread = ctx.draw.spread();
        // In a curved picture the corners of a box do not limit what lies between them.
        let curved = ctx.session().is_none_or(|session| session.views().iter().any(|view| view.curved.is_some()));
        if !enabled() || !spread.is_finite() || curved {
            return None;
        }
        let model = position::transform(ctx, class)?;
        let (low, high) = bounds(ctx).known()?;
        let placed = PlacedBox::of(&model, low, high);
        ctx.frame.note_bounded_draw();
        note_place(&mut ctx.frame, &ctx.compat, class, &placed);
        Some(Self { class, placed, spread })
    }

    /// Tests the view `index`, whose picture has `size` pixels.
    fn look(&self, compat: &Compat, frame: &Frame, session: &Session, index: usize, size: Size) -> ViewLook {
        let (_, own_lens) = session.tile(index);
        let view = position::of_view(compat, frame, self.class, index).filter(|_| !own_lens);
        let beside = 2.0 * self.spread / size.to_vector().max(DVec2::ONE);
        let unseen = view.as_ref().is_some_and(|view| outside(view, &self.placed, beside));
        ViewLook { view, unseen }
    }
}

/// Counts draws beside the program's own picture, and draws across its border.
fn note_place(frame: &mut Frame, compat: &Compat, class: DrawClass, placed: &PlacedBox) {
    if !frame.needs_places() {
        return;
    }
    let Some(own) = position::of_own_picture(compat, class) else { return };
    if outside(&own, placed, DVec2::ZERO) {
        frame.note_draw_beside();
    } else if extent(&own, placed).is_some_and(|part| !part.is_inside()) {
        frame.note_draw_at_border();
    }
}

/// Returns the texels of the atlas within `spread` of a part of a picture. They lie in the tile, or
/// so close to it that a wide line may reach them.
fn texels(part: PicturePart, tile: LowerLeftRect, spread: f64) -> TexelSpan {
    let along = |at: f64, start: i32, length: i32| {
        let length = f64::from(length);
        let inside = (0.5 * (1.0 + at) * length).clamp(0.0, length);
        f64::from(start) + inside
    };
    let across = |at: f64| along(at, tile.x, tile.width);
    let up = |at: f64| along(at, tile.y, tile.height);
    TexelSpan {
        left: (across(part.low.x) - spread).floor() as i32,
        bottom: (up(part.low.y) - spread).floor() as i32,
        right: (across(part.high.x) + spread).ceil() as i32,
        top: (up(part.high.y) + spread).ceil() as i32,
    }
}
