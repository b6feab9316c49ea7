//! The program's window: its size and its visibility.

use crate::backend::gl::driver::api::{self, Gl};
use crate::intercept::gl::state::driver::profile::Profile;
use std::ffi::{c_char, c_int, c_long, c_uint, c_ulong, c_void};
use std::sync::OnceLock;

/// `glXQueryDrawable`.
pub type QueryDrawable = unsafe extern "system" fn(*mut c_void, c_ulong, c_int, *mut c_uint);

/// `eglQuerySurface`.
pub type QuerySurface = unsafe extern "system" fn(*mut c_void, *mut c_void, i32, *mut i32) -> c_uint;

/// A window of the program, as its window system knows it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Window {
    /// Through GLX.
    Glx {
        /// `Display*`.
        display: usize,
        /// `GLXDrawable`.
        drawable: c_ulong,
        /// X11 window: the drawable itself, or the window for which it was made.
        x11: c_ulong,
        /// The driver's `glXQueryDrawable`.
        query: usize,
    },
    /// Through EGL.
    Egl {
        /// `EGLDisplay`.
        display: usize,
        /// `EGLSurface`.
        surface: usize,
        /// X11 display and X11 window of the surface, if the platform is X11.
        x11: Option<(usize, c_ulong)>,
        /// The driver's `eglQuerySurface`.
        query: usize,
    },
}

/// Size and visibility of a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Look {
    /// Size in pixels, at least 1 × 1.
    pub size: (u32, u32),
    /// True if the window is not visible: the window or one of its parents is not mapped. Known for
    /// X11 windows only.
    pub occluded: bool,
}

const GLX_WIDTH: c_int = 0x801D;
const GLX_HEIGHT: c_int = 0x801E;
const EGL_HEIGHT: i32 = 0x3056;
const EGL_WIDTH: i32 = 0x3057;

impl Window {
    /// Returns the window system's handle of the window.
    pub fn handle(&self) -> usize {
        match *self {
            Self::Glx { drawable, .. } => drawable as usize,
            Self::Egl { surface, .. } => surface,
        }
    }

    /// Returns the present size and visibility of the window. On X11 this is one question to the X
    /// server. GLX and EGL would ask two questions for the size alone.
    pub fn look(&self) -> Look {
        let x11 = match *self {
            Self::Glx { display, x11, .. } => x11_attributes(display, x11),
            Self::Egl { x11: Some((display, window)), .. } => x11_attributes(display, window),
            Self::Egl { .. } => None,
        };
        let (width, height) = match &x11 {
            Some(x11) => (x11.width.max(0) as u32, x11.height.max(0) as u32),
            None => self.asked_size(),
        };
        let size = (width.clamp(1, 16384), height.clamp(1, 16384));
        Look { size, occluded: x11.is_some_and(|x11| x11.map_state != IS_VIEWABLE) }
    }

    /// Returns the size in pixels, at least 1 × 1.
    pub fn size(&self) -> (u32, u32) {
        self.look().size
    }

    /// Returns the size according to GLX or EGL.
    fn asked_size(&self) -> (u32, u32) {
        match *self {
            Self::Glx { display, drawable, query, .. } => {
                let (mut width, mut height) = (0, 0);
                // SAFETY: the address is the driver's glXQueryDrawable; display and drawable are
                // those that the program made current.
                unsafe {
                    let query: QueryDrawable = std::mem::transmute(query);
                    query(display as *mut c_void, drawable, GLX_WIDTH, &mut width);
                    query(display as *mut c_void, drawable, GLX_HEIGHT, &mut height);
                }
                (width, height)
            }
            Self::Egl { display, surface, query, .. } => {
                let (mut width, mut height) = (0, 0);
                // SAFETY: as above, for eglQuerySurface.
                unsafe {
                    let query: QuerySurface = std::mem::transmute(query);
                    query(display as *mut c_void, surface as *mut c_void, EGL_WIDTH, &mut width);
                    query(display as *mut c_void, surface as *mut c_void, EGL_HEIGHT, &mut height);
                }
                (width.max(0) as u32, height.max(0) as u32)
            }
        }
    }

