//! Switches of the fixed-function vertex stage.

use crate::backend::gl::driver::api;

/// Number of lights that every driver has.
pub const LIGHTS: usize = 8;

/// Number of sets of texture coordinates that are followed.
pub const UNITS: usize = 8;

/// Source of a texture coordinate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Generated {
    /// The coordinate that the program gives.
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
    /// True if the direction to the viewer differs for each vertex.
    pub local_viewer: bool,
    /// True if back faces have a colour of their own.
    pub two_sided: bool,
    /// True if highlights are added after the texture.
    pub separate_specular: bool,
    /// Property that follows the colour.
    pub followed: Option<Followed>,
}

/// The switches of the vertex stage. Shaders read values (lights, materials, matrices, planes)
/// themselves.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct Pipeline {
    /// Lighting, if it is on.
    pub lighting: Option<Lighting>,
    /// True if normals are scaled to length 1.
    pub normalised: bool,
    /// True if normals are scaled by a factor that comes from the model-view matrix.
    pub rescaled: bool,
    /// For each unit whose texture is on, the sources of its four coordinates.
    pub units: [Option<[Generated; 4]>; UNITS],
    /// Present if fog is on; true if the program gives the fog coordinate.
    pub fog: Option<bool>,
    /// True if any clip plane of the program is on.
    pub clipped: bool,
    /// True if a primitive has the colour of its last vertex.
    pub flat: bool,
}

impl Pipeline {
    /// True if `switch` of `glEnable` is one of these switches.
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
