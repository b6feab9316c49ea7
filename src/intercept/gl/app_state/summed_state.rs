//! State and textures that Cupola does not use. The commands have hooks only if several machines
//! compare the calls of their programs.

use crate::backend::gl::driver::api;
use crate::correct::Size;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::framebuffer::commands::summed_pixels;
use crate::intercept::process::call_sum::add_values;
use std::ffi::c_void;

/// Number of values of a light's property, and of a property of a texture unit.
fn values(property: u32) -> usize {
    match property {
        api::GL_AMBIENT | api::GL_DIFFUSE | api::GL_SPECULAR | api::GL_POSITION | api::GL_TEXTURE_ENV_COLOR => 4,
        api::GL_SPOT_DIRECTION => 3,
        _ => 1,
    }
}

/// True for a question whether a texture is possible, which reads no pixels.
fn is_proxy(target: u32) -> bool {
    matches!(
        target,
        api::GL_PROXY_TEXTURE_2D
            | api::GL_PROXY_TEXTURE_3D
            | api::GL_PROXY_TEXTURE_1D_ARRAY
            | api::GL_PROXY_TEXTURE_2D_ARRAY
            | api::GL_PROXY_TEXTURE_CUBE_MAP
            | api::GL_PROXY_TEXTURE_CUBE_MAP_ARRAY
            | api::GL_PROXY_TEXTURE_RECTANGLE
    )
}

/// Bytes of a compressed picture.
fn bytes(size: i32) -> usize {
    usize::try_from(size).unwrap_or(0)
}

/// Hooks that pass the call on. `hooks!` adds its numbers to the checksum before.
macro_rules! state {
    (
        $( $name:literal $method:ident ( $($p:ident : $t:ty),* ); )*
        arrays: $( $array:literal $set:ident ( $($q:ident : $u:ty),* ) $kind:ty, $length:expr; )*
        pictures: $( $picture:literal $load:ident ( $($r:ident : $v:ty),* ) ; )*
    ) => {
        hooks! {
            "glTexImage3D" tex_image3_d(target: u32, level: i32, internal: i32, w: i32, h: i32, d: i32, border: i32, format: u32, kind: u32, pixels: *const c_void) = |ctx, gl| {
                if !is_proxy(target) {
                    summed_pixels::add_layers(&ctx.driver, (Size::new(w, h), d), (format, kind), pixels);
                }
                gl.tex_image3_d(target, level, internal, w, h, d, border, format, kind, pixels);
            };
            "glTexSubImage3D" tex_sub_image3_d(target: u32, level: i32, x: i32, y: i32, z: i32, w: i32, h: i32, d: i32, format: u32, kind: u32, pixels: *const c_void) = |ctx, gl| {
                summed_pixels::add_layers(&ctx.driver, (Size::new(w, h), d), (format, kind), pixels);
                gl.tex_sub_image3_d(target, level, x, y, z, w, h, d, format, kind, pixels);
            };
            $( $name $method($($p: $t),*) = |_ctx, gl| gl.$method($($p),*); )*
            $( $array $set($($q: $u,)* value: *const $kind) = |_ctx, gl| {
                let length: usize = $length;
                add_values(value, length);
                gl.$set($($q,)* value);
            }; )*
            $( $picture $load(target: u32, $($r: $v,)* size: i32, pixels: *const c_void) = |ctx, gl| {
                // Pixels in a buffer were summed up when it was filled.
                if !is_proxy(target) && !summed_pixels::in_buffer(&ctx.driver) {
                    add_values(pixels.cast::<u8>(), bytes(size));
                }
                gl.$load(target, $($r,)* size, pixels);
            }; )*
        }
    };
}

state! {
    "glActiveTexture" active_texture(unit: u32);
    "glAlphaFunc" alpha_func(function: u32, reference: f32);
    "glBindTexture" bind_texture(target: u32, texture: u32);
    "glBlendColor" blend_color(red: f32, green: f32, blue: f32, alpha: f32);
    "glBlendEquation" blend_equation(mode: u32);
    "glBlendEquationSeparate" blend_equation_separate(color: u32, alpha: u32);
    "glClearStencil" clear_stencil(value: i32);
    "glCullFace" cull_face(face: u32);
    "glDepthFunc" depth_func(function: u32);
    "glFrontFace" front_face(direction: u32);
    "glLightf" lightf(light: u32, property: u32, value: f32);
    "glLighti" lighti(light: u32, property: u32, value: i32);
    "glLineStipple" line_stipple(factor: i32, pattern: u16);
    "glLogicOp" logic_op(operation: u32);
    "glPolygonOffset" polygon_offset(factor: f32, units: f32);
    "glStencilFunc" stencil_func(function: u32, reference: i32, mask: u32);
    "glStencilFuncSeparate" stencil_func_separate(face: u32, function: u32, reference: i32, mask: u32);
    "glStencilOp" stencil_op(stencil: u32, depth: u32, pass: u32);
    "glStencilOpSeparate" stencil_op_separate(face: u32, stencil: u32, depth: u32, pass: u32);
    "glTexEnvf" tex_envf(target: u32, property: u32, value: f32);
    "glTexEnvi" tex_envi(target: u32, property: u32, value: i32);
    arrays:
    "glClipPlane" clip_plane(plane: u32) f64, 4;
    "glLightfv" lightfv(light: u32, property: u32) f32, values(property);
    "glLightiv" lightiv(light: u32, property: u32) i32, values(property);
    "glTexEnvfv" tex_envfv(target: u32, property: u32) f32, values(property);
    "glTexEnviv" tex_enviv(target: u32, property: u32) i32, values(property);
    pictures:
    "glCompressedTexImage2D" compressed_tex_image2_d(level: i32, format: u32, width: i32, height: i32, border: i32);
    "glCompressedTexImage3D" compressed_tex_image3_d(level: i32, format: u32, width: i32, height: i32, depth: i32, border: i32);
    "glCompressedTexSubImage2D" compressed_tex_sub_image2_d(level: i32, x: i32, y: i32, width: i32, height: i32, format: u32);
    "glCompressedTexSubImage3D" compressed_tex_sub_image3_d(level: i32, x: i32, y: i32, z: i32, width: i32, height: i32, depth: i32, format: u32);
}
