//! An atlas to draw views into: a framebuffer with colour, depth and stencil.

use crate::backend::gl::driver::api::Gl;
use crate::backend::gl::driver::errors::drain;
use crate::backend::gl::driver::{api, own_names};
use crate::backend::gl::objects::framebuffers::FramebufferBindings;
use crate::correct::LowerLeftRect;
use crate::error::{Error, ErrorKind, Result};

/// A framebuffer of Cupola. Its methods need the context on which it was made to be current.
#[derive(Debug)]
pub struct Surface {
    framebuffer: u32,
    /// Colour: a texture, or a renderbuffer if the surface is multisampled.
    color: u32,
    /// Texture view of `color` in an sRGB format, which is the target of drawing; 0 if `color` is
    /// the target.
    as_srgb: u32,
    depth: u32,
    samples: i32,
    size: (i32, i32),
}

/// State that [`Surface::begin_tile`] changed, to be restored.
#[derive(Clone, Copy, Debug)]
pub struct Saved {
    framebuffers: FramebufferBindings,
    viewport: LowerLeftRect,
    scissor: LowerLeftRect,
    scissor_test: bool,
}

impl Surface {
    /// Makes a surface of `size` (width, height in pixels) with RGBA8 colour and 24 + 8 bits of
    /// depth and stencil. `samples`: 0 = one sample per pixel, in a texture. `srgb`: the program
    /// may enable conversion to sRGB when it draws; the correction reads the texture without
    /// conversion in any case. On Mesa `glCopyPixels` reads linear values from an sRGB texture; so
    /// the texture is not sRGB if the driver supports texture views. Every binding that changes is
    /// restored. No error of the program may be pending.
    ///
    /// # Errors
    /// [`ErrorKind::Graphics`] where the driver refuses the framebuffer.
    pub fn new(gl: &Gl, size: (i32, i32), samples: i32, srgb: bool) -> Result<Self> {
        let (width, height) = size;
        let color_format = if srgb { api::GL_SRGB8_ALPHA8 } else { api::GL_RGBA8 };
        let mut surface = Self { framebuffer: 0, color: 0, as_srgb: 0, depth: 0, samples, size };
        // SAFETY: makes objects of Cupola on the current context; bindings are restored.
        unsafe {
            let bindings = Bindings::save(gl);
            if samples > 0 {
                surface.color = own_names::renderbuffer(gl);
                gl.bind_renderbuffer(api::GL_RENDERBUFFER, surface.color);
                gl.renderbuffer_storage_multisample(api::GL_RENDERBUFFER, samples, color_format, width, height);
            } else {
                surface.color = own_names::texture(gl);
                gl.bind_texture(api::GL_TEXTURE_2D, surface.color);
                if srgb && views_textures(gl) {
                    gl.tex_storage2_d(api::GL_TEXTURE_2D, 1, api::GL_RGBA8, width, height);
                    surface.as_srgb = own_names::texture(gl);
                    gl.texture_view(surface.as_srgb, api::GL_TEXTURE_2D, surface.color, color_format, 0, 1, 0, 1);
                } else {
                    gl.tex_storage2_d(api::GL_TEXTURE_2D, 1, color_format, width, height);
                }
                if srgb && surface.as_srgb == 0 {
                    let skip = api::GL_SKIP_DECODE_EXT as i32;
                    gl.tex_parameteri(api::GL_TEXTURE_2D, api::GL_TEXTURE_SRGB_DECODE_EXT, skip);
                }
            }
            surface.depth = own_names::renderbuffer(gl);
            gl.bind_renderbuffer(api::GL_RENDERBUFFER, surface.depth);
            let depth_format = api::GL_DEPTH24_STENCIL8;
            gl.renderbuffer_storage_multisample(api::GL_RENDERBUFFER, samples, depth_format, width, height);
            bindings.restore(gl);
        }
        match surface.rehome(gl) {
            Ok(()) => Ok(surface),
            Err(error) => {
                surface.destroy(gl);
                Err(error)
            }
        }
    }

    /// Makes a new framebuffer in the current context, which shares objects with the former
    /// context. Contexts do not share framebuffers. Every binding that changes is restored. No
    /// error of the program may be pending.
    ///
    /// # Errors
    /// [`ErrorKind::Graphics`] where the driver refuses the framebuffer.
    pub fn rehome(&mut self, gl: &Gl) -> Result<()> {
        // SAFETY: makes an object of Cupola on the current context; bindings are restored.
        let (status, error) = unsafe {
            let bindings = Bindings::save(gl);
            self.framebuffer = own_names::framebuffer(gl);
            gl.bind_framebuffer(api::GL_FRAMEBUFFER, self.framebuffer);
            let (target, point) = (api::GL_FRAMEBUFFER, api::GL_COLOR_ATTACHMENT0);
            if self.samples > 0 {
                gl.framebuffer_renderbuffer(target, point, api::GL_RENDERBUFFER, self.color);
            } else {
                let drawn = if self.as_srgb != 0 { self.as_srgb } else { self.color };
                gl.framebuffer_texture2_d(target, point, api::GL_TEXTURE_2D, drawn, 0);
            }
            gl.framebuffer_renderbuffer(target, api::GL_DEPTH_STENCIL_ATTACHMENT, api::GL_RENDERBUFFER, self.depth);
            let status = gl.check_framebuffer_status(api::GL_FRAMEBUFFER);
            bindings.restore(gl);
            (status, drain(gl))
        };
        // A driver may report a framebuffer as complete although its images have no memory.
        if status == api::GL_FRAMEBUFFER_COMPLETE && error == api::GL_NO_ERROR {
            return Ok(());
        }
        let ((width, height), samples) = (self.size, self.samples);
        Err(Error::new(
            ErrorKind::Graphics,
            format!(
                "the driver cannot make a framebuffer of {width} × {height} pixels with {samples} samples \
                 (status 0x{status:04X}, error 0x{error:04X}); a lower quality in [views] makes it smaller"
            ),
        ))
    }

