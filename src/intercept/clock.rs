//! The virtual clock, where this process has one: `libcupola_clock.so`, which `cupola run --clock`
//! preloads.
//!
//! It gets a call for each frame. Cupola itself runs in real time.

use crate::lock::Lock;
use std::ffi::{CStr, c_ulong};
use std::sync::{Mutex, OnceLock};

/// The functions of `libcupola_clock.so`.
struct Clock {
    end_frame: unsafe extern "C" fn(c_ulong),
    time: unsafe extern "C" fn() -> u64,
}

fn clock() -> Option<&'static Clock> {
    static CLOCK: OnceLock<Option<Clock>> = OnceLock::new();
    // SAFETY: asks the dynamic linker for a name.
    let find = |name: &CStr| unsafe { libc::dlsym(libc::RTLD_DEFAULT, name.as_ptr()) };
    CLOCK
        .get_or_init(|| {
            let (frame, time) = (find(c"cupola_clock_frame"), find(c"cupola_clock_time"));
            (!frame.is_null() && !time.is_null()).then(|| Clock {
                // SAFETY: the type that the library gives to this name.
                end_frame: unsafe { std::mem::transmute::<*mut libc::c_void, unsafe extern "C" fn(c_ulong)>(frame) },
                // SAFETY: as above.
                time: unsafe { std::mem::transmute::<*mut libc::c_void, unsafe extern "C" fn() -> u64>(time) },
            })
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

/// A frame of the window with this handle is complete, and will be shown next. The program's time
/// goes on.
pub fn end_frame(window: u64) {
    if let Some(clock) = clock() {
        // SAFETY: takes a number.
        unsafe { (clock.end_frame)(window) };
    }
}

/// Swapchains of Vulkan and their surfaces: a window gets a new swapchain when its size changes.
static SURFACES: Mutex<Vec<(u64, u64)>> = Mutex::new(Vec::new());

/// A swapchain was made for a surface.
pub fn note_swapchain(swapchain: u64, surface: u64) {
    if is_there() {
        let mut surfaces = SURFACES.locked();
        surfaces.retain(|(_, known)| *known != surface);
        surfaces.push((swapchain, surface));
    }
}

/// A frame of this swapchain is complete.
pub fn end_frame_of_swapchain(swapchain: u64) {
    if is_there() {
        let known = SURFACES.locked().iter().find(|(known, _)| *known == swapchain).map(|(_, surface)| *surface);
        end_frame(known.unwrap_or(swapchain));
    }
}
