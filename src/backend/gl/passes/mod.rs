//! Runs a plan on the current context: one draw for each batch of rectangles, one for the pixels
//! that are always black. `prepare` makes shaders, rectangles and textures, `present` draws.

mod ahead;
mod backdrop;
mod cleared_views;
mod full_clear;
mod prepare;
mod present;
mod unsampled_areas;

pub use backdrop::Spread;
pub use cleared_views::ClearedViews;

use crate::backend::gl::driver::api::*;
use crate::backend::gl::driver::errors::{MOST_ERRORS, drain};
use crate::backend::gl::objects::binaries::Binaries;
use crate::backend::gl::objects::target::Target;
use crate::backend::gl::passes::backdrop::Backdrop;
use crate::backend::gl::passes::cleared_views::Draw;
use crate::backend::gl::passes::full_clear::FullClear;
use crate::backend::gl::passes::unsampled_areas::UnsampledAreas;
use crate::backend::gl::state;
use crate::backend::gl::state::Capabilities;
use crate::backend::gl::state::known_state::KnownState;
use crate::cache::Cache;
use crate::correct::Footprints;
use crate::correct::shaders::glsl::{Specialised, Stage};
use crate::error::{Error, ErrorKind, Result};
use std::cell::Cell;
use std::collections::{HashMap, HashSet};
use std::mem::take;

/// Objects and draws of one output.
#[derive(Debug, Default)]
struct Output {
    size: (u32, u32),
    draws: Vec<Draw>,
    /// 0 = none.
    mask: u32,
    /// 0 = none.
    table: u32,
    /// Texture of the codes to which black is raised; 0 = none.
    black_picture: u32,
    footprints: Option<Footprints>,
    /// Part of the output that is black whatever the views show.
    black: f64,
}

/// Names of Cupola's objects in the context.
#[derive(Debug, Default)]
struct Names {
    vertex_array: u32,
    /// Vertices, indices.
    buffers: [u32; 2],
    /// Linear, nearest.
    samplers: [u32; 2],
    programs: HashMap<Specialised, u32>,
    /// Masks, tables and pictures of black.
    textures: Vec<u32>,
}

/// The correction on one context. Each context needs its own backend, since contexts do not share
/// vertex arrays.
///
/// The context on which the backend was made must be current. [`GlBackend::destroy`] deletes its
/// objects. Dropping deletes nothing, since no context may be current then.
pub struct GlBackend {
    caps: Capabilities,
    stage: Stage,
    binaries: Binaries,
    names: Names,
    outputs: Vec<Output>,
    /// Programs that the next plan needs and that do not exist yet.
    ahead: Vec<Specialised>,
    /// Programs of the last rough correction, which are kept for the next one.
    kept: HashSet<Specialised>,
    /// Programs before the first of several rough corrections; empty if none is prepared.
    exact: HashSet<Specialised>,
    full_clear: Option<FullClear>,
    unsampled: Option<UnsampledAreas>,
    backdrop: Option<Backdrop>,
    errors: Cell<u64>,
    left_out: Cell<u64>,
    narrowed: Cell<u64>,
    linked: u64,
    /// Error of the program that was read while preparing.
    pending: Cell<u32>,
}

impl GlBackend {
    /// Makes a backend on the current context, with nothing prepared. `is_gles`: the context is
    /// OpenGL ES.
    ///
    /// # Errors
    /// [`ErrorKind::Graphics`] where the context is older than OpenGL 3.3 or OpenGL ES 3.0.
    pub fn new(gl: &Gl, is_gles: bool) -> Result<Self> {
        Self::for_stage(gl, is_gles, Stage::Present)
    }

    /// As [`GlBackend::new`], with another last stage.
    pub(in crate::backend::gl) fn for_stage(gl: &Gl, is_gles: bool, stage: Stage) -> Result<Self> {
        let pending = Cell::new(drain(gl));
        let caps = Capabilities::of(gl, is_gles);
        let (needed, name) = if is_gles { (30, "OpenGL ES 3.0") } else { (33, "OpenGL 3.3") };
        if caps.version < needed {
            let (major, minor) = (caps.version / 10, caps.version % 10);
            let message = format!("Correcting needs {name}; the program's context is version {major}.{minor}.");
            return Err(Error::new(ErrorKind::Graphics, message));
        }
        let backend = Self {
            caps,
            stage,
            binaries: Binaries::default(),
            names: Names::default(),
            outputs: Vec::new(),
            ahead: Vec::new(),
            kept: HashSet::new(),
            exact: HashSet::new(),
            full_clear: None,
            unsampled: None,
            backdrop: None,
            errors: Cell::new(0),
            left_out: Cell::new(0),
            narrowed: Cell::new(0),
            linked: 0,
            pending,
        };
        backend.count_errors(gl);
        Ok(backend)
    }

    /// Returns the backend with `cache` for linked programs, if the driver offers program binaries.
    pub fn with_cache(mut self, gl: &Gl, cache: &Cache) -> Self {
        self.binaries = Binaries::new(gl, cache.clone(), self.caps.program_binaries);
        self
    }

    /// Takes over the programs of another backend of the same context, so that
    /// [`GlBackend::prepare`] links only those that are new. The other one has none afterwards.
    pub fn inherit(&mut self, other: &mut Self) {
        self.names.programs.extend(other.names.programs.drain());
        self.kept = take(&mut other.kept);
    }

