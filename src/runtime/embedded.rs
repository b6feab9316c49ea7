//! Cupola in a program that draws its own views: begin a frame, draw each view, end the frame. This
//! file is for OpenGL.

mod matrices;
pub mod vulkan;

use self::matrices::{check_planes, joined, no_view, projection, rotation, vectors_of_view};
use super::cache;
use super::session::{Extras, Session};
use crate::backend::gl::driver::api::{self, Gl};
use crate::backend::gl::objects::framebuffers::{FramebufferState, framebuffer_state};
use crate::backend::gl::objects::surface::{Saved, Surface, greatest_texture};
use crate::backend::gl::{GlBackend, Target};
use crate::correct::LowerLeftRect;
use crate::error::{Error, ErrorKind, Result};
use crate::rig::{Blend, Rig, Viewer};
use glam::DMat4;

/// Greatest width and height of the pictures, pixels.
const LARGEST_PICTURE: u32 = 16384;

/// Facts that a program needs to draw one view.
#[derive(Clone, Debug, PartialEq)]
pub struct EmbeddedView<'a> {
    /// Name: `front`, `left`, `projector-3` …
    pub name: &'a str,
    /// Camera axes of the program → axes of the view, from the view's eye.
    pub rotation: DMat4,
    /// Axes of the view → OpenGL's clip space.
    pub frustum: DMat4,
    /// Place in the atlas, in texels.
    pub tile: LowerLeftRect,
}

/// Counts of an [`Embedded`] since its creation.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct EmbeddedCounts {
    /// Number of ended frames.
    pub frames: u64,
    /// Number of drawn views.
    pub views: u64,
    /// Number of OpenGL errors that Cupola's own calls caused; none is left for the program.
    pub errors: u64,
}

enum State {
    Idle,
    Frame,
    View(Saved),
}

/// A rig on a program's OpenGL context.
///
/// All methods need the context current on which it was made. The program's state does not change,
/// except that between the begin and the end of a view the framebuffer bindings, the viewport and
/// the scissor are different; the end restores them.
pub struct Embedded {
    gl: Gl,
    rig: Rig,
    session: Session,
    surface: Surface,
    backend: GlBackend,
    state: State,
    counts: EmbeddedCounts,
    /// Targets of this frame's outputs; stored so that frames allocate nothing.
    targets: Vec<Target>,
    es: bool,
    plan: Planner,
}

/// Function that plans a rig: with perspective views only, or with pictures of outputs as views.
type Planner = fn(&Rig, (u32, u32), bool, u32, Extras) -> Result<Session>;

impl Embedded {
    /// Plans `rig` for pictures of `size` (width, height in pixels, 1…16384) and creates the
    /// objects that it needs on the current context, which must be OpenGL 3.3 or OpenGL ES 3.0 at
    /// least.
    ///
    /// # Errors
    /// Errors of the planner and of the driver; [`ErrorKind::InvalidArgument`] for a size out of
    /// range or a rig that corrects nothing.
    pub fn new(gl: Gl, rig: &Rig, size: (u32, u32)) -> Result<Self> {
        Self::planned(gl, rig, size, Session::new)
    }

    /// The same for a program whose shaders project vertices by [`Embedded::projection`]: outputs
    /// with the methods `vertex` and `primitive` have a view that is their own picture. Primitives
    /// are not divided.
    ///
    /// # Errors
    /// As for [`Embedded::new`].
    pub fn projecting(gl: Gl, rig: &Rig, size: (u32, u32)) -> Result<Self> {
        Self::planned(gl, rig, size, Session::projecting)
    }

    fn planned(gl: Gl, rig: &Rig, size: (u32, u32), plan: Planner) -> Result<Self> {
        let es = gl.is_es();
        let (session, surface, backend) = Self::prepare(&gl, rig, size, es, plan)?;
        let counts = EmbeddedCounts::default();
        Ok(Self {
            gl,
            rig: rig.clone(),
            session,
            surface,
            backend,
            state: State::Idle,
            counts,
            targets: Vec::new(),
            es,
            plan,
        })
    }

