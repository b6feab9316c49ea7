//! Images into which a program draws off screen: levels of textures, and renderbuffers. A *view
//! copy* of such an image has a tile of the image's size for each view.

use crate::backend::gl::driver::api::{self, Gl};
use crate::backend::gl::driver::own_names;
use crate::backend::gl::objects::framebuffers::{FramebufferBindings, blit};
use crate::backend::gl::objects::surface::greatest_texture;
use crate::correct::{LowerLeftRect, Size};
use crate::intercept::gl::state::offscreen::tile_grid::TileGrid;

/// An image of the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Name {
    /// A level of a texture, and the target of the texture.
    Texture {
        /// Its OpenGL name.
        name: u32,
        /// `GL_TEXTURE_2D`, `GL_TEXTURE_RECTANGLE` or `GL_TEXTURE_2D_MULTISAMPLE`.
        target: u32,
        /// The level of its mipmap.
        level: i32,
    },
    /// A renderbuffer.
    Renderbuffer(u32),
}

/// An image that the program draws or copies into.
pub struct Image {
    /// Its name.
    pub name: Name,
    /// Width and height.
    pub size: Size,
    /// Samples per pixel; 0 = not multisampled.
    pub samples: i32,
    /// Its sized internal format.
    pub format: u32,
    /// Its parts, as for `glBlitFramebuffer`: colour, or depth and stencil.
    pub mask: u32,
    /// True if the image gets perspective draws that have the shape of the window.
    pub scene: bool,
    /// True if the image gets perspective draws of another shape, for example a shadow map.
    pub other_shape: bool,
    /// True if the window is copied into the image.
    pub copies_window: bool,
    /// True if the image fills the window when it is shown.
    pub displayed: bool,
    /// True if the image was shown in a small part of the window.
    pub shown_small: bool,
    /// Images from which this image is made.
    pub reads: Vec<Name>,
    /// True if the program reads the image back.
    pub read_back: bool,
    /// True if compute shaders make something from the image that is needed for each view but
    /// cannot be made for each view.
    pub lost: bool,
    /// True if the program makes smaller pictures of the image (`glGenerateMipmap`).
    pub mipmapped: bool,
    /// True if the driver gives no view copy.
    pub refused: bool,
    /// View copy into which draws go instead of the image.
    pub view_copy: Option<ViewCopy>,
}

/// View copy of an image.
pub struct ViewCopy {
    /// The renderbuffer with the tiles.
    pub renderbuffer: u32,
    /// Framebuffers for copies, of each context that has copied.
    pairs: Vec<Pair>,
    /// Positions of the tiles.
    pub grid: TileGrid,
    /// Index of the tile whose content the program's image has.
    holds: Option<usize>,
}

/// Framebuffers of one context: `ours` with the view copy, and `own` with the program's image.
#[derive(Clone, Copy)]
pub struct Pair {
    /// Number of the context.
    pub context: u64,
    ours: u32,
    own: u32,
}

impl Pair {
    /// Deletes them in their context, which must be current.
    pub fn destroy(&self, gl: &Gl) {
        // SAFETY: objects of Cupola; the name 0 is ignored.
        unsafe { gl.delete_framebuffers(2, [self.ours, self.own].as_ptr()) };
    }
}

impl Image {
    /// True if the image holds colours.
    pub fn is_colour(&self) -> bool {
        self.mask & api::GL_COLOR_BUFFER_BIT != 0
    }

    /// True if `name` is the OpenGL name of its texture.
    pub fn is_texture(&self, name: u32) -> bool {
        matches!(self.name, Name::Texture { name: own, .. } if own == name)
    }

    /// Returns the attachment point of the image in a framebuffer for copies.
    fn point(&self) -> u32 {
        match self.mask {
            api::GL_COLOR_BUFFER_BIT => api::GL_COLOR_ATTACHMENT0,
            api::GL_DEPTH_BUFFER_BIT => api::GL_DEPTH_ATTACHMENT,
            api::GL_STENCIL_BUFFER_BIT => api::GL_STENCIL_ATTACHMENT,
            _ => api::GL_DEPTH_STENCIL_ATTACHMENT,
        }
    }

