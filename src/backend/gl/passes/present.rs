//! Presenting a frame: each output is drawn at its place in the target.

use crate::backend::gl::driver::api::*;
use crate::backend::gl::objects::program::{ATLAS_UNIT, BLACK_UNIT, MASK_UNIT, TABLE_UNIT};
use crate::backend::gl::objects::target::Target;
use crate::backend::gl::passes::cleared_views;
use crate::backend::gl::passes::cleared_views::{ClearedViews, Draw};
use crate::backend::gl::passes::{GlBackend, Output};
use crate::backend::gl::state;
use crate::backend::gl::state::known_state::KnownState;
use crate::correct::LowerLeftRect;
use std::cell::Cell;

impl GlBackend {
    /// Corrects the picture in `atlas_texture` (a 2D texture with encoded values, as large as the
    /// plan's atlas) into `targets`, one for each output of the plan, in its order. Allocates and
    /// compiles nothing, restores all state, and leaves no error of Cupola.
    ///
    /// Does nothing before [`GlBackend::prepare`], and while the program compiles a display list or
    /// picks. Conditional rendering and queries must not be active.
    ///
    /// Returns the error that the program itself had pending, mostly `GL_NO_ERROR`. OpenGL clears
    /// an error when it is read, so the caller has to return it from the program's next
    /// `glGetError`. An error that was pending at [`GlBackend::new`] or [`GlBackend::prepare`] is
    /// returned by the next call of this function.
    pub fn present(&self, gl: &Gl, atlas_texture: u32, targets: &[Target]) -> u32 {
        self.present_changed(gl, atlas_texture, targets, None, &KnownState::default())
    }

    /// As [`GlBackend::present`], but batches that show only `cleared_views` are cleared to their
    /// colour instead of being drawn. The picture is the same if the target stores 8 bits, as the
    /// atlas does. State in `known` is not queried.
    pub fn present_changed(
        &self,
        gl: &Gl,
        atlas_texture: u32,
        targets: &[Target],
        cleared_views: Option<&ClearedViews<'_>>,
        known: &KnownState,
    ) -> u32 {
        self.take_pending(gl);
        if self.names.vertex_array != 0 && state::can_draw(gl, &self.caps) {
            let saved = state::save_and_set(gl, &self.caps, self.units(), known);
            self.draw_outputs(gl, atlas_texture, targets, cleared_views);
            state::restore(gl, &self.caps, &saved);
        }
        self.count_errors(gl);
        self.pending.replace(GL_NO_ERROR)
    }

    /// Returns the number of batches so far that were cleared instead of being drawn.
    pub fn left_out(&self) -> u64 {
        self.left_out.get()
    }

    /// Returns the number of pictures of outputs so far that were drawn in a part only and cleared
    /// around it.
    pub fn narrowed(&self) -> u64 {
        self.narrowed.get()
    }

    fn draw_outputs(&self, gl: &Gl, atlas_texture: u32, targets: &[Target], cleared_views: Option<&ClearedViews<'_>>) {
        let [linear, nearest] = self.names.samplers;
        let more = self.units() > 1;
        // SAFETY: a context is current; all names are ones that it gave, or the caller's.
        unsafe {
            gl.bind_vertex_array(self.names.vertex_array);
            gl.active_texture(GL_TEXTURE0 + ATLAS_UNIT);
            gl.bind_texture(GL_TEXTURE_2D, atlas_texture);
            if more {
                gl.bind_sampler(MASK_UNIT, linear);
                gl.bind_sampler(BLACK_UNIT, linear);
                // Some drivers cannot filter textures of 32-bit floats, and a table must not be
                // filtered.
                gl.bind_sampler(TABLE_UNIT, nearest);
            }
        }
        let first = self.first_color(targets, cleared_views);
        if let (Some([red, green, blue]), Some(target)) = (first, targets.first()) {
            // SAFETY: a context is current; the colour has four numbers.
            unsafe {
                gl.bind_framebuffer(GL_DRAW_FRAMEBUFFER, target.framebuffer);
                gl.clear_bufferfv(GL_COLOR, 0, [red, green, blue, 1.0].as_ptr());
            }
        }
        for (output, target) in self.outputs.iter().zip(targets) {
            if target.viewport.width == 0 || target.viewport.height == 0 {
                continue;
            }
            // SAFETY: as above.
            unsafe {
                gl.bind_framebuffer(GL_DRAW_FRAMEBUFFER, target.framebuffer);
                if more {
                    gl.active_texture(GL_TEXTURE0 + TABLE_UNIT);
                    gl.bind_texture(GL_TEXTURE_2D, output.table);
                    gl.active_texture(GL_TEXTURE0 + BLACK_UNIT);
                    gl.bind_texture(GL_TEXTURE_2D, output.black_picture);
                    gl.active_texture(GL_TEXTURE0 + MASK_UNIT);
                    gl.bind_texture(GL_TEXTURE_2D, output.mask);
                }
            }
            state::set_viewport(gl, &self.caps, target.viewport);
            self.draw_output(gl, output, target.viewport, cleared_views, first);
        }
    }

