//! Target of draws to the per-view copies off screen.

use crate::backend::gl::driver::api::Gl;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::per_view::issue::{Copies, CopyTarget, issue};
use crate::intercept::gl::queries::scaling;
use crate::intercept::gl::state::draw::draw_class::{Changes, DrawClass};
use crate::intercept::gl::state::draw::views::Views;
use crate::intercept::scene::query_scaling::QueryScaling;
use crate::runtime::session::Session;
use std::sync::Arc;

/// Per-view copies. `prepare` sets the window space and returns the class of the draw.
struct CopiesPerView<F> {
    session: Option<Arc<Session>>,
    share: f64,
    /// Class that `prepare` returned for the present view.
    class: DrawClass,
    prepare: F,
}

/// Issues a draw for each of `count` views that `shown` contains. Views beyond the number of the
/// rig's views are the program's own picture.
pub fn each_view(
    ctx: &mut Context,
    changes: Changes,
    count: usize,
    shown: Views,
    draw: &mut dyn FnMut(&mut Context, &Gl),
    prepare: impl Fn(&mut Context, usize) -> DrawClass,
) {
    let session =
        ctx.drawable.target().map(|target| target.session.clone()).or_else(|| ctx.drawable.borrowed_session().cloned());
    let views = session.as_ref().map_or(0, |session| session.views().len());
    let mut target = CopiesPerView { session, share: 1.0 / count.max(1) as f64, class: DrawClass::Flat, prepare };
    issue(ctx, &Copies { changes, views, count, shown }, &mut target, draw);
}

impl<F: Fn(&mut Context, usize) -> DrawClass> CopyTarget for CopiesPerView<F> {
    fn prepare(&mut self, ctx: &mut Context, view: usize) -> Option<DrawClass> {
        self.class = (self.prepare)(ctx, view);
        let own = self.session.as_ref().map_or(0, |session| session.views().len());
        (view < own).then_some(self.class)
    }

    fn factors(&self, ctx: &mut Context, _view: usize, class: Option<DrawClass>) -> QueryScaling {
        let samples = match (self.class, &self.session) {
            (DrawClass::FixedScene | DrawClass::Scene(_), Some(_)) if class.is_none() => 0.0,
            (DrawClass::FixedScene | DrawClass::Scene(_), Some(session)) => {
                scaling::scene_samples(&ctx.app, &mut ctx.frame, &mut ctx.queries, session, true)
            }
            _ => self.share,
        };
        QueryScaling { samples, primitives: self.share }
    }
}
