//! GLX for commands: names of the driver that programs get on the current display, read from a small
//! off-screen context, and a [`window`] in which a driver shows finished pictures.

pub mod window;

use crate::backend::gl::driver::api::{GL_RENDERER, GL_VENDOR, GL_VERSION, Gl};
use crate::error::{Error, ErrorKind, Result};
use libloading::Library;
use std::ffi::{CStr, CString, c_char, c_int, c_ulong, c_void};
use std::ptr::{null, null_mut};

const GLX_DRAWABLE_TYPE: c_int = 0x8010;
const GLX_PBUFFER_BIT: c_int = 4;
const GLX_RGBA_TYPE: c_int = 0x8014;
const GLX_PBUFFER_HEIGHT: c_int = 0x8040;
const GLX_PBUFFER_WIDTH: c_int = 0x8041;

type Handle = *mut c_void;

/// Names that a driver reports.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Driver {
    /// `GL_VENDOR`.
    pub vendor: String,
    /// `GL_RENDERER`.
    pub renderer: String,
    /// `GL_VERSION`.
    pub version: String,
    /// True if the driver draws in this process. Otherwise the X server draws, and Cupola cannot
    /// intercept anything.
    pub direct: bool,
    /// Extensions of GLX, with a space between them.
    pub extensions: String,
}

/// Functions of Xlib and GLX that are needed.
struct Glx {
    open_display: unsafe extern "C" fn(*const c_char) -> Handle,
    close_display: unsafe extern "C" fn(Handle) -> c_int,
    default_screen: unsafe extern "C" fn(Handle) -> c_int,
    free: unsafe extern "C" fn(Handle) -> c_int,
    get_proc_address: unsafe extern "C" fn(*const c_char) -> *const c_void,
    choose_config: unsafe extern "C" fn(Handle, c_int, *const c_int, *mut c_int) -> *mut Handle,
    create_pbuffer: unsafe extern "C" fn(Handle, Handle, *const c_int) -> c_ulong,
    destroy_pbuffer: unsafe extern "C" fn(Handle, c_ulong),
    create_context: unsafe extern "C" fn(Handle, Handle, c_int, Handle, c_int) -> Handle,
    destroy_context: unsafe extern "C" fn(Handle, Handle),
    make_current: unsafe extern "C" fn(Handle, c_ulong, c_ulong, Handle) -> c_int,
    config_value: unsafe extern "C" fn(Handle, Handle, c_int, *mut c_int) -> c_int,
    swap_buffers: unsafe extern "C" fn(Handle, c_ulong),
    is_direct: unsafe extern "C" fn(Handle, Handle) -> c_int,
    query_extensions: unsafe extern "C" fn(Handle, c_int) -> *const c_char,
    // Keep the functions above valid. This is the last field, since fields are dropped in order.
    _libraries: [Library; 2],
}

impl Glx {
    fn load() -> Result<Self> {
        let load = |name: &str| {
            // SAFETY: the initialisers of both libraries are those that every GLX program runs.
            unsafe { Library::new(name) }.map_err(|error| graphics(format!("{name} cannot be loaded ({error})")))
        };
        let (x11, gl) = (load("libX11.so.6")?, load("libGL.so.1")?);
        macro_rules! function {
            ($library:ident, $name:literal) => {
                // SAFETY: the field's type is the function's type in its specification.
                *unsafe { $library.get($name) }
                    .map_err(|error| graphics(format!("a library is incomplete: {error}")))?
            };
        }
        Ok(Self {
            open_display: function!(x11, b"XOpenDisplay\0"),
            close_display: function!(x11, b"XCloseDisplay\0"),
            default_screen: function!(x11, b"XDefaultScreen\0"),
            free: function!(x11, b"XFree\0"),
            get_proc_address: function!(gl, b"glXGetProcAddressARB\0"),
            choose_config: function!(gl, b"glXChooseFBConfig\0"),
            create_pbuffer: function!(gl, b"glXCreatePbuffer\0"),
            destroy_pbuffer: function!(gl, b"glXDestroyPbuffer\0"),
            create_context: function!(gl, b"glXCreateNewContext\0"),
            destroy_context: function!(gl, b"glXDestroyContext\0"),
            make_current: function!(gl, b"glXMakeContextCurrent\0"),
            config_value: function!(gl, b"glXGetFBConfigAttrib\0"),
            swap_buffers: function!(gl, b"glXSwapBuffers\0"),
            is_direct: function!(gl, b"glXIsDirect\0"),
            query_extensions: function!(gl, b"glXQueryExtensionsString\0"),
            _libraries: [x11, gl],
        })
    }
}