    /// Returns the framebuffer's OpenGL name.
    pub fn framebuffer(&self) -> u32 {
        self.framebuffer
    }

    /// Returns the texture if the surface has one sample per pixel, else 0.
    pub fn texture(&self) -> u32 {
        if self.samples > 0 { 0 } else { self.color }
    }

    /// Returns the samples per pixel; 0 = not multisampled.
    pub fn samples(&self) -> i32 {
        self.samples
    }

    /// Width and height in pixels.
    pub fn size(&self) -> (i32, i32) {
        self.size
    }

    /// Binds the framebuffer, with viewport and scissor on `tile`.
    pub fn begin_tile(&self, gl: &Gl, tile: LowerLeftRect) -> Saved {
        let LowerLeftRect { x, y, width, height } = tile;
        let (mut viewport, mut scissor) = ([0; 4], [0; 4]);
        // SAFETY: queries and sets plain state of the current context; `end_tile` restores it.
        unsafe {
            let framebuffers = FramebufferBindings::save(gl);
            gl.get_integerv(api::GL_VIEWPORT, viewport.as_mut_ptr());
            gl.get_integerv(api::GL_SCISSOR_BOX, scissor.as_mut_ptr());
            let scissor_test = gl.is_enabled(api::GL_SCISSOR_TEST) != 0;
            gl.bind_framebuffer(api::GL_FRAMEBUFFER, self.framebuffer);
            gl.viewport(x, y, width, height);
            gl.scissor(x, y, width, height);
            gl.enable(api::GL_SCISSOR_TEST);
            Saved { framebuffers, viewport: viewport.into(), scissor: scissor.into(), scissor_test }
        }
    }

    /// Restores the state that [`Surface::begin_tile`] changed.
    pub fn end_tile(&self, gl: &Gl, saved: &Saved) {
        let (viewport, scissor) = (saved.viewport, saved.scissor);
        // SAFETY: plain state commands with values that the driver gave.
        unsafe {
            saved.framebuffers.restore(gl);
            gl.viewport(viewport.x, viewport.y, viewport.width, viewport.height);
            gl.scissor(scissor.x, scissor.y, scissor.width, scissor.height);
            if !saved.scissor_test {
                gl.disable(api::GL_SCISSOR_TEST);
            }
        }
    }

    /// Deletes the surface's objects.
    pub fn destroy(&self, gl: &Gl) {
        // SAFETY: objects of Cupola; the name 0 is ignored.
        unsafe {
            gl.delete_framebuffers(1, &self.framebuffer);
            gl.delete_renderbuffers(1, &self.depth);
            if self.samples > 0 {
                gl.delete_renderbuffers(1, &self.color);
            } else {
                gl.delete_textures(2, [self.color, self.as_srgb].as_ptr());
            }
        }
    }
}

/// True if the context supports texture views.
fn views_textures(gl: &Gl) -> bool {
    let mut version = [0; 2];
    // SAFETY: each writes one integer.
    unsafe {
        gl.get_integerv(api::GL_MAJOR_VERSION, &mut version[0]);
        gl.get_integerv(api::GL_MINOR_VERSION, &mut version[1]);
    }
    !gl.is_es() && version >= [4, 3] && gl.has_texture_view()
}

/// Returns the greatest width and height of a texture on the current context, at least 1024.
pub fn greatest_texture(gl: &Gl) -> u32 {
    let mut greatest = 0;
    // SAFETY: writes one integer.
    unsafe { gl.get_integerv(api::GL_MAX_TEXTURE_SIZE, &mut greatest) };
    greatest.max(1024) as u32
}

/// Bindings that change while a surface is made.
struct Bindings {
    framebuffers: FramebufferBindings,
    renderbuffer: i32,
    texture: i32,
}

impl Bindings {
    /// # Safety
    /// A context must be current.
    unsafe fn save(gl: &Gl) -> Self {
        let (mut renderbuffer, mut texture) = (0, 0);
        // SAFETY: each writes one integer.
        unsafe {
            gl.get_integerv(api::GL_RENDERBUFFER_BINDING, &mut renderbuffer);
            gl.get_integerv(api::GL_TEXTURE_BINDING_2D, &mut texture);
            Self { framebuffers: FramebufferBindings::save(gl), renderbuffer, texture }
        }
    }

    /// # Safety
    /// The context of `save` must be current.
    unsafe fn restore(&self, gl: &Gl) {
        // SAFETY: binds the objects that were bound.
        unsafe {
            self.framebuffers.restore(gl);
            gl.bind_renderbuffer(api::GL_RENDERBUFFER, self.renderbuffer as u32);
            gl.bind_texture(api::GL_TEXTURE_2D, self.texture as u32);
        }
    }
}
