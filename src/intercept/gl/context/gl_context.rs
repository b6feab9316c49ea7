//! What a program believes about one of its contexts.

use crate::backend::gl::api::{self, Gl};
use crate::intercept::camera::Cameras;
use crate::intercept::gl::context::list_recording::{Lists, Recording};
use crate::intercept::gl::state::attribute_stack::Pushed;
use crate::intercept::gl::state::background::Background;
use crate::intercept::gl::state::begin_end::Immediate;
use crate::intercept::gl::state::buffer_bindings::Bound;
use crate::intercept::gl::state::buffers::Buffers;
use crate::intercept::gl::state::default_framebuffer::{DefaultFramebuffer, OwnObjects};
use crate::intercept::gl::state::division_counter::Counter;
use crate::intercept::gl::state::draw_count::DrawCount;
use crate::intercept::gl::state::fixed_function::FixedFunction;
use crate::intercept::gl::state::front_buffer::FrontBufferThrottle;
use crate::intercept::gl::state::max_width::MaxWidth;
use crate::intercept::gl::state::offscreen::view_copies::{SharedViewCopies, ViewCopies};
use crate::intercept::gl::state::primitives::WidePrimitives;
use crate::intercept::gl::state::profile::{Profile, profile};
use crate::intercept::gl::state::program_pipelines::Pipelines;
use crate::intercept::gl::state::programs::{Program, Programs};
use crate::intercept::gl::state::projection::Projection;
use crate::intercept::gl::state::queries::{Condition, Queries};
use crate::intercept::gl::state::raster_position::RasterPosition;
use crate::intercept::gl::state::statistics::Counts;
use crate::intercept::gl::state::vertex_arrays::VertexArrays;
use crate::intercept::gl::state::vertex_ranges::Ranges;
use crate::intercept::gl::state::window::Window;
use crate::intercept::gl::state::window_space::{AppState, DriverState};
use crate::runtime::session::Session;
use std::collections::HashSet;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

