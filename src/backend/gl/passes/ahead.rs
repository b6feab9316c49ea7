//! Programs of a plan that is not in use yet. They are made one by one, between the frames of the
//! plan in use, so that the program does not stand still when its rig is edited.

use crate::backend::gl::driver::api::*;
use crate::backend::gl::objects::program;
use crate::backend::gl::passes::GlBackend;
use crate::backend::gl::state;
use crate::correct::Plan;
use crate::correct::shaders::draws::{Rows, draws};
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
        }
        self.count_errors(gl);
        made.map(|_| true)
    }
}
