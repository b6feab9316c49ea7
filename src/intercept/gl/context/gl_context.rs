//! What a program believes about one of its contexts.

use crate::backend::gl::api::{self, Gl};
use crate::intercept::camera::Cameras;
use crate::intercept::gl::compat::display_lists::{Lists, Recording};
use crate::intercept::gl::compat::matrices::Projection;
use crate::intercept::gl::compat::raster_position::Raster;
use crate::intercept::gl::context::statistics::Counts;
use crate::intercept::gl::context::window::Window;
use crate::intercept::gl::draw::background::Background;
use crate::intercept::gl::draw::culling::max_width::Widest;
use crate::intercept::gl::framebuffer::default_framebuffer::{DefaultFramebuffer, OwnObjects};
use crate::intercept::gl::shader::programs::{Program, Programs};
use crate::intercept::settings::settings;
use crate::runtime::session::{Extras, Session};
use std::collections::HashSet;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};

/// Which OpenGL a context speaks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Profile {
    /// OpenGL ES.
    pub es: bool,
    /// Desktop OpenGL without the fixed-function pipeline.
    pub core: bool,
    /// Major · 10 + minor.
    pub version: u32,
}

impl Profile {
    /// Desktop OpenGL with the fixed-function pipeline.
    pub fn compatibility(&self) -> bool {
        !self.es && !self.core
    }
}

/// What objects that contexts share are known by.
pub struct ShareGroup {
    /// Shaders and programs.
    pub programs: Mutex<Programs>,
    /// Display lists.
    pub lists: Mutex<Lists>,
    /// What is known of images that are drawn off screen; `None` while a context that is current has it.
    pub off_screen: Mutex<Option<crate::intercept::gl::offscreen::view_copies::Travelling>>,
    /// What is known of buffers.
    pub buffers: Mutex<crate::intercept::gl::vertex_input::buffers::Buffers>,
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

/// The program's view of its window-space state.
#[derive(Clone, Debug)]
pub struct Believed {
    /// The program's draw framebuffer, 0 = its window.
    pub draw_framebuffer: u32,
    /// The program's read framebuffer.
    pub read_framebuffer: u32,
    /// `glViewport`.
    pub viewport: [i32; 4],
    /// `glScissor`.
    pub scissor: [i32; 4],
    /// `GL_SCISSOR_TEST`.
    pub scissor_test: bool,
    /// `glDrawBuffer` of its window.
    pub draw_buffer: u32,
    /// `glReadBuffer` of its window.
    pub read_buffer: u32,
    /// `glMatrixMode`.
    pub matrix_mode: u32,
}

/// What is really set in the driver, where known; saves redundant calls.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Actual {
    /// The real viewport.
    pub viewport: Option<[i32; 4]>,
    /// The real scissor rectangle.
    pub scissor: Option<[i32; 4]>,
    /// Whether the real scissor test is on.
    pub scissor_test: Option<bool>,
}

