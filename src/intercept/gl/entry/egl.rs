//! The EGL vendor wrapper. libEGL finds Cupola through a JSON file; Cupola loads the real vendor.

use crate::backend::gl::driver::api::Gl;
use crate::intercept::gl::context::current;
use crate::intercept::gl::context::registry;
use crate::intercept::gl::entry::contexts;
use crate::intercept::gl::entry::display_sync;
use crate::intercept::gl::entry::vendor::{self, noted_calls, real_call};
use crate::intercept::gl::frame::{front_buffer, present};
use crate::intercept::gl::state::drawable::window::Window;
use crate::intercept::process::log;
use crate::lock::Lock;
use crate::system::variable;
use std::collections::HashMap;
use std::ffi::{CStr, c_char, c_int, c_uint, c_ulong, c_void};
use std::sync::{Mutex, OnceLock};

type Pointer = *mut c_void;

type GetProcAddress = unsafe extern "C" fn(*const c_char) -> Pointer;

type GetPlatformDisplay = unsafe extern "C" fn(c_uint, Pointer, *const isize) -> Pointer;

/// libglvnd's `__EGLapiImports`: functions that a vendor gives to libEGL.
#[repr(C)]
pub struct Imports {
    get_platform_display: Option<GetPlatformDisplay>,
    get_supports_api: Pointer,
    get_vendor_string: Pointer,
    get_proc_address: Option<GetProcAddress>,
    get_dispatch_address: Pointer,
    set_dispatch_index: Pointer,
    is_patch_supported: Pointer,
    initiate_patch: Pointer,
    release_patch: Pointer,
    patch_thread_attach: Pointer,
    find_native_display_platform: Pointer,
}

type Main = unsafe extern "C" fn(u32, *const c_void, Pointer, *mut Imports) -> c_uint;

static REAL: OnceLock<GetProcAddress> = OnceLock::new();

static REAL_DISPLAY: OnceLock<GetPlatformDisplay> = OnceLock::new();

static DRIVER: OnceLock<Gl> = OnceLock::new();

static KNOWN: Mutex<Option<Known>> = Mutex::new(None);

/// X11 displays of EGL displays, and X11 windows of EGL surfaces.
#[derive(Default)]
struct Known {
    displays: HashMap<usize, usize>,
    surfaces: HashMap<usize, c_ulong>,
}

const PLATFORM_X11: c_uint = 0x31D5;

/// Entry point for libEGL: loads the real vendor and puts Cupola in front of it.
///
/// # Safety
/// Called by libEGL with the pointers that its vendor interface describes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn __egl_Main(
    version: u32,
    exports: *const c_void,
    vendor: Pointer,
    imports: *mut Imports,
) -> c_uint {
    crate::fence::guard(|| {
        let vendors = variable("CUPOLA_EGL_REAL").and_then(|names| names.into_string().ok()).unwrap_or_default();
        let file = real_vendor(&vendors, &own_file());
        // SAFETY: the type is that of libEGL's entry.
        let Some(main) = (unsafe { vendor::entry::<Main>(file, c"__egl_Main", "CUPOLA_EGL_REAL") }) else { return 0 };
        // SAFETY: the same arguments that libEGL gave; `imports` is filled by the vendor.
        let ok = unsafe { main(version, exports, vendor, imports) };
        // SAFETY: a pointer of libEGL to its own structure.
        let imports = unsafe { imports.as_mut() };
        if let (true, Some(imports)) = (ok != 0 && vendor::wanted(), imports)
            && let Some(real) = imports.get_proc_address
        {
            let real = *REAL.get_or_init(|| real);
            // SAFETY: the vendor answers any NUL-terminated name.
            let gl = DRIVER.get_or_init(|| Gl::load(|name| unsafe { real(name.as_ptr()) }));
            current::set_driver(gl);
            imports.get_proc_address = Some(get_proc_address);
            if let Some(display) = imports.get_platform_display {
                REAL_DISPLAY.get_or_init(|| display);
                imports.get_platform_display = Some(get_platform_display);
            }
            // A vendor that rewrites libglvnd's stubs would bypass Cupola.
            imports.is_patch_supported = std::ptr::null_mut();
            imports.initiate_patch = std::ptr::null_mut();
            imports.release_patch = std::ptr::null_mut();
            imports.patch_thread_attach = std::ptr::null_mut();
        }
        ok
    })
    .unwrap_or(0)
}

