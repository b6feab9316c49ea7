//! Followed images that the next draw samples.

use crate::backend::gl::driver::api;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::driver::profile::Profile;
use crate::intercept::gl::state::offscreen::images::{Name, Set};
use crate::intercept::gl::state::offscreen::view_copies::ViewCopies;
use crate::intercept::gl::state::shader::Shaders;

/// Greatest number of samplers of a program that are examined.
const SAMPLERS: usize = 16;

/// Calls `look` for each texture that the next draw samples.
fn each_texture(driver: &Driver, shaders: &Shaders, mut look: impl FnMut(u32)) {
    let gl = driver.gl;
    let mut active = 0;
    // SAFETY: reads which textures the program's samplers use; the active unit is put back.
    unsafe {
        gl.get_integerv(api::GL_ACTIVE_TEXTURE, &mut active);
        match shaders.program() {
            Some(program) if program.draws_vertices() || program.compute.is_some() => {
                for sampler in program.samplers.iter().take(SAMPLERS) {
                    let mut unit = 0;
                    gl.get_uniformiv(program.name, sampler.location, &mut unit);
                    gl.active_texture(api::GL_TEXTURE0 + unit as u32);
                    look(bound(driver, sampler.target));
                }
            }
            _ if driver.profile.compatibility() => {
                for unit in 0..4 {
                    gl.active_texture(api::GL_TEXTURE0 + unit);
                    for target in [api::GL_TEXTURE_2D, api::GL_TEXTURE_RECTANGLE] {
                        if gl.is_enabled(target) != 0 {
                            look(bound(driver, target));
                        }
                    }
                }
            }
            _ => {}
        }
        gl.active_texture(active as u32);
    }
}

/// Returns the texture that is bound at the active unit; 0 for targets that the context does not
/// have.
pub fn bound(driver: &Driver, target: u32) -> u32 {
    let Profile { es, version, .. } = driver.profile;
    let binding = match target {
        api::GL_TEXTURE_2D => api::GL_TEXTURE_BINDING_2D,
        api::GL_TEXTURE_RECTANGLE if !es => api::GL_TEXTURE_BINDING_RECTANGLE,
        api::GL_TEXTURE_2D_MULTISAMPLE if version >= if es { 31 } else { 32 } => api::GL_TEXTURE_BINDING_2D_MULTISAMPLE,
        _ => return 0,
    };
    let mut texture = 0;
    // SAFETY: writes one integer.
    unsafe { driver.gl.get_integerv(binding, &mut texture) };
    texture as u32
}

/// Returns the followed images that the next draw samples.
pub fn sampled(driver: &Driver, shaders: &Shaders, view_copies: &ViewCopies) -> Set {
    let images = &view_copies.images;
    if !images.iter().any(|image| matches!(image.name, Name::Texture { .. })) {
        return 0;
    }
    let mut found = 0;
    each_texture(driver, shaders, |texture| {
        for (i, image) in images.iter().enumerate().take(64) {
            found |= Set::from(texture != 0 && image.is_texture(texture)) << i;
        }
    });
    found
}
