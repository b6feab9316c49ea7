//! Sizes of X11 windows, through the program's own connection of libxcb.
//!
//! The library is loaded when it is needed; Cupola does not link it. Errors are answers here, and
//! reach neither the program nor its error handler.

use std::ffi::{c_char, c_int, c_void};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// Time that a window manager gets to change a size. The program waits meanwhile.
const PATIENCE: Duration = Duration::from_millis(300);

/// Number of a request.
#[derive(Clone, Copy)]
#[repr(C)]
struct Cookie(u32);

type Connection = *mut c_void;
type Errors = *mut *mut c_void;
type Request1 = unsafe extern "C" fn(Connection, u32) -> Cookie;
type Reply<T> = unsafe extern "C" fn(Connection, Cookie, Errors) -> *mut T;

/// `xcb_get_geometry_reply_t`.
#[repr(C)]
struct Geometry {
    _head: [u32; 2],
    _root: u32,
    _place: [i16; 2],
    width: u16,
    height: u16,
}

/// `xcb_query_tree_reply_t`, without the children.
#[repr(C)]
struct Tree {
    _head: [u32; 2],
    root: u32,
    parent: u32,
}

/// `xcb_intern_atom_reply_t`.
#[repr(C)]
struct Atom {
    _head: [u32; 2],
    atom: u32,
}

/// `xcb_get_property_reply_t`; the value follows.
#[repr(C)]
struct Property {
    _head: [u32; 2],
    kind: u32,
    _after: u32,
    length: u32,
    _pad: [u32; 3],
}

/// Number of 32-bit numbers in the size hints of a window.
const HINTS: usize = 18;

/// `XA_WM_NORMAL_HINTS` and its type `XA_WM_SIZE_HINTS`.
const NORMAL_HINTS: [u32; 2] = [40, 41];

/// Place, width and height in `xcb_configure_window`.
const PLACE_AND_SIZE: u16 = 1 | 2 | 4 | 8;

struct Library {
    get_geometry: Request1,
    geometry: Reply<Geometry>,
    query_tree: Request1,
    tree: Reply<Tree>,
    intern_atom: unsafe extern "C" fn(Connection, u8, u16, *const c_char) -> Cookie,
    atom: Reply<Atom>,
    get_property: unsafe extern "C" fn(Connection, u8, u32, u32, u32, u32, u32) -> Cookie,
    property: Reply<Property>,
    change_property: unsafe extern "C" fn(Connection, u8, u32, u32, u32, u8, u32, *const c_void) -> Cookie,
    configure: unsafe extern "C" fn(Connection, u32, u16, *const u32) -> Cookie,
    check: unsafe extern "C" fn(Connection, Cookie) -> *mut c_void,
    free: unsafe extern "C" fn(*mut c_void),
    /// `XGetXCBConnection`; `None` if the program does not use Xlib with libxcb.
    of_xlib: Option<unsafe extern "C" fn(*mut c_void) -> Connection>,
}

fn library() -> Option<&'static Library> {
    static LIBRARY: OnceLock<Option<Library>> = OnceLock::new();
    LIBRARY
        .get_or_init(|| {
            // SAFETY: the libraries have no initialisers that could misbehave, and the signatures are
            // their own.
            unsafe {
                let xcb = Box::leak(Box::new(libloading::Library::new("libxcb.so.1").ok()?));
                let libc = Box::leak(Box::new(libloading::Library::new("libc.so.6").ok()?));
                let xlib = libloading::Library::new("libX11-xcb.so.1").ok().map(|xlib| Box::leak(Box::new(xlib)));
                Some(Library {
                    get_geometry: *xcb.get(b"xcb_get_geometry\0").ok()?,
                    geometry: *xcb.get(b"xcb_get_geometry_reply\0").ok()?,
                    query_tree: *xcb.get(b"xcb_query_tree\0").ok()?,
                    tree: *xcb.get(b"xcb_query_tree_reply\0").ok()?,
                    intern_atom: *xcb.get(b"xcb_intern_atom\0").ok()?,
                    atom: *xcb.get(b"xcb_intern_atom_reply\0").ok()?,
                    get_property: *xcb.get(b"xcb_get_property\0").ok()?,
                    property: *xcb.get(b"xcb_get_property_reply\0").ok()?,
                    change_property: *xcb.get(b"xcb_change_property_checked\0").ok()?,
                    configure: *xcb.get(b"xcb_configure_window_checked\0").ok()?,
                    check: *xcb.get(b"xcb_request_check\0").ok()?,
                    free: *libc.get(b"free\0").ok()?,
                    of_xlib: xlib.and_then(|xlib| xlib.get(b"XGetXCBConnection\0").ok().map(|function| *function)),
                })
            }
        })
        .as_ref()
}

