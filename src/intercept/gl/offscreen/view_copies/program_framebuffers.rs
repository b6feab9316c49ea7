//! The program's framebuffers, and those of Cupola that replace them.

use crate::backend::gl::driver::api::Gl;
use crate::backend::gl::objects::framebuffers::FramebufferBindings;
use crate::correct::{LowerLeftRect, Size};
use crate::intercept::gl::context::errors::drop_errors;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::offscreen::view_copies::{copy_count, leave, make_view_copy, possible};
use crate::intercept::gl::per_view::window_space::own_window_space;
use crate::intercept::gl::state::app::AppState;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::offscreen::framebuffers::{self, Framebuffer};
use crate::intercept::gl::state::offscreen::view_copies::ViewCopies;
use crate::intercept::process::log;

/// Returns the index of the program's draw framebuffer. Examines its attachments if they are not
/// known.
pub(in crate::intercept::gl::offscreen) fn look(ctx: &mut Context) -> usize {
    let name = ctx.app.draw_framebuffer();
    let index = ctx.view_copies.position(name).unwrap_or_else(|| {
        ctx.view_copies.framebuffers.push(Framebuffer::new(name));
        ctx.view_copies.framebuffers.len() - 1
    });
    if !ctx.view_copies.framebuffers[index].known {
        leave(ctx);
        ctx.driver.take_errors();
        let ViewCopies { framebuffers, images, .. } = &mut ctx.view_copies;
        framebuffers[index].examine(ctx.driver.gl, images);
        // The examination asks questions that some drivers do not know. Their errors have no
        // meaning.
        drop_errors(ctx.driver.gl);
    }
    index
}

/// Examines the attachments of the program's read framebuffer. No draw of this context has examined
/// it if compute shaders or another context write its images.
pub(in crate::intercept::gl::offscreen) fn look_at_read(
    driver: &mut Driver,
    app: &AppState,
    view_copies: &mut ViewCopies,
) {
    let name = app.read_framebuffer();
    let follows = view_copies.computes || view_copies.any();
    if !follows || name == 0 || name == app.draw_framebuffer() {
        return;
    }
    let index = view_copies.position(name).unwrap_or_else(|| {
        view_copies.framebuffers.push(Framebuffer::new(name));
        view_copies.framebuffers.len() - 1
    });
    if view_copies.framebuffers[index].known {
        return;
    }
    driver.take_errors();
    let ViewCopies { framebuffers, images, .. } = view_copies;
    // SAFETY: a framebuffer of the program; the bindings are put back.
    unsafe {
        let bindings = FramebufferBindings::save(driver.gl);
        driver.gl.bind_framebuffer(crate::backend::gl::driver::api::GL_DRAW_FRAMEBUFFER, name);
        framebuffers[index].examine(driver.gl, images);
        bindings.restore(driver.gl);
    }
    drop_errors(driver.gl);
}

/// Replaces the program's draw framebuffer, which is at `index`, by its view copy. Returns false if
/// it has none.
pub(in crate::intercept::gl::offscreen) fn enter(ctx: &mut Context, index: usize) -> bool {
    if ctx.view_copies.bound {
        return true;
    }
    if !ctx.view_copies.has_view_copies(&ctx.view_copies.framebuffers[index]) {
        return false;
    }
    if ctx.view_copies.framebuffers[index].view_copy == 0 && !make_framebuffer(ctx, index) {
        return false;
    }
    ctx.view_copies.bound = true;
    let view_copy = ctx.view_copies.framebuffers[index].view_copy;
    // SAFETY: a framebuffer of Cupola; `leave` binds the program's again.
    unsafe { ctx.driver.gl.bind_framebuffer(crate::backend::gl::driver::api::GL_DRAW_FRAMEBUFFER, view_copy) };
    true
}

/// Makes the framebuffer that replaces the one at `index`, with view copies of all attached images.
pub(in crate::intercept::gl::offscreen) fn make_framebuffer(ctx: &mut Context, index: usize) -> bool {
    let attached = ctx.view_copies.framebuffers[index].attachments;
    let places: [Option<usize>; framebuffers::COLOURS + 2] =
        attached.map(|name| name.and_then(|name| ctx.view_copies.images.iter().position(|image| image.name == name)));
    let mut complete = places.into_iter().flatten().all(|place| make_view_copy(ctx, place));
    ctx.driver.take_errors();
    if complete {
        let ViewCopies { framebuffers, images, .. } = &mut ctx.view_copies;
        let view_copy_of = |name| {
            let image = images.iter().find(|image| image.name == name);
            image.and_then(|image| image.view_copy.as_ref()).map(|view_copy| view_copy.renderbuffer)
        };
        complete = framebuffers[index].make_view_copy(ctx.driver.gl, view_copy_of);
        drop_errors(ctx.driver.gl);
    }
    if !complete {
        ctx.view_copies.framebuffers[index].obstacle = Some("the driver cannot make copies of it".into());
        log::once("a scene that the program draws off screen is shown flat: the driver cannot make copies of it");
    }
    complete
}

/// Runs a clear of a framebuffer of the program. `colours`: it clears colours. Returns false if the
/// framebuffer is drawn only once.
pub fn clear_with(ctx: &mut Context, colours: bool, issue: &dyn Fn(&Gl)) -> bool {
    if ctx.app.draw_framebuffer() == 0 || ctx.app.picking() || !possible(&ctx.drawable) {
        return false;
    }
    let index = look(ctx);
    // Clears of a part, or of the depth alone, as for a picture in a corner, do not remove the scene.
    let name = ctx.view_copies.framebuffers[index].images().next();
    let size = name.and_then(|name| ctx.view_copies.image(name)).map_or(Size::default(), |image| image.size);
    let part = ctx.app.scissor_test() && !ctx.app.scissor().contains(LowerLeftRect::of_size(size));
    ctx.view_copies.framebuffers[index].has_scene &= part || !colours;
    if !enter(ctx, index) {
        return false;
    }
    ctx.view_copies.changed(index);
    let gl = ctx.driver.gl;
    if !ctx.app.scissor_test() {
        ctx.set_scissor(None);
        issue(gl);
        return true;
    }
    let first = ctx.view_copies.framebuffers[index].images().next();
    let grid = first.and_then(|name| Some(ctx.view_copies.image(name)?.view_copy.as_ref()?.grid));
    for view in 0..copy_count(&ctx.drawable, &ctx.view_copies) {
        if let Some(grid) = grid {
            own_window_space(ctx, grid.tile(view));
            issue(gl);
        }
    }
    true
}
