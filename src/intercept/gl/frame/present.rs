//! The end of a frame: correction into the window, counts, captures.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::context::current::{after_panic, current};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::own_calls::OwnCalls;
use crate::intercept::gl::frame::{frame_number, frame_statistics, in_turn, publish};
use crate::intercept::gl::framebuffer::target::attach::{follow_rig, follow_size};
use crate::intercept::gl::offscreen::{inspected, view_copies};
use crate::intercept::gl::state::app::AppState;
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::gl::state::drawable::window::Window;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::frame::Frame;
use crate::intercept::gl::state::frame::Times;
use crate::intercept::gl::state::frame::device_times::DeviceTimes;
use crate::intercept::gl::vertex_input::buffers;
use crate::intercept::inspection::last_frame;
use crate::intercept::process::ending;
use crate::intercept::process::nodes;
use crate::intercept::process::{log, settings};
use crate::lock::Lock;
use crate::runtime::frame_times::FrameTimes;
use crate::system::thread_time;

/// Returns true if the current context draws to `window`.
fn is_current(window: &Window) -> bool {
    current().and_then(|c| c.drawable.window()).is_some_and(|current| current.handle() == window.handle())
}

/// Returns true if the current context draws to `window` and Cupola corrects the drawing.
pub fn corrects(window: &Window) -> bool {
    is_current(window)
        && !ending::has_begun()
        && current().is_some_and(|c| !c.switched_off && c.drawable.target().is_some())
}

/// Runs a swap of `window` (`None`: the drawable is not a window), with the corrected picture in
/// its back buffer. Returns `left_out` without a swap if the views are drawn in turn and are not
/// complete.
pub fn swap<R>(window: Option<Window>, left_out: R, swap: impl FnOnce() -> R) -> R {
    if ending::has_begun() {
        return swap();
    }
    let ours = window.as_ref().is_some_and(is_current);
    let complete = !ours || before_swap();
    // The frames of a round of views in turn have the same time: only a complete frame advances the
    // clock.
    let shown = match &window {
        Some(window) if complete => nodes::end_frame(window.handle() as u64, || window.size()),
        _ => complete,
    };
    let answer = if shown { swap() } else { left_out };
    if ours {
        after_swap();
    } else if let Some(window) = window {
        frame_number::swapped_elsewhere(&window);
        attach_unshown(window);
    }
    answer
}

/// Attaches the current context to a window that counted as not shown, once it is swapped.
fn attach_unshown(window: Window) {
    let Some(ctx) = current().filter(|c| !c.switched_off) else { return };
    if !ctx.drawable.swaps(window.handle()) {
        return;
    }
    let reads_elsewhere = ctx.drawable.reads_elsewhere();
    if crate::fence::guard(|| ctx.attach(Some(window), reads_elsewhere)).is_none() {
        after_panic("a window that is shown later");
    }
}

/// Corrects the frame into the window's back buffer before a swap. Returns false if the window must
/// not be swapped.
fn before_swap() -> bool {
    let Some(ctx) = current().filter(|c| !c.switched_off) else { return true };
    let show = || {
        let complete = frame(ctx);
        if ctx.drawable.target().is_some_and(|t| !t.config().double_buffered) {
            // SAFETY: changes no state. The swap of a window with one buffer is a flush.
            in_window(&ctx.driver, &ctx.app, &ctx.drawable, |gl| unsafe { gl.flush() });
        }
        complete
    };
    let complete = crate::fence::guard(show);
    if complete.is_none() {
        after_panic("presenting a frame");
    }
    complete.unwrap_or(true)
}

/// Begins the next frame after a swap.
fn after_swap() {
    let Some(ctx) = current().filter(|c| !c.switched_off) else { return };
    if crate::fence::guard(|| next_frame(ctx)).is_none() {
        after_panic("beginning a frame");
    }
}

/// Ends a frame without a swap, for a program that draws to the front buffer.
pub fn show_front(ctx: &mut Context) {
    let double = ctx.drawable.target().is_some_and(|t| t.config().double_buffered);
    if double {
        // SAFETY: changes state of the window's own framebuffer, which the program never uses.
        in_window(&ctx.driver, &ctx.app, &ctx.drawable, |gl| unsafe { gl.draw_buffer(api::GL_FRONT_AND_BACK) });
    }
    let complete = frame(ctx);
    in_window(&ctx.driver, &ctx.app, &ctx.drawable, |gl| {
        // SAFETY: as above. Drivers show the front buffer only in a flush, and only while it is
        // bound.
        unsafe {
            gl.flush();
            if double {
                gl.draw_buffer(api::GL_BACK);
            }
        }
    });
    if let Some(window) = ctx.drawable.window().filter(|_| complete) {
        nodes::end_frame(window.handle() as u64, || window.size());
    }
    next_frame(ctx);
}

/// Runs `run` with the window's own framebuffer bound for drawing.
fn in_window(driver: &Driver, app: &AppState, drawable: &Drawable, run: impl FnOnce(&Gl)) {
    let Some(target) = drawable.target() else { return };
    let bound = if app.draw_framebuffer() == 0 { target.framebuffer() } else { app.draw_framebuffer() };
    // SAFETY: the binding is put back.
    unsafe { driver.gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, 0) };
    run(driver.gl);
    // SAFETY: as above.
    unsafe { driver.gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, bound) };
}

