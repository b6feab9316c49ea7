//! The GLX vendor wrapper. libGLX loads Cupola as the vendor "cupola"; Cupola loads the real
//! vendor.

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
use std::ffi::{CStr, c_char, c_int, c_ulong, c_void};
use std::sync::{Mutex, OnceLock};

type GetProcAddress = unsafe extern "C" fn(*const u8) -> *mut c_void;

/// libglvnd's `__GLXapiImports`: functions that a vendor gives to libGLX.
#[repr(C)]
pub struct Imports {
    is_screen_supported: *mut c_void,
    get_proc_address: Option<GetProcAddress>,
    get_dispatch_address: *mut c_void,
    set_dispatch_index: *mut c_void,
    notify_error: *mut c_void,
    is_patch_supported: *mut c_void,
    initiate_patch: *mut c_void,
    release_patch: *mut c_void,
    patch_thread_attach: *mut c_void,
}

type Main = unsafe extern "C" fn(u32, *const c_void, *mut c_void, *mut Imports) -> c_int;

static REAL: OnceLock<GetProcAddress> = OnceLock::new();

static DRIVER: OnceLock<Gl> = OnceLock::new();

/// Drawables that are not windows, and the X11 windows of `GLXWindow`s.
static DRAWABLES: Mutex<Option<HashMap<c_ulong, Drawable>>> = Mutex::new(None);

enum Drawable {
    OffScreen,
    Window(c_ulong),
}

