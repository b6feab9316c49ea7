//! What a program believes about one of its contexts, and which context is current.

use super::background::Background;
use super::culling::widths::Widest;
use super::default_framebuffer::DefaultFramebuffer;
use super::lists::{Lists, Recording};
use super::matrices::Projection;
use super::programs::{Program, Programs};
use super::raster::Raster;
use super::window::Window;
use crate::backend::gl::api::{self, Gl};
use crate::intercept::camera::Cameras;
use crate::intercept::log;
use crate::runtime::session::Extras;
use std::cell::Cell;
use std::collections::{HashMap, HashSet};
use std::ffi::CStr;
use std::sync::atomic::{AtomicPtr, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

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
#[derive(Default)]
pub struct ShareGroup {
    /// Shaders and programs.
    pub programs: Mutex<Programs>,
    /// Display lists.
    pub lists: Mutex<Lists>,
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

/// Counts for `--stats`.
#[derive(Clone, Debug, Default)]
pub struct Counts {
    /// Presented frames.
    pub frames: u64,
    /// Draws of the program to its window.
    pub draws_seen: u64,
    /// Draws issued to each view.
    pub draws_issued: Vec<u64>,
    /// Flat draws issued to the panel.
    pub panel_draws: u64,
    /// Draws issued to the primary picture.
    pub primary_draws: u64,
    /// Programs of shaders that were linked for us.
    pub linked: u64,
    /// OpenGL errors of ours.
    pub errors: u64,
    /// Draws by the way their projection was found.
    pub found: Found,
}

/// How often each way of finding a projection was taken. Counting allocates nothing.
#[derive(Clone, Debug, Default)]
pub struct Found([(&'static str, u64); 8]);

impl Found {
    /// Counts one draw whose projection was found in this way; more than eight ways are not told apart.
    pub fn count(&mut self, how: &'static str) {
        if let Some(entry) = self.0.iter_mut().find(|e| e.1 == 0 || e.0 == how) {
            *entry = (how, entry.1 + 1);
        }
    }

    /// The ways that were taken, with their numbers of draws.
    pub fn iter(&self) -> impl Iterator<Item = (&'static str, u64)> + '_ {
        self.0.iter().copied().filter(|e| e.1 > 0)
    }
}

/// One context of the program.
pub struct Context {
    /// The driver.
    pub gl: &'static Gl,
    /// Which OpenGL.
    pub profile: Profile,
    /// A defect switched this context off: every call goes straight to the driver.
    pub switched_off: bool,
    /// The window that it draws to.
    pub window: Option<Window>,
    /// What stands in for the window's framebuffer; `None` = the window's own.
    pub target: Option<Box<DefaultFramebuffer>>,
    /// What stands in for other windows that it drew to lately.
    pub parked: Vec<(Window, Box<DefaultFramebuffer>)>,
    /// What the program believes.
    pub believed: Believed,
    /// `glPushAttrib`: the mask, what was believed, and `glListBase`.
    pub attribute_stack: Vec<(u32, Believed, u32)>,
    /// What the driver has.
    pub actual: Actual,
    /// The fixed-function projection.
    pub projection: Projection,
    /// Flat drawing behind the scene.
    pub background: Background,
    /// The cameras of the frame.
    pub cameras: Cameras,
    /// Scenes that are drawn off screen.
    pub duplicates: super::duplicate::Duplicates,
    /// The program object that draws: the one in use, or a pipeline's.
    pub program: Option<Arc<Program>>,
    /// Program pipelines, and which program is in use.
    pub pipelines: super::pipelines::Pipelines,
    /// The Begin/End that the program is in.
    pub immediate: super::immediate::Immediate,
    /// The greatest width of points and lines so far.
    pub widest: Widest,
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
    pub condition: super::conditional::Condition,
    /// Transform feedback is recording.
    pub feedback: bool,
    /// `GL_RASTERIZER_DISCARD`.
    pub discard: bool,
    /// How often flushes of the front buffer are answered.
    pub pace: super::front::Pace,
    /// Objects shared with other contexts.
    pub share: Arc<ShareGroup>,
    /// Counts for `--stats`.
    pub counts: Counts,
    /// Something was drawn since the last swap.
    pub frame_begun: bool,
    /// The lens of the last draw of the scene.
    pub lens: Option<crate::runtime::session::Intrinsics>,
    /// Largest viewport (area) that a scene was drawn to: in this frame, and in the last one.
    pub viewport_area: [i64; 2],
}

/// Windows that a context has left keep what stands in for them, but not more than these.
const MOST_PARKED: usize = 4;

thread_local! {
    static CURRENT: Cell<*mut Context> = const { Cell::new(std::ptr::null_mut()) };
    /// The window system's handle of the current context.
    static HANDLE: Cell<usize> = const { Cell::new(0) };
}

static DRIVER: AtomicPtr<Gl> = AtomicPtr::new(std::ptr::null_mut());

static CONTEXTS: Mutex<Option<Contexts>> = Mutex::new(None);

/// All contexts of the process.
#[derive(Default)]
struct Contexts {
    /// By their window system's handle.
    known: HashMap<usize, Entry>,
    /// Addresses of contexts that the program destroyed while a thread had them current: they live until it
    /// has another.
    dying: Vec<usize>,
}

struct Entry {
    share: Arc<ShareGroup>,
    // The address of a leaked Context; 0 = not current yet. Freed when the program destroys it.
    context: usize,
    /// A thread has it current.
    current: bool,
}

impl Contexts {
    /// The thread that had a context current has it no longer.
    fn release(&mut self, handle: usize, address: usize) {
        if let Some(index) = self.dying.iter().position(|dying| *dying == address) {
            self.dying.swap_remove(index);
            free(address);
        } else if let Some(entry) = self.known.get_mut(&handle).filter(|e| e.context == address) {
            entry.current = false;
        }
    }

    /// The program destroyed a context, or its handle came back without that.
    fn forget(&mut self, entry: Entry) {
        if entry.current {
            self.dying.push(entry.context);
        } else if entry.context != 0 {
            free(entry.context);
        }
    }
}

/// Frees a context that is current nowhere; its OpenGL objects went with it.
fn free(address: usize) {
    // SAFETY: the address came from Box::into_raw, and was just taken out of the only table that holds it;
    // no thread has the context current, so that no reference to it is left.
    drop(unsafe { Box::from_raw(address as *mut Context) });
}

fn contexts<R>(use_them: impl FnOnce(&mut Contexts) -> R) -> R {
    use_them(CONTEXTS.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert_with(Contexts::default))
}

/// The context that is current on this thread.
pub fn current() -> Option<&'static mut Context> {
    let pointer = CURRENT.get();
    // SAFETY: set only by `make_current` to a live, leaked Context; OpenGL lets a context be
    // current on one thread at a time, so the reference is unique while a hook runs.
    unsafe { pointer.as_mut() }
}

/// The driver's table for calls without a context of ours.
pub fn driver() -> &'static Gl {
    // SAFETY: set once, from a leaked table, before libglvnd can dispatch any GL call to us.
    unsafe { DRIVER.load(Ordering::Acquire).as_ref() }.expect("a vendor was loaded before any call")
}

/// Sets the table for calls without a context of ours.
pub fn set_driver(gl: &'static Gl) {
    DRIVER.store(std::ptr::from_ref(gl).cast_mut(), Ordering::Release);
}

/// A hook panicked: its context passes everything through from now on.
pub fn after_panic(name: &str) {
    log::once(&format!("a defect in {name}; this context is left alone from now on"));
    if let Some(ctx) = current() {
        ctx.switched_off = true;
        ctx.leave_alone();
    }
}

/// Notes that `handle` was created, sharing objects with `shared` (0 = with none).
pub fn created(handle: usize, shared: usize) {
    contexts(|contexts| {
        let share = contexts.known.get(&shared).map(|e| e.share.clone()).unwrap_or_default();
        if let Some(old) = contexts.known.insert(handle, Entry { share, context: 0, current: false }) {
            contexts.forget(old);
        }
    });
}

/// The program is about to make another context or window current: what it drew is shown to the window that it
/// leaves, whose buffers it may swap when another is current.
pub fn leaving(handle: usize, window: Option<&Window>) {
    let Some(ctx) = current().filter(|c| !c.switched_off && c.frame_begun) else { return };
    if HANDLE.get() == handle && ctx.window.as_ref() == window {
        return;
    }
    if crate::fence::guard(|| super::present::leave(ctx)).is_none() {
        after_panic("leaving a window");
    }
}

/// The context `handle` was made current with `window` (`None`: no window of the program's).
pub fn make_current(handle: usize, gl: &'static Gl, window: Option<Window>) {
    let left = CURRENT.replace(std::ptr::null_mut());
    let left_handle = HANDLE.replace(handle);
    let pointer = contexts(|contexts| {
        if !left.is_null() {
            contexts.release(left_handle, left as usize);
        }
        if handle == 0 {
            return std::ptr::null_mut();
        }
        let new = || Entry { share: Arc::default(), context: 0, current: false };
        let entry = contexts.known.entry(handle).or_insert_with(new);
        if entry.context == 0 {
            entry.context = Box::into_raw(Box::new(Context::new(gl, entry.share.clone()))) as usize;
        }
        entry.current = true;
        entry.context as *mut Context
    });
    CURRENT.set(pointer);
    if let Some(ctx) = current()
        && !ctx.switched_off
        && crate::fence::guard(|| ctx.attach(window)).is_none()
    {
        after_panic("make current");
    }
}

impl Context {
    fn new(gl: &'static Gl, share: Arc<ShareGroup>) -> Self {
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
        Self {
            gl,
            profile: profile(gl),
            switched_off: false,
            window: None,
            target: None,
            parked: Vec::new(),
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
            widest: Widest::default(),
            assembly: false,
            picking: false,
            raster: Raster::default(),
            recording: None,
            list_base: 0,
            pending_error: 0,
            block_buffers: HashSet::new(),
            buffer_generation: 0,
            condition: None,
            feedback: false,
            discard: false,
            pace: Default::default(),
            share,
            counts: Counts::default(),
            frame_begun: false,
            lens: None,
            viewport_area: [0; 2],
        }
    }

    /// The program's draws go to its window, which is ours.
    pub fn redirected(&self) -> bool {
        self.target.is_some() && self.believed.draw_framebuffer == 0
    }

    /// The program's reads come from its window, which is ours.
    pub fn reads_redirected(&self) -> bool {
        self.target.is_some() && self.believed.read_framebuffer == 0
    }

    /// A display list is being compiled: commands are not executed now.
    pub fn compiling(&self) -> bool {
        self.recording.is_some()
    }

    fn attach(&mut self, window: Option<Window>) {
        let first = self.window.is_none() && window.is_some() && self.believed.viewport == [0; 4];
        if self.window != window {
            self.change_window(window);
        }
        let Some(window) = self.window.clone() else { return };
        if let Some(size) = crate::intercept::settings::settings().and_then(|s| s.window_size) {
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
            super::default_framebuffer::attach(self, Extras::default());
        }
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
        if let Some(index) = self.parked.iter().position(|(parked, _)| Some(parked) == self.window.as_ref()) {
            let (window, target) = self.parked.remove(index);
            super::default_framebuffer::resume(self, &window, target);
            super::present::follow_size(self);
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

/// The program destroyed `handle`. A context that is current on any thread lives on until it is not.
pub fn destroyed(handle: usize) {
    contexts(|contexts| {
        if let Some(entry) = contexts.known.remove(&handle) {
            contexts.forget(entry);
        }
    });
}

fn profile(gl: &Gl) -> Profile {
    // SAFETY: the context is current; the string is the driver's and lives as long as it.
    let text = unsafe {
        let version = gl.get_string(api::GL_VERSION);
        if version.is_null() { "" } else { CStr::from_ptr(version.cast()).to_str().unwrap_or_default() }
    };
    let (es, numbers) = match text.strip_prefix("OpenGL ES") {
        Some(rest) => (true, rest.trim_start_matches(|c: char| !c.is_ascii_digit())),
        None => (false, text),
    };
    let mut parts = numbers.split(|c: char| !c.is_ascii_digit()).map(|n| n.parse::<u32>().unwrap_or(0));
    let version = parts.next().unwrap_or(0) * 10 + parts.next().unwrap_or(0);
    let mut mask = 0;
    if !es && version >= 32 {
        // SAFETY: the query exists since OpenGL 3.2 and writes one integer.
        unsafe { gl.get_integerv(api::GL_CONTEXT_PROFILE_MASK, &mut mask) };
    }
    Profile { es, core: mask as u32 & api::GL_CONTEXT_CORE_PROFILE_BIT != 0, version }
}
