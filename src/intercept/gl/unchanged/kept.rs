//! The corrected picture of the window that is kept for frames in which nothing changes.

use super::super::context::Context;
use super::super::counting;
use super::super::default_framebuffer::clear_transparent;
use super::super::errors::{take_error, take_own_errors};
use super::super::offscreen::Canvas;
use super::super::present::{self, read_back};
use crate::backend::gl::api::{self, Gl};
use crate::intercept::log;
use std::ffi::CStr;

/// The picture, and whether it is that of the frame before.
#[derive(Default)]
pub struct Kept {
    canvas: Option<(Canvas, (u32, u32))>,
    valid: bool,
}

impl Kept {
    /// The picture is no longer the window's.
    pub fn forget(&mut self) {
        self.valid = false;
    }

    /// Whether it is.
    pub fn is_valid(&self) -> bool {
        self.valid
    }
}

/// Interfaces of programs that write to OpenGL's objects without a call of OpenGL.
const OTHERS: [&CStr; 3] = [c"libcuda.so.1", c"libOpenCL.so.1", c"libamdhip64.so"];

/// Whether nothing else in the process can write to what is drawn, and a texture of 8 bits can be copied to the window without
/// a change.
fn possible(ctx: &Context) -> bool {
    let copies = ctx.profile.version >= 30 && ctx.gl.has_blit_framebuffer();
    let plain = ctx.target.as_ref().map(|target| target.config()).is_some_and(|config| {
        // OpenGL ES converts whatever a copy to or from sRGB holds.
        let raw = !(config.srgb && ctx.profile.es);
        config.double_buffered && config.samples == 0 && raw && config.red_bits == 8
    });
    // SAFETY: asks whether a library is loaded, which it stays for the program's own reasons.
    let loaded = |name: &CStr| unsafe {
        let library = libc::dlopen(name.as_ptr(), libc::RTLD_LAZY | libc::RTLD_NOLOAD);
        !library.is_null() && libc::dlclose(library) == 0
    };
    copies && plain && !super::unknown::called() && !OTHERS.iter().any(|name| loaded(name))
}

/// Draws to `framebuffer` and reads from `from`, within no scissor. Bindings and switches are put back.
fn in_framebuffers(ctx: &mut Context, framebuffer: u32, from: u32, draw: impl FnOnce(&Context)) {
    take_error(ctx);
    counting::aside(ctx, |ctx| {
        let gl = ctx.gl;
        let mut bound = [0; 2];
        let converts = !ctx.profile.es && ctx.known_state.is_on(gl, api::GL_FRAMEBUFFER_SRGB);
        // SAFETY: bindings of framebuffers of ours and of the window's, and switches; what is touched is put back.
        unsafe {
            gl.get_integerv(api::GL_READ_FRAMEBUFFER_BINDING, &mut bound[0]);
            gl.get_integerv(api::GL_DRAW_FRAMEBUFFER_BINDING, &mut bound[1]);
            let scissor = gl.is_enabled(api::GL_SCISSOR_TEST) != 0;
            if scissor {
                gl.disable(api::GL_SCISSOR_TEST);
            }
            if converts {
                gl.disable(api::GL_FRAMEBUFFER_SRGB);
            }
            gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, from);
            gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, framebuffer);
            draw(ctx);
            gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, bound[0] as u32);
            gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, bound[1] as u32);
            if scissor {
                gl.enable(api::GL_SCISSOR_TEST);
            }
            if converts {
                gl.enable(api::GL_FRAMEBUFFER_SRGB);
            }
        }
    });
    take_own_errors(ctx);
}

/// Copies all of a picture as large as the window, 0 being that.
fn copy(ctx: &mut Context, from: u32, to: u32, (width, height): (u32, u32)) {
    let (width, height) = (width as i32, height as i32);
    in_framebuffers(ctx, to, from, |ctx| {
        // SAFETY: both framebuffers are as large.
        unsafe {
            let color = api::GL_COLOR_BUFFER_BIT;
            ctx.gl.blit_framebuffer(0, 0, width, height, 0, 0, width, height, color, api::GL_NEAREST);
        }
    });
}

/// A canvas as large as the window, black where no output is.
fn new_canvas(ctx: &mut Context, (width, height): (u32, u32)) -> Canvas {
    let canvas = Canvas::new(ctx.gl, width as i32, height as i32);
    in_framebuffers(ctx, canvas.framebuffer, 0, |ctx| clear_transparent(ctx.gl, &ctx.known_state));
    canvas
}

/// Whether the back buffer holds the window's picture even where other windows cover it.
fn has_whole_back_buffer(ctx: &Context) -> bool {
    // SAFETY: a string of the driver, which lives as long as it.
    let version = unsafe {
        let text = ctx.gl.get_string(api::GL_VERSION);
        if text.is_null() { return false } else { CStr::from_ptr(text.cast()) }
    };
    !ctx.reads_elsewhere && version.to_bytes().windows(4).any(|word| word == b"Mesa")
}

/// Corrects the frame into the window and keeps the picture. `false`: it cannot be shown again, and nothing was done.
///
/// Where what is read from the window may be another's picture, the canvas is drawn to, and copied to the window; a few pixels are
/// rounded in another way there.
pub fn keep(ctx: &mut Context) -> bool {
    let Some(size) = ctx.target.as_ref().map(|target| target.size()).filter(|_| possible(ctx)) else { return false };
    let gl = ctx.gl;
    let canvas = match ctx.unchanged.kept.canvas.take() {
        Some((canvas, of)) if of == size => canvas,
        other => {
            if let Some((canvas, _)) = other {
                canvas.destroy(gl);
            }
            new_canvas(ctx, size)
        }
    };
    if has_whole_back_buffer(ctx) {
        present::correct_into(ctx, None);
        copy(ctx, 0, canvas.framebuffer, size);
    } else {
        present::correct_into(ctx, Some(canvas.framebuffer));
        copy(ctx, canvas.framebuffer, 0, size);
    }
    ctx.unchanged.kept = Kept { canvas: Some((canvas, size)), valid: true };
    true
}

/// Shows the picture in the window's back buffer. `false`: there is none.
pub fn show(ctx: &mut Context) -> bool {
    let canvas = ctx.unchanged.kept.canvas.as_ref().filter(|_| ctx.unchanged.kept.valid);
    let Some((canvas, size)) = canvas.map(|(canvas, size)| (canvas.framebuffer, *size)) else { return false };
    let fits = ctx.target.as_ref().is_some_and(|target| target.size() == size) && possible(ctx);
    if fits {
        copy(ctx, canvas, 0, size);
    } else {
        ctx.unchanged.kept.forget();
    }
    fits
}

/// Says in the log if the window's back buffer holds another picture than the one that was kept.
pub fn check(ctx: &Context) {
    let Some((canvas, (width, height))) = &ctx.unchanged.kept.canvas else { return };
    let rect = [0, 0, *width as i32, *height as i32];
    let picture = |gl: &Gl, framebuffer: u32| read_back(gl, framebuffer, "", rect).rgba;
    let (kept, now) = (picture(ctx.gl, canvas.framebuffer), picture(ctx.gl, 0));
    let differ = |(one, other): &(&[u8], &[u8])| one[..3] != other[..3];
    let pixels = kept.chunks_exact(4).zip(now.chunks_exact(4)).filter(differ).count();
    if pixels > 0 {
        let frame = ctx.counts.frames;
        log::once(&format!("frame {frame} was held for the one before and differs in {pixels} pixels"));
    }
}
