//! Objects of Cupola in the program's context: programs, textures, framebuffers.

pub mod binaries;
pub mod framebuffers;
pub mod own_framebuffer;
pub mod program;
pub mod surface;
pub mod target;
pub mod textures;
