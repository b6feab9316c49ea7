//! Framebuffers by name (OpenGL 4.5). Here too the stand-in image replaces the program's
//! framebuffer 0.
//!
//! For the window's framebuffer Cupola uses the older command, which works on the bound
//! framebuffer, and then restores the binding. Other framebuffers use the newer command, except if
//! the scissor has an effect: while the window is bound, the scissor is that of a tile.

use crate::backend::gl::driver::api;
use crate::correct::BlitRect;
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::context::list_recording;
use crate::intercept::gl::framebuffer::commands::{bindings, blits, clears, draw_buffers, window_answers};
use crate::intercept::gl::framebuffer::target::unsampled_areas::Cleared;
use crate::intercept::gl::offscreen::view_copies;
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::gl::state::driver::Driver;

/// Runs `run` with the program's framebuffers bound for drawing and reading; `None`: this binding
/// does not change.
pub(super) fn bound<R>(
    ctx: &mut Context,
    draw: Option<u32>,
    read: Option<u32>,
    run: impl FnOnce(&mut Context) -> R,
) -> R {
    let (own_draw, own_read) = (ctx.app.draw_framebuffer(), ctx.app.read_framebuffer());
    let change = |ctx: &mut Context, target: u32, from: u32, to: u32| {
        if from != to {
            bindings::bind(ctx, target, to);
        }
    };
    // The driver performs these commands at once while the program compiles a display list. What
    // Cupola calls for them must not become part of the list.
    let compiling = list_recording::pause(&ctx.share, &ctx.driver, &mut ctx.lists);
    change(ctx, api::GL_DRAW_FRAMEBUFFER, own_draw, draw.unwrap_or(own_draw));
    change(ctx, api::GL_READ_FRAMEBUFFER, own_read, read.unwrap_or(own_read));
    let answer = run(ctx);
    let (draw, read) = (ctx.app.draw_framebuffer(), ctx.app.read_framebuffer());
    change(ctx, api::GL_DRAW_FRAMEBUFFER, draw, own_draw);
    change(ctx, api::GL_READ_FRAMEBUFFER, read, own_read);
    if compiling {
        list_recording::go_on(&ctx.share, &ctx.driver, &mut ctx.lists, None);
    }
    answer
}

/// True if `name` is the window, and the window has a stand-in image.
pub(super) fn is_window(drawable: &Drawable, name: u32) -> bool {
    name == 0 && drawable.target().is_some()
}

/// Returns the driver's name of a framebuffer of the program.
pub(super) fn real(drawable: &Drawable, name: u32) -> u32 {
    drawable.target().filter(|_| name == 0).map_or(name, |target| target.framebuffer())
}

/// True if the name is the window, or an object that exists: then a call to bind it creates no
/// object.
fn exists(driver: &Driver, name: u32) -> bool {
    // SAFETY: a question about a name.
    name == 0 || unsafe { driver.gl.is_framebuffer(name) } != 0
}

