//! Windows of X11 that get the size of `--size`: when the program makes a surface of one, and when it
//! asks for the size of a swapchain.

use crate::intercept::process::settings;
use crate::intercept::vk::state::driver::instance::{self, Instance, Surface};
use crate::intercept::vk::state::driver::xcb::XcbWindow;
use crate::lock::Lock;
use ash::vk;
use std::ffi::{CStr, c_void};

/// Greatest number of changes of a window's size. The program may have its own ideas.
const MOST_RESIZED: u32 = 3;

/// Returns Cupola's function of an instance with this name, if windows get a size.
pub fn find(name: &CStr) -> Option<*const ()> {
    settings::settings().and_then(|settings| settings.window_size)?;
    Some(match name.to_bytes() {
        b"vkCreateXlibSurfaceKHR" => create_xlib as *const (),
        b"vkCreateXcbSurfaceKHR" => create_xcb as *const (),
        b"vkDestroySurfaceKHR" => destroy as *const (),
        b"vkGetPhysicalDeviceSurfaceCapabilitiesKHR" => capabilities as *const (),
        b"vkGetPhysicalDeviceSurfaceCapabilities2KHR" => capabilities2 as *const (),
        _ => return None,
    })
}

/// Notes the window of a new surface, and gives it the wanted size.
///
/// # Safety
/// The window must be live.
unsafe fn note(state: &Instance, surface: vk::SurfaceKHR, window: Option<XcbWindow>) {
    let Some(window) = window else { return };
    state.surfaces.locked().insert(surface, Surface { window, resized: 0 });
    // SAFETY: as promised.
    unsafe { follow(state, surface) };
}

/// Gives the window of a surface the wanted size, unless this was done often.
///
/// # Safety
/// The surface must be live.
unsafe fn follow(state: &Instance, surface: vk::SurfaceKHR) {
    let Some(size) = settings::settings().and_then(|settings| settings.window_size) else { return };
    let mut surfaces = state.surfaces.locked();
    let Some(known) = surfaces.get_mut(&surface).filter(|known| known.resized < MOST_RESIZED) else { return };
    // SAFETY: the program must keep the window as long as its surface.
    let resized = crate::fence::guard(|| unsafe { known.window.resize(size) });
    known.resized += u32::from(resized == Some(true));
}

/// `vkCreateXlibSurfaceKHR`.
///
/// # Safety
/// Called by the program.
unsafe extern "system" fn create_xlib(
    handle: vk::Instance,
    info: *const vk::XlibSurfaceCreateInfoKHR<'_>,
    allocator: *const vk::AllocationCallbacks<'_>,
    surface: *mut vk::SurfaceKHR,
) -> vk::Result {
    let Some(state) = instance::get(handle) else { return vk::Result::ERROR_INITIALIZATION_FAILED };
    // SAFETY: the program's own call with its arguments.
    unsafe {
        let result = (state.xlib.create_xlib_surface_khr)(handle, info, allocator, surface);
        if result == vk::Result::SUCCESS {
            let window = u32::try_from((*info).window).ok();
            let window = window.and_then(|window| XcbWindow::of_xlib((*info).dpy.cast::<c_void>(), window));
            note(&state, *surface, window);
        }
        result
    }
}

/// `vkCreateXcbSurfaceKHR`.
///
/// # Safety
/// Called by the program.
unsafe extern "system" fn create_xcb(
    handle: vk::Instance,
    info: *const vk::XcbSurfaceCreateInfoKHR<'_>,
    allocator: *const vk::AllocationCallbacks<'_>,
    surface: *mut vk::SurfaceKHR,
) -> vk::Result {
    let Some(state) = instance::get(handle) else { return vk::Result::ERROR_INITIALIZATION_FAILED };
    // SAFETY: the program's own call with its arguments.
    unsafe {
        let result = (state.xcb.create_xcb_surface_khr)(handle, info, allocator, surface);
        if result == vk::Result::SUCCESS {
            note(&state, *surface, XcbWindow::new((*info).connection.cast::<c_void>(), (*info).window));
        }
        result
    }
}

/// `vkDestroySurfaceKHR`.
///
/// # Safety
/// Called by the program.
unsafe extern "system" fn destroy(
    handle: vk::Instance,
    surface: vk::SurfaceKHR,
    allocator: *const vk::AllocationCallbacks<'_>,
) {
    let Some(state) = instance::get(handle) else { return };
    state.surfaces.locked().remove(&surface);
    // SAFETY: the program's own call with its arguments.
    unsafe { (state.surface.destroy_surface_khr)(handle, surface, allocator) };
}

/// `vkGetPhysicalDeviceSurfaceCapabilitiesKHR`.
///
/// # Safety
/// Called by the program.
unsafe extern "system" fn capabilities(
    device: vk::PhysicalDevice,
    surface: vk::SurfaceKHR,
    answer: *mut vk::SurfaceCapabilitiesKHR,
) -> vk::Result {
    let Some(state) = instance::get(device) else { return vk::Result::ERROR_INITIALIZATION_FAILED };
    // SAFETY: the program's own call with its arguments.
    unsafe {
        follow(&state, surface);
        (state.surface.get_physical_device_surface_capabilities_khr)(device, surface, answer)
    }
}

/// `vkGetPhysicalDeviceSurfaceCapabilities2KHR`.
///
/// # Safety
/// Called by the program.
unsafe extern "system" fn capabilities2(
    device: vk::PhysicalDevice,
    info: *const vk::PhysicalDeviceSurfaceInfo2KHR<'_>,
    answer: *mut vk::SurfaceCapabilities2KHR<'_>,
) -> vk::Result {
    let Some(state) = instance::get(device) else { return vk::Result::ERROR_INITIALIZATION_FAILED };
    // SAFETY: the program's own call with its arguments.
    unsafe {
        follow(&state, (*info).surface);
        (state.surface2.get_physical_device_surface_capabilities2_khr)(device, info, answer)
    }
}
