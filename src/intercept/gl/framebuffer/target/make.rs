//! Makes the atlas for a plan: its textures and the objects of the correction.

use crate::backend::gl::driver::api::Gl;
use crate::backend::gl::objects::surface::{Surface, greatest_texture};
use crate::backend::gl::{GlBackend, Target};
use crate::error::{Error, ErrorKind, Result};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::methods;
use crate::intercept::gl::framebuffer::target::unsampled_areas;
use crate::intercept::gl::state::drawable::cleared_views::ViewContents;
use crate::intercept::gl::state::drawable::default_framebuffer::DefaultFramebuffer;
use crate::intercept::gl::state::drawable::window::Window;
use crate::intercept::gl::state::drawable::window_config::Config;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::process::live::{self, Live};
use crate::intercept::process::settings;
use crate::rig::{Duplicate, Rig};
use crate::runtime::cache;
use crate::runtime::session::{Extras, Session};
use std::cell::Cell;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Surfaces that replace a window.
struct Surfaces {
    /// Surface to which the program draws.
    drawn: Surface,
    /// Copy with one sample per pixel, if the surface has several.
    resolved: Option<Surface>,
    /// The atlas, if the views are drawn in turn.
    collected: Option<Surface>,
}

impl Surfaces {
    fn new(gl: &Gl, session: &Session, config: &Config) -> Result<Self> {
        let make = |(width, height): (u32, u32), samples| {
            Surface::new(gl, (width as i32, height as i32), samples, config.srgb)
        };
        let mut made = Self { drawn: make(session.surface_size(), config.samples)?, resolved: None, collected: None };
        if let Err(error) = made.complete(session, config, make) {
            made.destroy(gl);
            return Err(error);
        }
        Ok(made)
    }

    fn complete(
        &mut self,
        session: &Session,
        config: &Config,
        make: impl Fn((u32, u32), i32) -> Result<Surface>,
    ) -> Result<()> {
        if config.samples > 0 {
            self.resolved = Some(make(session.surface_size(), 0)?);
        }
        if session.turns().is_some() {
            self.collected = Some(make(session.plan().views.atlas, 0)?);
        }
        Ok(())
    }

    fn destroy(self, gl: &Gl) {
        let Self { drawn, resolved, collected } = self;
        [Some(drawn), resolved, collected].into_iter().flatten().for_each(|surface| surface.destroy(gl));
    }
}

/// Time in each frame for the shaders of the next rig. A shader that was begun is finished.
const STEP: Duration = Duration::from_millis(20);

/// Plans `rig` for a window.
fn plan(ctx: &Context, rig: &Rig, window: &Window, settings: &settings::Settings, extras: Extras) -> Result<Session> {
    let planner = methods::planner(&ctx.projected, rig);
    let mut session = planner(rig, window.size(), settings.offscreen, greatest_texture(ctx.driver.gl), extras)?;
    let perspective = session.views().iter().all(|view| !view.program_lens && view.curved.is_none());
    if rig.views.duplicate == Duplicate::InTurn && perspective {
        // The panel exists from the start. If it were added later, views that were collected in
        // the old atlas would be lost.
        session = session.with(Extras { panel: true, ..extras })?.in_turn();
    }
    Ok(session)
}

impl DefaultFramebuffer {
    /// Makes a stand-in for a window of the program, with the present rig.
    pub fn new(ctx: &Context, window: &Window, settings: &settings::Settings, extras: Extras) -> Result<Self> {
        let profile = &ctx.driver.profile;
        if let Some(name) = ctx.driver.gl.missing_command(profile.es, profile.version) {
            let (major, minor) = (profile.version / 10, profile.version % 10);
            let message = format!("the driver reports OpenGL {major}.{minor}, but does not have {name}");
            return Err(Error::new(ErrorKind::Graphics, message));
        }
        let live = live::rig().ok_or_else(|| Error::new(ErrorKind::InvalidState, "there is no rig"))?;
        let session = plan(ctx, &live.rig, window, settings, extras)?;
        let config = Config::of_window(ctx.driver.gl, &ctx.driver.profile, window);
        Self::with_session(&ctx.driver, session, config, live, None)
    }

    /// Plans another rig for the same window, and notes the shaders that it needs. The stand-in
    /// stays as it is.
    pub fn look_ahead(
        &mut self,
        ctx: &Context,
        window: &Window,
        settings: &settings::Settings,
        live: Live,
        extras: Extras,
    ) -> Result<()> {
        let session = plan(ctx, &live.rig, window, settings, extras)?;
        self.backend.look_ahead(session.plan(), session.panel().is_some())?;
        self.next = Some((session, live));
        Ok(())
    }

    /// Makes shaders of the next rig for a while. Returns the stand-in with that rig once all of
    /// them exist; `None`: they are not finished. It takes over the shaders of this stand-in that
    /// are still valid. After an error this stand-in keeps them.
    pub fn make_next(&mut self, ctx: &Context, window: &Window) -> Result<Option<Self>> {
        let start = Instant::now();
        while self.backend.make_ahead(ctx.driver.gl)? {
            if start.elapsed() >= STEP {
                return Ok(None);
            }
        }
        let Some((session, live)) = self.next.take() else { return Ok(None) };
        let config = Config::of_window(ctx.driver.gl, &ctx.driver.profile, window);
        Self::with_session(&ctx.driver, session, config, live, Some(self)).map(Some)
    }

    fn with_session(
        driver: &Driver,
        session: Session,
        config: Config,
        Live { rig, version }: Live,
        mut old: Option<&mut Self>,
    ) -> Result<Self> {
        let gl = driver.gl;
        let mut backend = GlBackend::new(gl, driver.profile.es)?.with_cache(gl, cache::of_process());
        if let Some(old) = &mut old {
            backend.inherit(&mut old.backend);
        }
        let panel = session.panel().is_some() && settings::settings().is_none_or(|settings| settings.overlay);
        let surfaces = backend.prepare(gl, session.plan(), panel).and_then(|()| Surfaces::new(gl, &session, &config));
        let Surfaces { drawn, resolved, collected } = match surfaces {
            Ok(surfaces) => surfaces,
            Err(error) => {
                if let Some(old) = old {
                    old.backend.inherit(&mut backend);
                }
                backend.destroy(gl);
                return Err(error);
            }
        };
        // If the views are drawn in turn, the corners of the program's window are in these areas.
        let closed = match session.turns() {
            Some(_) => Vec::new(),
            None => unsampled_areas::prepare(gl, &mut backend, session.plan()),
        };
        let (issued, culled) = (vec![0; session.views().len()], vec![0; session.views().len()]);
        let outputs: Vec<_> = session.viewports().map(|place| Target { framebuffer: 0, viewport: place }).collect();
        backend.own_framebuffer(&outputs, session.window());
        let lenses = session.lenses();
        let session = Arc::new(session);
        Ok(Self {
            session,
            rig,
            version,
            next: None,
            rough: None,
            lenses,
            config,
            surface: drawn,
            resolved,
            collected,
            backend,
            content: ViewContents::default(),
            ready: Cell::new(None),
            issued,
            culled,
            closed,
            outputs,
        })
    }

    /// Returns the same stand-in with more tiles.
    pub fn enlarged(&self, ctx: &Context, extras: Extras) -> Result<Self> {
        let live = Live { rig: self.rig.clone(), version: self.version };
        let mut new = Self::with_session(&ctx.driver, self.session.with(extras)?, self.config, live, None)?;
        new.issued.clone_from(&self.issued);
        new.culled.clone_from(&self.culled);
        // The session is that of the earlier rig.
        new.rough.clone_from(&self.rough);
        Ok(new)
    }
}
