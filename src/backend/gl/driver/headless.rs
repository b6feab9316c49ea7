//! A context without a window: EGL without a surface.

use crate::backend::gl::driver::api::Gl;
use crate::error::{Error, ErrorKind, Result};
use libloading::Library;
use std::ffi::{CStr, c_char, c_void};
use std::mem::ManuallyDrop;
use std::ptr::null_mut;

/// Kind of a context.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Api {
    /// OpenGL, core profile, 3.3 or later.
    Core,
    /// OpenGL, compatibility profile, in the version that the driver offers.
    Compatibility,
    /// OpenGL ES, 3.0 or later.
    Es3,
}

const EGL_PLATFORM_SURFACELESS_MESA: u32 = 0x31DD;
const EGL_PLATFORM_DEVICE_EXT: u32 = 0x313F;
const EGL_OPENGL_API: u32 = 0x30A2;
const EGL_OPENGL_ES_API: u32 = 0x30A0;
const EGL_CONTEXT_MAJOR_VERSION: i32 = 0x3098;
const EGL_CONTEXT_MINOR_VERSION: i32 = 0x30FB;
const EGL_CONTEXT_OPENGL_PROFILE_MASK: i32 = 0x30FD;
const EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT: i32 = 1;
const EGL_CONTEXT_OPENGL_COMPATIBILITY_PROFILE_BIT: i32 = 2;
const EGL_NONE: i32 = 0x3038;

type Handle = *mut c_void;

/// Functions of EGL that are needed.
struct Egl {
    get_proc_address: unsafe extern "C" fn(*const c_char) -> *const c_void,
    get_display: unsafe extern "C" fn(Handle) -> Handle,
    initialize: unsafe extern "C" fn(Handle, *mut i32, *mut i32) -> u32,
    bind_api: unsafe extern "C" fn(u32) -> u32,
    create_context: unsafe extern "C" fn(Handle, Handle, Handle, *const i32) -> Handle,
    make_current: unsafe extern "C" fn(Handle, Handle, Handle, Handle) -> u32,
    destroy_context: unsafe extern "C" fn(Handle, Handle) -> u32,
    get_error: unsafe extern "C" fn() -> i32,
    // Keeps the functions above valid. It is never unloaded: displays stay initialised. A library
    // that is loaded again would not know them and would make new ones, each with its own threads.
    _library: ManuallyDrop<Library>,
}

/// A context that is current on the thread that made it, until it is dropped.
pub struct Headless {
    egl: Egl,
    display: Handle,
    context: Handle,
    /// The driver's functions.
    pub gl: Gl,
    /// True for OpenGL ES, false for desktop OpenGL.
    pub is_gles: bool,
}

impl Egl {
    fn load() -> Result<Self> {
        // SAFETY: libEGL's initialisers are those that every EGL program runs.
        let library = unsafe { Library::new("libEGL.so.1") }
            .map_err(|e| graphics(format!("EGL is missing: libEGL.so.1 cannot be loaded ({e}).")))?;
        macro_rules! function {
            ($name:literal) => {
                // SAFETY: the field's type is the function's type in the EGL specification.
                *unsafe { library.get($name) }.map_err(|e| graphics(format!("libEGL.so.1 is incomplete: {e}.")))?
            };
        }
        Ok(Self {
            get_proc_address: function!(b"eglGetProcAddress\0"),
            get_display: function!(b"eglGetDisplay\0"),
            initialize: function!(b"eglInitialize\0"),
            bind_api: function!(b"eglBindAPI\0"),
            create_context: function!(b"eglCreateContext\0"),
            make_current: function!(b"eglMakeCurrent\0"),
            destroy_context: function!(b"eglDestroyContext\0"),
            get_error: function!(b"eglGetError\0"),
            _library: ManuallyDrop::new(library),
        })
    }

