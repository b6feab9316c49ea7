//! Linked programs.

use crate::correct::projected::matrices::{LensConstants, ReprojectionMatrix};
use crate::intercept::gl::state::shader::uniforms::Uniforms;
use crate::intercept::gl::state::shader::variants::Variants;
use crate::runtime::session::Intrinsics;
use std::collections::HashMap;
use std::sync::{Arc, Mutex};

/// Rows that change nothing: the program's own picture.
pub const IDENTITY: ReprojectionMatrix = ReprojectionMatrix::IDENTITY;

/// Shaders and programs of a group of contexts.
#[derive(Default)]
pub struct Programs {
    pub(in crate::intercept::gl) sources: HashMap<u32, Arc<str>>,
    pub(in crate::intercept::gl) programs: HashMap<u32, Arc<Program>>,
}

/// A linked program.
pub struct Program {
    /// Its OpenGL name.
    pub name: u32,
    /// Where the rows of the re-projection go; −1 = it is not patched.
    pub(in crate::intercept::gl) location: i32,
    /// Where the lens of a view goes; −1 = all views are perspective ones.
    pub(in crate::intercept::gl) lens_location: i32,
    /// Index of our uniform among the active ones, to be own_uniform.
    pub own_uniform: Option<u32>,
    /// The bits of its stages that lie before rasterisation, as for `glUseProgramStages`.
    pub(in crate::intercept::gl) stages: u32,
    /// It uses the fixed-function matrices.
    pub(in crate::intercept::gl) fixed_matrices: bool,
    /// Its samplers of textures that can be drawn into.
    pub samplers: Vec<Sampler>,
    /// Where its vertices are, where that is proven.
    pub position: Option<Position>,
    /// Its fragments ask where on the screen they are.
    pub reads_frag_coord: bool,
    /// Its 4×4 matrices.
    pub uniforms: Mutex<Uniforms>,
    pub(in crate::intercept::gl) uploaded: Mutex<Uploaded>,
    /// The kinds and texts of its shaders, if its primitives may have to be divided.
    pub texts: Vec<(u32, Arc<str>)>,
    /// A primitive has the colour of its last vertex.
    pub flat: bool,
    /// What divides them.
    pub variants: Mutex<Variants>,
}

/// What a program has of a view.
#[derive(Default)]
pub(in crate::intercept::gl) struct Uploaded {
    pub(in crate::intercept::gl) rows: Option<ReprojectionMatrix>,
    pub(in crate::intercept::gl) lens: Option<LensConstants>,
}

/// What a program draws with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Lens {
    /// A perspective, and how it was found.
    Perspective(Intrinsics, &'static str),
    /// No perspective.
    Flat,
}

impl Program {
    /// Whether vertices go through its own shaders rather than the fixed-function pipeline.
    pub fn draws_vertices(&self) -> bool {
        self.stages != 0
    }

    /// The bits of its stages before rasterisation.
    pub fn stages(&self) -> u32 {
        self.stages
    }
}

/// A sampler of a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampler {
    /// Its location.
    pub location: i32,
    /// What it samples: `GL_TEXTURE_2D`, `GL_TEXTURE_RECTANGLE` or `GL_TEXTURE_2D_MULTISAMPLE`.
    pub target: u32,
}

/// Which array holds positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Array {
    /// That of `glVertexPointer`.
    Conventional,
    /// A generic attribute's, by its location.
    Generic(u32),
}

/// What is proven of a program: its positions are an array's, times matrices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Position {
    /// The array.
    pub array: Array,
    /// How many components count.
    pub components: usize,
    /// From the left.
    pub(in crate::intercept::gl) factors: Vec<Factor>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::intercept::gl) enum Factor {
    ModelView,
    Projection,
    /// By its number among the program's matrices.
    Uniform(usize),
}