    /// Returns the number of errors that Cupola's calls have caused. The program sees none of them.
    pub fn errors(&self) -> u64 {
        self.errors.get()
    }

    /// Returns the number of shader programs that were linked so far.
    pub fn linked(&self) -> u64 {
        self.linked
    }

    /// Declares that from now on `targets`, one for each prepared output, are the only content of
    /// their framebuffer of `size` pixels. Pixels outside all outputs become black, and the whole
    /// framebuffer may be cleared first.
    pub fn own_framebuffer(&mut self, targets: &[Target], size: (u32, u32)) {
        self.full_clear = FullClear::of(targets, size, self.outputs.iter().map(|output| output.black));
    }

    /// Closes the prepared areas after the program cleared the depth of the atlas, which is bound,
    /// to `cleared` (0…1). They get the depth farthest from `cleared`, so that drawing there fails
    /// the usual depth tests. Colours and stencil do not change.
    ///
    /// Returns the number of texels that were closed: 0 if no areas are prepared, if the program
    /// does not write depth, or while it counts samples. Allocates nothing. State and errors are
    /// restored as by [`GlBackend::present`], but the program's pending error is returned by the
    /// next call of `present`. State in `known` is not queried.
    pub fn close_unsampled(&self, gl: &Gl, cleared: f32, known: &KnownState) -> u64 {
        let Some(unsampled) = &self.unsampled else { return 0 };
        self.take_pending(gl);
        let texels = unsampled.close(gl, &self.caps, cleared, known);
        self.count_errors(gl);
        texels
    }

    /// Fills tiles of the framebuffer that is bound for drawing with a picture behind the scene.
    /// Returns false if the tiles could not be filled completely. The program's state and errors
    /// are restored as by [`GlBackend::close_unsampled`].
    ///
    /// # Errors
    /// [`ErrorKind::Graphics`] where the driver refuses the shader or a copy of the picture.
    pub fn spread(&mut self, gl: &Gl, what: &Spread<'_>, known: &KnownState) -> Result<bool> {
        self.take_pending(gl);
        let caps = self.caps;
        let mut backdrop = match self.backdrop.take() {
            Some(backdrop) => backdrop,
            None => state::while_uploading(gl, &caps, || Backdrop::new(gl, &caps, &self.binaries))?,
        };
        let done = backdrop.spread(gl, &caps, what, known);
        self.backdrop = Some(backdrop);
        self.count_errors(gl);
        done
    }

    /// Runs `work`, which uploads tightly packed rows to textures. The state that uploading changes
    /// is restored.
    pub fn while_uploading<R>(&self, gl: &Gl, work: impl FnOnce() -> R) -> R {
        state::while_uploading(gl, &self.caps, work)
    }

    /// Returns the name of the vertex array, which contexts do not share.
    pub fn vertex_array(&self) -> u32 {
        self.names.vertex_array
    }

    /// True if the current context is that of the backend: contexts do not share vertex arrays.
    /// Also true, wrongly, for another context that has a vertex array of the same name.
    pub fn is_of_current_context(&self, gl: &Gl) -> bool {
        // SAFETY: a query; without a context, functions of OpenGL do nothing and return 0.
        unsafe { gl.is_vertex_array(self.names.vertex_array) != 0 }
    }

    /// Moves to the current context, which shares objects with the former one. All bindings are
    /// restored.
    pub fn rehome(&mut self, gl: &Gl) {
        if let Some(backdrop) = &mut self.backdrop {
            backdrop.rehome(gl);
        }
        if self.names.vertex_array != 0 {
            let caps = self.caps;
            state::while_uploading(gl, &caps, || self.make_vertex_array(gl));
        }
    }

    /// Deletes everything in the context, which must be current.
    pub fn destroy(&mut self, gl: &Gl) {
        self.outputs.clear();
        if let Some(unsampled) = self.unsampled.take() {
            unsampled.destroy(gl);
        }
        if let Some(backdrop) = self.backdrop.take() {
            backdrop.destroy(gl);
        }
        let names = take(&mut self.names);
        // SAFETY: the context is current and gave these names; 0 is ignored.
        unsafe {
            for program in names.programs.values() {
                gl.delete_program(*program);
            }
            gl.delete_textures(names.textures.len() as i32, names.textures.as_ptr());
            gl.delete_samplers(2, names.samplers.as_ptr());
            gl.delete_buffers(2, names.buffers.as_ptr());
            gl.delete_vertex_arrays(1, &names.vertex_array);
        }
        self.count_errors(gl);
    }

    /// Returns the names of the programs in the context, sorted.
    #[cfg(test)]
    pub(in crate::backend::gl) fn programs(&self) -> Vec<u32> {
        let mut programs: Vec<u32> = self.names.programs.values().copied().collect();
        programs.sort_unstable();
        programs
    }

    /// Stores the program's first pending error.
    fn take_pending(&self, gl: &Gl) {
        let found = drain(gl);
        if self.pending.get() == GL_NO_ERROR {
            self.pending.set(found);
        }
    }

    fn count_errors(&self, gl: &Gl) {
        // SAFETY: a context is current. A lost context may report errors for ever.
        while unsafe { gl.get_error() } != GL_NO_ERROR {
            self.errors.set(self.errors.get() + 1);
            if self.errors.get().is_multiple_of(MOST_ERRORS) {
                break;
            }
        }
    }
}
