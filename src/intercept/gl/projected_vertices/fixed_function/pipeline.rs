//! Switches of the fixed-function pipeline's vertex stage.

use crate::backend::gl::driver::api::{self, Gl};
use crate::backend::gl::driver::values::integer;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::driver::profile::Profile;
use crate::intercept::gl::state::projected_vertices::fixed_pipeline::{
    Followed, Generated, LIGHTS, Lighting, Pipeline, UNITS,
};
use crate::intercept::scene::obstacle::Obstacle;

impl Pipeline {
    /// Returns the present switches.
    ///
    /// # Errors
    /// An enabled switch that Cupola does not support, for the log.
    pub fn read(driver: &Driver) -> Result<Self, Obstacle> {
        let (gl, profile) = (driver.gl, &driver.profile);
        if profile.version < 20 {
            return Err("there are no shaders before OpenGL 2.0".into());
        }
        let mut attenuation = [0.0f32; 4];
        // SAFETY: writes three numbers.
        unsafe { gl.get_floatv(api::GL_POINT_DISTANCE_ATTENUATION, attenuation.as_mut_ptr()) };
        if attenuation[..3] != [1.0, 0.0, 0.0] {
            return Err("a program's points become smaller with the distance".into());
        }
        let on = |switch: u32| is_on(gl, switch);
        Ok(Self {
            lighting: on(api::GL_LIGHTING).then(|| lighting(gl)),
            normalised: on(api::GL_NORMALIZE),
            rescaled: on(api::GL_RESCALE_NORMAL),
            units: units(gl, profile),
            fog: on(api::GL_FOG).then(|| integer(gl, api::GL_FOG_COORD_SRC) as u32 == api::GL_FOG_COORD),
            clipped: (0..6).any(|plane| on(api::GL_CLIP_PLANE0 + plane)),
            flat: integer(gl, api::GL_SHADE_MODEL) as u32 == api::GL_FLAT,
        })
    }
}

fn is_on(gl: &Gl, switch: u32) -> bool {
    // SAFETY: asks for a switch of the fixed-function pipeline.
    unsafe { gl.is_enabled(switch) != 0 }
}

fn lighting(gl: &Gl) -> Lighting {
    let lights = (0..LIGHTS).filter(|light| is_on(gl, api::GL_LIGHT0 + *light as u32)).fold(0, |all, i| all | 1 << i);
    let followed = is_on(gl, api::GL_COLOR_MATERIAL).then(|| Followed {
        face: integer(gl, api::GL_COLOR_MATERIAL_FACE) as u32,
        property: integer(gl, api::GL_COLOR_MATERIAL_PARAMETER) as u32,
    });
    Lighting {
        lights,
        local_viewer: integer(gl, api::GL_LIGHT_MODEL_LOCAL_VIEWER) != 0,
        two_sided: integer(gl, api::GL_LIGHT_MODEL_TWO_SIDE) != 0,
        separate_specular: integer(gl, api::GL_LIGHT_MODEL_COLOR_CONTROL) as u32 == api::GL_SEPARATE_SPECULAR_COLOR,
        followed,
    }
}

fn units(gl: &Gl, profile: &Profile) -> [Option<[Generated; 4]>; UNITS] {
    let mut all = [None; UNITS];
    let count = usize::try_from(integer(gl, api::GL_MAX_TEXTURE_COORDS)).unwrap_or(0).min(UNITS);
    let fixed = usize::try_from(integer(gl, api::GL_MAX_TEXTURE_UNITS)).unwrap_or(0);
    let active = integer(gl, api::GL_ACTIVE_TEXTURE) as u32;
    let assembly = is_on(gl, api::GL_FRAGMENT_PROGRAM_ARB);
    let kinds = [
        (api::GL_TEXTURE_1D, 0),
        (api::GL_TEXTURE_2D, 0),
        (api::GL_TEXTURE_3D, 0),
        (api::GL_TEXTURE_CUBE_MAP, 0),
        (api::GL_TEXTURE_RECTANGLE, 31),
    ];
    for (index, unit) in all.iter_mut().enumerate().take(count) {
        // SAFETY: this unit exists; the active one is put back.
        unsafe { gl.active_texture(api::GL_TEXTURE0 + index as u32) };
        let textured =
            index < fixed && kinds.iter().any(|(kind, version)| profile.version >= *version && is_on(gl, *kind));
        // A fragment program in assembly language may read any coordinate.
        if textured || assembly {
            let coordinates =
                [api::GL_TEXTURE_GEN_S, api::GL_TEXTURE_GEN_T, api::GL_TEXTURE_GEN_R, api::GL_TEXTURE_GEN_Q];
            let names = [api::GL_S, api::GL_T, api::GL_R, api::GL_Q];
            *unit = Some(std::array::from_fn(|i| match is_on(gl, coordinates[i]) {
                true => generated(gl, names[i]),
                false => Generated::Given,
            }));
        }
    }
    // SAFETY: as above.
    unsafe { gl.active_texture(active) };
    all
}

fn generated(gl: &Gl, coordinate: u32) -> Generated {
    let mut mode = 0;
    // SAFETY: writes one integer.
    unsafe { gl.get_tex_geniv(coordinate, api::GL_TEXTURE_GEN_MODE, &mut mode) };
    match mode as u32 {
        api::GL_OBJECT_LINEAR => Generated::Object,
        api::GL_SPHERE_MAP => Generated::Sphere,
        api::GL_REFLECTION_MAP => Generated::Reflection,
        api::GL_NORMAL_MAP => Generated::Normal,
        _ => Generated::Eye,
    }
}
