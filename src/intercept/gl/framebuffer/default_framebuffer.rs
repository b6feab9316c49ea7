//! What stands in for a window's framebuffer: one atlas of the rig's views.

use crate::backend::gl::api::{self, Gl};
use crate::backend::gl::surface::{Surface, greatest_texture};
use crate::backend::gl::{GlBackend, KnownState, Target};
use crate::error::{Error, ErrorKind, Result};
use crate::intercept::gl::context::errors::{take_error, take_own_errors};
use crate::intercept::gl::context::gl_context::Context;
use crate::intercept::gl::context::methods;
use crate::intercept::gl::context::own_calls::OwnCalls;
use crate::intercept::gl::framebuffer::{default_framebuffer, first_read, unsampled_areas};
use crate::intercept::gl::offscreen::view_copies;
use crate::intercept::gl::per_view::panel::clear_transparent;
use crate::intercept::gl::per_view::window_space::intersect;
use crate::intercept::gl::state::drawable::cleared_views::Content;
use crate::intercept::gl::state::drawable::default_framebuffer::{DefaultFramebuffer, Ready};
use crate::intercept::gl::state::drawable::window::{Look, Window};
use crate::intercept::gl::state::drawable::window_config::Config;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::driver::window_space::DriverState;
use crate::intercept::{live, log, settings};
use crate::runtime::cache;
use crate::runtime::session::{Extras, Session};
use std::cell::Cell;
use std::sync::Arc;

/// Puts our framebuffer in place of the window's. Where that fails the program keeps its own.
pub fn attach(ctx: &mut Context, extras: Extras) {
    let Some(settings) = settings::settings() else { return };
    let Some(window) = ctx.drawable.window.clone() else { return };
    if settings.rig.passthrough {
        return;
    }
    attach_now(&mut OwnCalls::without_messages(ctx), &window, settings, extras);
}

fn attach_now(ctx: &mut Context, window: &Window, settings: &settings::Settings, extras: Extras) {
    take_error(&mut ctx.driver);
    match DefaultFramebuffer::new(ctx, window, settings, extras) {
        Ok(target) => put(ctx, target),
        Err(error) => log::once(&format!("this window keeps its own picture: {error}")),
    }
    take_own_errors(&ctx.driver, &mut ctx.frame.counts);
}

/// Puts a new one, which is cleared, in place of the window's framebuffer.
fn put(ctx: &mut Context, target: DefaultFramebuffer) {
    ctx.frame.counts.linked += target.backend.linked();
    ctx.drawable.target = Some(Box::new(target));
    adopt(ctx);
    let gl = ctx.driver.gl;
    // SAFETY: state of ours and of our framebuffer.
    unsafe {
        ctx.set_scissor(None);
        clear_everything(gl);
    }
}

/// Goes on with the rig as its file is now; only between frames. Where that cannot be planned or made, everything stays.
pub fn follow_rig(ctx: &mut Context) {
    let version = live::version();
    if ctx.drawable.target.as_ref().is_none_or(|target| target.version == version) {
        return;
    }
    let ctx: &mut Context = &mut OwnCalls::without_messages(ctx);
    let (Some(settings), Some(window)) = (settings::settings(), ctx.drawable.window.clone()) else { return };
    let Some(mut old) = ctx.drawable.target.take() else { return };
    take_error(&mut ctx.driver);
    let extras = ctx.frame.draw_count.extras(old.extras());
    match DefaultFramebuffer::new(ctx, &window, settings, extras) {
        Ok(new) => {
            view_copies::clear(ctx);
            old.destroy(ctx.driver.gl);
            put(ctx, new);
        }
        Err(error) => {
            log::once(&format!("the rig stays as it was: {error}"));
            old.version = version;
            ctx.drawable.target = Some(old);
        }
    }
    take_own_errors(&ctx.driver, &mut ctx.frame.counts);
}

/// Puts what stood for a window earlier in its place again, if the window is still of that kind.
pub fn resume(ctx: &mut Context, window: &Window, target: Box<DefaultFramebuffer>) {
    take_error(&mut ctx.driver);
    if target.config == Config::of_window(ctx.driver.gl, &ctx.driver.profile, window) {
        ctx.drawable.target = Some(target);
        adopt(ctx);
    } else {
        target.destroy(ctx.driver.gl);
    }
    take_own_errors(&ctx.driver, &mut ctx.frame.counts);
}

