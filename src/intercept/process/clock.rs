//! The virtual clock, if this process has one: `libcupola_clock.so`, which `cupola run --clock`
//! preloads.
//!
//! It gets a call for each frame. Cupola itself runs in real time.

use crate::lock::Lock;
use std::ffi::{CStr, c_int, c_ulong, c_void};
use std::ptr::NonNull;
use std::sync::{Mutex, OnceLock};

/// The functions of `libcupola_clock.so`.
struct Clock {
    end_frame: unsafe extern "C" fn(c_ulong) -> c_int,
    advance: unsafe extern "C" fn(u64),
    time: unsafe extern "C" fn() -> u64,
}

fn clock() -> Option<&'static Clock> {
    static CLOCK: OnceLock<Option<Clock>> = OnceLock::new();
    CLOCK
        .get_or_init(|| {
            // SAFETY: looks up a name in the dynamic linker.
            let find = |name: &CStr| NonNull::new(unsafe { libc::dlsym(libc::RTLD_DEFAULT, name.as_ptr()) });
            let (frame, advance) = (find(c"cupola_clock_frame")?, find(c"cupola_clock_advance")?);
            let time = find(c"cupola_clock_time")?;
            // SAFETY: the types are those of the library's functions with these names.
            unsafe {
                Some(Clock {
                    end_frame: std::mem::transmute::<NonNull<c_void>, unsafe extern "C" fn(c_ulong) -> c_int>(frame),
                    advance: std::mem::transmute::<NonNull<c_void>, unsafe extern "C" fn(u64)>(advance),
                    time: std::mem::transmute::<NonNull<c_void>, unsafe extern "C" fn() -> u64>(time),
                })
            }
        })
        .as_ref()
}

/// True if the program has a virtual clock.
pub fn is_there() -> bool {
    clock().is_some()
}

/// The program's monotonic clock in nanoseconds; `None` without a virtual clock.
pub fn time() -> Option<u64> {
    // SAFETY: returns a number.
    clock().map(|clock| unsafe { (clock.time)() })
}

/// Notes that a frame of the window with this handle is complete and will be shown next. The
/// program's time advances, unless the frames of another window lead. Returns whether it advanced.
pub fn end_frame(window: u64) -> bool {
    // SAFETY: takes a number and returns one.
    clock().is_some_and(|clock| unsafe { (clock.end_frame)(window) } != 0)
}

/// Advances the program's monotonic clock to this time in nanoseconds, unless it is later already.
pub fn advance(time: u64) {
    if let Some(clock) = clock() {
        // SAFETY: takes a number.
        unsafe { (clock.advance)(time) };
    }
}

/// Swapchains of Vulkan and their surfaces: a window gets a new swapchain when its size changes.
static SURFACES: Mutex<Vec<(u64, u64)>> = Mutex::new(Vec::new());

/// Notes the surface of a new swapchain.
pub fn note_swapchain(swapchain: u64, surface: u64) {
    if is_there() || super::nodes::are_there() {
        let mut surfaces = SURFACES.locked();
        surfaces.retain(|(_, known)| *known != surface);
        surfaces.push((swapchain, surface));
    }
}

/// Returns the surface of a swapchain as the window's handle, or the swapchain itself if its
/// surface is unknown.
pub fn window_of_swapchain(swapchain: u64) -> u64 {
    let known = SURFACES.locked().iter().find(|(known, _)| *known == swapchain).map(|(_, surface)| *surface);
    known.unwrap_or(swapchain)
}
