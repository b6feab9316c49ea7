//! Masks, tables and pictures of black as textures.

use crate::backend::gl::driver::api::*;
use crate::backend::gl::driver::own_names;
use crate::backend::gl::state::Capabilities;
use crate::correct::BlackPicture;
use crate::correct::Mask;
use crate::correct::Table;

/// Makes a texture of the mask's weights; returns 0 if their number is wrong.
pub(in crate::backend::gl) fn upload_mask(gl: &Gl, caps: &Capabilities, mask: &Mask) -> u32 {
    let texture;
    let (width, height) = (mask.width as i32, mask.height as i32);
    if mask.weights.len() != mask.width as usize * mask.height as usize {
        return 0;
    }
    // SAFETY: a context is current, rows are tightly packed, and the array holds width · height
    // values.
    unsafe {
        texture = own_names::texture(gl);
        gl.bind_texture(GL_TEXTURE_2D, texture);
        gl.tex_parameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
        if caps.norm16 {
            let data = mask.weights.as_ptr().cast();
            gl.tex_image2_d(GL_TEXTURE_2D, 0, GL_R16 as i32, width, height, 0, GL_RED, GL_UNSIGNED_SHORT, data);
        } else {
            // Half floats have 11 bits: an error of 0.05 % for a weight near 1.
            let weights: Vec<f32> = mask.weights.iter().map(|w| f32::from(*w) / 65535.0).collect();
            let data = weights.as_ptr().cast();
            gl.tex_image2_d(GL_TEXTURE_2D, 0, GL_R16F as i32, width, height, 0, GL_RED, GL_FLOAT, data);
        }
    }
    texture
}

/// Makes a texture of the codes to which black is raised; returns 0 if their number is wrong.
pub(in crate::backend::gl) fn upload_black(gl: &Gl, caps: &Capabilities, black: &BlackPicture) -> u32 {
    let (width, height) = (black.width as i32, black.height as i32);
    if black.codes.len() != black.width as usize * black.height as usize {
        return 0;
    }
    // SAFETY: a context is current, rows are tightly packed, and the array holds width · height
    // pixels of four values.
    unsafe {
        let texture = own_names::texture(gl);
        gl.bind_texture(GL_TEXTURE_2D, texture);
        gl.tex_parameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
        if caps.norm16 {
            let data = black.codes.as_flattened().as_ptr().cast();
            gl.tex_image2_d(GL_TEXTURE_2D, 0, GL_RGBA16 as i32, width, height, 0, GL_RGBA, GL_UNSIGNED_SHORT, data);
        } else {
            // Half floats have 11 significant bits, enough for these small values.
            let codes: Vec<f32> = black.codes.as_flattened().iter().map(|code| f32::from(*code) / 65535.0).collect();
            let data = codes.as_ptr().cast();
            gl.tex_image2_d(GL_TEXTURE_2D, 0, GL_RGBA16F as i32, width, height, 0, GL_RGBA, GL_FLOAT, data);
        }
        texture
    }
}

/// Makes a texture of the table's directions and weights.
pub(in crate::backend::gl) fn upload_table(gl: &Gl, table: &Table) -> u32 {
    let (width, height) = (table.entries().0 as i32, table.entries().1 as i32);
    let texels = table.texels().as_flattened().as_ptr().cast();
    // SAFETY: a context is current, rows are tightly packed, and a table has as many texels of four
    // floats as entries.
    unsafe {
        let texture = own_names::texture(gl);
        gl.bind_texture(GL_TEXTURE_2D, texture);
        gl.tex_parameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
        gl.tex_image2_d(GL_TEXTURE_2D, 0, GL_RGBA32F as i32, width, height, 0, GL_RGBA, GL_FLOAT, texels);
        texture
    }
}