    fn prepare(gl: &Gl, rig: &Rig, size: (u32, u32), es: bool, plan: Planner) -> Result<(Session, Surface, GlBackend)> {
        check_request(rig, size)?;
        if gl.text(api::GL_VERSION).is_empty() {
            return Err(Error::new(ErrorKind::InvalidState, NO_CONTEXT));
        }
        let session = plan(rig, size, false, greatest_texture(gl), Extras::default())?;
        let mut backend = GlBackend::new(gl, es)?.with_cache(gl, cache::of_process());
        if let Err(error) = backend.prepare(gl, session.plan(), false) {
            backend.destroy(gl);
            return Err(error);
        }
        let atlas = session.plan().views.atlas;
        match Surface::new(gl, (atlas.0 as i32, atlas.1 as i32), 0, false) {
            Ok(surface) => {
                log_plan(rig, &session);
                Ok((session, surface, backend))
            }
            Err(error) => {
                backend.destroy(gl);
                Err(error)
            }
        }
    }

    /// Plans again for pictures of another size; only between frames. On an error the old size
    /// stays.
    ///
    /// # Errors
    /// As for [`Embedded::new`]; [`ErrorKind::InvalidState`] inside a frame.
    pub fn resize(&mut self, size: (u32, u32)) -> Result<()> {
        self.expect_idle()?;
        if size == self.session.window() {
            return Ok(());
        }
        self.replan(self.rig.clone(), size)
    }

    /// Plans again for a viewer elsewhere; only between frames. Views and tiles may change. On an
    /// error everything stays.
    ///
    /// # Errors
    /// As for [`Embedded::new`] and [`Rig::with_viewer`]; [`ErrorKind::InvalidState`] inside a
    /// frame.
    pub fn set_viewer(&mut self, viewer: Viewer) -> Result<()> {
        self.expect_idle()?;
        if viewer == self.rig.viewer {
            return Ok(());
        }
        self.replan(self.rig.with_viewer(viewer)?, self.session.window())
    }

    fn replan(&mut self, rig: Rig, size: (u32, u32)) -> Result<()> {
        self.expect_context()?;
        let (session, surface, backend) = Self::prepare(&self.gl, &rig, size, self.es, self.plan)?;
        self.backend.destroy(&self.gl);
        self.surface.destroy(&self.gl);
        (self.session, self.surface, self.backend, self.rig) = (session, surface, backend, rig);
        Ok(())
    }

    /// Returns the blending of an output.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidArgument`] for an output that does not exist.
    pub fn blend(&self, output: usize) -> Result<&Blend> {
        self.rig.outputs.get(output).map(|output| &output.blend).ok_or_else(|| self.no_output(output))
    }

    /// Changes the blending of an output from the next frame on; only between frames. The views
    /// stay. Shaders that change are compiled again, which takes milliseconds for each batch. On an
    /// error everything stays.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidState`] inside a frame; [`ErrorKind::InvalidArgument`] for an output
    /// that does not exist, a value out of its range, or overlap of an output that is no projector;
    /// errors of the driver.
    pub fn set_blend(&mut self, output: usize, blend: Blend) -> Result<()> {
        self.expect_idle()?;
        blend.check()?;
        let mut rig = self.rig.clone();
        let Some(described) = rig.outputs.get_mut(output) else { return Err(self.no_output(output)) };
        if blend.overlap && !described.kind.is_projector() {
            let message = format!("output {output} is no projector; expected overlap = 0 (use `ramps` instead)");
            return Err(Error::new(ErrorKind::InvalidArgument, message));
        }
        described.blend = blend;
        let size = self.session.window();
        let session = (self.plan)(&rig, size, false, greatest_texture(&self.gl), Extras::default())?;
        self.backend.prepare(&self.gl, session.plan(), false)?;
        (self.rig, self.session) = (rig, session);
        Ok(())
    }