    /// Returns an initialised display: the surfaceless platform, else the first device that works,
    /// else the default display.
    fn display(&self) -> Result<Handle> {
        type GetPlatformDisplay = unsafe extern "C" fn(u32, Handle, *const i32) -> Handle;
        type QueryDevices = unsafe extern "C" fn(i32, *mut Handle, *mut i32) -> u32;
        let mut candidates = Vec::new();
        let platform = self.function(c"eglGetPlatformDisplayEXT");
        if !platform.is_null() {
            // SAFETY: the type is the function's type in EGL_EXT_platform_base.
            let platform: GetPlatformDisplay = unsafe { std::mem::transmute(platform) };
            // SAFETY: for an unknown platform the function returns no display; that is defined
            // behaviour.
            candidates.push(unsafe { platform(EGL_PLATFORM_SURFACELESS_MESA, null_mut(), std::ptr::null()) });
            let query = self.function(c"eglQueryDevicesEXT");
            if !query.is_null() {
                let mut devices = [null_mut(); 16];
                let mut count = 0;
                // SAFETY: the type is the function's type in EGL_EXT_device_enumeration; there is
                // room for 16.
                let found = unsafe {
                    let query: QueryDevices = std::mem::transmute(query);
                    query(16, devices.as_mut_ptr(), &mut count)
                };
                let count = if found == 0 { 0 } else { count.clamp(0, 16) as usize };
                for device in &devices[..count] {
                    // SAFETY: the device is one that EGL listed.
                    candidates.push(unsafe { platform(EGL_PLATFORM_DEVICE_EXT, *device, std::ptr::null()) });
                }
            }
        }
        // SAFETY: null asks for the default display.
        candidates.push(unsafe { (self.get_display)(null_mut()) });
        for display in candidates.into_iter().filter(|d| !d.is_null()) {
            // SAFETY: the display comes from EGL; null versions are not wanted.
            if unsafe { (self.initialize)(display, null_mut(), null_mut()) } != 0 {
                return Ok(display);
            }
        }
        Err(graphics(
            "EGL has no display without a window: no OpenGL driver is installed, or it offers neither EGL_MESA_platform_surfaceless nor EGL_EXT_platform_device.",
        ))
    }

    fn function(&self, name: &CStr) -> *const c_void {
        // SAFETY: the name ends with a zero.
        unsafe { (self.get_proc_address)(name.as_ptr()) }
    }
}

impl Headless {
    /// Makes a context of the kind `api` and makes it current on this thread.
    ///
    /// # Errors
    /// [`ErrorKind::Graphics`] where there is no EGL, no driver, or no such context; the message
    /// says which.
    pub fn new(api: Api) -> Result<Self> {
        let egl = Egl::load()?;
        let display = egl.display()?;
        let is_gles = api == Api::Es3;
        let attributes: &[i32] = match api {
            Api::Core => &[
                EGL_CONTEXT_MAJOR_VERSION,
                3,
                EGL_CONTEXT_MINOR_VERSION,
                3,
                EGL_CONTEXT_OPENGL_PROFILE_MASK,
                EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                EGL_NONE,
            ],
            // The profile is only defined from 3.2 on.
            Api::Compatibility => &[
                EGL_CONTEXT_MAJOR_VERSION,
                3,
                EGL_CONTEXT_MINOR_VERSION,
                3,
                EGL_CONTEXT_OPENGL_PROFILE_MASK,
                EGL_CONTEXT_OPENGL_COMPATIBILITY_PROFILE_BIT,
                EGL_NONE,
            ],
            Api::Es3 => &[EGL_CONTEXT_MAJOR_VERSION, 3, EGL_NONE],
        };
        // SAFETY: the display is initialised; no configuration and no surface are allowed by
        // EGL_KHR_no_config_context and EGL_KHR_surfaceless_context, else the calls fail.
        let context = unsafe {
            (egl.bind_api)(if is_gles { EGL_OPENGL_ES_API } else { EGL_OPENGL_API });
            (egl.create_context)(display, null_mut(), null_mut(), attributes.as_ptr())
        };
        if context.is_null() {
            return Err(graphics(format!("EGL cannot make a {api:?} context: {}.", egl.error())));
        }
        // SAFETY: display and context come from EGL.
        if unsafe { (egl.make_current)(display, null_mut(), null_mut(), context) } == 0 {
            let message = format!("EGL cannot use a context without a surface: {}.", egl.error());
            // SAFETY: as above; the context is not current.
            unsafe { (egl.destroy_context)(display, context) };
            return Err(graphics(message));
        }
        let gl = Gl::load(|name| egl.function(name));
        Ok(Self { egl, display, context, gl, is_gles })
    }

    /// Returns the driver's renderer and version.
    pub fn driver(&self) -> String {
        let mut parts = [crate::backend::gl::driver::api::GL_RENDERER, crate::backend::gl::driver::api::GL_VERSION]
            .map(|name| self.gl.text(name))
            .to_vec();
        parts.retain(|part| !part.is_empty());
        parts.join(", ")
    }
}

impl Egl {
    fn error(&self) -> String {
        // SAFETY: the function takes no arguments.
        format!("error {:#x}", unsafe { (self.get_error)() })
    }
}

impl Drop for Headless {
    fn drop(&mut self) {
        // SAFETY: both come from EGL. The display stays initialised: others may share it.
        unsafe {
            (self.egl.make_current)(self.display, null_mut(), null_mut(), null_mut());
            (self.egl.destroy_context)(self.display, self.context);
        }
    }
}

fn graphics(message: impl Into<String>) -> Error {
    Error::new(ErrorKind::Graphics, message)
}
