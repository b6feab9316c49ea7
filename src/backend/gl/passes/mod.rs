//! Runs a plan on the current context: one draw for each batch of rectangles, one for the pixels
//! that are always black.

mod backdrop;
mod cleared_views;
mod full_clear;
mod present;
mod unsampled_areas;

pub use backdrop::Spread;
pub use cleared_views::ClearedViews;

use crate::backend::gl::driver::api::*;
use crate::backend::gl::driver::errors::{MOST_ERRORS, drain};
use crate::backend::gl::driver::own_names;
use crate::backend::gl::objects::binaries::Binaries;
use crate::backend::gl::objects::program;
use crate::backend::gl::objects::target::Target;
use crate::backend::gl::objects::textures;
use crate::backend::gl::passes::backdrop::Backdrop;
use crate::backend::gl::passes::cleared_views::{Draw, Shows};
use crate::backend::gl::passes::full_clear::FullClear;
use crate::backend::gl::passes::unsampled_areas::UnsampledAreas;
use crate::backend::gl::state;
use crate::backend::gl::state::Capabilities;
use crate::backend::gl::state::known_state::KnownState;
use crate::cache::Cache;
use crate::correct::OutputPass;
use crate::correct::footprints;
use crate::correct::shaders::constants::Constants;
use crate::correct::shaders::draws;
use crate::correct::shaders::draws::{DrawList, FLOATS, Rows, SOURCE_FLOATS};
use crate::correct::shaders::glsl::{Language, Specialised, Stage, specialise};
use crate::correct::{Footprints, Plan, Source, Tile};
use crate::error::{Error, ErrorKind, Result};
use std::cell::Cell;
use std::collections::HashMap;
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
    }

    /// Returns the number of errors that Cupola's calls have caused. The program sees none of them.
    pub fn errors(&self) -> u64 {
        self.errors.get()
    }

    /// Returns the number of shader programs that were linked so far.
    pub fn linked(&self) -> u64 {
        self.linked
    }

    /// Compiles all shaders of `plan` and uploads rectangles and masks. `panel`: the flat panel is
    /// shown where the plan has one. Takes milliseconds per batch: call it only when the rig, a
    /// size or the panel changes. Programs that stay the same are used again. If the driver refuses
    /// a shader, the former correction stays in use.
    ///
    /// # Errors
    /// [`ErrorKind::Graphics`] where the driver refuses a shader or runs out of memory;
    /// [`ErrorKind::Internal`] where the plan exceeds the limits of the shaders.
    pub fn prepare(&mut self, gl: &Gl, plan: &Plan, panel: bool) -> Result<()> {
        self.prepare_passes(gl, plan, &plan.passes, panel)
    }

    /// As [`GlBackend::prepare`] for some of the plan's outputs.
    pub(in crate::backend::gl) fn prepare_passes(
        &mut self,
        gl: &Gl,
        plan: &Plan,
        passes: &[OutputPass],
        panel: bool,
    ) -> Result<()> {
        self.take_pending(gl);
        let caps = self.caps;
        let result = state::while_uploading(gl, &caps, || self.build(gl, plan, passes, panel));
        let before = self.errors();
        self.count_errors(gl);
        result?;
        if self.errors() != before {
            return Err(Error::new(
                ErrorKind::Graphics,
                "The driver reported an error while Cupola prepared the correction.",
            ));
        }
        Ok(())
    }

    /// Declares that from now on `targets`, one for each prepared output, are the only content of
    /// their framebuffer of `size` pixels. Pixels outside all outputs become black, and the whole
    /// framebuffer may be cleared first.
    pub fn own_framebuffer(&mut self, targets: &[Target], size: (u32, u32)) {
        self.full_clear = FullClear::of(targets, size, self.outputs.iter().map(|output| output.black));
    }

    /// Uploads `areas`, rectangles of an atlas of the given size in texels, for
    /// [`GlBackend::close_unsampled`]. With an empty list nothing is closed. Call it only when the
    /// plan changes.
    ///
    /// # Errors
    /// [`ErrorKind::Graphics`] where the driver refuses a shader.
    pub fn prepare_unsampled(&mut self, gl: &Gl, areas: &[Tile], atlas: (u32, u32)) -> Result<()> {
        self.take_pending(gl);
        if let Some(old) = self.unsampled.take() {
            old.destroy(gl);
        }
        if !areas.is_empty() {
            let unsampled = state::while_uploading(gl, &self.caps, || {
                UnsampledAreas::new(gl, &self.caps, &self.binaries, areas, atlas)
            });
            self.unsampled = Some(unsampled?);
        }
        self.count_errors(gl);
        Ok(())
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

    fn build(&mut self, gl: &Gl, plan: &Plan, passes: &[OutputPass], panel: bool) -> Result<()> {
        self.make_objects(gl);
        let mut old = take(&mut self.names.programs);
        let result = self.build_draws(gl, plan, passes, panel, &mut old);
        // Programs that stay the same were taken out of `old`. On an error nothing is deleted,
        // since the former correction stays in use.
        match result {
            Ok((outputs, list)) => {
                for program in old.into_values() {
                    // SAFETY: a context is current; the name is one that it gave.
                    unsafe { gl.delete_program(program) };
                }
                self.upload_textures(gl, passes, outputs);
                let [vertices, indices] = self.names.buffers;
                fill(gl, vertices, &list.vertices);
                fill(gl, indices, &list.indices);
                Ok(())
            }
            Err(error) => {
                self.names.programs.extend(old);
                Err(error)
            }
        }
    }

    fn make_objects(&mut self, gl: &Gl) {
        if self.names.vertex_array != 0 {
            return;
        }
        // SAFETY: a context is current; one name is written to each place.
        unsafe {
            self.names.buffers = [own_names::buffer(gl), own_names::buffer(gl)];
            self.make_vertex_array(gl);
            gl.gen_samplers(2, self.names.samplers.as_mut_ptr());
            for (sampler, filter) in self.names.samplers.into_iter().zip([GL_LINEAR, GL_NEAREST]) {
                gl.sampler_parameteri(sampler, GL_TEXTURE_MIN_FILTER, filter as i32);
                gl.sampler_parameteri(sampler, GL_TEXTURE_MAG_FILTER, filter as i32);
                gl.sampler_parameteri(sampler, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE as i32);
                gl.sampler_parameteri(sampler, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE as i32);
                if self.caps.srgb_decode {
                    gl.sampler_parameteri(sampler, GL_TEXTURE_SRGB_DECODE_EXT, GL_SKIP_DECODE_EXT as i32);
                }
            }
        }
    }

    fn make_vertex_array(&mut self, gl: &Gl) {
        let stride = (FLOATS * size_of::<f32>()) as i32;
        // SAFETY: a context is current; one name is written; the attributes lie in the buffer.
        unsafe {
            gl.gen_vertex_arrays(1, &mut self.names.vertex_array);
            gl.bind_vertex_array(self.names.vertex_array);
            let [vertices, indices] = self.names.buffers;
            gl.bind_buffer(GL_ARRAY_BUFFER, vertices);
            gl.bind_buffer(GL_ELEMENT_ARRAY_BUFFER, indices);
            let clip = FLOATS - SOURCE_FLOATS;
            for (attribute, count, offset) in [(0, clip, 0), (1, SOURCE_FLOATS, clip * size_of::<f32>())] {
                gl.enable_vertex_attrib_array(attribute);
                gl.vertex_attrib_pointer(attribute, count as i32, GL_FLOAT, 0, stride, offset as *const _);
            }
        }
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

    fn build_draws(
        &mut self,
        gl: &Gl,
        plan: &Plan,
        passes: &[OutputPass],
        panel: bool,
        old: &mut HashMap<Specialised, u32>,
    ) -> Result<(Vec<Output>, DrawList)> {
        let list = draws::draws(plan, passes, panel, Rows::FromBottom)?;
        let mut outputs = Vec::with_capacity(passes.len());
        for (pass, draws) in passes.iter().zip(&list.outputs) {
            let index = plan.passes.iter().position(|other| std::ptr::eq(other, pass));
            let views = index.and_then(|index| plan.views.output_views.get(index));
            let footprints = views.and_then(|views| footprints(plan, pass, views));
            let black = pass.black_part();
            let mut output = Output { size: pass.size, footprints, black, ..Output::default() };
            for draw in draws {
                let program = self.program(gl, &draw.constants, old)?;
                let (first, count) = (draw.first as i32, draw.count as i32);
                let views = draw.views.iter().fold(0, |bits, view| bits | 1u64.checked_shl(*view as u32).unwrap_or(0));
                let followed = draw.views.iter().all(|view| *view < 64);
                let shows = if followed { cleared_views::shows(&draw.constants) } else { Shows::Other };
                output.draws.push(Draw { program, first, count, views, shows, nearest: draw.nearest });
            }
            outputs.push(output);
        }
        Ok((outputs, list))
    }

    fn program(&mut self, gl: &Gl, constants: &Constants, old: &mut HashMap<Specialised, u32>) -> Result<u32> {
        let language = if self.caps.gles { Language::Essl300 } else { Language::Glsl330 };
        let text = specialise(constants, language, self.stage);
        let known = self.names.programs.get(&text).copied().or_else(|| old.remove(&text));
        let program = match known {
            Some(program) => program,
            None => {
                self.linked += 1;
                program::build(gl, &text, &self.binaries)?
            }
        };
        self.names.programs.insert(text, program);
        Ok(program)
    }

    fn upload_textures(&mut self, gl: &Gl, passes: &[OutputPass], outputs: Vec<Output>) {
        self.outputs = outputs;
        for texture in take(&mut self.names.textures) {
            // SAFETY: a context is current; the name is one that it gave.
            unsafe { gl.delete_textures(1, &texture) };
        }
        for (pass, output) in passes.iter().zip(&mut self.outputs) {
            if let Some(mask) = &pass.mask {
                output.mask = textures::upload_mask(gl, &self.caps, mask);
                self.names.textures.push(output.mask);
            }
            if let Some(black) = &pass.black {
                output.black_picture = textures::upload_black(gl, &self.caps, black);
                self.names.textures.push(output.black_picture);
            }
            let table_is_read = pass.batches.iter().any(|batch| batch.facets.is_none());
            if let Source::Table(table) = &pass.source
                && table_is_read
            {
                output.table = textures::upload_table(gl, table);
                self.names.textures.push(output.table);
            }
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

fn fill<T: Copy>(gl: &Gl, buffer: u32, values: &[T]) {
    // SAFETY: a context is current and gave the name; `size` is that of the array. A buffer has no
    // fixed type: bound as `GL_ARRAY_BUFFER` it changes no vertex array.
    unsafe {
        gl.bind_buffer(GL_ARRAY_BUFFER, buffer);
        let size = std::mem::size_of_val(values) as isize;
        gl.buffer_data(GL_ARRAY_BUFFER, size, values.as_ptr().cast(), GL_STATIC_DRAW);
    }
}
