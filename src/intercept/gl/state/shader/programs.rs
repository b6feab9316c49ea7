//! Linked programs.

use crate::backend::gl::driver::api::Gl;
use crate::correct::projected::matrices::{LensConstants, ReprojectionMatrix};
use crate::intercept::gl::state::shader::assembly::AssemblyProgram;
use crate::intercept::gl::state::shader::attribute_matrices::AttributeMatrix;
use crate::intercept::gl::state::shader::camera_matrices::CameraMatrices;
use crate::intercept::gl::state::shader::position_names::PositionNames;
use crate::intercept::gl::state::shader::uniforms::Uniforms;
use crate::intercept::gl::state::shader::variants::Variants;
use crate::intercept::scene::lens::Told;
use std::collections::{BTreeMap, HashMap, HashSet};
use std::ffi::CString;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::{Arc, Mutex};

/// Reprojection matrix that changes nothing, for the program's own picture.
pub const IDENTITY: ReprojectionMatrix = ReprojectionMatrix::IDENTITY;

/// Shaders and programs of a group of contexts.
#[derive(Default)]
pub struct Programs {
    /// Latest texts that the program gave to the shaders.
    pub(in crate::intercept::gl) sources: HashMap<u32, Arc<str>>,
    /// Texts at the time when the shaders were compiled. These are linked.
    pub(in crate::intercept::gl) compiled: HashMap<u32, Arc<str>>,
    /// Shaders that are compiled from a text that Cupola changed for a linked program.
    pub(in crate::intercept::gl) changed: HashSet<u32>,
    pub(in crate::intercept::gl) uses: Uses,
    pub(in crate::intercept::gl) programs: HashMap<u32, Arc<Program>>,
    /// What the application has set for the next link of each program.
    pub(in crate::intercept::gl) link_settings: HashMap<u32, LinkSettings>,
    /// Vertex programs in assembly language that Cupola changed.
    pub(in crate::intercept::gl) assembly: HashMap<u32, Arc<AssemblyProgram>>,
}

/// A buffer that shaders change.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ChangedBuffer {
    /// Atomic counters.
    Counters {
        /// Their binding.
        binding: u32,
        /// Their size in bytes.
        size: usize,
    },
    /// A storage buffer.
    Storage {
        /// The program.
        program: u32,
        /// Number of its block, whose binding the application may change.
        block: u32,
    },
}

/// An image that shaders may write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WrittenImage {
    /// The program.
    pub program: u32,
    /// Location of its uniform.
    pub location: i32,
    /// Type of its uniform.
    pub kind: u32,
}

/// Settings for the next link of a program, by their kind and name: commands for another program.
pub(in crate::intercept::gl) type LinkSettings = BTreeMap<(u8, CString), Arc<dyn Fn(&Gl, u32) + Send + Sync>>;

/// Programs in use, by their names. OpenGL keeps a deleted program as long as it is in use. Cupola
/// puts other programs in use for its own draws. It therefore deletes a program in the driver only
/// when no context uses it any more.
#[derive(Default)]
pub(in crate::intercept::gl) struct Uses {
    /// Number of contexts that use a program.
    contexts: HashMap<u32, u32>,
    /// Programs whose deletion waits.
    deleted: HashSet<u32>,
}

impl Uses {
    /// Notes that a context uses `new` in place of `old`; 0 = none.
    pub fn change(&mut self, old: u32, new: u32) {
        if new != 0 {
            *self.contexts.entry(new).or_insert(0) += 1;
        }
        if let Some(count) = self.contexts.get_mut(&old) {
            *count -= 1;
            if *count == 0 {
                self.contexts.remove(&old);
            }
        }
    }

    /// Notes that the program deletes an object. Returns true if the deletion has to wait.
    pub fn delete(&mut self, name: u32) -> bool {
        let used = self.contexts.contains_key(&name);
        if used {
            self.deleted.insert(name);
        }
        used
    }

    /// True if a context uses a program.
    pub fn contain(&self, name: u32) -> bool {
        self.contexts.contains_key(&name)
    }