/// One context of the program.
pub struct Context {
    /// A number of its own, among all contexts of the process.
    pub id: u64,
    /// The driver.
    pub gl: &'static Gl,
    /// Which OpenGL.
    pub profile: Profile,
    /// The program's vertices cannot be projected straight to an output: windows have views.
    pub views_only: bool,
    /// What stands in for the fixed-function pipeline where vertices are projected.
    pub fixed: crate::intercept::gl::projected_vertices::fixed_function::substitute::Fixed,
    /// Counts primitives that were not divided far enough.
    pub coarse: Option<crate::intercept::gl::projected_vertices::division_counter::Counter>,
    /// Primitives were divided by stages that cannot count.
    pub uncounted: bool,
    /// A defect switched this context off: every call goes straight to the driver.
    pub switched_off: bool,
    /// The window that it draws to.
    pub window: Option<Window>,
    /// What stands in for the window's framebuffer; `None` = the window's own.
    pub target: Option<Box<DefaultFramebuffer>>,
    /// The plan of a window that another context of the group draws, for a context without one: what it draws off
    /// screen may be shown there.
    pub lent: Option<Arc<Session>>,
    /// What stands in for other windows that it drew to lately.
    pub parked: Vec<(Window, Box<DefaultFramebuffer>)>,
    /// The program reads from another drawable than it draws to.
    pub reads_elsewhere: bool,
    /// Objects of pictures that were given to other contexts.
    pub left_behind: Vec<OwnObjects>,
    /// What the program believes.
    pub believed: Believed,
    /// `glPushAttrib`.
    pub attribute_stack: Vec<crate::intercept::gl::context::window_state::Pushed>,
    /// What the driver has.
    pub actual: Actual,
    /// The fixed-function projection.
    pub projection: Projection,
    /// Flat drawing behind the scene.
    pub background: Background,
    /// The cameras of the frame.
    pub cameras: Cameras,
    /// Scenes that are drawn off screen.
    pub duplicates: crate::intercept::gl::offscreen::view_copies::Duplicates,
    /// The program object that draws: the one in use, or a pipeline's.
    pub program: Option<Arc<Program>>,
    /// Program pipelines, and which program is in use.
    pub pipelines: crate::intercept::gl::shader::program_pipelines::Pipelines,
    /// The Begin/End that the program is in.
    pub immediate: crate::intercept::gl::compat::begin_end::Immediate,
    /// How many draws a frame has.
    pub workload: crate::intercept::gl::frame::draw_count::Workload,
    /// Where the draw that is being issued comes to be in each view, if that is known.
    pub areas: Vec<crate::correct::Texels>,
    /// Where draws from buffers are.
    pub ranges: crate::intercept::gl::draw::culling::ranges::Ranges,
    /// Vertex arrays.
    pub vertex_arrays: crate::intercept::gl::vertex_input::vertex_arrays::VertexArrays,
    /// Which buffers are bound.
    pub bound: crate::intercept::gl::vertex_input::buffer_bindings::Bound,
    /// State that need not be asked for.
    pub known_state: crate::backend::gl::KnownState,
    /// The greatest width of points and lines so far.
    pub widest: Widest,
    /// Points and lines that may leave their tile.
    pub outlines: crate::intercept::gl::draw::wide_primitives::Outlines,
    /// The driver's anisotropic filtering may never end.
    pub endless_anisotropy: bool,
    /// A vertex program in assembly language was switched on: the fixed-function matrices may say nothing.
    pub assembly: bool,
    /// `glRenderMode` is not `GL_RENDER`.
    pub picking: bool,
    /// The raster position.
    pub raster: Raster,
    /// The display list that is being compiled.
    pub recording: Option<Recording>,
    /// `glListBase`.
    pub list_base: u32,
    /// An error of the program's that we had to take out of the driver.
    pub pending_error: u32,
    /// Buffers that were bound for uniform blocks.
    pub block_buffers: HashSet<u32>,
    /// Grows with every change of a buffer that may hold uniform blocks.
    pub buffer_generation: u64,
    /// Conditional rendering.
    pub condition: crate::intercept::gl::draw::conditional_render::Condition,
    /// The accumulation buffer, once the program used it.
    pub accumulation: Option<crate::backend::gl::accumulation::Accumulation>,
    /// Queries that count what is drawn.
    pub counting: crate::intercept::gl::queries::scaling::Counting,
    /// Transform feedback is recording.
    pub feedback: bool,
    /// `GL_RASTERIZER_DISCARD`.
    pub discard: bool,
    /// How often flushes of the front buffer are answered.
    pub pace: crate::intercept::gl::frame::front_buffer::Pace,
    /// Objects shared with other contexts.
    pub share: Arc<ShareGroup>,
    /// Counts for `--stats`.
    pub counts: Counts,
    /// Something was drawn since the last swap.
    pub frame_begun: bool,
    /// Nothing of the window could be seen after its last swap.
    pub hidden: bool,
    /// The lens of the last draw of the scene.
    pub lens: Option<crate::runtime::session::Intrinsics>,
    /// Largest viewport (area) that a scene was drawn to: in this frame, and in the last one.
    pub viewport_area: [i64; 2],
}