/// Goes on with a picture that another context of the group began.
pub fn take_over(ctx: &mut Context, mut target: Box<DefaultFramebuffer>) {
    take_error(&mut ctx.driver);
    match target.rehome(ctx.driver.gl) {
        Ok(()) => {
            ctx.drawable.target = Some(target);
            adopt(ctx);
            ctx.frame.begun = true;
        }
        Err(error) => {
            log::once(&format!("what another context drew to this window is lost: {error}"));
            target.destroy(ctx.driver.gl);
            attach(ctx, Extras::default());
        }
    }
    take_own_errors(&ctx.driver, &mut ctx.frame.counts);
}

/// Makes the rest of the context fit a new target.
fn adopt(ctx: &mut Context) {
    view_copies::leave(ctx);
    ctx.driver.window_space = DriverState::default();
    ctx.compat.projection.clear();
    ctx.queries.forget_views();
    ctx.frame.cameras.clear();
    ctx.frame.background.clear();
    let Some(target) = &ctx.drawable.target else { return };
    let framebuffer = target.framebuffer();
    // SAFETY: binds our framebuffer where the program's window is bound.
    unsafe {
        if ctx.app.read_framebuffer == 0 {
            ctx.driver.gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, ctx.drawable.window_for_reading());
        }
        if ctx.app.draw_framebuffer == 0 {
            ctx.driver.gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, framebuffer);
            if ctx.app.draw_buffer == api::GL_NONE {
                ctx.driver.gl.draw_buffers(1, &api::GL_NONE);
            }
        }
    }
}

/// Reserves the flat panel, from its first use on.
pub fn want_panel(ctx: &mut Context) {
    let needed = ctx
        .drawable
        .target
        .as_ref()
        .is_some_and(|t| t.session.panel().is_none() && t.session.views().iter().any(|v| !v.program_lens));
    if needed {
        enlarge(ctx, |extras| extras.panel = true);
    }
}

/// Plans anew for a program of so many draws in a frame. What is drawn already is lost.
pub fn plan_for(ctx: &mut Context, draws: u32) {
    let Some(old) = ctx.drawable.target.take() else { return };
    let extras = Extras { draws: Some(draws), ..old.extras() };
    let same = |new: &Session| new.views() == old.session.views();
    match old.session.with(extras) {
        Ok(new) if !same(&new) => {
            view_copies::clear(ctx);
            old.destroy(ctx.driver.gl);
            attach(ctx, extras);
        }
        Ok(_) => ctx.drawable.target = Some(old),
        Err(error) => {
            log::once(&format!("the views stay as they are: {error}"));
            ctx.drawable.target = Some(old);
        }
    }
}

/// Plans anew with more tiles; what is drawn already moves to its new place.
fn enlarge(ctx: &mut Context, add: impl FnOnce(&mut Extras)) {
    enlarge_now(&mut OwnCalls::begin(ctx), add);
}

fn enlarge_now(ctx: &mut Context, add: impl FnOnce(&mut Extras)) {
    let Some(old) = ctx.drawable.target.take() else { return };
    take_error(&mut ctx.driver);
    let mut extras = old.extras();
    add(&mut extras);
    match old.enlarged(ctx, extras) {
        Ok(new) => {
            ctx.frame.counts.linked += new.backend.linked();
            ctx.drawable.target = Some(Box::new(new));
            let gl = ctx.driver.gl;
            adopt(ctx);
            ctx.set_scissor(None);
            if let Some(new) = &ctx.drawable.target {
                // SAFETY: copies between two framebuffers of ours; the bindings are put back by `adopt`.
                unsafe {
                    gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, new.surface.framebuffer());
                    clear_everything(gl);
                    copy_tiles(gl, &old, new);
                    gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, ctx.app.read_framebuffer);
                    gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, ctx.app.draw_framebuffer);
                }
            }
            adopt(ctx);
            old.destroy(gl);
        }
        Err(error) => {
            log::once(&format!("flat drawing is left out: {error}"));
            ctx.drawable.target = Some(old);
        }
    }
    take_own_errors(&ctx.driver, &mut ctx.frame.counts);
}

