//! Examination of images: the facts that the driver gives of a texture or a renderbuffer.

use crate::backend::gl::driver::api::{self, Gl};
use crate::correct::Size;
use crate::intercept::gl::state::offscreen::images::{Image, Name, with_texture};

/// Returns the sized format for a format that leaves its size to the driver. `red` and `depth` are
/// the numbers of bits that the driver chose.
pub(super) fn sized(format: u32, red: i32, depth: i32) -> u32 {
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
            size: Size::new(width, height),
            samples,
            format: sized(format as u32, red, depth),
            mask,
            scene: false,
            other_shape: false,
            copies_window: false,
            displayed: false,
            shown_small: false,
            reads: Vec::new(),
            read_back: false,
            lost: false,
            mipmapped: false,
            refused: false,
            view_copy: None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::sized;
    use crate::backend::gl::driver::api;

    #[test]
    fn formats_without_a_size_get_the_driver_s() {
        assert_eq!(sized(api::GL_RGBA, 8, 0), api::GL_RGBA8);
        assert_eq!(sized(api::GL_RGBA, 16, 0), api::GL_RGBA16F);
        assert_eq!(sized(api::GL_DEPTH_COMPONENT, 0, 16), api::GL_DEPTH_COMPONENT16);
        assert_eq!(sized(api::GL_R11F_G11F_B10F, 11, 0), api::GL_R11F_G11F_B10F);
    }
}