    /// Returns the number of texture units in use: one if only the atlas is read.
    fn units(&self) -> usize {
        let more = self.outputs.iter().any(|output| output.mask | output.table | output.black_picture != 0);
        if more { state::UNITS } else { 1 }
    }

    /// Returns the colour to which the framebuffer of all outputs is cleared before they are drawn;
    /// `None`: no clear.
    fn first_color(&self, targets: &[Target], cleared_views: Option<&ClearedViews<'_>>) -> Option<[f32; 3]> {
        let full_clear = self.full_clear.filter(|full_clear| full_clear.serves(targets))?;
        let draws = || self.outputs.iter().flat_map(|output| &output.draws);
        let cleared_views = cleared_views
            .filter(|cleared_views| draws().any(|draw| draw.views != 0 && draw.shows_cleared(cleared_views)));
        full_clear.color(cleared_views.map(|cleared_views| cleared_views.color))
    }

    /// Draws one output. `held`: colour to which the framebuffer was already cleared.
    fn draw_output(
        &self,
        gl: &Gl,
        output: &Output,
        viewport: LowerLeftRect,
        cleared_views: Option<&ClearedViews<'_>>,
        held: Option<[f32; 3]>,
    ) {
        let unscaled =
            (i64::from(viewport.width), i64::from(viewport.height)) == (output.size.0.into(), output.size.1.into());
        let shows_cleared = |draw: &&Draw| {
            cleared_views.is_some_and(|cleared_views| draw.views != 0 && draw.shows_cleared(cleared_views))
        };
        let left_out = output.draws.iter().filter(shows_cleared).count();
        let part = cleared_views.filter(|_| unscaled).and_then(|cleared_views| {
            cleared_views::part(cleared_views, &output.draws, output.footprints.as_ref(), output.size)
        });
        let cleared = match cleared_views.filter(|_| left_out > 0 || part.is_some()) {
            Some(cleared_views) => {
                if held != Some(cleared_views.color) {
                    state::clear(gl, &self.caps, viewport, cleared_views.color);
                }
                self.left_out.set(self.left_out.get() + left_out as u64);
                Some(*cleared_views)
            }
            None => held.map(|color| ClearedViews { views: 0, color, touched: &[] }),
        };
        let [linear, nearest] = self.names.samplers;
        let bound = Cell::new(0);
        let issue = |draw: &Draw| {
            let first = draw.first as usize * size_of::<u32>();
            let sampler = if draw.nearest && unscaled { nearest } else { linear };
            // SAFETY: a context is current; the names are its own, and the indices lie in the
            // buffer.
            unsafe {
                if bound.replace(sampler) != sampler {
                    gl.bind_sampler(ATLAS_UNIT, sampler);
                }
                gl.use_program(draw.program);
                gl.draw_elements(GL_TRIANGLES, draw.count, GL_UNSIGNED_INT, first as *const _);
            }
        };
        let needed = || {
            output.draws.iter().filter(|draw| cleared.is_none_or(|cleared_views| !draw.shows_cleared(&cleared_views)))
        };
        match (cleared_views, part) {
            (Some(cleared_views), Some(part)) => {
                self.narrowed.set(self.narrowed.get() + 1);
                let within = part.moved(viewport.x, viewport.y);
                needed().filter(|draw| !draw.narrows(cleared_views)).for_each(issue);
                state::within(gl, &self.caps, within, || {
                    needed().filter(|draw| draw.narrows(cleared_views)).for_each(issue);
                });
            }
            _ => needed().for_each(issue),
        }
    }
}
