//! Preparation: shaders, rectangles and textures of a plan.

use crate::backend::gl::driver::api::*;
use crate::backend::gl::driver::own_names;
use crate::backend::gl::objects::program;
use crate::backend::gl::objects::textures;
use crate::backend::gl::passes::cleared_views::{Draw, Shows};
use crate::backend::gl::passes::unsampled_areas::UnsampledAreas;
use crate::backend::gl::passes::{GlBackend, Output, cleared_views};
use crate::backend::gl::state;
use crate::correct::OutputPass;
use crate::correct::footprints;
use crate::correct::shaders::constants::Constants;
use crate::correct::shaders::draws;
use crate::correct::shaders::draws::{DrawList, FLOATS, Rows, SOURCE_FLOATS};
use crate::correct::shaders::glsl::{Language, Specialised, specialise};
use crate::correct::{Plan, Source, Tile};
use crate::error::{Error, ErrorKind, Result};
use std::collections::HashMap;
use std::mem::{replace, take};

fn fill<T: Copy>(gl: &Gl, buffer: u32, values: &[T]) {
    // SAFETY: a context is current and gave the name; `size` is that of the array. A buffer has no
    // fixed type: bound as `GL_ARRAY_BUFFER` it changes no vertex array.
    unsafe {
        gl.bind_buffer(GL_ARRAY_BUFFER, buffer);
        let size = std::mem::size_of_val(values) as isize;
        gl.buffer_data(GL_ARRAY_BUFFER, size, values.as_ptr().cast(), GL_STATIC_DRAW);
    }
}

impl GlBackend {
    /// Compiles all shaders of `plan` and uploads rectangles and masks. `panel`: the flat panel is
    /// shown where the plan has one. Takes milliseconds per batch: call it only when the rig, a
    /// size or the panel changes. Programs that stay the same are used again. If the driver refuses
    /// a shader, the former correction stays in use.
    ///
    /// # Errors
    /// [`ErrorKind::Graphics`] where the driver refuses a shader or runs out of memory;
    /// [`ErrorKind::Internal`] where the plan exceeds the limits of the shaders.
    pub fn prepare(&mut self, gl: &Gl, plan: &Plan, panel: bool) -> Result<()> {
        self.exact.clear();
        self.prepare_passes(gl, plan, &plan.passes, panel)
    }

    /// As [`GlBackend::prepare`] for a [rough correction](crate::correct::rough), after which the
    /// former correction or another one is prepared: the programs of the former correction stay, and
    /// those of the rough one also after the next `prepare`.
    ///
    /// # Errors
    /// As for [`GlBackend::prepare`].
    pub fn prepare_rough(&mut self, gl: &Gl, plan: &Plan, panel: bool) -> Result<()> {
        let list = draws::draws(plan, &plan.passes, panel, Rows::FromBottom)?;
        let rough = list.outputs.iter().flatten().map(|draw| self.text(&draw.constants)).collect();
        if self.exact.is_empty() {
            self.exact = self.names.programs.keys().cloned().collect();
        }
        let before = replace(&mut self.kept, self.exact.clone());
        let prepared = self.prepare_passes(gl, plan, &plan.passes, panel);
        self.kept = if prepared.is_ok() { rough } else { before };
        prepared
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

    fn build(&mut self, gl: &Gl, plan: &Plan, passes: &[OutputPass], panel: bool) -> Result<()> {
        self.make_objects(gl);
        let mut old = take(&mut self.names.programs);
        let result = self.build_draws(gl, plan, passes, panel, &mut old);
        // Programs that stay the same were taken out of `old`. On an error nothing is deleted,
        // since the former correction stays in use.
        match result {
            Ok((outputs, list)) => {
                for (text, program) in old {
                    if self.kept.contains(&text) {
                        self.names.programs.insert(text, program);
                        continue;
                    }
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

    pub(super) fn make_vertex_array(&mut self, gl: &Gl) {
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

    /// Returns the texts of the program for these constants.
    pub(super) fn text(&self, constants: &Constants) -> Specialised {
        let language = if self.caps.gles { Language::Essl300 } else { Language::Glsl330 };
        specialise(constants, language, self.stage)
    }

    pub(super) fn program(
        &mut self,
        gl: &Gl,
        constants: &Constants,
        old: &mut HashMap<Specialised, u32>,
    ) -> Result<u32> {
        let text = self.text(constants);
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
}
