//! A context of the program and its parts.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::context::list_recording::{ListState, Lists};
use crate::intercept::gl::state::app::AppState;
use crate::intercept::gl::state::compat::Compat;
use crate::intercept::gl::state::draw::DrawState;
use crate::intercept::gl::state::drawable::Drawable;
use crate::intercept::gl::state::driver::Driver;
use crate::intercept::gl::state::frame::Frame;
use crate::intercept::gl::state::offscreen::view_copies::{SharedViewCopies, ViewCopies};
use crate::intercept::gl::state::projected_vertices::ProjectedVertices;
use crate::intercept::gl::state::queries::Queries;
use crate::intercept::gl::state::shader::Shaders;
use crate::intercept::gl::state::shader::programs::Programs;
use crate::intercept::gl::state::vertex_input::VertexInput;
use crate::intercept::gl::state::vertex_input::buffers::Buffers;
use crate::runtime::session::Session;
use std::sync::{Arc, Mutex};

/// Records of the objects that contexts share.
pub struct ShareGroup {
    /// Shaders and programs.
    pub(in crate::intercept::gl) programs: Mutex<Programs>,
    /// Display lists.
    pub(in crate::intercept::gl) lists: Mutex<Lists>,
    /// Records of images that are drawn off screen; `None` while one of the current contexts holds
    /// them.
    pub(in crate::intercept::gl) off_screen: Mutex<Option<SharedViewCopies>>,
    pub(in crate::intercept::gl) buffers: Mutex<Buffers>,
}

impl Default for ShareGroup {
    fn default() -> Self {
        Self {
            programs: Default::default(),
            lists: Default::default(),
            off_screen: Mutex::new(Some(Default::default())),
            buffers: Default::default(),
        }
    }
}

/// A context of the program. The names in parentheses are the folders that own a part. Other
/// folders call the part's methods (`tests/architecture/parts.rs`).
pub struct Context {
    /// True if a panic switched this context off. Every call goes straight to the driver.
    pub(in crate::intercept::gl) switched_off: bool,
    /// Objects shared with other contexts.
    pub(in crate::intercept::gl) share: Arc<ShareGroup>,
    /// The driver and its state (`context`).
    pub(in crate::intercept::gl) driver: Driver,
    /// State that the program has set (`app_state`, `framebuffer`).
    pub(in crate::intercept::gl) app: AppState,
    /// The window and its stand-in (`entry`, `framebuffer`).
    pub(in crate::intercept::gl) drawable: Drawable,
    /// State of the current frame (`frame`, `draw`).
    pub(in crate::intercept::gl) frame: Frame,
    /// The draw that is being issued (`draw`, `per_view`).
    pub(in crate::intercept::gl) draw: DrawState,
    /// The program object that draws (`shader`).
    pub(in crate::intercept::gl) shaders: Shaders,
    /// Buffers and vertex arrays (`vertex_input`).
    pub(in crate::intercept::gl) vertex_input: VertexInput,
    /// Queries that count what is drawn (`queries`).
    pub(in crate::intercept::gl) queries: Queries,
    /// Scenes that are drawn off screen (`offscreen`).
    pub(in crate::intercept::gl) view_copies: ViewCopies,
    /// Matrices, Begin/End, raster position (`compat`).
    pub(in crate::intercept::gl) compat: Compat,
    /// The display list that is being compiled (`compat`).
    pub(in crate::intercept::gl) lists: ListState,
    /// Methods `vertex` and `primitive` (`projected_vertices`).
    pub(in crate::intercept::gl) projected: ProjectedVertices,
}

impl Context {
    /// Returns the state of a context that has just become current for the first time.
    pub fn new(gl: &'static Gl, share: Arc<ShareGroup>) -> Self {
        Self {
            switched_off: false,
            share,
            driver: Driver::new(gl),
            app: Default::default(),
            drawable: Default::default(),
            frame: Default::default(),
            draw: Default::default(),
            shaders: Default::default(),
            vertex_input: Default::default(),
            queries: Default::default(),
            view_copies: Default::default(),
            compat: Default::default(),
            lists: Default::default(),
            projected: Default::default(),
        }
    }

    /// Returns the plan of the window that this context draws to. A context without a window has
    /// the plan of another context's window.
    pub fn session(&self) -> Option<&Session> {
        self.drawable.session()
    }

    /// True if the program draws to its window and Cupola replaces the window's framebuffer.
    pub fn redirected(&self) -> bool {
        self.drawable.target().is_some() && self.app.draw_framebuffer() == 0
    }

    /// True if the program reads from its window and Cupola replaces the window's framebuffer.
    pub fn reads_redirected(&self) -> bool {
        self.drawable.target().is_some() && self.app.read_framebuffer() == 0 && !self.drawable.reads_elsewhere()
    }

    /// Notes that something is drawn to the window.
    pub fn note_drawn(&mut self) {
        self.frame.note_drawn();
        if let Some(target) = self.drawable.target() {
            target.note_drawn();
        }
    }

    /// True if OpenGL surely executes a call of the program whose arguments are valid. False where
    /// the program may be between Begin and End.
    pub fn takes_calls(&self) -> bool {
        !self.compat.under_way() && !self.app.picking() && self.session().is_some()
    }

    /// True while a display list is being compiled. Commands are then not executed now.
    pub fn compiling(&self) -> bool {
        self.lists.recording.is_some()
    }

    /// Gives the program its own window back permanently.
    pub fn leave_alone(&mut self) {
        if let Some(target) = self.drawable.take_target() {
            let gl = self.driver.gl;
            // SAFETY: framebuffer 0 always exists; it gets the buffers that the program has chosen.
            // Then the program's own bindings are put back.
            unsafe {
                gl.bind_framebuffer(api::GL_FRAMEBUFFER, 0);
                if self.driver.profile.has_buffers() {
                    self.app.buffers().draw_to_window(gl, self.driver.profile.es);
                    if !self.drawable.reads_elsewhere() {
                        gl.read_buffer(self.app.buffers().read());
                    }
                }
                gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, self.app.draw_framebuffer());
                gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, self.app.read_framebuffer());
            }
            self.driver.forget_window_space(api::GL_VIEWPORT_BIT | api::GL_SCISSOR_BIT);
            self.restore_window_space();
            target.destroy(self.driver.gl);
        }
    }
}
