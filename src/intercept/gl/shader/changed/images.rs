//! Images that shaders of a draw write.

use super::buffers::Bound;
use crate::backend::gl::driver::api::{self, Gl};
use crate::backend::gl::driver::values::integer;
use crate::intercept::gl::state::shader::programs::WrittenImage;
use crate::intercept::process::log;

/// Greatest image that is copied for each draw, in bytes.
const LARGEST: i64 = 1 << 20;

/// Targets of textures, what is bound there, and whether their images can be copied, in the order
/// of the types of images in OpenGL's registry.
const TARGETS: [(u32, u32, bool); 11] = [
    (api::GL_TEXTURE_1D, api::GL_TEXTURE_BINDING_1D, false),
    (api::GL_TEXTURE_2D, api::GL_TEXTURE_BINDING_2D, true),
    (api::GL_TEXTURE_3D, api::GL_TEXTURE_BINDING_3D, true),
    (api::GL_TEXTURE_RECTANGLE, api::GL_TEXTURE_BINDING_RECTANGLE, true),
    (api::GL_TEXTURE_CUBE_MAP, api::GL_TEXTURE_BINDING_CUBE_MAP, true),
    (api::GL_TEXTURE_BUFFER, api::GL_TEXTURE_BINDING_BUFFER, false),
    (api::GL_TEXTURE_1D_ARRAY, api::GL_TEXTURE_BINDING_1D_ARRAY, false),
    (api::GL_TEXTURE_2D_ARRAY, api::GL_TEXTURE_BINDING_2D_ARRAY, true),
    (api::GL_TEXTURE_CUBE_MAP_ARRAY, api::GL_TEXTURE_BINDING_CUBE_MAP_ARRAY, true),
    (api::GL_TEXTURE_2D_MULTISAMPLE, api::GL_TEXTURE_BINDING_2D_MULTISAMPLE, false),
    (api::GL_TEXTURE_2D_MULTISAMPLE_ARRAY, api::GL_TEXTURE_BINDING_2D_MULTISAMPLE_ARRAY, false),
];

/// What is bound to an image unit that shaders write.
pub(super) enum BoundImage {
    /// An image of a texture.
    Texture(Texture),
    /// A part of a buffer.
    Buffer(Bound),
}

/// An image of a texture.
#[derive(Clone, Copy)]
pub(super) struct Texture {
    name: u32,
    target: u32,
    level: i32,
    /// Width, height, and number of layers.
    size: [i32; 3],
    format: u32,
}

/// An image of the program, and the texture of Cupola with a copy of it.
pub(super) struct KeptImage {
    of: Texture,
    copy: u32,
}

/// What is bound to an image unit.
pub struct ImageUnit {
    /// Name of the texture.
    pub texture: u32,
    /// Level of the texture.
    pub level: i32,
    /// How shaders may access it, as in OpenGL.
    pub access: u32,
}

/// Returns what is bound to the unit of an image uniform; `None` if nothing is.
pub fn unit(gl: &Gl, program: u32, location: i32) -> Option<ImageUnit> {
    let (mut unit, [mut texture, mut level, mut access]) = (0, [0; 3]);
    // SAFETY: each writes one integer.
    unsafe {
        gl.get_uniformiv(program, location, &mut unit);
        gl.get_integeri_v(api::GL_IMAGE_BINDING_NAME, unit as u32, &mut texture);
        gl.get_integeri_v(api::GL_IMAGE_BINDING_LEVEL, unit as u32, &mut level);
        gl.get_integeri_v(api::GL_IMAGE_BINDING_ACCESS, unit as u32, &mut access);
    }
    (texture != 0).then_some(ImageUnit { texture: texture as u32, level, access: access as u32 })
}

/// Returns what is bound to the unit of an image uniform; `None` if the shaders cannot write it, or
/// if it cannot be kept. Errors may be left.
pub(super) fn bound(gl: &Gl, image: WrittenImage) -> Option<BoundImage> {
    let WrittenImage { program, location, kind } = image;
    let (target, binding, can_copy) = TARGETS[kind.checked_sub(api::GL_IMAGE_1D)? as usize % TARGETS.len()];
    let ImageUnit { texture: name, level, .. } =
        unit(gl, program, location).filter(|unit| unit.access != api::GL_READ_ONLY)?;
    let before = integer(gl, binding);
    // SAFETY: the binding is put back.
    unsafe { gl.bind_texture(target, name) };
    let is_of_target = integer(gl, binding) as u32 == name;
    let bound = match target {
        _ if !is_of_target => None,
        api::GL_TEXTURE_BUFFER => of_buffer(gl),
        _ => of_texture(gl, Texture { name, target, level, size: [0; 3], format: 0 }, can_copy),
    };
    // SAFETY: the binding of the program.
    unsafe { gl.bind_texture(target, before as u32) };
    bound
}

