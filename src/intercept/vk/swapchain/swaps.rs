//! How the frames of a swapchain are displayed: the rig's swap interval, and its swap group.

use crate::intercept::process::log;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::structures::in_chain;
use crate::rig::WindowSwaps;
use ash::vk;

/// Returns the present mode for the rig's swap interval, or the program's.
///
/// # Safety
/// The structure must be one that the program passes for this device.
pub unsafe fn present_mode(
    device: &Device,
    given: &vk::SwapchainCreateInfoKHR<'_>,
    swaps: WindowSwaps,
) -> vk::PresentModeKHR {
    let Some(interval) = swaps.interval else { return given.present_mode };
    // SAFETY: as promised.
    let chosen_later = unsafe {
        in_chain::<vk::SwapchainPresentModesCreateInfoEXT<'_>>(
            given.p_next,
            vk::StructureType::SWAPCHAIN_PRESENT_MODES_CREATE_INFO_EXT,
        )
    };
    if chosen_later.is_some() {
        log::once("window.swap_interval: the program itself chooses how long each frame waits");
        return given.present_mode;
    }
    if interval > 0 {
        return vk::PresentModeKHR::FIFO;
    }
    let (mut modes, mut count) = ([vk::PresentModeKHR::FIFO; 16], 16);
    let ask = device.driver.instance.surface.get_physical_device_surface_present_modes_khr;
    // SAFETY: the program's surface; there is room for as many modes as the number says.
    let answer = unsafe { ask(device.driver.physical, given.surface, &mut count, modes.as_mut_ptr()) };
    let known = if answer == vk::Result::SUCCESS { &modes[..count.min(16) as usize] } else { &[] };
    let wanted = [vk::PresentModeKHR::IMMEDIATE, vk::PresentModeKHR::MAILBOX];
    wanted.into_iter().find(|mode| known.contains(mode)).unwrap_or(given.present_mode)
}

/// Returns true if the swapchain should join the driver's present barrier, and the driver lets it.
///
/// # Safety
/// The structure must be one that the program passes for this device.
pub unsafe fn joins(device: &Device, given: &vk::SwapchainCreateInfoKHR<'_>, swaps: WindowSwaps) -> bool {
    if swaps.group.is_none() {
        return false;
    }
    if !device.role.joins_barriers {
        log::once(
            "window.swap_group: the Vulkan driver has no VK_NV_present_barrier, or the rig had no swap group when the \
             program started, so displays are not locked together",
        );
        return false;
    }
    // SAFETY: as promised; the instance has the function, as the device joins barriers.
    let can = unsafe {
        let mut barrier = vk::SurfaceCapabilitiesPresentBarrierNV::default();
        let mut answer = vk::SurfaceCapabilities2KHR::default().push_next(&mut barrier);
        let surface = vk::PhysicalDeviceSurfaceInfo2KHR::default().surface(given.surface);
        let ask = device.driver.instance.surface2.get_physical_device_surface_capabilities2_khr;
        let result = ask(device.driver.physical, &surface, &mut answer);
        result == vk::Result::SUCCESS && barrier.present_barrier_supported == vk::TRUE
    };
    if !can {
        log::once(NOT_LET);
    }
    can
}

/// Message if a window cannot join.
pub const NOT_LET: &str = "window.swap_group: the Vulkan driver does not let the window join its present barrier, so \
                           displays are not locked together";