/// What objects that contexts share are known by.
pub struct ShareGroup {
    /// Shaders and programs.
    pub(in crate::intercept::gl) programs: Mutex<Programs>,
    /// Display lists.
    pub(in crate::intercept::gl) lists: Mutex<Lists>,
    /// What is known of images that are drawn off screen; `None` while a context that is current has it.
    pub(in crate::intercept::gl) off_screen: Mutex<Option<SharedViewCopies>>,
    /// What is known of buffers.
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

/// One context of the program.
pub struct Context {
    /// A number of its own, among all contexts of the process.
    pub(in crate::intercept::gl) id: u64,
    /// The driver.
    pub(in crate::intercept::gl) gl: &'static Gl,
    /// Which OpenGL.
    pub(in crate::intercept::gl) profile: Profile,
    /// The program's vertices cannot be projected straight to an output: windows have views.
    pub(in crate::intercept::gl) views_only: bool,
    /// What stands in for the fixed-function pipeline where vertices are projected.
    pub(in crate::intercept::gl) fixed_function: FixedFunction,
    /// Counts primitives that were not divided far enough.
    pub(in crate::intercept::gl) coarse: Option<Counter>,
    /// Primitives were divided by stages that cannot count.
    pub(in crate::intercept::gl) uncounted: bool,
    /// A defect switched this context off: every call goes straight to the driver.
    pub(in crate::intercept::gl) switched_off: bool,
    /// The window that it draws to.
    pub(in crate::intercept::gl) window: Option<Window>,
    /// What stands in for the window's framebuffer; `None` = the window's own.
    pub(in crate::intercept::gl) target: Option<Box<DefaultFramebuffer>>,
    /// The plan of a window that another context of the group draws, for a context without one: what it draws off
    /// screen may be shown there.
    pub(in crate::intercept::gl) lent: Option<Arc<Session>>,
    /// What stands in for other windows that it drew to lately.
    pub(in crate::intercept::gl) parked: Vec<(Window, Box<DefaultFramebuffer>)>,
    /// The program reads from another drawable than it draws to.
    pub(in crate::intercept::gl) reads_elsewhere: bool,
    /// Objects of pictures that were given to other contexts.
    pub(in crate::intercept::gl) left_behind: Vec<OwnObjects>,
    /// What the program has set.
    pub(in crate::intercept::gl) app: AppState,
    /// `glPushAttrib`.
    pub(in crate::intercept::gl) attribute_stack: Vec<Pushed>,
    /// What the driver has.
    pub(in crate::intercept::gl) driver_state: DriverState,
    /// The fixed-function projection.
    pub(in crate::intercept::gl) projection: Projection,
    /// Flat drawing behind the scene.
    pub(in crate::intercept::gl) background: Background,
    /// The cameras of the frame.
    pub(in crate::intercept::gl) cameras: Cameras,
    /// Scenes that are drawn off screen.
    pub(in crate::intercept::gl) view_copies: ViewCopies,
    /// The program object that draws: the one in use, or a pipeline's.
    pub(in crate::intercept::gl) program: Option<Arc<Program>>,
    /// Program pipelines, and which program is in use.
    pub(in crate::intercept::gl) pipelines: Pipelines,
    /// The Begin/End that the program is in.
    pub(in crate::intercept::gl) immediate: Immediate,
    /// How many draws a frame has.
    pub(in crate::intercept::gl) draw_count: DrawCount,
    /// Where the draw that is being issued comes to be in each view, if that is known.
    pub(in crate::intercept::gl) areas: Vec<crate::correct::TexelSpan>,
    /// Where draws from buffers are.
    pub(in crate::intercept::gl) ranges: Ranges,
    /// Vertex arrays.
    pub(in crate::intercept::gl) vertex_arrays: VertexArrays,
    /// Which buffers are bound.
    pub(in crate::intercept::gl) buffer_bindings: Bound,
    /// State that need not be asked for.
    pub(in crate::intercept::gl) known_state: crate::backend::gl::KnownState,
    /// The greatest width of points and lines so far.
    pub(in crate::intercept::gl) max_width: MaxWidth,
    /// Points and lines that may leave their tile.
    pub(in crate::intercept::gl) wide_primitives: WidePrimitives,
    /// The driver's anisotropic filtering may never end.
    pub(in crate::intercept::gl) endless_anisotropy: bool,
    /// A vertex program in assembly language was switched on: the fixed-function matrices may say nothing.
    pub(in crate::intercept::gl) assembly: bool,
    /// `glRenderMode` is not `GL_RENDER`.
    pub(in crate::intercept::gl) picking: bool,
    /// The raster position.
    pub(in crate::intercept::gl) raster: RasterPosition,
    /// The display list that is being compiled.
    pub(in crate::intercept::gl) recording: Option<Recording>,
    /// `glListBase`.
    pub(in crate::intercept::gl) list_base: u32,
    /// An error of the program's that we had to take out of the driver.
    pub(in crate::intercept::gl) pending_error: u32,
    /// Buffers that were bound for uniform blocks.
    pub(in crate::intercept::gl) block_buffers: HashSet<u32>,
    /// Grows with every change of a buffer that may hold uniform blocks.
    pub(in crate::intercept::gl) buffer_generation: u64,
    /// Conditional rendering.
    pub(in crate::intercept::gl) condition: Condition,
    /// The accumulation buffer, once the program used it.
    pub(in crate::intercept::gl) accumulation: Option<crate::backend::gl::accumulation::Accumulation>,
    /// Queries that count what is drawn.
    pub(in crate::intercept::gl) queries: Queries,
    /// Transform feedback is recording.
    pub(in crate::intercept::gl) feedback: bool,
    /// `GL_RASTERIZER_DISCARD`.
    pub(in crate::intercept::gl) discard: bool,
    /// How often flushes of the front buffer are answered.
    pub(in crate::intercept::gl) front_buffer: FrontBufferThrottle,
    /// Objects shared with other contexts.
    pub(in crate::intercept::gl) share: Arc<ShareGroup>,
    /// Counts for `--stats`.
    pub(in crate::intercept::gl) counts: Counts,
    /// Something was drawn since the last swap.
    pub(in crate::intercept::gl) frame_begun: bool,
    /// Nothing of the window could be seen after its last swap.
    pub(in crate::intercept::gl) occluded: bool,
    /// The lens of the last draw of the scene.
    pub(in crate::intercept::gl) lens: Option<crate::runtime::session::Intrinsics>,
    /// Largest viewport (area) that a scene was drawn to: in this frame, and in the last one.
    pub(in crate::intercept::gl) viewport_area: [i64; 2],
}

impl Context {
    /// A context that has just become current for the first time.
    pub fn new(gl: &'static Gl, share: Arc<ShareGroup>) -> Self {
        let app = AppState {
            draw_framebuffer: 0,
            read_framebuffer: 0,
            viewport: [0; 4],
            scissor: [0; 4],
            scissor_test: false,
            draw_buffer: api::GL_BACK,
            read_buffer: api::GL_BACK,
            matrix_mode: api::GL_MODELVIEW,
        };
        static CONTEXTS: AtomicU64 = AtomicU64::new(0);
        Self {
            id: CONTEXTS.fetch_add(1, Ordering::Relaxed),
            gl,
            profile: profile(gl),
            views_only: false,
            fixed_function: Default::default(),
            coarse: None,
            uncounted: false,
            switched_off: false,
            window: None,
            target: None,
            lent: None,
            parked: Vec::new(),
            left_behind: Vec::new(),
            reads_elsewhere: false,
            app,
            attribute_stack: Vec::new(),
            driver_state: DriverState::default(),
            projection: Projection::default(),
            background: Background::default(),
            cameras: Cameras::default(),
            view_copies: Default::default(),
            program: None,
            pipelines: Default::default(),
            immediate: Default::default(),
            draw_count: Default::default(),
            areas: Vec::new(),
            ranges: Default::default(),
            vertex_arrays: Default::default(),
            buffer_bindings: Default::default(),
            known_state: Default::default(),
            max_width: MaxWidth::default(),
            wide_primitives: Default::default(),
            endless_anisotropy: crate::intercept::gl::state::profile::is_endless(gl),
            assembly: false,
            picking: false,
            raster: RasterPosition::default(),
            recording: None,
            list_base: 0,
            pending_error: 0,
            block_buffers: HashSet::new(),
            buffer_generation: 0,
            condition: None,
            accumulation: None,
            queries: Default::default(),
            feedback: false,
            discard: false,
            front_buffer: Default::default(),
            share,
            counts: Counts::default(),
            frame_begun: false,
            occluded: false,
            lens: None,
            viewport_area: [0; 2],
        }
    }