/// Defines all hooks of this file. The hooks of clears differ only in the types of their values, so
/// each has one line.
macro_rules! named_framebuffer_hooks {
    ($( $name:literal $method:ident $bound:ident ( $($p:ident: $t:ty),* ) by $how:ident; )*) => {
        hooks! {
            $( $name $method(framebuffer: u32, buffer: u32, $($p: $t),*) = |ctx, gl| {
                if ctx.drawable.target().is_none() || !exists(&ctx.driver, framebuffer) {
                    gl.$method(framebuffer, buffer, $($p),*);
                } else if ctx.compiling() {
                    // The older command would become part of the display list.
                    gl.$method(real(&ctx.drawable, framebuffer), buffer, $($p),*);
                } else {
                    bound(ctx, Some(framebuffer), None, |ctx| {
                        _ = clears::clear_with(ctx, Cleared::$how(buffer, $($p),*), |gl| gl.$bound(buffer, $($p),*));
                    });
                }
            }; )*
            "glNamedFramebufferDrawBuffer" named_framebuffer_draw_buffer(framebuffer: u32, buffer: u32) = |ctx, gl| {
                if is_window(&ctx.drawable, framebuffer) {
                    bound(ctx, Some(0), None, |ctx| draw_buffers::select_draw_buffer(ctx, buffer));
                } else {
                    view_copies::forget(ctx, framebuffer);
                    gl.named_framebuffer_draw_buffer(framebuffer, buffer);
                }
            };
            "glNamedFramebufferDrawBuffers" named_framebuffer_draw_buffers(framebuffer: u32, count: i32, buffers: *const u32) = |ctx, gl| {
                if is_window(&ctx.drawable, framebuffer) {
                    bound(ctx, Some(0), None, |ctx| draw_buffers::select_draw_buffers(ctx, count, buffers));
                } else {
                    view_copies::forget(ctx, framebuffer);
                    gl.named_framebuffer_draw_buffers(framebuffer, count, buffers);
                }
            };
            "glNamedFramebufferReadBuffer" named_framebuffer_read_buffer(framebuffer: u32, buffer: u32) = |ctx, gl| {
                if is_window(&ctx.drawable, framebuffer) {
                    bound(ctx, None, Some(0), |ctx| draw_buffers::select_read_buffer(ctx, buffer));
                } else {
                    gl.named_framebuffer_read_buffer(framebuffer, buffer);
                }
            };
            "glBlitNamedFramebuffer" blit_named_framebuffer(read: u32, draw: u32, x0: i32, y0: i32, x1: i32, y1: i32, u0: i32, v0: i32, u1: i32, v1: i32, mask: u32, filter: u32) = |ctx, gl| {
                if ctx.drawable.target().is_none() || !exists(&ctx.driver, read) || !exists(&ctx.driver, draw) {
                    gl.blit_named_framebuffer(read, draw, x0, y0, x1, y1, u0, v0, u1, v1, mask, filter);
                } else if ctx.compiling() {
                    gl.blit_named_framebuffer(real(&ctx.drawable, read), real(&ctx.drawable, draw), x0, y0, x1, y1, u0, v0, u1, v1, mask, filter);
                } else {
                    let (source, destination) = (BlitRect::new(x0, y0, x1, y1), BlitRect::new(u0, v0, u1, v1));
                    bound(ctx, Some(draw), Some(read), |ctx| blits::blit(ctx, source, destination, mask, filter));
                }
            };
            "glNamedFramebufferTexture" named_framebuffer_texture(framebuffer: u32, attachment: u32, texture: u32, level: i32) = |ctx, gl| {
                view_copies::forget(ctx, framebuffer);
                gl.named_framebuffer_texture(framebuffer, attachment, texture, level);
            };
            "glNamedFramebufferTextureLayer" named_framebuffer_texture_layer(framebuffer: u32, attachment: u32, texture: u32, level: i32, layer: i32) = |ctx, gl| {
                view_copies::forget(ctx, framebuffer);
                gl.named_framebuffer_texture_layer(framebuffer, attachment, texture, level, layer);
            };
            "glNamedFramebufferRenderbuffer" named_framebuffer_renderbuffer(framebuffer: u32, attachment: u32, kind: u32, renderbuffer: u32) = |ctx, gl| {
                view_copies::forget(ctx, framebuffer);
                gl.named_framebuffer_renderbuffer(framebuffer, attachment, kind, renderbuffer);
            };
            "glCheckNamedFramebufferStatus" check_named_framebuffer_status(framebuffer: u32, target: u32) -> u32 = |ctx, gl| {
                gl.check_named_framebuffer_status(real(&ctx.drawable, framebuffer), target)
            };
            "glGetNamedFramebufferAttachmentParameteriv" get_named_framebuffer_attachment_parameteriv(framebuffer: u32, attachment: u32, name: u32, values: *mut i32) = |ctx, gl| {
                if is_window(&ctx.drawable, framebuffer) {
                    bound(ctx, Some(0), None, |ctx| window_answers::attachment_parameter(ctx, api::GL_DRAW_FRAMEBUFFER, attachment, name, values));
                } else {
                    gl.get_named_framebuffer_attachment_parameteriv(framebuffer, attachment, name, values);
                }
            };
        }
    };
}

named_framebuffer_hooks! {
    "glClearNamedFramebufferfv" clear_named_framebufferfv clear_bufferfv(index: i32, value: *const f32) by by_floats;
    "glClearNamedFramebufferiv" clear_named_framebufferiv clear_bufferiv(index: i32, value: *const i32) by by_integers;
    "glClearNamedFramebufferuiv" clear_named_framebufferuiv clear_bufferuiv(index: i32, value: *const u32) by by_integers;
    "glClearNamedFramebufferfi" clear_named_framebufferfi clear_bufferfi(index: i32, depth: f32, stencil: i32) by by_pair;
}