    fn no_output(&self, index: usize) -> Error {
        let count = self.rig.outputs.len();
        Error::new(ErrorKind::InvalidArgument, format!("there is no output {index}; there are {count}, from 0"))
    }

    /// Returns the number of views; it changes only with [`Embedded::resize`] and
    /// [`Embedded::set_viewer`].
    pub fn view_count(&self) -> usize {
        self.session.views().len()
    }

    /// Describes a view, for a program whose camera has `near` and `far` planes (0 < near < far;
    /// far may be infinite).
    ///
    /// # Errors
    /// [`ErrorKind::InvalidArgument`] for an index that does not exist or for wrong planes.
    pub fn view(&self, index: usize, near: f64, far: f64) -> Result<EmbeddedView<'_>> {
        let view = self.session.views().get(index).ok_or_else(|| no_view(index, self.view_count()))?;
        check_planes(near, far)?;
        Ok(EmbeddedView {
            name: &view.name,
            rotation: rotation(&self.session, view),
            frustum: projection(&view.frustum, near, far),
            tile: self.session.tile(index).0,
        })
    }

    /// Returns the values of `cupola_view` for a view, for the functions of
    /// [`correct::projected::projection`](crate::correct::projected::projection), if the program
    /// draws with the perspective `matrix`.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidArgument`] for an index that does not exist, or a matrix that is no
    /// perspective.
    pub fn projection(&self, index: usize, matrix: &DMat4) -> Result<[f32; 32]> {
        let (rows, lens) = vectors_of_view(&self.session, index, matrix)?;
        Ok(joined(&rows, &lens))
    }

    /// Begins a frame.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidState`] inside another frame, or if the context is not current.
    pub fn begin_frame(&mut self) -> Result<()> {
        self.expect_idle()?;
        self.expect_context()?;
        self.state = State::Frame;
        Ok(())
    }

    /// Begins a frame that ends in `framebuffer`.
    ///
    /// # Errors
    /// As [`Self::begin_frame`] and [`Self::check_framebuffer`].
    pub fn begin_frame_into(&mut self, framebuffer: u32) -> Result<()> {
        self.expect_idle()?;
        self.check_framebuffer(framebuffer)?;
        self.state = State::Frame;
        Ok(())
    }

    /// Begins a view: binds its tile for drawing and sets viewport and scissor to it.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidState`] outside a frame or inside another view;
    /// [`ErrorKind::InvalidArgument`] for an index that does not exist.
    pub fn begin_view(&mut self, index: usize) -> Result<()> {
        if !matches!(self.state, State::Frame) {
            return Err(Error::new(
                ErrorKind::InvalidState,
                "a view begins between the begin and the end of a frame, after the end of the view before",
            ));
        }
        if index >= self.view_count() {
            return Err(no_view(index, self.view_count()));
        }
        self.expect_context()?;
        self.state = State::View(self.surface.begin_tile(&self.gl, self.session.tile(index).0));
        self.counts.views += 1;
        Ok(())
    }

    /// Ends a view: restores framebuffer bindings, viewport and scissor.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidState`] outside a view.
    pub fn end_view(&mut self) -> Result<()> {
        match std::mem::replace(&mut self.state, State::Frame) {
            State::View(saved) => {
                self.surface.end_tile(&self.gl, &saved);
                Ok(())
            }
            state => {
                self.state = state;
                Err(Error::new(ErrorKind::InvalidState, "no view was begun"))
            }
        }
    }

    /// Ends a frame: corrects the views into `framebuffer` (0 = the window), each output at its
    /// place in the rectangle (x, y from the bottom left; as large as the pictures are).
    ///
    /// Returns the OpenGL error that the program itself had pending, which this call takes out of
    /// the driver.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidState`] outside a frame or inside a view, and as
    /// [`Self::check_framebuffer`]. The frame has not ended then.
    pub fn end_frame(&mut self, framebuffer: u32, x: i32, y: i32) -> Result<u32> {
        if !matches!(self.state, State::Frame) {
            return Err(Error::new(
                ErrorKind::InvalidState,
                "a frame ends after its begin and after the end of its last view",
            ));
        }
        self.check_framebuffer(framebuffer)?;
        self.state = State::Idle;
        self.targets.clear();
        self.targets.extend(self.session.viewports().map(|place| Target { framebuffer, viewport: place.moved(x, y) }));
        let pending = self.backend.present(&self.gl, self.surface.texture(), &self.targets);
        self.counts.frames += 1;
        Ok(pending)
    }

    /// Counts so far.
    pub fn counts(&self) -> EmbeddedCounts {
        EmbeddedCounts { errors: self.backend.errors(), ..self.counts }
    }

    /// Deletes everything on the context.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidState`] if the context is not current. Then nothing is deleted, because
    /// the names would be those of other objects.
    pub fn destroy(mut self) -> Result<()> {
        self.expect_context()?;
        self.backend.destroy(&self.gl);
        self.surface.destroy(&self.gl);
        Ok(())
    }

    /// Fails unless pictures can be presented into `framebuffer` (0 = the window) of the context.
    ///
    /// # Errors
    /// [`ErrorKind::InvalidState`] if the context is not current; [`ErrorKind::InvalidArgument`] if
    /// there is no such framebuffer, or it is incomplete.
    pub fn check_framebuffer(&self, framebuffer: u32) -> Result<()> {
        self.expect_context()?;
        let invalid = |message: String| Err(Error::new(ErrorKind::InvalidArgument, message));
        match (framebuffer_state(&self.gl, framebuffer), framebuffer) {
            (FramebufferState::Complete, _) => Ok(()),
            (FramebufferState::Missing, name) => invalid(format!("the context has no framebuffer {name}")),
            (_, 0) => invalid("the context has no window to present into (framebuffer 0)".to_owned()),
            (FramebufferState::Incomplete(status), name) => {
                invalid(format!("framebuffer {name} is not complete (status {status:#06x})"))
            }
        }
    }

    /// Fails unless the context on which this was made is current.
    fn expect_context(&self) -> Result<()> {
        if self.backend.is_of_current_context(&self.gl) {
            return Ok(());
        }
        let message = match self.gl.text(api::GL_VERSION).is_empty() {
            true => NO_CONTEXT,
            false => "another OpenGL context is current than the one on which the object was made",
        };
        Err(Error::new(ErrorKind::InvalidState, message))
    }

    fn expect_idle(&self) -> Result<()> {
        if matches!(self.state, State::Idle) {
            Ok(())
        } else {
            Err(Error::new(ErrorKind::InvalidState, "a frame has begun and not ended"))
        }
    }
}

const NO_CONTEXT: &str = "no OpenGL context is current in this thread";

fn log_plan(rig: &Rig, session: &Session) {
    let ((width, height), plan) = (session.window(), &session.plan().views);
    let (count, (atlas_width, atlas_height)) = (plan.views.len(), plan.atlas);
    log::info!(
        "rig {}: {width} x {height} pixels from {count} views in an atlas of {atlas_width} x {atlas_height} texels",
        rig.name
    );
    for note in &plan.notes {
        log::warn!("rig {}: {note}", rig.name);
    }
}

/// Checks that are the same for every API.
fn check_request(rig: &Rig, size: (u32, u32)) -> Result<()> {
    let message = if rig.passthrough {
        format!("the rig `{}` corrects nothing; without Cupola the program shows the same", rig.name)
    } else if [size.0, size.1].iter().any(|length| !(1..=LARGEST_PICTURE).contains(length)) {
        let (width, height) = size;
        format!("a picture of {width} × {height} pixels; expected 1 × 1 to {LARGEST_PICTURE} × {LARGEST_PICTURE}")
    } else {
        return Ok(());
    };
    Err(Error::new(ErrorKind::InvalidArgument, message))
}