    /// True if the deletion of a program waits.
    pub fn is_deleted(&self, name: u32) -> bool {
        self.deleted.contains(&name)
    }

    /// Takes a deleted program that no context uses any more, if there is one.
    pub fn take_unused(&mut self) -> Option<u32> {
        let name = self.deleted.iter().copied().find(|name| !self.contexts.contains_key(name))?;
        self.deleted.remove(&name);
        Some(name)
    }
}

/// A linked program.
pub struct Program {
    /// Its OpenGL name.
    pub name: u32,
    /// Location of the reprojection matrix; −1 = the program is not patched.
    pub(in crate::intercept::gl) location: i32,
    /// Location of a view's lens constants; −1 = all views are perspective views.
    pub(in crate::intercept::gl) lens_location: i32,
    /// Indices of Cupola's uniforms among the active ones, in their order.
    pub own_uniforms: Vec<u32>,
    /// Locations of Cupola's uniforms.
    pub own_locations: Vec<Range<i32>>,
    /// Name of a program of Cupola without an executable, which answers for this one: this one was
    /// linked again without success while it was in use, and so keeps its executable. 0 = none.
    pub(in crate::intercept::gl) failed: AtomicU32,
    /// True if the driver has accepted it for a pipeline since it was linked.
    pub(in crate::intercept::gl) is_stage: AtomicBool,
    /// Buffers that its shaders change.
    pub changed_buffers: Vec<ChangedBuffer>,
    /// Images that draws of the program may write.
    pub written_images: Vec<WrittenImage>,
    /// The bits of its stages that lie before rasterisation, as for `glUseProgramStages`.
    pub(in crate::intercept::gl) stages: u32,
    /// True if the program uses the fixed-function matrices.
    pub(in crate::intercept::gl) fixed_matrices: bool,
    /// Its samplers of textures that can be drawn into.
    pub samplers: Vec<Sampler>,
    /// Source of its positions, if the source is proven.
    pub position: Option<Position>,
    /// True if subroutines can be chosen. The choice is lost when another program is put in use.
    pub(in crate::intercept::gl) subroutines: bool,
    /// True if its fragments read window coordinates. These are the coordinates in the framebuffer
    /// that is drawn to.
    pub reads_frag_coord: bool,
    /// Present if its fragments get the coordinates of the program's window instead.
    pub frag_coord: Option<FragCoord>,
    /// True if its primitives choose a viewport by its index.
    pub chooses_viewport: bool,
    /// Names that flow into its position; `None` = unknown, so that any name may.
    pub position_names: Option<PositionNames>,
    /// True if some of its matrices are vectors that are set one by one.
    pub(in crate::intercept::gl) has_vectors: bool,
    /// Its 4×4 matrices that may flow into its position.
    pub uniforms: Mutex<Uniforms>,
    /// Its compute shader.
    pub compute: Option<ComputeStage>,
    /// True if some of its stages can choose between its own matrices and those of Cupola.
    pub has_camera_matrices: bool,
    /// The matrices between which its stages choose.
    pub camera_matrices: Mutex<CameraMatrices>,
    /// 4×4 matrices in its vertex attributes.
    pub attribute_matrices: Mutex<Vec<AttributeMatrix>>,
    pub(in crate::intercept::gl) uploaded: Mutex<Uploaded>,
    /// The kinds and texts of its shaders, if its primitives may have to be divided.
    pub texts: Vec<(u32, Arc<str>)>,
    /// True if a primitive has the colour of its last vertex.
    pub flat: bool,
    /// Variants that divide its primitives.
    pub variants: Mutex<Variants>,
}

/// Kind of a compute shader's writes to buffers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BufferWrites {
    /// Nothing.
    Nothing,
    /// Sums and other results of atomic functions.
    Sums,
    /// Values at places in a buffer.
    Places,
}