/// Returns the one of `vendors` (separated by colons) that the library file `own_file` wraps.
/// libEGL needs a library for each vendor. The copy of Cupola's library for vendor n, counted from
/// 0, is called `libEGL_cupola_n.so`.
fn real_vendor<'a>(vendors: &'a str, own_file: &str) -> &'a str {
    let number = own_file.strip_prefix("libEGL_cupola_").and_then(|rest| rest.strip_suffix(".so")?.parse().ok());
    vendors.split(':').nth(number.unwrap_or(0)).filter(|name| !name.is_empty()).unwrap_or("libEGL_mesa.so.0")
}

/// Returns the name of the file from which this library was loaded; empty if unknown.
fn own_file() -> String {
    // SAFETY: all zeroes is a valid Dl_info: null pointers.
    let mut info: libc::Dl_info = unsafe { std::mem::zeroed() };
    // SAFETY: any address may be asked for; `info` is written.
    let found = unsafe { libc::dladdr(__egl_Main as *const c_void, &mut info) } != 0;
    if !found || info.dli_fname.is_null() {
        return String::new();
    }
    // SAFETY: the dynamic linker's name of a loaded library ends with a zero and lives as long as
    // the library.
    let path = unsafe { CStr::from_ptr(info.dli_fname) }.to_string_lossy();
    path.rsplit('/').next().unwrap_or_default().to_owned()
}

unsafe extern "C" fn get_platform_display(platform: c_uint, native: Pointer, attributes: *const isize) -> Pointer {
    let Some(real) = REAL_DISPLAY.get() else { return std::ptr::null_mut() };
    // SAFETY: libEGL's own call, passed on.
    let display = unsafe { real(platform, native, attributes) };
    if platform == PLATFORM_X11 && !native.is_null() {
        known(|k| k.displays.insert(display as usize, native as usize));
    }
    display
}

fn known<R>(use_it: impl FnOnce(&mut Known) -> R) -> R {
    use_it(KNOWN.locked().get_or_insert_with(Known::default))
}

/// Returns the driver's function of this name.
fn real(name: &CStr) -> Pointer {
    // SAFETY: the vendor answers any NUL-terminated name.
    REAL.get().map_or(std::ptr::null_mut(), |real| unsafe { real(name.as_ptr()) })
}

unsafe extern "C" fn get_proc_address(name: *const c_char) -> Pointer {
    // SAFETY: libEGL passes NUL-terminated names.
    let name = unsafe { CStr::from_ptr(name) };
    let real = real(name);
    let Ok(text) = name.to_str() else { return real };
    if real.is_null() {
        return real;
    }
    let ours = match text {
        "eglMakeCurrent" => make_current as *const (),
        "eglSwapBuffers" => swap_buffers as *const (),
        "eglSwapBuffersWithDamageKHR" => swap_buffers_with_damage_khr as *const (),
        "eglSwapBuffersWithDamageEXT" => swap_buffers_with_damage_ext as *const (),
        "eglCreateContext" => create_context as *const (),
        "eglDestroyContext" => destroy_context as *const (),
        "eglCreateWindowSurface" => create_window_surface as *const (),
        "eglCreatePlatformWindowSurface" => create_platform_window_surface as *const (),
        "eglCreatePlatformWindowSurfaceEXT" => create_platform_window_surface_ext as *const (),
        "eglReleaseThread" => release_thread as *const (),
        "eglWaitGL" => wait_gl as *const (),
        "eglWaitClient" => wait_client as *const (),
        "eglDestroySurface" => destroy_surface as *const (),
        "eglSetDamageRegionKHR" => set_damage_region as *const (),
        "eglPostSubBufferNV" => post_sub_buffer as *const (),
        _ => match vendor::hook(text) {
            Some(hook) => hook,
            None => return real,
        },
    };
    ours.cast_mut().cast()
}

