//! Programs that show what they draw without a swap: windows with one buffer, and drawing to the front.
//!
//! Such a program ends a picture with `glFlush` or `glFinish`. Each is a frame for us if something was
//! drawn since the last one.

use crate::backend::gl::api;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use std::time::{Duration, Instant};

/// How often flushes were answered lately.
#[derive(Default)]
pub struct Pace {
    begun: Option<Instant>,
    shown: u32,
}

/// Flushes are counted over this long.
const SPAN: Duration = Duration::from_millis(16);

/// More flushes in a span than this are those of a program that flushes after each primitive.
const MOST: u32 = 8;

impl Pace {
    /// Whether one more frame may be shown `now`.
    fn allows(&mut self, now: Instant) -> bool {
        if self.begun.is_none_or(|begun| now.duration_since(begun) > SPAN) {
            *self = Self { begun: Some(now), shown: 0 };
        }
        self.shown += 1;
        self.shown <= MOST
    }
}

/// Whether what is drawn is meant to be seen without a swap.
pub fn draws_to_front(ctx: &Context) -> bool {
    let front = matches!(
        ctx.believed.draw_buffer,
        api::GL_FRONT
            | api::GL_FRONT_LEFT
            | api::GL_FRONT_RIGHT
            | api::GL_FRONT_AND_BACK
            | api::GL_LEFT
            | api::GL_RIGHT
    );
    ctx.target.as_ref().is_some_and(|t| front || !t.config().double_buffered)
}

/// The program wants to see what it drew. `finally`: it waits for it, so the picture is never left out.
pub fn show(ctx: &mut Context, finally: bool) {
    let drawing = ctx.compiling() || ctx.immediate.under_way() || ctx.picking;
    if ctx.frame_begun && !drawing && draws_to_front(ctx) && (ctx.pace.allows(Instant::now()) || finally) {
        crate::intercept::gl::frame::present::show_front(ctx);
    }
}

/// As [`show`], for the window systems' calls that wait for OpenGL.
pub fn show_current() {
    let Some(ctx) = crate::intercept::gl::context::current::current().filter(|c| !c.switched_off) else { return };
    if crate::fence::guard(|| show(ctx, true)).is_none() {
        crate::intercept::gl::context::current::after_panic("showing the front buffer");
    }
}

hooks! {
    "glFlush" flush() = |ctx, gl| {
        show(ctx, false);
        gl.flush();
    };
    "glFinish" finish() = |ctx, gl| {
        show(ctx, true);
        gl.finish();
    };
}

#[cfg(test)]
mod tests {
    use super::{MOST, Pace, SPAN};
    use std::time::Instant;

    #[test]
    fn a_flush_after_each_primitive_is_slowed_down_and_a_single_one_never() {
        let start = Instant::now();
        let mut pace = Pace::default();
        assert_eq!((0..1000).filter(|_| pace.allows(start)).count(), MOST as usize);
        assert!((1..50).all(|i| pace.allows(start + (SPAN * 2) * i)));
    }
}