    /// Makes the view copy with `count` tiles in the context `context`, which must be current. All
    /// bindings are put back; errors may be left. Returns false if the driver gives none.
    pub fn make_view_copy(&mut self, gl: &Gl, context: u64, count: usize) -> bool {
        let grid = TileGrid::new(self.size, count);
        let Size { width, height } = grid.extent(count);
        if width.max(height) as u32 > greatest_texture(gl) {
            return false;
        }
        let mut view_copy = ViewCopy { renderbuffer: 0, pairs: Vec::new(), grid, holds: None };
        // SAFETY: makes an object of Cupola; the binding is put back.
        unsafe {
            let mut renderbuffer = 0;
            gl.get_integerv(api::GL_RENDERBUFFER_BINDING, &mut renderbuffer);
            view_copy.renderbuffer = own_names::renderbuffer(gl);
            gl.bind_renderbuffer(api::GL_RENDERBUFFER, view_copy.renderbuffer);
            if self.samples > 0 {
                let samples = self.samples;
                gl.renderbuffer_storage_multisample(api::GL_RENDERBUFFER, samples, self.format, width, height);
            } else {
                gl.renderbuffer_storage(api::GL_RENDERBUFFER, self.format, width, height);
            }
            gl.bind_renderbuffer(api::GL_RENDERBUFFER, renderbuffer as u32);
        }
        self.view_copy = Some(view_copy);
        // SAFETY: asks for the error flag.
        if self.pair(gl, context).is_none() || unsafe { gl.get_error() } != api::GL_NO_ERROR {
            self.destroy_view_copy(gl, context);
            return false;
        }
        // Each view has the present content of the image until the image is drawn again.
        for index in 0..count {
            self.store(gl, context, index);
        }
        true
    }

    /// Returns the framebuffers for copies in `context`, which must be current. Bindings are put
    /// back. `None`: there is no view copy, or the driver gives no framebuffers.
    fn pair(&mut self, gl: &Gl, context: u64) -> Option<Pair> {
        let view_copy = self.view_copy.as_ref()?;
        if let Some(pair) = view_copy.pairs.iter().find(|pair| pair.context == context) {
            return Some(*pair);
        }
        let mut pair = Pair { context, ours: 0, own: 0 };
        // SAFETY: makes objects of Cupola; bindings are put back.
        let complete = unsafe {
            let bindings = FramebufferBindings::save(gl);
            pair.ours = own_names::framebuffer(gl);
            pair.own = own_names::framebuffer(gl);
            let own = self.attach_for_copies(gl, pair.own, self.name);
            let ours = self.attach_for_copies(gl, pair.ours, Name::Renderbuffer(view_copy.renderbuffer));
            bindings.restore(gl);
            own && ours
        };
        if !complete {
            pair.destroy(gl);
            return None;
        }
        self.view_copy.as_mut()?.pairs.push(pair);
        Some(pair)
    }

    /// Returns the framebuffer with the view copy alone in `context`, which must be current; 0 if
    /// there is none.
    pub fn view_copy_framebuffer(&mut self, gl: &Gl, context: u64) -> u32 {
        self.pair(gl, context).map_or(0, |pair| pair.ours)
    }

    /// # Safety
    /// `framebuffer` must be one of Cupola's. It stays bound.
    unsafe fn attach_for_copies(&self, gl: &Gl, framebuffer: u32, image: Name) -> bool {
        // SAFETY: as promised; the image lives.
        unsafe {
            gl.bind_framebuffer(api::GL_FRAMEBUFFER, framebuffer);
            attach(gl, self.point(), image);
            if !self.is_colour() {
                gl.draw_buffers(1, &api::GL_NONE);
                gl.read_buffer(api::GL_NONE);
            }
            gl.check_framebuffer_status(api::GL_FRAMEBUFFER) == api::GL_FRAMEBUFFER_COMPLETE
        }
    }

    /// Notes that the view copy was drawn to. The program's image no longer has the
    /// content of a tile.
    pub fn changed(&mut self) {
        if let Some(view_copy) = &mut self.view_copy {
            view_copy.holds = None;
        }
    }

