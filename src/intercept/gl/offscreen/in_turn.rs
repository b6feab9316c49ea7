//! Off-screen drawing if the views are drawn in turn: to the program's own images, with the lens of
//! the present view.
//!
//! There are no copies. Everything that a program computes from its images belongs to the present
//! view, so images need not be followed. Only two facts are needed: which draws are the scene, and
//! which flat draw to the window shows it.

use crate::backend::gl::driver::api::Gl;
use crate::correct::LowerLeftRect;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::offscreen::inspected::{self, Seen};
use crate::intercept::gl::offscreen::view_copies::look;
use crate::intercept::gl::offscreen::{coverage, sampling};
use crate::intercept::gl::per_view::classify::classify_by_projection;
use crate::intercept::gl::per_view::issue::{Copies, CopyTarget, issue};
use crate::intercept::gl::per_view::window_space::{own_window_space, program_window_space};
use crate::intercept::gl::shader::camera_matrices::upload;
use crate::intercept::gl::state::draw::draw_class::{Changes, DrawClass};
use crate::intercept::gl::state::draw::views::Views;
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::gl::state::drawable::default_framebuffer::DefaultFramebuffer;
use crate::intercept::gl::state::offscreen::displayed::Shows;
use crate::intercept::gl::state::offscreen::images::Set;
use crate::intercept::scene::query_scaling::QueryScaling;
use crate::intercept::scene::viewport;
use crate::runtime::Session;

/// Issues a draw to a framebuffer of the program. Returns false if the caller must issue it
/// unchanged.
pub fn draw(ctx: &mut Context, changes: Changes, draw: &mut dyn FnMut(&mut Context, &Gl)) -> bool {
    let Some((view, views, window)) = ctx.session().and_then(|s| Some((s.turn()?, s.views().len(), s.window()))) else {
        return false;
    };
    if ctx.app.draw_framebuffer() == 0 || ctx.app.picking() || ctx.app.discard() || ctx.app.feedback() {
        return false;
    }
    // Needed because flat draws to the window are compared with the attached images.
    look(ctx);
    let class = match classify_by_projection(ctx) {
        DrawClass::Flat if upload::holds_inverse(ctx) => DrawClass::Screen,
        DrawClass::Flat => return false,
        class if viewport::has_shape_of_window(ctx.app.viewport().size(), window) => class,
        _ => return false,
    };
    ctx.frame.note_scene_off_screen();
    inspected::note(ctx, &Seen { class, sampled: 0, why: None });
    let copies = Copies { changes, views, count: views, shown: Views::only(view) };
    issue(ctx, &copies, &mut OwnImages { class, window: None }, draw);
    true
}

/// Determines what a flat draw to the window shows. `main`: the draw has the main viewport.
pub fn look_at_window(ctx: &mut Context, main: bool) -> Shows {
    if main && upload::holds_inverse(ctx) {
        return whole(ctx, 0);
    }
    let sampled = if main { sampling::sampled(&ctx.driver, &ctx.shaders, &ctx.view_copies) } else { 0 };
    if !main || (sampled == 0 && !ctx.frame.scene_off_screen()) {
        return Shows::Nothing;
    }
    let samples = ctx.drawable.target().map_or(0, |target| target.config().samples);
    match coverage::fills_viewport(ctx, samples) {
        Err(measure) => Shows::Unknown(measure),
        Ok(true) => whole(ctx, sampled),
        Ok(false) => Shows::Nothing,
    }
}

/// The draw shows images in the whole window.
fn whole(ctx: &Context, sampled: Set) -> Shows {
    coverage::window(&ctx.drawable).map_or(Shows::Nothing, |window| Shows::Pictures(sampled, window.whole()))
}

/// Issues a draw to the window that shows a scene which was drawn off screen.
pub fn show(ctx: &mut Context, changes: Changes, draw: &mut dyn FnMut(&mut Context, &Gl)) {
    let Some((view, views)) = ctx.session().and_then(|session| Some((session.turn()?, session.views().len()))) else {
        return;
    };
    let window = ctx.drawable.target().and_then(DefaultFramebuffer::own_picture);
    let copies = Copies { changes, views, count: views, shown: Views::only(view) };
    issue(ctx, &copies, &mut OwnImages { class: DrawClass::Screen, window }, draw);
}

/// An image of the program, or the picture of its window.
struct OwnImages {
    class: DrawClass,
    window: Option<LowerLeftRect>,
}

impl CopyTarget for OwnImages {
    fn prepare(&mut self, ctx: &mut Context, _view: usize) -> Option<DrawClass> {
        match self.window {
            Some(tile) => own_window_space(ctx, tile),
            None => program_window_space(&mut ctx.draw),
        }
        Some(self.class)
    }

    fn factors(&self, _ctx: &mut Context, _view: usize, _class: Option<DrawClass>) -> QueryScaling {
        QueryScaling::ONCE
    }

    fn issued(&mut self, ctx: &mut Context, view: usize) {
        if let Some(target) = ctx.drawable.target_mut().filter(|_| self.window.is_some()) {
            target.issued(view);
        }
    }
}

/// True if the views are drawn in turn.
pub fn is_on(drawable: &Drawable) -> bool {
    drawable.session().and_then(Session::turns).is_some()
}
