//! Transform feedback: whether it is recording, since a draw must be recorded once, not once per view.

use super::context::Context;
use super::hook::hooks;
use crate::backend::gl::api;

/// Asks the driver where it knows (OpenGL 4.0, OpenGL ES 3.0); elsewhere `recording` is what it is.
fn follow(ctx: &mut Context, recording: bool) {
    let known = ctx.profile.version >= if ctx.profile.es { 30 } else { 40 };
    ctx.feedback = recording;
    if known {
        let (mut active, mut paused) = (0, 0);
        // SAFETY: each query writes one boolean.
        unsafe {
            ctx.gl.get_booleanv(api::GL_TRANSFORM_FEEDBACK_ACTIVE, &mut active);
            ctx.gl.get_booleanv(api::GL_TRANSFORM_FEEDBACK_PAUSED, &mut paused);
        }
        ctx.feedback = active != 0 && paused == 0;
    }
}

hooks! {
    "glBeginTransformFeedback" begin_transform_feedback(mode: u32) = |ctx, gl| {
        gl.begin_transform_feedback(mode);
        follow(ctx, true);
    };
    "glEndTransformFeedback" end_transform_feedback() = |ctx, gl| {
        gl.end_transform_feedback();
        follow(ctx, false);
    };
    "glPauseTransformFeedback" pause_transform_feedback() = |ctx, gl| {
        gl.pause_transform_feedback();
        follow(ctx, false);
    };
    "glResumeTransformFeedback" resume_transform_feedback() = |ctx, gl| {
        gl.resume_transform_feedback();
        follow(ctx, true);
    };
    "glBindTransformFeedback" bind_transform_feedback(target: u32, name: u32) = |ctx, gl| {
        gl.bind_transform_feedback(target, name);
        follow(ctx, false);
    };
}