/// # Safety
/// Both framebuffers must live; the caller puts the bindings back.
unsafe fn copy_tiles(gl: &Gl, old: &DefaultFramebuffer, new: &DefaultFramebuffer) {
    if old.surface.samples() > 0 && gl.is_es() {
        // Multisampled pictures cannot be copied to another place; the next frame draws them.
        return;
    }
    let tiles = |t: &DefaultFramebuffer| {
        let views = (0..t.session.views().len()).map(|i| Some(t.session.tile(i).0));
        views.chain([t.session.panel(), t.session.primary()]).collect::<Vec<_>>()
    };
    let (from, mut to) = (tiles(old), tiles(new));
    if from.len() > 2 && new.session.primary().is_some() && old.session.primary().is_none() {
        // A new primary picture begins with the flat one, which it contains.
        let last = to.len() - 1;
        to[last] = None;
    }
    let mask = api::GL_COLOR_BUFFER_BIT | api::GL_DEPTH_BUFFER_BIT | api::GL_STENCIL_BUFFER_BIT;
    // SAFETY: as promised.
    unsafe { gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, old.surface.framebuffer()) };
    for (from, to) in from.into_iter().zip(to) {
        if let (Some([x, y, w, h]), Some([u, v, _, _])) = (from, to) {
            // SAFETY: both rectangles lie in their framebuffers.
            unsafe { gl.blit_framebuffer(x, y, x + w, y + h, u, v, u + w, v + h, mask, api::GL_NEAREST) };
        }
    }
    if let (Some([x, y, w, h]), Some([u, v, _, _]), None) =
        (old.session.panel(), new.session.primary(), old.session.primary())
    {
        // SAFETY: as above.
        unsafe { gl.blit_framebuffer(x, y, x + w, y + h, u, v, u + w, v + h, mask, api::GL_NEAREST) };
    }
}

/// Binds what the program's reads of `part` (x, y, width, height) of its window come from; the origin of its picture there.
/// `alpha`: the read takes alpha, too.
pub fn bind_for_reading(ctx: &mut Context, part: [i32; 4], alpha: bool) -> [i32; 2] {
    let own_picture = |t: &DefaultFramebuffer| {
        t.primary().or_else(|| t.flat_tiles().into_iter().flatten().find(|(_, panel)| !panel).map(|tile| tile.0))
    };
    if ctx.drawable.target.as_ref().is_some_and(|t| own_picture(t).is_none()) {
        enlarge(ctx, |extras| extras.primary = true);
        first_read::fill_primary(&mut OwnCalls::begin(ctx));
    }
    let Some(tile) = ctx.drawable.target.as_ref().and_then(|t| own_picture(t)) else { return [0, 0] };
    make_ready(ctx, intersect(part, tile), alpha);
    let Some(target) = ctx.drawable.target.as_ref().filter(|target| target.resolved.is_some()) else {
        return [tile[0], tile[1]];
    };
    // SAFETY: a framebuffer of ours; `end_reading` puts the program's back.
    unsafe { ctx.driver.gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, target.readable().framebuffer()) };
    [tile[0], tile[1]]
}

/// Resolves the samples of `part`, and gives it the alpha of a window without one, where that is needed and not done.
fn make_ready(ctx: &mut Context, part: [i32; 4], alpha: bool) {
    let Some(target) = &ctx.drawable.target else { return };
    let opaque = alpha && target.config.alpha_bits == 0;
    let needed = opaque || target.resolved.is_some();
    let holds = |ready: Ready| ready.contains(part) && (ready.opaque || !opaque);
    if !needed || part[2] == 0 || part[3] == 0 || target.ready.get().is_some_and(holds) {
        return;
    }
    let ctx: &mut Context = &mut OwnCalls::begin(ctx);
    if let Some(target) = &ctx.drawable.target {
        target.resolve(ctx, Some(part));
    }
    if opaque {
        make_opaque(ctx, part);
    }
    if let Some(target) = &ctx.drawable.target {
        target.ready.set(Some(Ready { part, opaque }));
    }
}

/// A window without alpha has alpha 1 wherever it is read; ours has what the program drew. Of the program's own picture
/// the correction takes the colours only.
fn make_opaque(ctx: &mut Context, part: [i32; 4]) {
    let gl = ctx.driver.gl;
    let Some(target) = ctx.drawable.target.as_ref() else { return };
    let framebuffer = target.readable().framebuffer();
    ctx.set_scissor(Some(part));
    let mut bound = 0;
    let mut mask = [0u8; 4];
    // SAFETY: clears a part of a framebuffer of ours; binding and mask are put back.
    unsafe {
        gl.get_integerv(api::GL_DRAW_FRAMEBUFFER_BINDING, &mut bound);
        gl.get_booleanv(api::GL_COLOR_WRITEMASK, mask.as_mut_ptr());
        gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, framebuffer);
        gl.color_mask(0, 0, 0, 1);
        gl.clear_bufferfv(api::GL_COLOR, 0, [0.0f32, 0.0, 0.0, 1.0].as_ptr());
        gl.color_mask(mask[0], mask[1], mask[2], mask[3]);
        gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, bound as u32);
    }
    if !ctx.redirected() {
        ctx.restore_window_space();
    }
}

