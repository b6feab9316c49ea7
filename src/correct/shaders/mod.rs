//! TODO-NOTE

pub mod constants;
pub mod draws;
pub mod glsl;
pub mod map;
pub mod polynomials;
pub mod response;
pub mod spirv;
pub mod uniforms;
pub mod uniforms_optics;
pub mod uniforms_panorama;
pub mod uniforms_projector;
