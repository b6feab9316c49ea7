//! Windows that a program leaves before it swaps them: for another window, or at its end.

use crate::intercept::gl::context::current::current;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::frame::{frame_number, frame_statistics, front_buffer, present};
use crate::intercept::gl::offscreen::inspected;
use crate::intercept::inspection::last_frame;
use crate::intercept::process::settings;

/// Corrects the window, since the program selects another window before it swaps this one.
pub fn leave(ctx: &mut Context) {
    if front_buffer::draws_to_front(&ctx.app, &ctx.drawable) {
        front_buffer::show(ctx, true);
    } else {
        present::correct(ctx);
        // A thread without a context may swap the frame later. It could read no pictures.
        if let (Some(settings), Some(window)) = (settings::settings(), ctx.drawable.window())
            && last_frame::is_last(settings, frame_number::next(window.handle()))
        {
            inspected::end_frame(&mut ctx.driver, &ctx.drawable, &mut ctx.view_copies);
            frame_statistics::keep(ctx, settings);
        }
    }
}

/// Stores a requested picture that the program no longer swaps, when the thread or the process
/// ends. Later the driver may be unable to draw.
pub fn at_end() {
    let Some(ctx) = current().filter(|c| !c.switched_off && c.frame.begun()) else { return };
    let next = ctx.drawable.window().map(|window| frame_number::next(window.handle()));
    if next.is_some() && settings::settings().is_some_and(|settings| settings.frames == next) {
        // Nobody is left at the end to whom a panic could be reported.
        let _ = crate::fence::guard(|| leave(ctx));
    }
}
