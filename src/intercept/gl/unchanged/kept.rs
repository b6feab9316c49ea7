//! The corrected picture of the window that is kept for frames in which nothing changes.

use super::super::context::Context;
use super::super::counting;
use super::super::offscreen::Canvas;
use super::super::present::read_back;
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

/// Whether nothing else in the process can write to what is drawn, and the window's own picture can be copied to a texture and
/// back without a change.
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
    copies && plain && !ctx.reads_elsewhere && !super::unknown::called() && !OTHERS.iter().any(|name| loaded(name))
}

/// Copies the window's back buffer to a canvas or back. Bindings and switches are put back.
fn copy(ctx: &mut Context, canvas: u32, (width, height): (u32, u32), from_window: bool) {
    counting::aside(ctx, |ctx| {
        let gl = ctx.gl;
        let (width, height) = (width as i32, height as i32);
        let (read, draw) = if from_window { (0, canvas) } else { (canvas, 0) };
        let mut bound = [0; 2];
        let converts = !ctx.profile.es && ctx.known_state.is_on(gl, api::GL_FRAMEBUFFER_SRGB);
        // SAFETY: copies between a framebuffer of ours and the window's; what is touched is put back.
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
            gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, read);
            gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, draw);
            let color = api::GL_COLOR_BUFFER_BIT;
            gl.blit_framebuffer(0, 0, width, height, 0, 0, width, height, color, api::GL_NEAREST);
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
}

/// Keeps the picture that the window's back buffer holds, if it can be shown again.
pub fn keep(ctx: &mut Context) {
    let Some(size) = ctx.target.as_ref().map(|target| target.size()).filter(|_| possible(ctx)) else { return };
    let gl = ctx.gl;
    let canvas = match ctx.unchanged.kept.canvas.take() {
        Some((canvas, of)) if of == size => canvas,
        other => {
            if let Some((canvas, _)) = other {
                canvas.destroy(gl);
            }
            Canvas::new(gl, size.0 as i32, size.1 as i32)
        }
    };
    copy(ctx, canvas.framebuffer, size, true);
    ctx.unchanged.kept = Kept { canvas: Some((canvas, size)), valid: true };
}

/// Shows the picture in the window's back buffer. `false`: there is none.
pub fn show(ctx: &mut Context) -> bool {
    let canvas = ctx.unchanged.kept.canvas.as_ref().filter(|_| ctx.unchanged.kept.valid);
    let Some((canvas, size)) = canvas.map(|(canvas, size)| (canvas.framebuffer, *size)) else { return false };
    let fits = ctx.target.as_ref().is_some_and(|target| target.size() == size) && possible(ctx);
    if fits {
        copy(ctx, canvas, size, false);
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
