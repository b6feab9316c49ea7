//! Anisotropic filtering, which Mesa's software renderer cannot do in every view.
//!
//! llvmpipe (22.3 and later) adds up all texels of a pixel's footprint, in loops without a limit. A
//! view that is turned to the side shows surfaces at flatter angles than the program's own picture.
//! If a footprint is billions of texels long, drawing does not end. So in windows with such views
//! textures are filtered without anisotropy.

use crate::backend::gl::driver::api;
use crate::intercept::gl::context::hooks::hooks;
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::gl::state::drawable::default_framebuffer::DefaultFramebuffer;
use crate::intercept::gl::state::driver::Driver;

/// Returns true if the parameter must stay at its default.
fn left_out(driver: &Driver, drawable: &Drawable, parameter: u32) -> bool {
    let turned = |t: &DefaultFramebuffer| t.session.views().iter().any(|v| !v.program_lens);
    parameter == api::GL_TEXTURE_MAX_ANISOTROPY && driver.endless_anisotropy && drawable.target().is_some_and(turned)
}

macro_rules! filtering_hooks {
    ($( $name:literal $method:ident ($object:ident, $value:ty); )*) => {
        hooks! {
            $( $name $method($object: u32, parameter: u32, value: $value) = |ctx, gl| {
                if !left_out(&ctx.driver, &ctx.drawable, parameter) { gl.$method($object, parameter, value) }
            }; )*
        }
    };
}

filtering_hooks! {
    "glTexParameterf" tex_parameterf(target, f32);
    "glTexParameteri" tex_parameteri(target, i32);
    "glTexParameterfv" tex_parameterfv(target, *const f32);
    "glTexParameteriv" tex_parameteriv(target, *const i32);
    "glTextureParameterf" texture_parameterf(texture, f32);
    "glTextureParameteri" texture_parameteri(texture, i32);
    "glTextureParameterfv" texture_parameterfv(texture, *const f32);
    "glTextureParameteriv" texture_parameteriv(texture, *const i32);
    "glSamplerParameterf" sampler_parameterf(sampler, f32);
    "glSamplerParameteri" sampler_parameteri(sampler, i32);
    "glSamplerParameterfv" sampler_parameterfv(sampler, *const f32);
    "glSamplerParameteriv" sampler_parameteriv(sampler, *const i32);
}