fn window(display: Pointer, surface: Pointer) -> Option<Window> {
    let (native_display, native_window) = known(|k| {
        let window = k.surfaces.get(&(surface as usize)).copied();
        (k.displays.get(&(display as usize)).copied(), window)
    });
    let native_window = native_window?;
    let x11 = native_display.filter(|_| native_window != 0).map(|display| (display, native_window));
    Some(Window::Egl {
        display: display as usize,
        surface: surface as usize,
        x11,
        query: real(c"eglQuerySurface") as usize,
    })
}

unsafe extern "C" fn make_current(display: Pointer, draw: Pointer, read: Pointer, context: Pointer) -> c_uint {
    contexts::leaving(context as usize, window(display, draw).as_ref());
    let ok =
        real_call!(c"eglMakeCurrent", (Pointer, Pointer, Pointer, Pointer) -> c_uint, display, draw, read, context);
    if let (true, Some(gl)) = (ok != 0, DRIVER.get()) {
        contexts::make_current(context as usize, gl, window(display, draw), read != draw);
    }
    ok
}

/// Returns the window that is about to be swapped, with the swap interval of the rig.
fn synchronised(display: Pointer, surface: Pointer) -> Option<Window> {
    let window = window(display, surface)?;
    if let Some(wanted) = display_sync::take(surface as usize) {
        if let Some(interval) = wanted.interval {
            real_call!(c"eglSwapInterval", (Pointer, c_int) -> c_uint, display, interval as c_int);
        }
        if wanted.group.is_some() {
            log::once("window.swap_group: EGL has no swap groups, so displays are not locked together");
        }
    }
    Some(window)
}

unsafe extern "C" fn swap_buffers(display: Pointer, surface: Pointer) -> c_uint {
    present::swap(
        synchronised(display, surface),
        1,
        || real_call!(c"eglSwapBuffers", (Pointer, Pointer) -> c_uint, display, surface),
    )
}

unsafe extern "C" fn release_thread() -> c_uint {
    contexts::leaving(0, None);
    let ok = real_call!(c"eglReleaseThread", () -> c_uint,);
    if let (true, Some(gl)) = (ok != 0, DRIVER.get()) {
        contexts::make_current(0, gl, None, false);
    }
    ok
}

unsafe extern "C" fn wait_gl() -> c_uint {
    front_buffer::show_current();
    real_call!(c"eglWaitGL", () -> c_uint,)
}

unsafe extern "C" fn wait_client() -> c_uint {
    front_buffer::show_current();
    real_call!(c"eglWaitClient", () -> c_uint,)
}

unsafe extern "C" fn post_sub_buffer(
    display: Pointer,
    surface: Pointer,
    x: c_int,
    y: c_int,
    w: c_int,
    h: c_int,
) -> c_uint {
    let window = window(display, surface);
    // The whole window changes with any part of the program's picture.
    let size = window.as_ref().filter(|window| present::corrects(window)).map(Window::size);
    let [x, y, w, h] = size.map_or([x, y, w, h], |(width, height)| [0, 0, width as c_int, height as c_int]);
    present::swap(
        window,
        1,
        || real_call!(c"eglPostSubBufferNV", (Pointer, Pointer, c_int, c_int, c_int, c_int) -> c_uint, display, surface, x, y, w, h),
    )
}

unsafe extern "C" fn set_damage_region(display: Pointer, surface: Pointer, rects: *mut c_int, count: c_int) -> c_uint {
    // Cupola draws to the whole window, whatever part of its picture the program redraws.
    if window(display, surface).as_ref().is_some_and(present::corrects) {
        return 1;
    }
    real_call!(c"eglSetDamageRegionKHR", (Pointer, Pointer, *mut c_int, c_int) -> c_uint, display, surface, rects, count)
}