/// Reads the names of the driver of the display that `DISPLAY` names. Call it in a separate
/// process: Xlib ends the process on a protocol error, and the libraries stay loaded until the
/// process ends.
///
/// # Errors
/// [`ErrorKind::Graphics`] if there is no Xlib, no GLX, no such display, or no context; the message
/// says which.
pub fn driver() -> Result<Driver> {
    let (glx, display) = connect(None)?;
    let driver = on_display(glx, display);
    // SAFETY: the display is open, and nothing of it is used from here on.
    unsafe { (glx.close_display)(display) };
    driver
}

/// Loads GLX and connects to a display; `None`: that of `DISPLAY`.
fn connect(name: Option<&str>) -> Result<(&'static Glx, Handle)> {
    // Never dropped: drivers leave handlers behind in Xlib that must stay loaded.
    let glx = Box::leak(Box::new(Glx::load()?));
    let given = name.map(CString::new).transpose().map_err(|_| graphics("the display's name contains a zero"))?;
    // SAFETY: null names the display of DISPLAY; a name ends with a zero.
    let display = unsafe { (glx.open_display)(given.as_ref().map_or(null(), |name| name.as_ptr())) };
    if display.is_null() {
        let name = name.map(str::to_owned).or_else(|| std::env::var("DISPLAY").ok()).unwrap_or_default();
        return Err(graphics(match name.as_str() {
            "" => "there is no X display (DISPLAY is not set)".to_owned(),
            name => format!("the X display {name} cannot be opened"),
        }));
    }
    Ok((glx, display))
}

fn on_display(glx: &Glx, display: Handle) -> Result<Driver> {
    let wanted = [GLX_DRAWABLE_TYPE, GLX_PBUFFER_BIT, 0];
    let mut count = 0;
    // SAFETY: the display is open, the list ends with 0, `count` is written.
    let configs = unsafe { (glx.choose_config)(display, (glx.default_screen)(display), wanted.as_ptr(), &mut count) };
    if configs.is_null() || count < 1 {
        return Err(graphics("the X display has no GLX, or no off-screen drawing"));
    }
    // SAFETY: there is at least one entry; the list is Xlib's to free.
    let config = unsafe {
        let config = *configs;
        (glx.free)(configs.cast());
        config
    };
    let size = [GLX_PBUFFER_WIDTH, 16, GLX_PBUFFER_HEIGHT, 16, 0];
    // SAFETY: the configuration is the display's and can draw off screen; the list ends with 0.
    let (context, pbuffer) = unsafe {
        let context = (glx.create_context)(display, config, GLX_RGBA_TYPE, null_mut(), 1);
        (context, (glx.create_pbuffer)(display, config, size.as_ptr()))
    };
    // SAFETY: all three are the display's; GLX refuses a null context and answers 0.
    let current = !context.is_null() && unsafe { (glx.make_current)(display, pbuffer, pbuffer, context) } != 0;
    let driver = if current {
        // SAFETY: the name ends with a zero.
        let gl = Gl::load(|name| unsafe { (glx.get_proc_address)(name.as_ptr()) });
        // SAFETY: display and context are valid.
        let direct = unsafe { (glx.is_direct)(display, context) } != 0;
        // SAFETY: the display is open and has this screen; the text is the driver's, and ends with
        // a zero.
        let extensions = unsafe {
            let text = (glx.query_extensions)(display, (glx.default_screen)(display));
            if text.is_null() { String::new() } else { CStr::from_ptr(text).to_string_lossy().into_owned() }
        };
        let (vendor, renderer, version) = (gl.text(GL_VENDOR), gl.text(GL_RENDERER), gl.text(GL_VERSION));
        Ok(Driver { vendor, renderer, version, direct, extensions })
    } else {
        Err(graphics("GLX cannot make a usable context"))
    };
    // SAFETY: each object is destroyed once, after it is no longer current.
    unsafe {
        (glx.make_current)(display, 0, 0, null_mut());
        (glx.destroy_pbuffer)(display, pbuffer);
        if !context.is_null() {
            (glx.destroy_context)(display, context);
        }
    }
    driver
}

fn graphics(message: impl Into<String>) -> Error {
    Error::new(ErrorKind::Graphics, message)
}
