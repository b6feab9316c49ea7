//! Calls that set the part of a context's state that Cupola follows ([`KnownState`]). Draws and
//! corrections then need not ask the driver for it.
//!
//! State that a display list may set is unknown after the list ran. State that `glPopAttrib`
//! restores is known if the restored value equals the one before.

use crate::backend::gl::KnownState;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;

/// Notes a call of the program that sets followed state. `note` stores the new values; it is not
/// called if the call goes into a list or may be refused.
pub fn note(ctx: &mut Context, note: impl FnOnce(&KnownState)) {
    if ctx.compiling() {
        ctx.lists.note_state();
    } else if ctx.takes_calls() {
        note(&ctx.driver.known_state);
    } else {
        ctx.driver.known_state.forget();
    }
}

/// Defines hooks of calls that are passed on to the driver and then noted.
macro_rules! noted {
    ($( $name:literal $method:ident ( $($p:ident : $t:ty),* ) = |$known:ident| $note:expr; )*) => {
        hooks! {
            $( $name $method($($p: $t),*) = |ctx, gl| {
                gl.$method($($p),*);
                note(ctx, |$known| $note);
            }; )*
        }
    };
}

noted! {
    "glColorMask" color_mask(red: u8, green: u8, blue: u8, alpha: u8) = |known| known.note_mask([red, green, blue, alpha]);
    "glColorMaski" color_maski(index: u32, red: u8, green: u8, blue: u8, alpha: u8) = |known| known.forget_masks();
    "glBlendFunc" blend_func(source: u32, destination: u32) = |known| known.note_blending([source, destination, source, destination]);
    "glBlendFuncSeparate" blend_func_separate(source: u32, destination: u32, source_alpha: u32, destination_alpha: u32) = |known|
        known.note_blending([source, destination, source_alpha, destination_alpha]);
    "glBlendFunci" blend_funci(buffer: u32, source: u32, destination: u32) = |known| known.forget_blending();
    "glBlendFuncSeparatei" blend_func_separatei(buffer: u32, source: u32, destination: u32, source_alpha: u32, destination_alpha: u32) = |known|
        known.forget_blending();
    "glClearColor" clear_color(red: f32, green: f32, blue: f32, alpha: f32) = |known| known.note_clear_color(Some([red, green, blue, alpha]));
    "glClearColorIiEXT" clear_color_ii_ext(red: i32, green: i32, blue: i32, alpha: i32) = |known| known.note_clear_color(None);
    "glClearColorIuiEXT" clear_color_iui_ext(red: u32, green: u32, blue: u32, alpha: u32) = |known| known.note_clear_color(None);
    "glClearDepth" clear_depth(depth: f64) = |known| known.forget_clear_depth();
    "glClearDepthf" clear_depthf(depth: f32) = |known| known.forget_clear_depth();
    "glClearDepthdNV" clear_depthd_nv(depth: f64) = |known| known.forget_clear_depth();
}
