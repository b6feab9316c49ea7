//! Switches of the fixed-function vertex stage.

use crate::backend::gl::driver::api;

/// Lights that every driver has.
pub const LIGHTS: usize = 8;

/// Sets of texture coordinates that are followed.
pub const UNITS: usize = 8;

/// Source of a texture coordinate.
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

/// Properties and faces that follow the colour (`glColorMaterial`).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Followed {
    /// `GL_FRONT`, `GL_BACK` or `GL_FRONT_AND_BACK`.
    pub face: u32,
    /// `GL_AMBIENT` and so on.
    pub property: u32,
}

/// Switches of lighting.
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
    /// Property that follows the colour.
    pub followed: Option<Followed>,
}

/// The switches of the vertex stage; what has a value (lights, materials, matrices, planes) shaders
/// read themselves.
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
    /// True if `switch` of `glEnable` is one of these.
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
