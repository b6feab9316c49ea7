//! Replaces a window's framebuffer by the atlas of the rig's views, and follows the window and the
//! rig file.

use crate::backend::gl::KnownState;
use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::context::errors::take_own_errors;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::own_calls::OwnCalls;
use crate::intercept::gl::offscreen::view_copies;
use crate::intercept::gl::per_view::panel::clear_transparent;
use crate::intercept::gl::state::drawable::default_framebuffer::DefaultFramebuffer;
use crate::intercept::gl::state::drawable::window::{Look, Window};
use crate::intercept::gl::state::drawable::window_config::Config;
use crate::intercept::process::live::{self, Live};
use crate::intercept::process::{log, settings};
use crate::rig::Rig;
use crate::runtime::session::{Extras, Session};

/// Replaces the window's framebuffer by the stand-in. If that fails, the program keeps the
/// window's.
pub fn attach(ctx: &mut Context, extras: Extras) {
    let Some(settings) = settings::settings() else { return };
    let Some(window) = ctx.drawable.window().cloned() else { return };
    if settings.rig.passthrough {
        return;
    }
    attach_now(&mut OwnCalls::without_messages(ctx), &window, settings, extras);
}

fn attach_now(ctx: &mut Context, window: &Window, settings: &settings::Settings, extras: Extras) {
    ctx.driver.take_errors();
    match DefaultFramebuffer::new(ctx, window, settings, extras) {
        Ok(target) => put(ctx, target),
        Err(error) => log::once(&format!("this window keeps its own picture: {error}")),
    }
    take_own_errors(&mut ctx.driver);
}

/// Uses the present rig in the same stand-in if nothing but the adaptation of the program's camera
/// is new, which has no effect on the views. Returns false if more is new.
fn follows_camera(target: &mut DefaultFramebuffer, live: Live) -> bool {
    if *target.rig != (Rig { camera: target.rig.camera, ..(*live.rig).clone() }) {
        return false;
    }
    target.session.set_camera(live.rig.camera);
    (target.rig, target.version) = (live.rig, live.version);
    true
}

/// Replaces the window's framebuffer by a new stand-in, and clears it.
fn put(ctx: &mut Context, target: DefaultFramebuffer) {
    ctx.frame.note_linked(target.backend.linked());
    ctx.drawable.put_target(Box::new(target));
    start_again(ctx);
}

/// Adapts the context to its stand-in, and clears that.
fn start_again(ctx: &mut Context) {
    adopt(ctx);
    let gl = ctx.driver.gl;
    // SAFETY: state of Cupola and of the stand-in framebuffer.
    unsafe {
        ctx.set_scissor(None);
        clear_everything(gl);
    }
}

/// Uses the present content of the rig file. Must be called between frames. If somebody watches, the
/// new rig is shown by a rough correction until it rests. It is planned in one frame, and its
/// shaders are made in the following ones, so that the program goes on meanwhile. A rig that was
/// begun is finished before a newer one, unless that is shown roughly. If the rig cannot be planned,
/// or its images cannot be made, the last one that could stays.
pub fn follow_rig(ctx: &mut Context) {
    let version = live::version();
    let is_settled =
        |target: &DefaultFramebuffer| target.version == version && target.next.is_none() && !target.has_rested();
    if ctx.drawable.target().is_none_or(is_settled) {
        return;
    }
    let ctx: &mut Context = &mut OwnCalls::without_messages(ctx);
    let (Some(settings), Some(window)) = (settings::settings(), ctx.drawable.window().cloned()) else { return };
    let Some(mut old) = ctx.drawable.take_target() else { return };
    ctx.driver.take_errors();
    let is_new = old.version != version;
    if is_new && old.next.is_none() && live::rig().is_some_and(|live| follows_camera(&mut old, live)) {
        view_copies::clear(ctx);
        ctx.drawable.put_target(old);
        start_again(ctx);
        take_own_errors(&mut ctx.driver);
        return;
    }
    let linked = old.backend.linked();
    if is_new && live::rig().is_some_and(|live| old.show_roughly(ctx.driver.gl, &live)) {
        ctx.frame.note_linked(old.backend.linked() - linked);
        ctx.drawable.put_target(old);
        take_own_errors(&mut ctx.driver);
        return;
    }
    // If the new rig fails, a newer one is still tried.
    let tried = old.next.as_ref().map_or(version, |(_, live)| live.version);
    let planned = match (live::rig(), &old.next) {
        (Some(live), None) => {
            let extras = ctx.frame.draw_count().extras(old.extras());
            old.look_ahead(ctx, &window, settings, live, extras)
        }
        _ => Ok(()),
    };
    let next = planned.and_then(|()| old.make_next(ctx, &window));
    ctx.frame.note_linked(old.backend.linked() - linked);
    match next {
        Ok(Some(new)) => {
            view_copies::clear(ctx);
            old.destroy(ctx.driver.gl);
            put(ctx, new);
        }
        Ok(None) => ctx.drawable.put_target(old),
        Err(error) => {
            log::once(&format!("the rig stays as it was: {error}"));
            (old.version, old.next) = (tried, None);
            if let Err(error) = old.leave_roughly_shown(ctx.driver.gl) {
                log::once(&format!("the correction of the earlier rig cannot be made again: {error}"));
            }
            ctx.drawable.put_target(old);
        }
    }
    take_own_errors(&mut ctx.driver);
}