/// A window and the program's connection to its X server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct XcbWindow {
    /// `xcb_connection_t*`.
    connection: usize,
    window: u32,
}

impl XcbWindow {
    /// Returns a window of a connection.
    pub fn new(connection: *mut c_void, window: u32) -> Option<Self> {
        (!connection.is_null()).then_some(Self { connection: connection as usize, window })
    }

    /// Returns a window of Xlib's.
    ///
    /// # Safety
    /// `display` must be a live `Display*`.
    pub unsafe fn of_xlib(display: *mut c_void, window: u32) -> Option<Self> {
        let connection = library()?.of_xlib?;
        // SAFETY: as promised.
        Self::new(unsafe { connection(display) }, window)
    }

    /// Gives the top-level window around this one a size and puts it into the upper left corner.
    /// Waits until this window has the size. Does nothing if it has it. Returns true if the size was
    /// changed.
    ///
    /// # Safety
    /// The connection must be live.
    pub unsafe fn resize(self, size: (u32, u32)) -> bool {
        let Some(library) = library() else { return false };
        let server = Server { library, connection: self.connection as Connection };
        // SAFETY: as promised.
        unsafe {
            if server.size(self.window).is_none_or(|now| now == size) {
                return false;
            }
            let (top, managed) = server.top(self.window);
            server.permit(top, size);
            server.configure(top, size);
            let begin = Instant::now();
            while managed && server.size(self.window) != Some(size) && begin.elapsed() < PATIENCE {
                std::thread::sleep(Duration::from_millis(5));
            }
        }
        true
    }
}

struct Server {
    library: &'static Library,
    connection: Connection,
}

/// The functions are safe to call while the connection is live.
impl Server {
    /// Waits for a reply, and reads it. `None` if it is an error.
    unsafe fn reply<T, R>(&self, wait: Reply<T>, cookie: Cookie, read: impl FnOnce(*const T) -> R) -> Option<R> {
        let mut error = std::ptr::null_mut();
        // SAFETY: the cookie is of a request with this reply; libxcb allocates reply and error.
        unsafe {
            let reply = wait(self.connection, cookie, &mut error);
            if !error.is_null() {
                (self.library.free)(error);
            }
            if reply.is_null() {
                return None;
            }
            let read = read(reply);
            (self.library.free)(reply.cast());
            Some(read)
        }
    }

    /// Waits until a request is done, with or without an error.
    unsafe fn done(&self, cookie: Cookie) {
        // SAFETY: the cookie is of a checked request.
        unsafe {
            let error = (self.library.check)(self.connection, cookie);
            if !error.is_null() {
                (self.library.free)(error);
            }
        }
    }

    unsafe fn size(&self, window: u32) -> Option<(u32, u32)> {
        // SAFETY: the connection is live.
        unsafe {
            let cookie = (self.library.get_geometry)(self.connection, window);
            self.reply(self.library.geometry, cookie, |geometry| ((*geometry).width.into(), (*geometry).height.into()))
        }
    }

    unsafe fn atom(&self, name: &std::ffi::CStr) -> u32 {
        // SAFETY: the connection is live.
        unsafe {
            let (length, any) = (name.count_bytes() as u16, 1);
            let cookie = (self.library.intern_atom)(self.connection, any, length, name.as_ptr());
            self.reply(self.library.atom, cookie, |atom| (*atom).atom).unwrap_or(0)
        }
    }

