//! Images into which a program draws off screen: levels of textures, and renderbuffers. A *view
//! copy* of such an image has a tile of the image's size for each view.

use crate::backend::gl::driver::api::{self, Gl};
use crate::backend::gl::driver::own_names;
use crate::backend::gl::objects::framebuffers::{FramebufferBindings, blit};
use crate::backend::gl::objects::surface::greatest_texture;
use crate::correct::LowerLeftRect;

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
    pub size: [i32; 2],
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

/// Tiles of equal size, row by row from the bottom left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TileGrid {
    columns: i32,
    size: [i32; 2],
}

impl TileGrid {
    fn new(size: [i32; 2], count: usize) -> Self {
        let count = count.max(1) as i32;
        Self { columns: (1..=count).find(|columns| columns * columns >= count).unwrap_or(1), size }
    }

    /// Size of an image with `count` tiles.
    pub fn extent(&self, count: usize) -> [i32; 2] {
        [self.columns * self.size[0], (count as i32 + self.columns - 1) / self.columns * self.size[1]]
    }

    /// Returns a tile.
    pub fn tile(&self, index: usize) -> LowerLeftRect {
        let (index, [width, height]) = (index as i32, self.size);
        LowerLeftRect::new(index % self.columns * width, index / self.columns * height, width, height)
    }
}

impl Image {
    /// Returns an image with the facts that the driver gives. `None` if the image cannot have a
    /// view copy: a layer, a face of a cube, or no image at all. Bindings are put back; errors may
    /// be left.
    pub fn examine_texture(gl: &Gl, texture: u32, level: i32) -> Option<Self> {
        let targets = [
            (api::GL_TEXTURE_2D, api::GL_TEXTURE_BINDING_2D),
            (api::GL_TEXTURE_RECTANGLE, api::GL_TEXTURE_BINDING_RECTANGLE),
            (api::GL_TEXTURE_2D_MULTISAMPLE, api::GL_TEXTURE_BINDING_2D_MULTISAMPLE),
        ];
        targets.into_iter().find_map(|(target, binding)| {
            let mut answers = [0; 7];
            let is_one = with_texture(gl, target, binding, texture, || {
                let names = [
                    api::GL_TEXTURE_WIDTH,
                    api::GL_TEXTURE_HEIGHT,
                    api::GL_TEXTURE_SAMPLES,
                    api::GL_TEXTURE_INTERNAL_FORMAT,
                    api::GL_TEXTURE_RED_SIZE,
                    api::GL_TEXTURE_DEPTH_SIZE,
                    api::GL_TEXTURE_STENCIL_SIZE,
                ];
                for (answer, name) in answers.iter_mut().zip(names) {
                    // SAFETY: writes one integer.
                    unsafe { gl.get_tex_level_parameteriv(target, level, name, answer) };
                }
            });
            is_one.then(|| Self::new(Name::Texture { name: texture, target, level }, answers)).flatten()
        })
    }

    /// As [`Image::examine_texture`], for a renderbuffer.
    pub fn examine_renderbuffer(gl: &Gl, renderbuffer: u32) -> Option<Self> {
        let names = [
            api::GL_RENDERBUFFER_WIDTH,
            api::GL_RENDERBUFFER_HEIGHT,
            api::GL_RENDERBUFFER_SAMPLES,
            api::GL_RENDERBUFFER_INTERNAL_FORMAT,
            api::GL_RENDERBUFFER_RED_SIZE,
            api::GL_RENDERBUFFER_DEPTH_SIZE,
            api::GL_RENDERBUFFER_STENCIL_SIZE,
        ];
        let mut answers = [0; 7];
        // SAFETY: the binding is put back; each question writes one integer.
        unsafe {
            let mut bound = 0;
            gl.get_integerv(api::GL_RENDERBUFFER_BINDING, &mut bound);
            gl.bind_renderbuffer(api::GL_RENDERBUFFER, renderbuffer);
            for (answer, name) in answers.iter_mut().zip(names) {
                gl.get_renderbuffer_parameteriv(api::GL_RENDERBUFFER, name, answer);
            }
            gl.bind_renderbuffer(api::GL_RENDERBUFFER, bound as u32);
        }
        Self::new(Name::Renderbuffer(renderbuffer), answers)
    }