    /// Copies tile `index` into the program's own image, and makes the smaller pictures that the
    /// program asked for. The scissor test must be off; bindings are put back.
    pub fn supply(&mut self, gl: &Gl, context: u64, index: usize) {
        if self.view_copy.as_ref().is_none_or(|view_copy| view_copy.holds == Some(index)) {
            return;
        }
        let (mask, mipmapped) = (self.mask, self.mipmapped);
        let Some(pair) = self.pair(gl, context) else { return };
        let Some(view_copy) = &mut self.view_copy else { return };
        let from = view_copy.grid.tile(index);
        copy(gl, (pair.ours, from), (pair.own, LowerLeftRect { x: 0, y: 0, ..from }), mask);
        view_copy.holds = Some(index);
        if let (true, Name::Texture { name, target: api::GL_TEXTURE_2D, .. }) = (mipmapped, self.name) {
            with_texture(gl, api::GL_TEXTURE_2D, api::GL_TEXTURE_BINDING_2D, name, || {
                // SAFETY: the program's texture is bound; the program has asked for this.
                unsafe { gl.generate_mipmap(api::GL_TEXTURE_2D) };
            });
        }
    }

    /// Copies the program's own image into tile `index`: the reverse of [`Image::supply`].
    pub fn store(&mut self, gl: &Gl, context: u64, index: usize) {
        let mask = self.mask;
        let Some(pair) = self.pair(gl, context) else { return };
        let Some(view_copy) = &mut self.view_copy else { return };
        let to = view_copy.grid.tile(index);
        copy(gl, (pair.own, LowerLeftRect { x: 0, y: 0, ..to }), (pair.ours, to), mask);
        view_copy.holds = Some(index);
    }

    /// Deletes the view copy in `context`, which must be current. Returns the framebuffers that
    /// other contexts have to delete.
    pub fn destroy_view_copy(&mut self, gl: &Gl, context: u64) -> Vec<Pair> {
        let Some(mut view_copy) = self.view_copy.take() else { return Vec::new() };
        // SAFETY: an object of Cupola; the name 0 is ignored.
        unsafe { gl.delete_renderbuffers(1, &view_copy.renderbuffer) };
        view_copy.pairs.retain(|pair| {
            if pair.context == context {
                pair.destroy(gl);
            }
            pair.context != context
        });
        view_copy.pairs
    }
}

/// Attaches an image to the framebuffer that is bound for drawing.
///
/// # Safety
/// The framebuffer must be one of Cupola's, and the image must live.
pub unsafe fn attach(gl: &Gl, point: u32, image: Name) {
    // SAFETY: as promised.
    unsafe {
        match image {
            Name::Texture { name, target, level } => {
                gl.framebuffer_texture2_d(api::GL_DRAW_FRAMEBUFFER, point, target, name, level);
            }
            Name::Renderbuffer(name) => {
                gl.framebuffer_renderbuffer(api::GL_DRAW_FRAMEBUFFER, point, api::GL_RENDERBUFFER, name);
            }
        }
    }
}

/// Copies between rectangles of one size in two framebuffers; bindings are put back. The
/// scissor test must be off.
fn copy(gl: &Gl, from: (u32, LowerLeftRect), to: (u32, LowerLeftRect), mask: u32) {
    // SAFETY: framebuffers of Cupola, or bindings as the program made them, that are put back.
    unsafe {
        let bindings = FramebufferBindings::save(gl);
        gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, from.0);
        gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, to.0);
        blit(gl, from.1.corners(), to.1.corners(), mask, api::GL_NEAREST);
        bindings.restore(gl);
    }
}

/// Runs `run` with a texture bound. If the texture is not one of `target`, runs nothing and returns
/// false. The program's binding is put back.
pub(super) fn with_texture(gl: &Gl, target: u32, binding: u32, texture: u32, run: impl FnOnce()) -> bool {
    let (mut before, mut bound) = (0, 0);
    // SAFETY: the binding is put back.
    unsafe {
        gl.get_integerv(binding, &mut before);
        gl.bind_texture(target, texture);
        gl.get_integerv(binding, &mut bound);
        let is_one = bound as u32 == texture && texture != 0;
        if is_one {
            run();
        }
        gl.bind_texture(target, before as u32);
        is_one
    }
}

/// A set of images, with a bit for each index in the list. Images after the 64th are not followed.
pub type Set = u64;