/// Greatest number of times that Cupola gives a window the requested size again after the program
/// has changed it.
const MOST_RESIZED: u32 = 3;

/// Examines the window, and makes a new plan if the window's size is not that of the plan. Must be
/// called between frames. A window without a stand-in is not examined, since this would be a
/// question to the display in each frame.
pub fn follow_size(ctx: &mut Context) {
    if ctx.drawable.target().is_none() {
        ctx.drawable.note_occluded(false);
        return;
    }
    let Some(window) = ctx.drawable.window().cloned() else { return };
    let Look { mut size, occluded } = window.look();
    ctx.drawable.note_occluded(occluded);
    if let Some(wanted) = settings::settings().and_then(|settings| settings.window_size)
        && size != wanted
        && ctx.drawable.resized() < MOST_RESIZED
    {
        ctx.drawable.note_resized();
        window.resize(wanted);
        size = window.size();
    }
    if ctx.drawable.target().is_some_and(|t| t.size() != size) {
        let mut extras = Extras::default();
        if let Some(old) = ctx.drawable.take_target() {
            extras = old.extras();
            view_copies::clear(ctx);
            old.destroy(ctx.driver.gl);
        }
        ctx.frame.forget_viewports();
        attach(ctx, extras);
    }
}

/// Uses an earlier stand-in of a window again, if the window still has the same configuration.
pub fn resume(ctx: &mut Context, window: &Window, target: Box<DefaultFramebuffer>) {
    ctx.driver.take_errors();
    if target.config == Config::of_window(ctx.driver.gl, &ctx.driver.profile, window) {
        ctx.drawable.put_target(target);
        adopt(ctx);
    } else {
        target.destroy(ctx.driver.gl);
    }
    take_own_errors(&mut ctx.driver);
}

/// Continues a picture that another context of the group began.
pub fn take_over(ctx: &mut Context, mut target: Box<DefaultFramebuffer>) {
    ctx.driver.take_errors();
    match target.rehome(ctx.driver.gl) {
        Ok(()) => {
            ctx.drawable.put_target(target);
            adopt(ctx);
            ctx.frame.note_drawn();
        }
        Err(error) => {
            log::once(&format!("drawing of another context to this window is lost: {error}"));
            target.destroy(ctx.driver.gl);
            attach(ctx, Extras::default());
        }
    }
    take_own_errors(&mut ctx.driver);
}

/// Adapts the rest of the context to a new stand-in.
pub fn adopt(ctx: &mut Context) {
    view_copies::leave(ctx);
    ctx.driver.forget_window_space(u32::MAX);
    ctx.compat.projection.clear();
    ctx.queries.forget_views();
    ctx.frame.views_changed();
    let Some(target) = ctx.drawable.target() else { return };
    let framebuffer = target.framebuffer();
    let has_buffers = ctx.driver.profile.has_buffers();
    // SAFETY: binds the stand-in framebuffer where the program has bound its window.
    unsafe {
        if ctx.app.read_framebuffer() == 0 {
            ctx.driver.gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, ctx.drawable.window_for_reading());
            if has_buffers && !ctx.drawable.reads_elsewhere() {
                ctx.app.buffers().read_from_stand_in(ctx.driver.gl);
            }
        }
        if ctx.app.draw_framebuffer() == 0 {
            ctx.driver.gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, framebuffer);
            if has_buffers {
                ctx.app.buffers().draw_to_stand_in(ctx.driver.gl);
            }
        }
    }
}

/// Plans the views again, for a program with this number of `draws` in a frame if it is known, and
/// `without_panel`. Earlier drawing of the frame is lost.
pub fn plan_for(ctx: &mut Context, draws: Option<u32>, without_panel: bool) {
    let Some(old) = ctx.drawable.take_target() else { return };
    let before = old.extras();
    let extras = Extras { draws: draws.or(before.draws), panel: before.panel && !without_panel, ..before };
    let same = |new: &Session| new.views() == old.session.views() && extras.panel == before.panel;
    match old.session.with(extras) {
        Ok(new) if !same(&new) => {
            view_copies::clear(ctx);
            old.destroy(ctx.driver.gl);
            attach(ctx, extras);
        }
        Ok(_) => ctx.drawable.put_target(old),
        Err(error) => {
            log::once(&format!("the views are not adapted to what the program draws: {error}"));
            ctx.drawable.put_target(old);
        }
    }
}

/// # Safety
/// The stand-in framebuffer must be bound for drawing, with the scissor test off.
pub unsafe fn clear_everything(gl: &Gl) {
    clear_transparent(gl, &KnownState::default());
    let mut depth = 0u8;
    let mut stencil = 0;
    // SAFETY: the masks are put back.
    unsafe {
        gl.get_booleanv(api::GL_DEPTH_WRITEMASK, &mut depth);
        gl.get_integerv(api::GL_STENCIL_WRITEMASK, &mut stencil);
        gl.depth_mask(1);
        gl.stencil_mask(u32::MAX);
        gl.clear_bufferfi(api::GL_DEPTH_STENCIL, 0, 1.0, 0);
        gl.depth_mask(depth);
        gl.stencil_mask(stencil as u32);
    }
}