    /// The plan of the window that is drawn, or for which is drawn.
    pub fn session(&self) -> Option<&Session> {
        Self::session_of(&self.target, &self.lent)
    }

    /// The same of these two parts of a context.
    pub fn session_of<'a>(
        target: &'a Option<Box<DefaultFramebuffer>>,
        lent: &'a Option<Arc<Session>>,
    ) -> Option<&'a Session> {
        target.as_ref().map(|target| &*target.session).or(lent.as_deref())
    }

    /// The program's draws go to its window, which is ours.
    pub fn redirected(&self) -> bool {
        self.target.is_some() && self.app.draw_framebuffer == 0
    }

    /// The program's reads come from its window, which is ours.
    pub fn reads_redirected(&self) -> bool {
        self.target.is_some() && self.app.read_framebuffer == 0 && !self.reads_elsewhere
    }

    /// What reads of the program's framebuffer 0 are bound to.
    pub fn window_for_reading(&self) -> u32 {
        self.target.as_ref().filter(|_| !self.reads_elsewhere).map_or(0, |target| target.framebuffer())
    }

    /// Whether OpenGL does what a call of the program says if its arguments are right: not where it may be between Begin and
    /// End.
    pub fn takes_calls(&self) -> bool {
        !self.immediate.under_way() && !self.picking && self.session().is_some()
    }

    /// A display list is being compiled: commands are not executed now.
    pub fn compiling(&self) -> bool {
        self.recording.is_some()
    }

    /// Gives the program its own window back, for good.
    pub fn leave_alone(&mut self) {
        if let Some(target) = self.target.take() {
            let [x, y, width, height] = self.app.viewport;
            // SAFETY: puts back what the program has set; the framebuffers are ours.
            unsafe {
                if self.app.draw_framebuffer == 0 {
                    self.gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, 0);
                }
                if self.app.read_framebuffer == 0 {
                    self.gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, 0);
                }
                self.gl.viewport(x, y, width, height);
                let [x, y, width, height] = self.app.scissor;
                self.gl.scissor(x, y, width, height);
                if self.app.scissor_test {
                    self.gl.enable(api::GL_SCISSOR_TEST);
                } else {
                    self.gl.disable(api::GL_SCISSOR_TEST);
                }
            }
            target.destroy(self.gl);
        }
    }
}