    /// Returns the window that determines the size, and whether a window manager knows it. It is
    /// the one with the property `WM_STATE`, or the outermost one below the root.
    unsafe fn top(&self, window: u32) -> (u32, bool) {
        let mut top = window;
        // SAFETY: the connection is live.
        unsafe {
            let state = self.atom(c"WM_STATE");
            for _ in 0..16 {
                let cookie = (self.library.get_property)(self.connection, 0, top, state, 0, 0, 0);
                let is_known = self.reply(self.library.property, cookie, |property| (*property).kind != 0);
                if state != 0 && is_known == Some(true) {
                    return (top, true);
                }
                let cookie = (self.library.query_tree)(self.connection, top);
                let tree = self.reply(self.library.tree, cookie, |tree| ((*tree).root, (*tree).parent));
                match tree {
                    Some((root, parent)) if parent != root && parent != 0 => top = parent,
                    _ => break,
                }
            }
        }
        (top, false)
    }

    /// Changes the size hints of a window so that they permit a size. A window manager would keep a
    /// window that has one size at that size.
    unsafe fn permit(&self, window: u32, size: (u32, u32)) {
        let [property, kind] = NORMAL_HINTS;
        // SAFETY: the connection is live; all numbers of the value are there if the length says so.
        unsafe {
            let cookie = (self.library.get_property)(self.connection, 0, window, property, kind, 0, HINTS as u32);
            let read = |found: *const Property| {
                let is_whole = (*found).length as usize >= HINTS;
                is_whole.then(|| found.add(1).cast::<[i32; HINTS]>().read_unaligned())
            };
            let Some(Some(mut hints)) = self.reply(self.library.property, cookie, read) else { return };
            if permit(&mut hints, size) {
                let (replace, bits) = (0, 32);
                let value = hints.as_ptr().cast();
                let count = HINTS as u32;
                let cookie = (self.library.change_property)(
                    self.connection,
                    replace,
                    window,
                    property,
                    kind,
                    bits,
                    count,
                    value,
                );
                self.done(cookie);
            }
        }
    }

    unsafe fn configure(&self, window: u32, (width, height): (u32, u32)) {
        // SAFETY: the connection is live.
        unsafe {
            let values = [0, 0, width, height];
            self.done((self.library.configure)(self.connection, window, PLACE_AND_SIZE, values.as_ptr()));
        }
    }
}

/// Permits a size in size hints. Returns true if it was not permitted.
fn permit(hints: &mut [i32; HINTS], size: (u32, u32)) -> bool {
    // `PMinSize`, `PMaxSize`, `PResizeInc`, `PAspect` of Xlib.
    const LEAST: i32 = 1 << 4;
    const MOST: i32 = 1 << 5;
    const INCREMENT: i32 = 1 << 6;
    const ASPECT: i32 = 1 << 7;
    let before = *hints;
    hints[0] &= !(INCREMENT | ASPECT);
    for (axis, side) in [size.0, size.1].into_iter().enumerate() {
        let side = side as c_int;
        if hints[0] & LEAST != 0 {
            hints[5 + axis] = hints[5 + axis].min(side);
        }
        if hints[0] & MOST != 0 {
            hints[7 + axis] = hints[7 + axis].max(side);
        }
    }
    *hints != before
}

#[cfg(test)]
mod tests {
    use super::{HINTS, permit};

    #[test]
    fn hints_permit_the_size_afterwards() {
        let mut hints = [0; HINTS];
        assert!(!permit(&mut hints, (300, 200)), "a window of any size");
        (hints[0], hints[5], hints[6], hints[7], hints[8]) = (1 << 4 | 1 << 5 | 1 << 7, 96, 400, 96, 400);
        assert!(permit(&mut hints, (300, 200)));
        assert_eq!((hints[0], &hints[5..9]), (1 << 4 | 1 << 5, &[96, 200, 300, 400][..]));
        assert!(!permit(&mut hints, (300, 200)));
    }
}
