//! Windows that are left before they are swapped: for another window, or at the end.

use crate::intercept::gl::context::current::current;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::frame::{frame_number, frame_statistics, front_buffer, present};
use crate::intercept::gl::offscreen::inspected;
use crate::intercept::last_frame;
use crate::intercept::settings;

/// The program turns to another window before it swaps this one.
pub fn leave(ctx: &mut Context) {
    if front_buffer::draws_to_front(&ctx.app, &ctx.drawable) {
        front_buffer::show(ctx, true);
    } else {
        present::correct(ctx);
        // The frame may be swapped by a thread without a context, which can read nothing.
        if let (Some(settings), Some(window)) = (settings::settings(), &ctx.drawable.window)
            && last_frame::is_last(settings, frame_number::next(window.handle()))
        {
            inspected::end_frame(ctx);
            frame_statistics::keep(ctx, settings);
        }
    }
}

/// The thread or the process ends. A picture that was asked for and is not swapped any more is kept
/// now: later the driver may be unable to draw.
pub fn at_end() {
    let Some(ctx) = current().filter(|c| !c.switched_off && c.frame.begun) else { return };
    let next = ctx.drawable.window.as_ref().map(|window| frame_number::next(window.handle()));
    if next.is_some() && settings::settings().is_some_and(|settings| settings.frames == next) {
        // A panic at the end has nobody left to tell.
        let _ = crate::fence::guard(|| leave(ctx));
    }
}
