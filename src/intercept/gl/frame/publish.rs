//! Finished pictures for other processes: what is read of a frame, and when.

use crate::backend::gl::driver::api;
use crate::correct::LowerLeftRect;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::own_calls::OwnCalls;
use crate::intercept::gl::context::read_pixels::while_reading;
use crate::intercept::gl::state::driver::profile::reads_to_memory;
use crate::intercept::gl::state::frame::publishing::{Publishing, Way};
use crate::intercept::process::publishing;
use crate::intercept::process::{log, settings};
use crate::ring::Format;
use std::sync::Arc;

/// Returns true if frames of the context's window are published.
pub fn wants(ctx: &Context) -> bool {
    ctx.drawable.window().is_some_and(|window| publishing::wants(window.handle() as u64, shown_version(ctx)))
}

/// Returns the version of the rig that the context's window shows.
fn shown_version(ctx: &Context) -> u64 {
    ctx.drawable.target().map_or(0, |target| target.version)
}

/// Publishes the frame that was just corrected: starts reading its pictures, and publishes the
/// pictures whose reading is complete.
pub fn frame(ctx: &mut Context, number: u64) {
    let ctx: &mut Context = &mut OwnCalls::begin(ctx);
    let Some(mut publishing) = fitting(ctx) else { return };
    let gl = ctx.driver.gl;
    publishing.publish(gl, false);
    if !publishing.targets.is_empty()
        && let Some(target) = ctx.drawable.target()
    {
        let cleared = target.views_cleared();
        let (texture, known) = (target.texture(), &ctx.driver.known_state);
        let pending = target.backend().present_changed(gl, texture, &publishing.targets, cleared.as_ref(), known);
        if pending != api::GL_NO_ERROR {
            ctx.driver.note_error(pending);
        }
    }
    let version = shown_version(ctx);
    let stamp = publishing::stamp(number, version);
    while_reading(gl, 0, || publishing.read(gl, stamp));
    // Somebody waits for the first picture of a changed rig: it does not wait for the next frame.
    let is_awaited = publishing.version.replace(version).is_some_and(|before| before != version);
    if publishing::waits() || is_awaited {
        publishing.publish(gl, true);
    }
    ctx.frame.put_publishing(publishing);
}

/// Publishes the pictures that the device has copied meanwhile. `all`: waits for all of them.
pub fn hand_on(ctx: &mut Context, all: bool) {
    if let Some(publishing) = ctx.frame.publishing_mut() {
        publishing.publish(ctx.driver.gl, all);
    }
}

/// Returns the reader for the window's present size and outputs. `None`: nothing is published.
fn fitting(ctx: &mut Context) -> Option<Box<Publishing>> {
    let gl = ctx.driver.gl;
    let session = ctx.drawable.target().map(|target| &target.session);
    let window = match session {
        Some(session) => session.window(),
        None => ctx.drawable.window()?.size(),
    };
    if let Some(publishing) = ctx.frame.take_publishing() {
        if publishing.session.as_ref().map(Arc::as_ptr) == session.map(Arc::as_ptr) && publishing.window == window {
            return Some(publishing);
        }
        publishing.destroy(gl);
    }
    let profile = &ctx.driver.profile;
    let later = profile.version >= if profile.es { 30 } else { 32 };
    // Corrected pictures outside of the window are opaque, and so is a window without alpha.
    let is_opaque = ctx.drawable.target().is_some_and(|target| target.config().alpha_bits == 0);
    let way = match later {
        _ if is_opaque && reads_to_memory(gl, profile) => Way::Direct,
        true => Way::Buffers,
        false => Way::Copied,
    };
    // OpenGL ES has no such canvas, and reads no such pixels.
    let is_deep = publishing::is_deep() && !profile.es;
    if publishing::is_deep() && profile.es {
        log::once("the published pictures of OpenGL ES have 8 bits for each colour");
    }
    let format = (way, if is_deep { Format::Rgba16 } else { Format::Rgba8 });
    let new = match session {
        None => {
            let whole = ("window".to_owned(), LowerLeftRect::of_size(window));
            Publishing::new(gl, (None, window), std::iter::once(whole), std::iter::empty(), format)
        }
        Some(session) => {
            let (rig, plan) = (session.rig(), session.plan());
            let places: Vec<LowerLeftRect> = session.viewports().collect();
            let own_size = settings::settings().is_some_and(|settings| settings.offscreen);
            let beside = (rig.outputs.len()..plan.passes.len()).filter(|index| plan.passes[*index].here);
            let shown = rig.published_outputs();
            // The window has 8 bits, so pictures with more are drawn again outside of it.
            let (in_window, elsewhere): (Vec<_>, Vec<_>) = if own_size || is_deep {
                (Vec::new(), shown.chain(beside).collect())
            } else {
                (shown.collect(), beside.collect())
            };
            let named = |index: usize| plan.passes[index].name.clone();
            let size = |index: usize| match places.get(index) {
                Some(LowerLeftRect { width, height, .. }) if !own_size => {
                    (u32::try_from(*width).unwrap_or(0), u32::try_from(*height).unwrap_or(0))
                }
                _ => plan.passes[index].size,
            };
            Publishing::new(
                gl,
                (Some(Arc::clone(session)), window),
                in_window.into_iter().map(|index| (named(index), places[index])),
                elsewhere.into_iter().map(|index| (named(index), index, size(index))),
                format,
            )
        }
    };
    Some(Box::new(new)).filter(|new| !new.is_empty())
}