/// Returns the damage for the driver. A window that keeps the program's own picture has the
/// program's damage. A corrected window has an empty list, which means the whole window, as any
/// part of the program's picture changes all of it.
fn damage(window: Option<&Window>, rects: *const c_int, count: c_int) -> (*const c_int, c_int) {
    if window.is_some_and(present::corrects) { (std::ptr::null(), 0) } else { (rects, count) }
}

unsafe extern "C" fn swap_buffers_with_damage_khr(
    display: Pointer,
    surface: Pointer,
    rects: *const c_int,
    count: c_int,
) -> c_uint {
    let window = synchronised(display, surface);
    let (rects, count) = damage(window.as_ref(), rects, count);
    present::swap(
        window,
        1,
        || real_call!(c"eglSwapBuffersWithDamageKHR", (Pointer, Pointer, *const c_int, c_int) -> c_uint, display, surface, rects, count),
    )
}

unsafe extern "C" fn swap_buffers_with_damage_ext(
    display: Pointer,
    surface: Pointer,
    rects: *const c_int,
    count: c_int,
) -> c_uint {
    let window = synchronised(display, surface);
    let (rects, count) = damage(window.as_ref(), rects, count);
    present::swap(
        window,
        1,
        || real_call!(c"eglSwapBuffersWithDamageEXT", (Pointer, Pointer, *const c_int, c_int) -> c_uint, display, surface, rects, count),
    )
}

fn note_surface(surface: Pointer, native: c_ulong) {
    if !surface.is_null() {
        known(|k| k.surfaces.insert(surface as usize, native));
    }
}

/// Returns the X11 window that a native window points at; 0 if the platform is not X11.
fn x11_window(display: Pointer, native: Pointer) -> c_ulong {
    if native.is_null() || !known(|k| k.displays.contains_key(&(display as usize))) {
        return 0;
    }
    // SAFETY: on X11 the native window is a pointer to the window's id.
    unsafe { *native.cast::<c_ulong>() }
}

noted_calls! {
    c"eglCreateContext" create_context(display: Pointer, config: Pointer, share: Pointer, attributes: *const c_int) -> Pointer,
        |context| registry::created(context as usize, share as usize);
    c"eglDestroyContext" destroy_context(display: Pointer, context: Pointer) -> c_uint, |ok| if ok != 0 {
        registry::destroyed(context as usize);
    };
    c"eglCreateWindowSurface" create_window_surface(display: Pointer, config: Pointer, native: c_ulong, attributes: *const c_int) -> Pointer,
        |surface| note_surface(surface, native);
    c"eglCreatePlatformWindowSurface" create_platform_window_surface(display: Pointer, config: Pointer, native: Pointer, attributes: *const isize) -> Pointer,
        |surface| note_surface(surface, x11_window(display, native));
    c"eglCreatePlatformWindowSurfaceEXT" create_platform_window_surface_ext(display: Pointer, config: Pointer, native: Pointer, attributes: *const c_int) -> Pointer,
        |surface| note_surface(surface, x11_window(display, native));
    c"eglDestroySurface" destroy_surface(display: Pointer, surface: Pointer) -> c_uint,
        |ok| {
            known(|k| k.surfaces.remove(&(surface as usize)));
            display_sync::forget(surface as usize);
        };
}

#[cfg(test)]
mod tests {
    use super::real_vendor;

    #[test]
    fn each_copy_has_its_vendor() {
        assert_eq!(real_vendor("libEGL_a.so.0:/b/libEGL_b.so", "libEGL_cupola_1.so"), "/b/libEGL_b.so");
        assert_eq!(real_vendor("libEGL_a.so.0:/b/libEGL_b.so", "libEGL_cupola_0.so"), "libEGL_a.so.0");
        assert_eq!(real_vendor("libEGL_a.so.0", "libcupola.so"), "libEGL_a.so.0");
        assert_eq!(real_vendor("", "libcupola.so"), "libEGL_mesa.so.0");
        assert_eq!(real_vendor("libEGL_a.so.0", "libEGL_cupola_7.so"), "libEGL_mesa.so.0");
    }
}
