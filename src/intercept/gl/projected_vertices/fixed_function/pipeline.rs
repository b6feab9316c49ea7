//! What of the fixed-function pipeline's vertex stage is switched on.

use crate::backend::gl::api::{self, Gl};
use crate::intercept::gl::context::gl_context::{Context, Profile};

/// Lights that every driver has.
pub const LIGHTS: usize = 8;
/// Sets of texture coordinates that are followed.
pub const UNITS: usize = 8;

/// How a coordinate of a texture is made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Generated {
    /// As the program gives it.
    #[default]
    Given,
    /// `GL_OBJECT_LINEAR`.
    Object,
    /// `GL_EYE_LINEAR`.
    Eye,
    /// `GL_SPHERE_MAP`.
    Sphere,
    /// `GL_REFLECTION_MAP`.
    Reflection,
    /// `GL_NORMAL_MAP`.
    Normal,
}

/// Which properties of which faces follow the colour (`glColorMaterial`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Followed {
    /// `GL_FRONT`, `GL_BACK` or `GL_FRONT_AND_BACK`.
    pub face: u32,
    /// `GL_AMBIENT` and so on.
    pub property: u32,
}

/// What lighting does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Lighting {
    /// A bit for each light that is on.
    pub lights: u8,
    /// The viewer's direction is another for each vertex.
    pub local_viewer: bool,
    /// Back faces have a colour of their own.
    pub two_sided: bool,
    /// Highlights are added after the texture.
    pub separate_specular: bool,
    /// What follows the colour.
    pub followed: Option<Followed>,
}

/// The switches of the vertex stage; what has a value (lights, materials, matrices, planes) shaders read themselves.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Pipeline {
    /// Lighting, if it is on.
    pub lighting: Option<Lighting>,
    /// Normals are brought to length 1.
    pub normalised: bool,
    /// Normals are scaled by what the model-view matrix has of scale.
    pub rescaled: bool,
    /// Of each unit whose texture is on: how its four coordinates are made.
    pub units: [Option<[Generated; 4]>; UNITS],
    /// Fog is on; whether its coordinate is the program's.
    pub fog: Option<bool>,
    /// Some plane of the program's clips.
    pub clipped: bool,
    /// A primitive has the colour of its last vertex.
    pub flat: bool,
}

impl Pipeline {
    /// The switches as they are.
    ///
    /// # Errors
    /// What is on that is not followed, for the log.
    pub fn read(ctx: &Context) -> Result<Self, &'static str> {
        let (gl, profile) = (ctx.gl, &ctx.profile);
        if profile.version < 20 {
            return Err("there are no shaders before OpenGL 2.0");
        }
        let mut attenuation = [0.0f32; 4];
        // SAFETY: writes three numbers.
        unsafe { gl.get_floatv(api::GL_POINT_DISTANCE_ATTENUATION, attenuation.as_mut_ptr()) };
        if attenuation[..3] != [1.0, 0.0, 0.0] {
            return Err("a program's points become smaller with the distance");
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

    /// Whether `switch` of `glEnable` is one of these.
    pub fn has(switch: u32) -> bool {
        matches!(
            switch,
            api::GL_LIGHTING
                | api::GL_COLOR_MATERIAL
                | api::GL_NORMALIZE
                | api::GL_RESCALE_NORMAL
                | api::GL_FOG
                | api::GL_TEXTURE_1D
                | api::GL_TEXTURE_2D
                | api::GL_TEXTURE_3D
                | api::GL_TEXTURE_CUBE_MAP
                | api::GL_TEXTURE_RECTANGLE
                | api::GL_TEXTURE_GEN_S
                | api::GL_TEXTURE_GEN_T
                | api::GL_TEXTURE_GEN_R
                | api::GL_TEXTURE_GEN_Q
                | api::GL_VERTEX_PROGRAM_ARB
                | api::GL_FRAGMENT_PROGRAM_ARB
                | api::GL_LIGHT0..=api::GL_LIGHT7
                | api::GL_CLIP_PLANE0..=api::GL_CLIP_PLANE5
        )
    }
}

fn is_on(gl: &Gl, switch: u32) -> bool {
    // SAFETY: asks for a switch of the fixed-function pipeline.
    unsafe { gl.is_enabled(switch) != 0 }
}

fn integer(gl: &Gl, name: u32) -> i32 {
    let mut value = 0;
    // SAFETY: every value that is asked for here is one integer.
    unsafe { gl.get_integerv(name, &mut value) };
    value
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
        // SAFETY: a unit that there is; the active one is put back.
        unsafe { gl.active_texture(api::GL_TEXTURE0 + index as u32) };
        let textured =
            index < fixed && kinds.iter().any(|(kind, version)| profile.version >= *version && is_on(gl, *kind));
        // An assembly program may read any.
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