/// Returns the buffer of the buffer texture that is bound.
fn of_buffer(gl: &Gl) -> Option<BoundImage> {
    let ask = |name: u32| {
        let mut answer = 0;
        // SAFETY: writes one integer.
        unsafe { gl.get_tex_level_parameteriv(api::GL_TEXTURE_BUFFER, 0, name, &mut answer) };
        answer
    };
    let buffer = u32::try_from(ask(api::GL_TEXTURE_BUFFER_DATA_STORE_BINDING)).ok().filter(|buffer| *buffer != 0)?;
    let (start, length) = (ask(api::GL_TEXTURE_BUFFER_OFFSET), ask(api::GL_TEXTURE_BUFFER_SIZE));
    Some(BoundImage::Buffer(Bound::part(buffer, start.into(), Some(length.into()).filter(|length| *length > 0))))
}

/// Completes the facts of the texture that is bound. `None`: its image cannot be copied, or is too
/// large.
fn of_texture(gl: &Gl, texture: Texture, can_copy: bool) -> Option<BoundImage> {
    let faces = texture.target == api::GL_TEXTURE_CUBE_MAP;
    let asked = if faces { api::GL_TEXTURE_CUBE_MAP_POSITIVE_X } else { texture.target };
    let ask = |name: u32| {
        let mut answer = 0;
        // SAFETY: writes one integer.
        unsafe { gl.get_tex_level_parameteriv(asked, texture.level, name, &mut answer) };
        answer
    };
    let layers = if faces { 6 } else { ask(api::GL_TEXTURE_DEPTH).max(1) };
    let size = [ask(api::GL_TEXTURE_WIDTH), ask(api::GL_TEXTURE_HEIGHT), layers];
    let channels =
        [api::GL_TEXTURE_RED_SIZE, api::GL_TEXTURE_GREEN_SIZE, api::GL_TEXTURE_BLUE_SIZE, api::GL_TEXTURE_ALPHA_SIZE];
    let bits: i64 = channels.into_iter().map(|channel| i64::from(ask(channel))).sum();
    let bytes = size.into_iter().fold(bits / 8, |bytes, side| bytes.saturating_mul(side.into()));
    if bytes > LARGEST || !can_copy || !gl.has_copy_image_sub_data() || !gl.has_tex_storage3_d() {
        log::once(
            "shaders that draw the scene write to an image that Cupola does not copy, as it is larger than 1 MiB, or of \
             a kind or a version of OpenGL without copies: they write once for each view; with --duplicate in-turn they \
             write as without Cupola",
        );
        return None;
    }
    (bytes > 0)
        .then(|| BoundImage::Texture(Texture { size, format: ask(api::GL_TEXTURE_INTERNAL_FORMAT) as u32, ..texture }))
}

impl KeptImage {
    /// Copies an image. `None` if the driver has no texture of its format. Errors may be left.
    pub(super) fn keep(gl: &Gl, of: Texture) -> Option<Self> {
        let (mut copy, [width, height, layers]) = (0, of.size);
        let before = integer(gl, api::GL_TEXTURE_BINDING_2D_ARRAY);
        let mut has = 0;
        // SAFETY: a texture of Cupola, whose name lives for one draw only; the binding is put back.
        unsafe {
            gl.gen_textures(1, &mut copy);
            gl.bind_texture(api::GL_TEXTURE_2D_ARRAY, copy);
            gl.tex_storage3_d(api::GL_TEXTURE_2D_ARRAY, 1, of.format, width, height, layers);
            gl.get_tex_level_parameteriv(api::GL_TEXTURE_2D_ARRAY, 0, api::GL_TEXTURE_WIDTH, &mut has);
            gl.bind_texture(api::GL_TEXTURE_2D_ARRAY, before as u32);
        }
        let kept = Self { of, copy };
        if has != width {
            kept.delete(gl);
            return None;
        }
        kept.copy(gl, true);
        Some(kept)
    }

    /// Puts the content back.
    pub(super) fn put_back(&self, gl: &Gl) {
        self.copy(gl, false);
    }

    fn copy(&self, gl: &Gl, to_copy: bool) {
        let Texture { name, target, level, size: [width, height, layers], .. } = self.of;
        let (own, copy) = ((name, target, level), (self.copy, api::GL_TEXTURE_2D_ARRAY, 0));
        let (from, to) = if to_copy { (own, copy) } else { (copy, own) };
        // SAFETY: both images exist and have this size.
        unsafe {
            gl.copy_image_sub_data(from.0, from.1, from.2, 0, 0, 0, to.0, to.1, to.2, 0, 0, 0, width, height, layers);
        }
    }

    /// Deletes the copy.
    pub(super) fn delete(self, gl: &Gl) {
        // SAFETY: a texture of Cupola.
        unsafe { gl.delete_textures(1, &self.copy) };
    }
}
