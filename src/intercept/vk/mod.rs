//! Vulkan, as a layer between the loader and the driver.
//!
//! The loader asks [`negotiate`] for our two `Get…ProcAddr`. [`instance`] and [`device`] remember the next
//! layer's functions; a [`swapchain`]'s images are ours, and [`present`] makes of the program's picture
//! what the outputs show. With nothing to do the loader gets the next layer's own addresses.
pub mod canvas;
pub mod device;
pub mod image;
pub mod instance;
pub mod layout;
pub mod negotiate;
pub mod present;
pub mod readback;
pub mod swapchain;

/// Our function for a device's function of this name.
fn hook(name: &[u8]) -> Option<*const ()> {
    Some(match name {
        b"vkDestroyDevice" => device::destroy as *const (),
        b"vkGetDeviceQueue" => device::queue as *const (),
        b"vkGetDeviceQueue2" => device::queue2 as *const (),
        b"vkCreateSwapchainKHR" => swapchain::create as *const (),
        b"vkDestroySwapchainKHR" => swapchain::destroy as *const (),
        b"vkGetSwapchainImagesKHR" => swapchain::images as *const (),
        b"vkQueuePresentKHR" => present::present as *const (),
        _ => return None,
    })
}
