//! Makes the atlas for a plan: its textures and the objects of the correction.

use crate::backend::gl::driver::api::Gl;
use crate::backend::gl::objects::surface::{Surface, greatest_texture};
use crate::backend::gl::{GlBackend, Target};
use crate::error::{Error, ErrorKind, Result};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::methods;
use crate::intercept::gl::framebuffer::target::unsampled_areas;
use crate::intercept::gl::state::drawable::cleared_views::Content;
use crate::intercept::gl::state::drawable::default_framebuffer::DefaultFramebuffer;
use crate::intercept::gl::state::drawable::window::Window;
use crate::intercept::gl::state::drawable::window_config::Config;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::{live, settings};
use crate::runtime::cache;
use crate::runtime::session::{Extras, Session};
use std::cell::Cell;
use std::sync::Arc;

/// The atlas, and where it has samples the one that they are resolved to.
fn surfaces(gl: &Gl, size: (i32, i32), config: &Config) -> Result<(Surface, Option<Surface>)> {
    let surface = Surface::new(gl, size, config.samples, config.srgb)?;
    if config.samples == 0 {
        return Ok((surface, None));
    }
    match Surface::new(gl, size, 0, config.srgb) {
        Ok(resolved) => Ok((surface, Some(resolved))),
        Err(error) => {
            surface.destroy(gl);
            Err(error)
        }
    }
}

impl DefaultFramebuffer {
    /// For a window of the program, with the rig as its file is now.
    pub fn new(ctx: &Context, window: &Window, settings: &settings::Settings, extras: Extras) -> Result<Self> {
        let gl = ctx.driver.gl;
        let profile = &ctx.driver.profile;
        if let Some(name) = gl.missing_command(profile.es, profile.version) {
            let (major, minor) = (profile.version / 10, profile.version % 10);
            let message = format!("the driver says that it has OpenGL {major}.{minor}, and has no {name}");
            return Err(Error::new(ErrorKind::Graphics, message));
        }
        let live = live::rig().ok_or_else(|| Error::new(ErrorKind::InvalidState, "there is no rig"))?;
        let plan = methods::planner(ctx, &live.rig);
        let session = plan(&live.rig, window.size(), settings.offscreen, greatest_texture(gl), extras)?;
        let config = Config::of_window(gl, &ctx.driver.profile, window);
        Self::with_session(&ctx.driver, session, config, live.version)
    }

    fn with_session(driver: &Driver, session: Session, config: Config, version: u64) -> Result<Self> {
        let gl = driver.gl;
        let size = (session.plan().views.atlas.0 as i32, session.plan().views.atlas.1 as i32);
        let mut backend = GlBackend::new(gl, driver.profile.es)?.with_cache(gl, cache::of_process());
        let panel = session.panel().is_some();
        let surfaces = match backend.prepare(gl, session.plan(), panel) {
            Ok(()) => surfaces(gl, size, &config),
            Err(error) => Err(error),
        };
        let (surface, resolved) = match surfaces {
            Ok(surfaces) => surfaces,
            Err(error) => {
                backend.destroy(gl);
                return Err(error);
            }
        };
        let closed = unsampled_areas::prepare(gl, &mut backend, session.plan());
        let (issued, culled) = (vec![0; session.views().len()], vec![0; session.views().len()]);
        let outputs: Vec<_> = session.viewports().map(|place| Target { framebuffer: 0, viewport: place }).collect();
        backend.own_framebuffer(&outputs, session.window());
        let lenses = session.lenses();
        let session = Arc::new(session);
        Ok(Self {
            session,
            version,
            lenses,
            config,
            surface,
            resolved,
            backend,
            content: Content::default(),
            ready: Cell::new(None),
            issued,
            culled,
            closed,
            outputs,
        })
    }

    /// The same with more tiles.
    pub fn enlarged(&self, ctx: &Context, extras: Extras) -> Result<Self> {
        let mut new = Self::with_session(&ctx.driver, self.session.with(extras)?, self.config, self.version)?;
        new.issued.clone_from(&self.issued);
        new.culled.clone_from(&self.culled);
        Ok(new)
    }
}