    /// True if the window has a back buffer. Its own framebuffer must be bound for drawing.
    pub fn double_buffered(&self, gl: &Gl, profile: &Profile) -> bool {
        if profile.es {
            return true;
        }
        let mut double = 1;
        // SAFETY: writes one integer about the framebuffer that is bound.
        unsafe { gl.get_integerv(api::GL_DOUBLEBUFFER, &mut double) };
        double != 0
    }

    /// Gives the top-level X11 window this size. Does nothing on other platforms.
    pub fn resize(&self, size: (u32, u32)) {
        let (display, window) = match *self {
            Self::Glx { display, x11, .. } => (display, x11),
            Self::Egl { x11: Some((display, window)), .. } => (display, window),
            Self::Egl { .. } => return,
        };
        if display != 0
            && let Some(x11) = x11()
            && self.size() != size
        {
            x11.resize(display as *mut c_void, window, size);
        }
    }
}

/// Xlib's `XWindowAttributes`.
#[repr(C)]
struct Attributes {
    /// x, y.
    _place: [c_int; 2],
    width: c_int,
    height: c_int,
    /// Border width, depth.
    _border: [c_int; 2],
    _visual: *mut c_void,
    _root: c_ulong,
    /// Class, bit gravity, window gravity, backing store.
    _kinds: [c_int; 4],
    /// Backing planes, backing pixel.
    _backing: [c_ulong; 2],
    _save_under: c_int,
    _colormap: c_ulong,
    _map_installed: c_int,
    map_state: c_int,
    /// All event masks, yours, not propagated.
    _masks: [c_long; 3],
    _override_redirect: c_int,
    _screen: *mut c_void,
}

/// `IsViewable` of X11: the window and all its parents are mapped.
const IS_VIEWABLE: c_int = 2;

/// Returns the attributes of an X11 window; `None` if Xlib is missing or the server does not
/// answer.
fn x11_attributes(display: usize, window: c_ulong) -> Option<Attributes> {
    if display == 0 || window == 0 {
        return None;
    }
    let get = x11()?.get_window_attributes;
    let mut attributes = std::mem::MaybeUninit::<Attributes>::zeroed();
    // SAFETY: display and window are live objects of the program; there is room for the answer, and
    // zeros are valid in it, too.
    unsafe {
        let ok = get(display as *mut c_void, window, attributes.as_mut_ptr());
        (ok != 0).then(|| attributes.assume_init())
    }
}

/// The functions of Xlib that examine and resize a window. The program has loaded Xlib; Cupola does
/// not link it.
struct X11 {
    query_tree:
        unsafe extern "C" fn(*mut c_void, c_ulong, *mut c_ulong, *mut c_ulong, *mut *mut c_ulong, *mut c_uint) -> c_int,
    get_window_attributes: unsafe extern "C" fn(*mut c_void, c_ulong, *mut Attributes) -> c_int,
    move_resize: unsafe extern "C" fn(*mut c_void, c_ulong, c_int, c_int, c_uint, c_uint) -> c_int,
    sync: unsafe extern "C" fn(*mut c_void, c_int) -> c_int,
    free: unsafe extern "C" fn(*mut c_void) -> c_int,
    intern_atom: unsafe extern "C" fn(*mut c_void, *const c_char, c_int) -> c_ulong,
    list_properties: unsafe extern "C" fn(*mut c_void, c_ulong, *mut c_int) -> *mut c_ulong,
    get_hints: unsafe extern "C" fn(*mut c_void, c_ulong, *mut SizeHints, *mut c_long) -> c_int,
    set_hints: unsafe extern "C" fn(*mut c_void, c_ulong, *mut SizeHints),
}

/// Xlib's `XSizeHints`: the sizes that a window manager permits.
#[repr(C)]
#[derive(Default)]
struct SizeHints {
    flags: c_long,
    /// x, y, width, height.
    _place: [c_int; 4],
    least: [c_int; 2],
    most: [c_int; 2],
    _increment: [c_int; 2],
    /// Aspects and base size.
    _others: [c_int; 6],
    _gravity: c_int,
}

