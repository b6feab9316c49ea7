//! The map that the correction's shaders compute, read back. The programs are the same except for
//! the last stage.

use super::driver::api::*;
use super::driver::values::integer;
use super::objects::target::Target;
use super::passes::GlBackend;
use crate::backend::gl::objects::framebuffers::FramebufferBindings;
use crate::correct::shaders::glsl::Stage;
use crate::correct::shaders::map::MapPixel;
use crate::correct::{LowerLeftRect, Plan};
use crate::error::{Error, ErrorKind, Result};

/// Computes the map of output `output` of `plan` on the current context, whose state is restored.
/// Row 0 is at the top. Each direction is that of the atlas coordinates that the sampler gets. So
/// it contains the error of every f32 operation up to there; only the step from the atlas back to a
/// direction is computed in f64.
///
/// # Errors
/// [`ErrorKind::InvalidArgument`] where the plan has no such output; [`ErrorKind::Graphics`] where
/// the context cannot render to 32-bit floats, is too old, or refuses a shader or the size.
pub fn gpu_map(gl: &Gl, is_gles: bool, plan: &Plan, output: usize) -> Result<Vec<MapPixel>> {
    let Some(pass) = plan.passes.get(output) else {
        let message = format!("There is no output {output}; the plan has {}.", plan.passes.len());
        return Err(Error::new(ErrorKind::InvalidArgument, message));
    };
    let mut backend = GlBackend::for_stage(gl, is_gles, Stage::Map)?;
    let result = backend
        .prepare_passes(gl, plan, std::slice::from_ref(pass), false)
        .and_then(|()| read(gl, &backend, pass.size));
    backend.destroy(gl);
    let texels = result?;
    let width = pass.size.0 as usize;
    let mut pixels = Vec::with_capacity(texels.len());
    for row in texels.chunks_exact(width).rev() {
        pixels.extend(row.iter().map(|texel| MapPixel::new(plan, *texel)));
    }
    Ok(pixels)
}

/// Draws into a texture of 32-bit floats and reads it, bottom row first.
fn read(gl: &Gl, backend: &GlBackend, size: (u32, u32)) -> Result<Vec<[f32; 4]>> {
    let (width, height) = (size.0 as i32, size.1 as i32);
    let (mut texture, mut framebuffer) = (0, 0);
    let texture_before = integer(gl, GL_TEXTURE_BINDING_2D) as u32;
    let unpack_before = integer(gl, GL_PIXEL_UNPACK_BUFFER_BINDING) as u32;
    let pack_before = integer(gl, GL_PIXEL_PACK_BUFFER_BINDING) as u32;
    let mut texels = vec![[0.0f32; 4]; size.0 as usize * size.1 as usize];
    // SAFETY: a context is current; the names are those that it gave; rows of four floats need no
    // padding whatever the pack alignment, and the array holds width · height of them.
    let status = unsafe {
        let framebuffers = FramebufferBindings::save(gl);
        gl.gen_textures(1, &mut texture);
        gl.bind_texture(GL_TEXTURE_2D, texture);
        gl.bind_buffer(GL_PIXEL_UNPACK_BUFFER, 0);
        gl.tex_image2_d(GL_TEXTURE_2D, 0, GL_RGBA32F as i32, width, height, 0, GL_RGBA, GL_FLOAT, std::ptr::null());
        gl.bind_buffer(GL_PIXEL_UNPACK_BUFFER, unpack_before);
        gl.gen_framebuffers(1, &mut framebuffer);
        gl.bind_framebuffer(GL_FRAMEBUFFER, framebuffer);
        gl.framebuffer_texture2_d(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
        let status = gl.check_framebuffer_status(GL_FRAMEBUFFER);
        if status == GL_FRAMEBUFFER_COMPLETE {
            backend.present(gl, 0, &[Target { framebuffer, viewport: LowerLeftRect::new(0, 0, width, height) }]);
            gl.bind_buffer(GL_PIXEL_PACK_BUFFER, 0);
            gl.read_pixels(0, 0, width, height, GL_RGBA, GL_FLOAT, texels.as_mut_ptr().cast());
        }
        gl.bind_buffer(GL_PIXEL_PACK_BUFFER, pack_before);
        gl.bind_texture(GL_TEXTURE_2D, texture_before);
        framebuffers.restore(gl);
        gl.delete_framebuffers(1, &framebuffer);
        gl.delete_textures(1, &texture);
        status
    };
    // SAFETY: as above.
    let error = unsafe { gl.get_error() };
    if status != GL_FRAMEBUFFER_COMPLETE || error != GL_NO_ERROR {
        let message = format!(
            "The driver cannot draw {width}×{height} pixels of 32-bit floats (framebuffer status {status:#x}, error {error:#x})."
        );
        return Err(Error::new(ErrorKind::Graphics, message));
    }
    Ok(texels)
}
