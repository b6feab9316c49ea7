//! State of transform feedback. While it records, a draw must be recorded once, not once per view.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::list_recording;
use crate::intercept::gl::state::app::AppState;
use crate::intercept::gl::state::driver::Driver;

/// Notes whether transform feedback records. The driver answers this (OpenGL 4.0, OpenGL ES 3.0);
/// for older versions `recording` is the answer.
fn follow(driver: &Driver, app: &mut AppState, recording: bool) {
    let known = driver.profile.version >= if driver.profile.es { 30 } else { 40 };
    app.note_feedback(recording);
    if known {
        let (mut active, mut paused) = (0, 0);
        // SAFETY: each query writes one boolean.
        unsafe {
            driver.gl.get_booleanv(api::GL_TRANSFORM_FEEDBACK_ACTIVE, &mut active);
            driver.gl.get_booleanv(api::GL_TRANSFORM_FEEDBACK_PAUSED, &mut paused);
        }
        app.note_feedback(active != 0 && paused == 0);
    }
}

/// Runs a command of the program, which may be part of a display list. `recording`: whether
/// transform feedback records after this command.
fn command(ctx: &mut Context, recording: bool, issue: impl Fn(&Gl) + Send + Sync + 'static) {
    list_recording::now_or_later(ctx, move |ctx| {
        issue(ctx.driver.gl);
        follow(&ctx.driver, &mut ctx.app, recording);
    });
}

hooks! {
    "glBeginTransformFeedback" begin_transform_feedback(mode: u32) = |ctx, _gl|
        command(ctx, true, move |gl| gl.begin_transform_feedback(mode));
    "glEndTransformFeedback" end_transform_feedback() = |ctx, _gl| command(ctx, false, |gl| gl.end_transform_feedback());
    "glPauseTransformFeedback" pause_transform_feedback() = |ctx, _gl| command(ctx, false, |gl| gl.pause_transform_feedback());
    "glResumeTransformFeedback" resume_transform_feedback() = |ctx, _gl| command(ctx, true, |gl| gl.resume_transform_feedback());
    "glBindTransformFeedback" bind_transform_feedback(target: u32, name: u32) = |ctx, _gl|
        command(ctx, false, move |gl| gl.bind_transform_feedback(target, name));
}