impl SizeHints {
    /// `PMinSize`, `PMaxSize`, `PResizeInc`, `PAspect` of Xlib.
    const LEAST: c_long = 1 << 4;
    const MOST: c_long = 1 << 5;
    const INCREMENT: c_long = 1 << 6;
    const ASPECT: c_long = 1 << 7;

    /// Permits a size. Returns true if it was not permitted.
    fn permit(&mut self, size: [c_int; 2]) -> bool {
        let before = self.flags;
        self.flags &= !(Self::INCREMENT | Self::ASPECT);
        let mut is_new = self.flags != before;
        for (axis, side) in size.into_iter().enumerate() {
            if self.flags & Self::LEAST != 0 && self.least[axis] > side {
                (self.least[axis], is_new) = (side, true);
            }
            if self.flags & Self::MOST != 0 && self.most[axis] < side {
                (self.most[axis], is_new) = (side, true);
            }
        }
        is_new
    }
}

fn x11() -> Option<&'static X11> {
    static LIBRARY: OnceLock<Option<X11>> = OnceLock::new();
    LIBRARY
        .get_or_init(|| {
            // SAFETY: Xlib has no initialisers that could misbehave, and the signatures are its
            // own.
            unsafe {
                let library = Box::leak(Box::new(libloading::Library::new("libX11.so.6").ok()?));
                Some(X11 {
                    query_tree: *library.get(b"XQueryTree\0").ok()?,
                    get_window_attributes: *library.get(b"XGetWindowAttributes\0").ok()?,
                    move_resize: *library.get(b"XMoveResizeWindow\0").ok()?,
                    sync: *library.get(b"XSync\0").ok()?,
                    free: *library.get(b"XFree\0").ok()?,
                    intern_atom: *library.get(b"XInternAtom\0").ok()?,
                    list_properties: *library.get(b"XListProperties\0").ok()?,
                    get_hints: *library.get(b"XGetWMNormalHints\0").ok()?,
                    set_hints: *library.get(b"XSetWMNormalHints\0").ok()?,
                })
            }
        })
        .as_ref()
}

impl X11 {
    fn resize(&self, display: *mut c_void, window: c_ulong, size: (u32, u32)) {
        let top = self.top(display, window);
        let (width, height) = (size.0 as c_int, size.1 as c_int);
        let (mut hints, mut supplied) = (SizeHints::default(), 0);
        // SAFETY: display and window are live objects of the program, and there is room for the
        // answers.
        unsafe {
            // A window manager would keep a window that has one size at that size.
            if (self.get_hints)(display, top, &mut hints, &mut supplied) != 0 && hints.permit([width, height]) {
                (self.set_hints)(display, top, &mut hints);
            }
            (self.move_resize)(display, top, 0, 0, size.0, size.1);
            (self.sync)(display, 0);
        }
    }

    /// Returns the window that determines the size: toolkits put the OpenGL window into other
    /// windows. It is the one that the window manager knows (it has the property `WM_STATE`), or the
    /// outermost one below the root.
    fn top(&self, display: *mut c_void, window: c_ulong) -> c_ulong {
        let mut top = window;
        // SAFETY: display and window are live objects of the program; the lists are freed.
        unsafe {
            let state = (self.intern_atom)(display, c"WM_STATE".as_ptr(), 0);
            for _ in 0..16 {
                let mut count = 0;
                let properties = (self.list_properties)(display, top, &mut count);
                if !properties.is_null() {
                    let list = std::slice::from_raw_parts(properties, usize::try_from(count).unwrap_or(0));
                    let is_known = list.contains(&state);
                    (self.free)(properties.cast());
                    if is_known {
                        break;
                    }
                }
                let (mut root, mut parent, mut children, mut count) = (0, 0, std::ptr::null_mut(), 0);
                if (self.query_tree)(display, top, &mut root, &mut parent, &mut children, &mut count) == 0 {
                    break;
                }
                if !children.is_null() {
                    (self.free)(children.cast());
                }
                if parent == root || parent == 0 {
                    break;
                }
                top = parent;
            }
        }
        top
    }
}
