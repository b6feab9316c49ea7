//! A rig that is being edited is shown at once, by a rough correction over the views of the rig
//! before. Its own plan follows when the rig has rested for a while.

use crate::backend::gl::driver::api::Gl;
use crate::error::Result;
use crate::intercept::gl::state::drawable::default_framebuffer::{DefaultFramebuffer, RoughlyShown};
use crate::intercept::process::live::{Live, REST};
use crate::intercept::process::log;
use crate::intercept::process::settings::{self, Settings};
use std::time::Instant;

impl DefaultFramebuffer {
    /// True if the own plan of the roughly corrected rig is due.
    pub fn has_rested(&self) -> bool {
        self.rough.as_ref().is_some_and(|shown| shown.since.elapsed() >= REST)
    }

    /// Shows another rig by a rough correction, which differs in more than the adaptation of the
    /// program's camera. Returns false if that is not possible; then nothing has changed.
    pub fn show_roughly(&mut self, gl: &Gl, live: &Live) -> bool {
        let is_served =
            settings::settings().is_some_and(Settings::is_watched) && live.rig.camera == self.session.program_camera();
        let Some(plan) = is_served.then(|| self.session.rough(&live.rig)).flatten() else { return false };
        let prepared = self.backend.prepare_rough(gl, &plan, self.shows_panel());
        if let Err(error) = prepared.and_then(|()| self.prepare_outputs(gl)) {
            log::once(&format!("a changed rig is not shown before it is planned: {error}"));
            return false;
        }
        let before = self.rough.take().map_or_else(|| self.rig.clone(), |shown| shown.before);
        (self.rig, self.version, self.next) = (live.rig.clone(), live.version, None);
        self.rough = Some(RoughlyShown { since: Instant::now(), before });
        true
    }

    /// Goes back from a rough correction to that of the session's own rig.
    ///
    /// # Errors
    /// As for [`GlBackend::prepare`](crate::backend::gl::GlBackend::prepare).
    pub fn leave_roughly_shown(&mut self, gl: &Gl) -> Result<()> {
        let Some(shown) = self.rough.take() else { return Ok(()) };
        self.rig = shown.before;
        self.backend.prepare(gl, self.session.plan(), self.shows_panel())?;
        self.prepare_outputs(gl)
    }

    fn shows_panel(&self) -> bool {
        self.session.panel().is_some() && settings::settings().is_none_or(|settings| settings.overlay)
    }

    /// Adapts what depends on the outputs' pictures. The whole views are drawn from now on.
    fn prepare_outputs(&mut self, gl: &Gl) -> Result<()> {
        self.backend.own_framebuffer(&self.outputs, self.session.window());
        if !self.closed.is_empty() {
            self.backend.prepare_unsampled(gl, &[], self.session.plan().views.atlas)?;
            self.closed = Vec::new();
        }
        Ok(())
    }
}