/// A compute shader.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ComputeStage {
    /// Locations of its images of two dimensions.
    pub images: Vec<i32>,
    /// Locations of other images that it may write: with layers, of one or three dimensions, of
    /// buffers.
    pub other_images: Vec<i32>,
    /// True if it has atomic functions on images.
    pub image_atomics: bool,
    /// Kind of its writes to buffers.
    pub buffers: BufferWrites,
    /// True if it has matrices that may be the camera's, and does not get those of a view.
    pub loses_cameras: bool,
}

/// Constants of a view that were uploaded to a program.
#[derive(Default)]
pub(in crate::intercept::gl) struct Uploaded {
    pub(in crate::intercept::gl) reprojection: Option<ReprojectionMatrix>,
    pub(in crate::intercept::gl) lens: Option<LensConstants>,
    /// Value of the uniform of [`FragCoord`].
    pub(in crate::intercept::gl) to_window: Option<[f32; 4]>,
}

/// Source of the program's window coordinates in fragment shaders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FragCoord {
    /// Location of Cupola's uniform.
    pub location: i32,
    /// True if rows count from above.
    pub upper_left: bool,
}

impl FragCoord {
    /// Cupola's uniform: the numbers that are subtracted from the driver's coordinates, and the
    /// factors for the result.
    pub const UNIFORM: &str = "cupola_to_window";
}

/// Projection with which a program draws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProgramLens {
    /// A perspective projection, and the way in which it was found.
    Perspective(Told, &'static str),
    /// No perspective projection.
    Flat,
}

impl Program {
    /// True if vertices go through its own shaders rather than the fixed-function pipeline.
    pub fn draws_vertices(&self) -> bool {
        self.stages != 0
    }

    /// Returns the name of the program that answers the application's questions about this one.
    pub fn asked(&self) -> u32 {
        match self.failed.load(Ordering::Relaxed) {
            0 => self.name,
            failed => failed,
        }
    }

    /// True if the application cannot set a uniform at this location, since it is one of Cupola's,
    /// or since the last link failed.
    pub fn refuses(&self, location: i32) -> bool {
        self.failed.load(Ordering::Relaxed) != 0 || self.owns(location)
    }

    /// True if the location is that of a uniform of Cupola.
    pub fn owns(&self, location: i32) -> bool {
        self.own_locations.iter().any(|own| own.contains(&location))
    }

    /// Returns the bits of its stages before rasterisation.
    pub fn stages(&self) -> u32 {
        self.stages
    }
}

/// A sampler of a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampler {
    /// Its location.
    pub location: i32,
    /// Texture target: `GL_TEXTURE_2D`, `GL_TEXTURE_RECTANGLE` or `GL_TEXTURE_2D_MULTISAMPLE`.
    pub target: u32,
}

/// Array that holds positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Array {
    /// The array of `glVertexPointer`.
    Conventional,
    /// The array of a generic attribute, by its location.
    Generic(u32),
}

/// Proven source of a program's positions: an array that is multiplied by matrices.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Position {
    /// The array.
    pub array: Array,
    /// Number of components that count.
    pub components: usize,
    /// Matrices by which the array is multiplied, from the left.
    pub(in crate::intercept::gl) factors: Vec<Factor>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::intercept::gl) enum Factor {
    ModelView,
    Projection,
    /// A matrix by its index among the program's matrices.
    Uniform(usize),
}

#[cfg(test)]
mod tests {
    use super::Uses;

    #[test]
    fn a_deleted_program_lives_as_long_as_a_context_uses_it() {
        let mut uses = Uses::default();
        assert!(!uses.delete(3), "nobody uses it");
        uses.change(0, 3);
        uses.change(0, 3);
        assert!(uses.delete(3) && uses.is_deleted(3));
        uses.change(3, 4);
        assert_eq!(uses.take_unused(), None, "another context uses it");
        uses.change(3, 0);
        assert_eq!((uses.take_unused(), uses.take_unused()), (Some(3), None));
        assert!(!uses.is_deleted(3) && !uses.delete(3) && uses.delete(4));
        uses.change(4, 4);
        assert_eq!(uses.take_unused(), None, "used again");
    }
}