/// Corrects the views into the window. Allocates nothing.
pub(super) fn correct(ctx: &mut Context) {
    correct_now(&mut OwnCalls::begin(ctx));
}

fn correct_now(ctx: &mut Context) {
    let Some(target) = ctx.drawable.take_target() else { return };
    if !target.is_collected() {
        target.resolve(&ctx.driver, &ctx.app, &ctx.drawable, None);
    }
    let cleared = target.views_cleared();
    let (texture, outputs) = (target.texture(), target.outputs());
    let errors = target.backend().errors();
    let pending =
        target.backend().present_changed(ctx.driver.gl, texture, outputs, cleared.as_ref(), &ctx.driver.known_state);
    if pending != api::GL_NO_ERROR {
        ctx.driver.note_error(pending);
    }
    let failed = target.backend().errors() > errors;
    ctx.drawable.put_target(target);
    if ctx.frame.note_correction(failed) >= MOST_FAILED_CORRECTIONS {
        log::once("this window keeps its own picture: the driver reports an error for each correction");
        ctx.leave_alone();
    }
}

/// Number of failed corrections in a row after which Cupola leaves the window alone.
const MOST_FAILED_CORRECTIONS: u32 = 2;

/// Logs that a program draws everything flat, that it leaves out objects beside its own picture, or
/// that its window is too small.
fn look_for_a_scene(ctx: &mut Context) {
    let (mut flat_program, mut culling_program, mut small_window) = ctx.frame.take_program_checks();
    if let Some(session) = ctx.drawable.session() {
        let (counts, has_scene) = (ctx.frame.counts(), ctx.frame.shows_scene());
        let (draws, missing) = (counts.draws_seen, counts.missing);
        let text = flat_program.look(draws, has_scene, session, &missing, || frame_statistics::off_screen(ctx));
        text.into_iter().for_each(log::once);
    }
    if let Some(session) = ctx.drawable.session() {
        let text = culling_program.look(ctx.frame.counts().places, ctx.frame.lens().as_ref(), session);
        text.iter().for_each(|text| log::once(text));
        small_window.look(session);
    }
    ctx.frame.put_program_checks((flat_program, culling_program, small_window));
}

/// Corrects the frame, and stores statistics and captures. Returns false if the views are not
/// complete.
fn frame(ctx: &mut Context) -> bool {
    if !in_turn::end_frame(ctx) {
        return false;
    }
    ctx.frame.note_presented();
    look_for_a_scene(ctx);
    let Some(settings) = settings::settings() else {
        correct(ctx);
        return true;
    };
    let number = ctx.drawable.window().map_or(ctx.frame.counts().frames, |window| frame_number::count(window.handle()));
    let last = last_frame::is_last(settings, number);
    let kept = last || settings.frames.is_none();
    let published = publish::wants(ctx);
    if is_occluded(&ctx.drawable) && !(kept && last_frame::wants_outputs(settings)) && !published {
        ctx.frame.note_hidden();
    } else {
        measure(&ctx.driver, &mut ctx.frame, |gl, _, device| device.drawn(gl));
        let before = ctx.frame.is_timed().then(thread_time);
        correct(ctx);
        measure(&ctx.driver, &mut ctx.frame, |gl, times, device| {
            device.corrected(gl);
            times.correction.add(thread_time().saturating_sub(before.unwrap_or_default()));
        });
    }
    if published {
        publish::frame(ctx, number);
    }
    if last {
        publish::hand_on(ctx, true);
    }
    if kept {
        inspected::end_frame(&mut ctx.driver, &ctx.drawable, &mut ctx.view_copies);
        frame_statistics::keep(ctx, settings);
    }
    if last {
        last_frame::end_program();
    }
    true
}

/// Returns true if the window was occluded after the last swap and still is. So a visible window
/// costs one question per frame, and a window that becomes visible again is corrected at once.
fn is_occluded(drawable: &Drawable) -> bool {
    drawable.occluded() && drawable.window().is_some_and(|window| window.look().occluded)
}

/// Measures times if the settings request them.
fn measure(driver: &Driver, frame: &mut Frame, act: impl FnOnce(&Gl, &mut FrameTimes, &mut DeviceTimes)) {
    if let Some(Times { shared, device }) = frame.times_mut() {
        act(driver.gl, &mut shared.locked(), device);
    }
}

fn next_frame(ctx: &mut Context) {
    publish::hand_on(ctx, false);
    let inspects = settings::settings().filter(|settings| settings.inspect.is_some());
    if let (Some(settings), Some(window)) = (inspects, ctx.drawable.window()) {
        last_frame::begin(settings, frame_number::next(window.handle()));
    }
    if !ctx.frame.is_timed() && settings::settings().is_some_and(settings::Settings::needs_statistics) {
        let device = DeviceTimes::new(ctx.driver.gl, &ctx.driver.profile);
        ctx.frame.begin_timing(device);
    }
    measure(&ctx.driver, &mut ctx.frame, |gl, times, device| {
        times.end_frame();
        device.begin(gl, times);
    });
    ctx.frame.end();
    view_copies::end_frame(ctx);
    buffers::of(&ctx.share).end_frame();
    ctx.vertex_input.storage_changed();
    follow_size(ctx);
    follow_rig(ctx);
}