/// Entry point for libGLX: loads the real vendor and puts Cupola in front of it.
///
/// # Safety
/// Called by libGLX with the pointers that its vendor interface describes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn __glx_Main(
    version: u32,
    exports: *const c_void,
    vendor: *mut c_void,
    imports: *mut Imports,
) -> c_int {
    crate::fence::guard(|| {
        let name = variable("CUPOLA_GLX_REAL")
            .and_then(|name| name.into_string().ok())
            .filter(|n| !n.is_empty() && n != "cupola");
        let file = format!("libGLX_{}.so.0", name.as_deref().unwrap_or("mesa"));
        // SAFETY: the type is that of libGLX's entry.
        let Some(main) = (unsafe { vendor::entry::<Main>(&file, c"__glx_Main", "CUPOLA_GLX_REAL") }) else { return 0 };
        // SAFETY: the same arguments that libGLX gave; `imports` is filled by the vendor.
        let ok = unsafe { main(version, exports, vendor, imports) };
        // SAFETY: a pointer of libGLX to its own structure.
        let imports = unsafe { imports.as_mut() };
        if let (true, Some(imports)) = (ok != 0 && vendor::wanted(), imports)
            && let Some(real) = imports.get_proc_address
        {
            let real = *REAL.get_or_init(|| real);
            // SAFETY: the vendor answers any NUL-terminated name.
            let gl = DRIVER.get_or_init(|| Gl::load(|name| unsafe { real(name.as_ptr().cast()) }));
            current::set_driver(gl);
            imports.get_proc_address = Some(get_proc_address);
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

/// Returns the driver's function of this name.
fn real(name: &CStr) -> *mut c_void {
    // SAFETY: the vendor answers any NUL-terminated name.
    REAL.get().map_or(std::ptr::null_mut(), |real| unsafe { real(name.as_ptr().cast()) })
}

unsafe extern "C" fn get_proc_address(name: *const u8) -> *mut c_void {
    // SAFETY: libGLX passes NUL-terminated names.
    let name = unsafe { CStr::from_ptr(name.cast::<c_char>()) };
    let real = real(name);
    let Ok(text) = name.to_str() else { return real };
    if real.is_null() {
        return real;
    }
    let ours = match text {
        "glXMakeCurrent" => make_current as *const (),
        "glXMakeContextCurrent" | "glXMakeCurrentReadSGI" => make_context_current as *const (),
        "glXSwapBuffers" => swap_buffers as *const (),
        "glXSwapBuffersMscOML" => swap_buffers_msc as *const (),
        "glXCreateContext" => create_context as *const (),
        "glXCreateNewContext" => create_new_context as *const (),
        "glXCreateContextWithConfigSGIX" => create_context_with_config as *const (),
        "glXCreateContextAttribsARB" => create_context_attribs as *const (),
        "glXDestroyContext" => destroy_context as *const (),
        "glXCreateWindow" => create_window as *const (),
        "glXCreatePixmap" => create_pixmap as *const (),
        "glXCreateGLXPixmap" => create_glx_pixmap as *const (),
        "glXCreatePbuffer" => create_pbuffer as *const (),
        "glXDestroyWindow" => destroy_window as *const (),
        "glXDestroyPixmap" => destroy_pixmap as *const (),
        "glXDestroyGLXPixmap" => destroy_glx_pixmap as *const (),
        "glXDestroyPbuffer" => destroy_pbuffer as *const (),
        "glXCopySubBufferMESA" => copy_sub_buffer as *const (),
        "glXWaitGL" => wait_gl as *const (),
        _ => match vendor::hook(text) {
            Some(hook) => hook,
            None => return real,
        },
    };
    ours.cast_mut().cast()
}

type Pointer = *mut c_void;

fn window(display: Pointer, drawable: c_ulong) -> Option<Window> {
    if drawable == 0 {
        return None;
    }
    let drawables = DRAWABLES.locked();
    let x11 = match drawables.as_ref().and_then(|d| d.get(&drawable)) {
        Some(Drawable::OffScreen) => return None,
        Some(Drawable::Window(x11)) => *x11,
        None => drawable,
    };
    Some(Window::Glx { display: display as usize, drawable, x11, query: real(c"glXQueryDrawable") as usize })
}

fn note_drawable(drawable: c_ulong, kind: Drawable) {
    if drawable != 0 {
        let mut drawables = DRAWABLES.locked();
        drawables.get_or_insert_with(HashMap::new).insert(drawable, kind);
    }
}

fn now_current(ok: c_int, display: Pointer, drawable: c_ulong, read: c_ulong, context: Pointer) {
    if let (true, Some(gl)) = (ok != 0, DRIVER.get()) {
        contexts::make_current(context as usize, gl, window(display, drawable), read != drawable);
    }
}

unsafe extern "C" fn make_current(display: Pointer, drawable: c_ulong, context: Pointer) -> c_int {
    contexts::leaving(context as usize, window(display, drawable).as_ref());
    let ok = real_call!(c"glXMakeCurrent", (Pointer, c_ulong, Pointer) -> c_int, display, drawable, context);
    now_current(ok, display, drawable, drawable, context);
    ok
}

unsafe extern "C" fn make_context_current(display: Pointer, draw: c_ulong, read: c_ulong, context: Pointer) -> c_int {
    contexts::leaving(context as usize, window(display, draw).as_ref());
    let ok = real_call!(c"glXMakeContextCurrent", (Pointer, c_ulong, c_ulong, Pointer) -> c_int, display, draw, read, context);
    now_current(ok, display, draw, read, context);
    ok
}

/// Returns the window that is about to be swapped, with the swap interval and the swap group of the
/// rig. NVIDIA's driver wants these from the thread that swaps.
fn synchronised(display: Pointer, drawable: c_ulong) -> Option<Window> {
    let window = window(display, drawable)?;
    if let Some(wanted) = display_sync::take(drawable as usize) {
        wanted.interval.into_iter().for_each(|interval| set_interval(display, drawable, interval));
        wanted.group.into_iter().for_each(|group| join_group(display, drawable, group, wanted.barrier));
    }
    Some(window)
}

fn set_interval(display: Pointer, drawable: c_ulong, interval: u32) {
    if !real(c"glXSwapIntervalEXT").is_null() {
        real_call!(c"glXSwapIntervalEXT", (Pointer, c_ulong, c_int) -> (), display, drawable, interval as c_int);
    } else if !real(c"glXSwapIntervalMESA").is_null() {
        real_call!(c"glXSwapIntervalMESA", (u32) -> c_int, interval);
    } else {
        log::once("window.swap_interval: the driver has no such setting");
    }
}

fn join_group(display: Pointer, drawable: c_ulong, group: u32, barrier: Option<u32>) {
    let joined = !real(c"glXJoinSwapGroupNV").is_null()
        && real_call!(c"glXJoinSwapGroupNV", (Pointer, c_ulong, u32) -> c_int, display, drawable, group) != 0;
    if !joined {
        log::once(&format!(
            "window.swap_group: the driver does not let the window join group {group}, so displays are not locked \
             together; `cupola doctor` says whether it has swap groups"
        ));
        return;
    }
    let Some(barrier) = barrier else {
        return log::once(&format!("the window has joined swap group {group}"));
    };
    let bound = !real(c"glXBindSwapBarrierNV").is_null()
        && real_call!(c"glXBindSwapBarrierNV", (Pointer, u32, u32) -> c_int, display, group, barrier) != 0;
    log::once(&match bound {
        true => format!("the window has joined swap group {group} and barrier {barrier}"),
        false => format!(
            "window.swap_barrier: the window has joined swap group {group}, but the driver does not bind the group to \
             barrier {barrier}: is the synchronisation card connected?"
        ),
    });
}

unsafe extern "C" fn swap_buffers(display: Pointer, drawable: c_ulong) {
    present::swap(
        synchronised(display, drawable),
        (),
        || real_call!(c"glXSwapBuffers", (Pointer, c_ulong) -> (), display, drawable),
    );
}

unsafe extern "C" fn copy_sub_buffer(display: Pointer, drawable: c_ulong, x: c_int, y: c_int, w: c_int, h: c_int) {
    let window = window(display, drawable);
    // The whole window changes with any part of the program's picture.
    let size = window.as_ref().filter(|window| present::corrects(window)).map(Window::size);
    let [x, y, w, h] = size.map_or([x, y, w, h], |(width, height)| [0, 0, width as c_int, height as c_int]);
    present::swap(
        window,
        (),
        || real_call!(c"glXCopySubBufferMESA", (Pointer, c_ulong, c_int, c_int, c_int, c_int) -> (), display, drawable, x, y, w, h),
    );
}

unsafe extern "C" fn wait_gl() {
    front_buffer::show_current();
    real_call!(c"glXWaitGL", () -> (),);
}

unsafe extern "C" fn swap_buffers_msc(
    display: Pointer,
    drawable: c_ulong,
    target: i64,
    divisor: i64,
    remainder: i64,
) -> i64 {
    present::swap(
        synchronised(display, drawable),
        0,
        || real_call!(c"glXSwapBuffersMscOML", (Pointer, c_ulong, i64, i64, i64) -> i64, display, drawable, target, divisor, remainder),
    )
}

/// Forgets a drawable that was destroyed. Its number may come back as another drawable.
fn forget_drawable(drawable: c_ulong) {
    let mut drawables = DRAWABLES.locked();
    drawables.get_or_insert_with(HashMap::new).remove(&drawable);
    display_sync::forget(drawable as usize);
}

noted_calls! {
    c"glXCreateContext" create_context(display: Pointer, visual: Pointer, share: Pointer, direct: c_int) -> Pointer,
        |context| registry::created(context as usize, share as usize);
    c"glXCreateNewContext" create_new_context(display: Pointer, config: Pointer, kind: c_int, share: Pointer, direct: c_int) -> Pointer,
        |context| registry::created(context as usize, share as usize);
    c"glXCreateContextWithConfigSGIX" create_context_with_config(display: Pointer, config: Pointer, kind: c_int, share: Pointer, direct: c_int) -> Pointer,
        |context| registry::created(context as usize, share as usize);
    c"glXCreateContextAttribsARB" create_context_attribs(display: Pointer, config: Pointer, share: Pointer, direct: c_int, attributes: *const c_int) -> Pointer,
        |context| registry::created(context as usize, share as usize);
    c"glXDestroyContext" destroy_context(display: Pointer, context: Pointer) -> (), |done| registry::destroyed(context as usize);
    c"glXCreateWindow" create_window(display: Pointer, config: Pointer, x11: c_ulong, attributes: *const c_int) -> c_ulong,
        |drawable| note_drawable(drawable, Drawable::Window(x11));
    c"glXCreatePixmap" create_pixmap(display: Pointer, config: Pointer, pixmap: c_ulong, attributes: *const c_int) -> c_ulong,
        |drawable| note_drawable(drawable, Drawable::OffScreen);
    c"glXCreateGLXPixmap" create_glx_pixmap(display: Pointer, visual: Pointer, pixmap: c_ulong) -> c_ulong,
        |drawable| note_drawable(drawable, Drawable::OffScreen);
    c"glXCreatePbuffer" create_pbuffer(display: Pointer, config: Pointer, attributes: *const c_int) -> c_ulong,
        |drawable| note_drawable(drawable, Drawable::OffScreen);
    c"glXDestroyWindow" destroy_window(display: Pointer, drawable: c_ulong) -> (), |done| forget_drawable(drawable);
    c"glXDestroyPixmap" destroy_pixmap(display: Pointer, drawable: c_ulong) -> (), |done| forget_drawable(drawable);
    c"glXDestroyGLXPixmap" destroy_glx_pixmap(display: Pointer, drawable: c_ulong) -> (), |done| forget_drawable(drawable);
    c"glXDestroyPbuffer" destroy_pbuffer(display: Pointer, drawable: c_ulong) -> (), |done| forget_drawable(drawable);
}
