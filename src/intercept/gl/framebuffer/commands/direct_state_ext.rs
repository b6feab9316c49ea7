//! Framebuffers by name with the commands of `GL_EXT_direct_state_access`. Here too the stand-in
//! image replaces the program's framebuffer 0. Unlike the commands of OpenGL 4.5, these create the
//! object of a name that was only generated.

use crate::backend::gl::driver::api;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::framebuffer::commands::direct_state::{bound, is_window, real};
use crate::intercept::gl::framebuffer::commands::{draw_buffers, window_answers};
use crate::intercept::gl::offscreen::view_copies;

hooks! {
    "glFramebufferDrawBufferEXT" framebuffer_draw_buffer_ext(framebuffer: u32, buffer: u32) = |ctx, gl| {
        if is_window(&ctx.drawable, framebuffer) {
            bound(ctx, Some(0), None, |ctx| draw_buffers::select_draw_buffer(ctx, buffer));
        } else {
            view_copies::forget(ctx, framebuffer);
            gl.framebuffer_draw_buffer_ext(framebuffer, buffer);
        }
    };
    "glFramebufferDrawBuffersEXT" framebuffer_draw_buffers_ext(framebuffer: u32, count: i32, buffers: *const u32) = |ctx, gl| {
        if is_window(&ctx.drawable, framebuffer) {
            bound(ctx, Some(0), None, |ctx| draw_buffers::select_draw_buffers(ctx, count, buffers));
        } else {
            view_copies::forget(ctx, framebuffer);
            gl.framebuffer_draw_buffers_ext(framebuffer, count, buffers);
        }
    };
    "glFramebufferReadBufferEXT" framebuffer_read_buffer_ext(framebuffer: u32, buffer: u32) = |ctx, gl| {
        if is_window(&ctx.drawable, framebuffer) {
            bound(ctx, None, Some(0), |ctx| draw_buffers::select_read_buffer(ctx, buffer));
        } else {
            gl.framebuffer_read_buffer_ext(framebuffer, buffer);
        }
    };
    "glCheckNamedFramebufferStatusEXT" check_named_framebuffer_status_ext(framebuffer: u32, target: u32) -> u32 = |ctx, gl| {
        gl.check_named_framebuffer_status_ext(real(&ctx.drawable, framebuffer), target)
    };
    "glGetNamedFramebufferAttachmentParameterivEXT" get_named_framebuffer_attachment_parameteriv_ext(framebuffer: u32, attachment: u32, name: u32, values: *mut i32) = |ctx, gl| {
        if is_window(&ctx.drawable, framebuffer) {
            bound(ctx, Some(0), None, |ctx| window_answers::attachment_parameter(ctx, api::GL_DRAW_FRAMEBUFFER, attachment, name, values));
        } else {
            gl.get_named_framebuffer_attachment_parameteriv_ext(framebuffer, attachment, name, values);
        }
    };
    "glNamedFramebufferTextureEXT" named_framebuffer_texture_ext(framebuffer: u32, attachment: u32, texture: u32, level: i32) = |ctx, gl| {
        view_copies::forget(ctx, framebuffer);
        gl.named_framebuffer_texture_ext(framebuffer, attachment, texture, level);
    };
    "glNamedFramebufferTexture1DEXT" named_framebuffer_texture1_dext(framebuffer: u32, attachment: u32, kind: u32, texture: u32, level: i32) = |ctx, gl| {
        view_copies::forget(ctx, framebuffer);
        gl.named_framebuffer_texture1_dext(framebuffer, attachment, kind, texture, level);
    };
    "glNamedFramebufferTexture2DEXT" named_framebuffer_texture2_dext(framebuffer: u32, attachment: u32, kind: u32, texture: u32, level: i32) = |ctx, gl| {
        view_copies::forget(ctx, framebuffer);
        gl.named_framebuffer_texture2_dext(framebuffer, attachment, kind, texture, level);
    };
    "glNamedFramebufferTexture3DEXT" named_framebuffer_texture3_dext(framebuffer: u32, attachment: u32, kind: u32, texture: u32, level: i32, layer: i32) = |ctx, gl| {
        view_copies::forget(ctx, framebuffer);
        gl.named_framebuffer_texture3_dext(framebuffer, attachment, kind, texture, level, layer);
    };
    "glNamedFramebufferTextureLayerEXT" named_framebuffer_texture_layer_ext(framebuffer: u32, attachment: u32, texture: u32, level: i32, layer: i32) = |ctx, gl| {
        view_copies::forget(ctx, framebuffer);
        gl.named_framebuffer_texture_layer_ext(framebuffer, attachment, texture, level, layer);
    };
    "glNamedFramebufferRenderbufferEXT" named_framebuffer_renderbuffer_ext(framebuffer: u32, attachment: u32, kind: u32, renderbuffer: u32) = |ctx, gl| {
        view_copies::forget(ctx, framebuffer);
        gl.named_framebuffer_renderbuffer_ext(framebuffer, attachment, kind, renderbuffer);
    };
}