/// Windows that a context has left keep what stands in for them, but not more than these.
const MOST_PARKED: usize = 4;

impl Context {
    /// A context that has just become current for the first time.
    pub fn new(gl: &'static Gl, share: Arc<ShareGroup>) -> Self {
        let believed = Believed {
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
            fixed: Default::default(),
            coarse: None,
            uncounted: false,
            switched_off: false,
            window: None,
            target: None,
            lent: None,
            parked: Vec::new(),
            left_behind: Vec::new(),
            reads_elsewhere: false,
            believed,
            attribute_stack: Vec::new(),
            actual: Actual::default(),
            projection: Projection::default(),
            background: Background::default(),
            cameras: Cameras::default(),
            duplicates: Default::default(),
            program: None,
            pipelines: Default::default(),
            immediate: Default::default(),
            workload: Default::default(),
            areas: Vec::new(),
            ranges: Default::default(),
            vertex_arrays: Default::default(),
            bound: Default::default(),
            known_state: Default::default(),
            widest: Widest::default(),
            outlines: Default::default(),
            endless_anisotropy: crate::intercept::gl::draw::anisotropy::is_endless(gl),
            assembly: false,
            picking: false,
            raster: Raster::default(),
            recording: None,
            list_base: 0,
            pending_error: 0,
            block_buffers: HashSet::new(),
            buffer_generation: 0,
            condition: None,
            accumulation: None,
            counting: Default::default(),
            feedback: false,
            discard: false,
            pace: Default::default(),
            share,
            counts: Counts::default(),
            frame_begun: false,
            hidden: false,
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
        self.target.is_some() && self.believed.draw_framebuffer == 0
    }

    /// The program's reads come from its window, which is ours.
    pub fn reads_redirected(&self) -> bool {
        self.target.is_some() && self.believed.read_framebuffer == 0 && !self.reads_elsewhere
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

    /// The context became current with `window`.
    pub fn attach(&mut self, window: Option<Window>, reads_elsewhere: bool) {
        self.reads_elsewhere = reads_elsewhere;
        for objects in std::mem::take(&mut self.left_behind) {
            objects.destroy(self.gl);
        }
        let first = self.window.is_none() && window.is_some() && self.believed.viewport == [0; 4];
        if self.window != window {
            self.change_window(window);
        }
        crate::intercept::gl::offscreen::view_copies::collect(self);
        let Some(window) = self.window.clone() else {
            self.borrow();
            return;
        };
        self.lent = None;
        if let Some(size) = settings().and_then(|s| s.window_size) {
            window.resize(size);
        }
        if first {
            let (width, height) = window.size();
            self.believed.viewport = [0, 0, width as i32, height as i32];
            self.believed.scissor = self.believed.viewport;
            if !window.double_buffered(self.gl, &self.profile) {
                self.believed.draw_buffer = api::GL_FRONT;
                self.believed.read_buffer = api::GL_FRONT;
            }
        }
        if self.target.is_none() {
            match crate::intercept::gl::context::current::take_picture(self, &window) {
                Some(picture) => crate::intercept::gl::framebuffer::default_framebuffer::take_over(self, picture),
                None => crate::intercept::gl::framebuffer::default_framebuffer::attach(self, Extras::default()),
            }
        } else if self.believed.read_framebuffer == 0 {
            // SAFETY: what the program's reads come from, which may be another drawable now.
            unsafe { self.gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, self.window_for_reading()) };
        }
    }

    /// A context without a window draws for that of another in its group.
    fn borrow(&mut self) {
        let lent = crate::intercept::gl::context::current::lend_session(self);
        if self.lent.as_ref().map(Arc::as_ptr) != lent.as_ref().map(Arc::as_ptr) {
            self.lent = lent;
            self.projection.clear();
            self.cameras.clear();
        }
        if self.believed.viewport == [0; 4] {
            // SAFETY: each writes four integers.
            unsafe {
                self.gl.get_integerv(api::GL_VIEWPORT, self.believed.viewport.as_mut_ptr());
                self.gl.get_integerv(api::GL_SCISSOR_BOX, self.believed.scissor.as_mut_ptr());
            }
        }
    }

    /// Gives away what stands for `window`. Its objects that belong to this context alone are deleted when it is
    /// current again.
    pub fn give_picture(&mut self, window: &Window) -> Option<Box<DefaultFramebuffer>> {
        let parked = self.parked.iter().position(|(parked, _)| parked == window);
        let target = match parked {
            Some(index) => Some(self.parked.remove(index).1),
            None if self.window.as_ref() == Some(window) => self.target.take(),
            None => None,
        }?;
        self.left_behind.push(target.own_objects());
        Some(target)
    }

    /// Another window, or none: what stood for the old one is kept for when the program comes back to it.
    fn change_window(&mut self, window: Option<Window>) {
        let old = std::mem::replace(&mut self.window, window);
        if let (Some(old), Some(target)) = (old, self.target.take()) {
            if self.parked.len() >= MOST_PARKED {
                self.parked.remove(0).1.destroy(self.gl);
            }
            self.parked.push((old, target));
            // SAFETY: the program's window is bound in place of ours.
            unsafe {
                if self.believed.draw_framebuffer == 0 {
                    self.gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, 0);
                }
                if self.believed.read_framebuffer == 0 {
                    self.gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, 0);
                }
            }
            self.restore_window_space();
        }
        self.frame_begun = false;
        self.hidden = false;
        if let Some(index) = self.parked.iter().position(|(parked, _)| Some(parked) == self.window.as_ref()) {
            let (window, target) = self.parked.remove(index);
            crate::intercept::gl::framebuffer::default_framebuffer::resume(self, &window, target);
            crate::intercept::gl::frame::present::follow_size(self);
        }
    }

    /// Gives the program its own window back, for good.
    pub fn leave_alone(&mut self) {
        if let Some(target) = self.target.take() {
            let [x, y, width, height] = self.believed.viewport;
            // SAFETY: puts back what the program believes; the framebuffers are ours.
            unsafe {
                if self.believed.draw_framebuffer == 0 {
                    self.gl.bind_framebuffer(api::GL_DRAW_FRAMEBUFFER, 0);
                }
                if self.believed.read_framebuffer == 0 {
                    self.gl.bind_framebuffer(api::GL_READ_FRAMEBUFFER, 0);
                }
                self.gl.viewport(x, y, width, height);
                let [x, y, width, height] = self.believed.scissor;
                self.gl.scissor(x, y, width, height);
                if self.believed.scissor_test {
                    self.gl.enable(api::GL_SCISSOR_TEST);
                } else {
                    self.gl.disable(api::GL_SCISSOR_TEST);
                }
            }
            target.destroy(self.gl);
        }
    }
}

