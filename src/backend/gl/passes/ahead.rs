//! Programs of a plan that is not in use yet. They are made one by one, between the frames of the
//! plan in use, so that the program does not stand still when its rig is edited.

use crate::backend::gl::driver::api::*;
use crate::backend::gl::objects::program;
use crate::backend::gl::passes::GlBackend;
use crate::backend::gl::state;
use crate::backend::gl::state::known_state::KnownState;
use crate::correct::shaders::draws::{Rows, draws};
use crate::correct::{LowerLeftRect, Plan};
use crate::error::Result;
use std::collections::HashSet;

impl GlBackend {
    /// Notes which programs the next plan needs that do not exist yet. `panel`: as for
    /// [`GlBackend::prepare`].
    ///
    /// # Errors
    /// [`crate::ErrorKind::Internal`] where the plan exceeds the limits of the shaders.
    pub fn look_ahead(&mut self, plan: &Plan, panel: bool) -> Result<()> {
        let list = draws(plan, &plan.passes, panel, Rows::FromBottom)?;
        let texts: HashSet<_> = list.outputs.iter().flatten().map(|draw| self.text(&draw.constants)).collect();
        self.ahead = texts.into_iter().filter(|text| !self.names.programs.contains_key(text)).collect();
        Ok(())
    }

    /// Makes one program for the next plan. [`GlBackend::inherit`] and [`GlBackend::prepare`] of
    /// another backend then find it. Returns false if all programs exist. State and errors of the
    /// program are restored as by [`GlBackend::prepare`].
    ///
    /// # Errors
    /// [`crate::ErrorKind::Graphics`] where the driver refuses the shader.
    pub fn make_ahead(&mut self, gl: &Gl) -> Result<bool> {
        let Some(text) = self.ahead.pop() else { return Ok(false) };
        self.take_pending(gl);
        let caps = self.caps;
        let made = state::while_uploading(gl, &caps, || program::build(gl, &text, &self.binaries));
        if let Ok(program) = made {
            self.linked += 1;
            self.names.programs.insert(text, program);
            self.use_once(gl, program);
        }
        self.count_errors(gl);
        made.map(|_| true)
    }

    /// Draws nothing to the window with a program. Drivers compile a part of a program when it is
    /// used first.
    fn use_once(&self, gl: &Gl, program: u32) {
        if self.names.vertex_array == 0 || !state::can_draw(gl, &self.caps) {
            return;
        }
        let saved = state::save_and_set(gl, &self.caps, 1, &KnownState::default());
        state::set_viewport(gl, &self.caps, LowerLeftRect::default());
        // SAFETY: a context is current; the names are its own, and the buffer has at least one
        // triangle.
        unsafe {
            gl.bind_framebuffer(GL_DRAW_FRAMEBUFFER, 0);
            gl.bind_vertex_array(self.names.vertex_array);
            gl.use_program(program);
            // A context may have no window.
            if gl.check_framebuffer_status(GL_DRAW_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE {
                gl.draw_elements(GL_TRIANGLES, 3, GL_UNSIGNED_INT, std::ptr::null());
            }
        }
        state::restore(gl, &self.caps, &saved);
    }
}