    /// Returns an image with the facts of the driver's answers: width, height, samples, format,
    /// bits of red, depth and stencil.
    pub(in crate::intercept::gl) fn new(name: Name, answers: [i32; 7]) -> Option<Self> {
        let [width, height, samples, format, red, depth, stencil] = answers;
        let mut mask = 0;
        if depth > 0 {
            mask |= api::GL_DEPTH_BUFFER_BIT;
        }
        if stencil > 0 {
            mask |= api::GL_STENCIL_BUFFER_BIT;
        }
        if mask == 0 {
            mask = api::GL_COLOR_BUFFER_BIT;
        }
        (width > 0 && height > 0).then(|| Self {
            name,
            size: [width, height],
            samples,
            format: sized(format as u32, red, depth),
            mask,
            scene: false,
            other_shape: false,
            copies_window: false,
            displayed: false,
            reads: Vec::new(),
            read_back: false,
            lost: false,
            mipmapped: false,
            refused: false,
            view_copy: None,
        })
    }

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
        let [width, height] = grid.extent(count);
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

/// Returns the sized format for a format that leaves its size to the driver. `red` and `depth` are
/// the numbers of bits that the driver chose.
fn sized(format: u32, red: i32, depth: i32) -> u32 {
    match (format, red, depth) {
        (4 | api::GL_RGBA | api::GL_BGRA, 16, _) => api::GL_RGBA16F,
        (4 | api::GL_RGBA | api::GL_BGRA, 32, _) => api::GL_RGBA32F,
        (4 | api::GL_RGBA | api::GL_BGRA, ..) => api::GL_RGBA8,
        (3 | api::GL_RGB, 16, _) => api::GL_RGB16F,
        (3 | api::GL_RGB, 32, _) => api::GL_RGB32F,
        (3 | api::GL_RGB, ..) => api::GL_RGB8,
        (api::GL_SRGB | api::GL_SRGB_ALPHA, ..) => api::GL_SRGB8_ALPHA8,
        (api::GL_RED, ..) => api::GL_R8,
        (api::GL_RG, ..) => api::GL_RG8,
        (api::GL_DEPTH_COMPONENT, _, 16) => api::GL_DEPTH_COMPONENT16,
        (api::GL_DEPTH_COMPONENT, _, 32) => api::GL_DEPTH_COMPONENT32,
        (api::GL_DEPTH_COMPONENT, ..) => api::GL_DEPTH_COMPONENT24,
        (api::GL_DEPTH_STENCIL, ..) => api::GL_DEPTH24_STENCIL8,
        (other, ..) => other,
    }
}

/// A set of images, with a bit for each index in the list. Images after the 64th are not followed.
pub type Set = u64;

#[cfg(test)]
mod tests {
    use super::{TileGrid, sized};
    use crate::backend::gl::driver::api;
    use crate::correct::BlitRect;

    #[test]
    fn tiles_are_apart_and_inside() {
        for count in 1..33 {
            let grid = TileGrid::new([7, 5], count);
            let [width, height] = grid.extent(count);
            let all: Vec<_> = (0..count).map(|index| grid.tile(index)).collect();
            for (i, tile) in all.iter().enumerate() {
                let BlitRect { start: [x, y], end: [right, top] } = tile.corners();
                assert!(x % 7 == 0 && y % 5 == 0 && right <= width && top <= height);
                assert!(!all[..i].contains(&all[i]));
            }
        }
    }

    #[test]
    fn formats_without_a_size_get_the_driver_s() {
        assert_eq!(sized(api::GL_RGBA, 8, 0), api::GL_RGBA8);
        assert_eq!(sized(api::GL_RGBA, 16, 0), api::GL_RGBA16F);
        assert_eq!(sized(api::GL_DEPTH_COMPONENT, 0, 16), api::GL_DEPTH_COMPONENT16);
        assert_eq!(sized(api::GL_R11F_G11F_B10F, 11, 0), api::GL_R11F_G11F_B10F);
    }
}