fn profile(gl: &Gl) -> Profile {
    let text = gl.text(api::GL_VERSION);
    let (es, numbers) = match text.strip_prefix("OpenGL ES") {
        Some(rest) => (true, rest.trim_start_matches(|c: char| !c.is_ascii_digit())),
        None => (false, text.as_str()),
    };
    let mut parts = numbers.split(|c: char| !c.is_ascii_digit()).map(|n| n.parse::<u32>().unwrap_or(0));
    let version = parts.next().unwrap_or(0) * 10 + parts.next().unwrap_or(0);
    let (mut mask, mut flags) = (0, 0);
    if !es && version >= 30 {
        // SAFETY: the query exists since OpenGL 3.0 and writes one integer.
        unsafe { gl.get_integerv(api::GL_CONTEXT_FLAGS, &mut flags) };
    }
    let forward = flags as u32 & api::GL_CONTEXT_FLAG_FORWARD_COMPATIBLE_BIT != 0;
    if !es && version >= 32 {
        // SAFETY: the query exists since OpenGL 3.2 and writes one integer.
        unsafe { gl.get_integerv(api::GL_CONTEXT_PROFILE_MASK, &mut mask) };
    }
    Profile { es, core: forward || mask as u32 & api::GL_CONTEXT_CORE_PROFILE_BIT != 0, version }
}