/// The pair of [`bind_for_reading`].
pub fn end_reading(ctx: &mut Context) {
    if ctx.reads_redirected()
        && let Some(target) = ctx.drawable.target.as_ref().filter(|target| target.resolved.is_some())
    {
        // SAFETY: what the program's window stands for.
        unsafe { ctx.driver.gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, target.framebuffer()) };
    }
}

/// # Safety
/// Our framebuffer must be bound for drawing, with the scissor test off.
unsafe fn clear_everything(gl: &Gl) {
    clear_transparent(gl, &KnownState::default());
    let mut depth = 0u8;
    let mut stencil = 0;
    // SAFETY: the masks are put back.
    unsafe {
        gl.get_booleanv(api::GL_DEPTH_WRITEMASK, &mut depth);
        gl.get_integerv(api::GL_STENCIL_WRITEMASK, &mut stencil);
        gl.depth_mask(1);
        gl.stencil_mask(u32::MAX);
        gl.clear_bufferfi(api::GL_DEPTH_STENCIL, 0, 1.0, 0);
        gl.depth_mask(depth);
        gl.stencil_mask(stencil as u32);
    }
}

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
    fn new(ctx: &Context, window: &Window, settings: &settings::Settings, extras: Extras) -> Result<Self> {
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
        let outputs: Vec<_> = session.viewports().map(|viewport| Target { framebuffer: 0, viewport }).collect();
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
    fn enlarged(&self, ctx: &Context, extras: Extras) -> Result<Self> {
        let mut new = Self::with_session(&ctx.driver, self.session.with(extras)?, self.config, self.version)?;
        new.issued.clone_from(&self.issued);
        new.culled.clone_from(&self.culled);
        Ok(new)
    }

    /// Resolves the samples of `part`, or of everything. The program's bindings are put back.
    pub fn resolve(&self, ctx: &Context, part: Option<[i32; 4]>) {
        let Some(resolved) = &self.resolved else { return };
        self.ready.set(None);
        let gl = ctx.driver.gl;
        let [x, y, w, h] = part.unwrap_or([0, 0, self.surface.size().0, self.surface.size().1]);
        let real = |name: u32| if name == 0 { self.framebuffer() } else { name };
        let reads =
            if ctx.drawable.reads_elsewhere { ctx.app.read_framebuffer } else { real(ctx.app.read_framebuffer) };
        // SAFETY: copies between framebuffers of ours; scissor and bindings are put back.
        unsafe {
            let scissor = gl.is_enabled(api::GL_SCISSOR_TEST) != 0;
            if scissor {
                gl.disable(api::GL_SCISSOR_TEST);
            }
            gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, self.surface.framebuffer());
            gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, resolved.framebuffer());
            gl.blit_framebuffer(x, y, x + w, y + h, x, y, x + w, y + h, api::GL_COLOR_BUFFER_BIT, api::GL_NEAREST);
            if part.is_some() {
                let depth = api::GL_DEPTH_BUFFER_BIT | api::GL_STENCIL_BUFFER_BIT;
                gl.blit_framebuffer(x, y, x + w, y + h, x, y, x + w, y + h, depth, api::GL_NEAREST);
            }
            gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, reads);
            gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, real(ctx.app.draw_framebuffer));
            if scissor {
                gl.enable(api::GL_SCISSOR_TEST);
            }
        }
    }
}

/// Looks at the window, and plans anew where it has another size than the plan. Only between frames.
pub fn follow_size(ctx: &mut Context) {
    let Some(window) = ctx.drawable.window.clone() else { return };
    let Look { size, occluded } = window.look();
    ctx.drawable.occluded = occluded;
    if ctx.drawable.target.as_ref().is_some_and(|t| t.size() != size) {
        let mut extras = Extras::default();
        if let Some(old) = ctx.drawable.target.take() {
            extras = old.extras();
            view_copies::clear(ctx);
            old.destroy(ctx.driver.gl);
        }
        ctx.frame.forget_viewports();
        default_framebuffer::attach(ctx, extras);
    }
}
