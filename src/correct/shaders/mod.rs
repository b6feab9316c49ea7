//! From passes to shaders and draws, for either graphics API.
//!
//! The build script compiles the WGSL sources and generates a struct for the constants of each pass
//! (`constants`). `uniforms` and `uniforms_…` fill the structs. `glsl` and `spirv` put the values
//! into the text or into the words of a program, so that compilers drop the branches that a batch
//! does not need. `draws` lists vertices and draw calls. `map` reads the map that the shaders
//! compute, for tests and tools.

pub mod constants;
pub mod draws;
pub mod glsl;
pub mod map;
pub mod polynomials;
pub mod response;
pub mod spirv;
pub mod uniforms;
mod uniforms_content;
mod uniforms_optics;
pub mod uniforms_panorama;
pub mod uniforms_projector;
