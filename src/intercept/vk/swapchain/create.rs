//! Creation of swapchains. The program draws to stand-in images, and the real images get the
//! correction.

use crate::error::{Error, ErrorKind, Result};
use crate::intercept::process::clock;
use crate::intercept::process::live::{self, Live};
use crate::intercept::process::log;
use crate::intercept::process::settings::{self, Settings};
use crate::intercept::scene::obstacle::Obstacle;
use crate::intercept::vk::state::device;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::swapchains::formats::{TexelFormat, is_usual};
use crate::intercept::vk::state::swapchains::{PictureSource, StandIn, Swapchain};
use crate::intercept::vk::state::views::atlas_layout::AtlasLayout;
use crate::intercept::vk::state::views::vertices::VertexProcessing;
use crate::intercept::vk::swapchain::swaps;
use crate::lock::Lock;
use crate::rig::{Duplicate, Method, Rig};
use ash::prelude::VkResult;
use ash::vk::{self, Handle};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};

impl Swapchain {
    /// Returns image number `index` of the program.
    pub fn given(&self, index: usize) -> Option<vk::Image> {
        match &self.stand_in {
            Some(stand_in) => stand_in.given(index),
            None => self.real.get(index).copied(),
        }
    }

    /// Returns the source of the next picture of image `index`; `None` if the image is presented
    /// unchanged.
    pub fn show(&self, index: usize) -> Option<PictureSource> {
        let in_views = self.stand_in.as_ref()?.in_views(index);
        Some(match (self.failed, in_views) {
            (true, true) => PictureSource::Tile,
            (true, false) => PictureSource::Own,
            (false, true) => PictureSource::Views,
            (false, false) => PictureSource::Panel,
        })
    }
}

/// Plans a rig for a window. The log reports outputs that are made by another method.
pub(super) fn plan(device: &Device, rig: &Rig, size: (u32, u32), read: bool) -> Result<AtlasLayout> {
    report_methods(device, rig);
    if rig.views.duplicate == Duplicate::InTurn {
        log::once("Vulkan: views are not drawn in turn: off-screen drawing is followed as with duplicate \"auto\"");
    }
    AtlasLayout::new(rig, size, device.driver.greatest_image(), read, device.role.vertices.vertices)
}

/// Reports outputs that are made by another method than their own.
pub(super) fn report_methods(device: &Device, rig: &Rig) {
    let vertices = device.role.vertices.vertices;
    let projects = vertices != VertexProcessing::Views;
    let undivided = device.role.vertices.undivided.as_ref().and_then(Obstacle::reason);
    let has = |lost: &dyn Fn(&Method) -> bool| rig.outputs.iter().any(|output| lost(&output.method));
    let reasons = [
        undivided.filter(|_| has(&Method::divides)),
        (!projects && has(&|m| m.projects_vertices() && !m.divides()))
            .then_some("vertices are projected after a new start"),
    ];
    for why in reasons.into_iter().flatten() {
        log::once(&format!("Vulkan: {why}: outputs that ask for it are made by method \"fragment\" instead"));
    }
}

/// Returns the reason why a swapchain is left alone; `None` if it is not.
fn obstacle(info: &vk::SwapchainCreateInfoKHR<'_>) -> Option<String> {
    if TexelFormat::of(info.image_format).is_none() {
        let kinds = "supported are RGBA and BGRA of 8 bits, RGB of 10 bits and RGBA of 16-bit floats";
        return Some(format!("images of {:?}; {kinds}", info.image_format));
    }
    if !is_usual(info.image_color_space) {
        return Some(format!("colours in the space {:?}, which are not encoded like sRGB", info.image_color_space));
    }
    if info.image_array_layers != 1 || info.flags.contains(vk::SwapchainCreateFlagsKHR::PROTECTED) {
        return Some("layered or protected images".to_owned());
    }
    let shared = [vk::PresentModeKHR::SHARED_DEMAND_REFRESH, vk::PresentModeKHR::SHARED_CONTINUOUS_REFRESH];
    shared.contains(&info.present_mode).then(|| "images that are displayed while they are drawn".to_owned())
}

/// `vkCreateSwapchainKHR`.
///
/// # Safety
/// Called by the program.
pub unsafe extern "system" fn create(
    handle: vk::Device,
    info: *const vk::SwapchainCreateInfoKHR<'_>,
    allocator: *const vk::AllocationCallbacks<'_>,
    swapchain: *mut vk::SwapchainKHR,
) -> vk::Result {
    let Some(device) = device::get(handle) else { return vk::Result::ERROR_INITIALIZATION_FAILED };
    // SAFETY: the program's structure.
    let given = unsafe { &*info };
    // SAFETY: the program's own call; the structure differs only in its usage and flags.
    let next = |info: &vk::SwapchainCreateInfoKHR<'_>| unsafe {
        let result = (device.driver.swapchain.create_swapchain_khr)(handle, info, allocator, swapchain);
        if result == vk::Result::SUCCESS {
            clock::note_swapchain((*swapchain).as_raw(), info.surface.as_raw());
        }
        result
    };
    let looked_after = device.role.active && !device.swapchains.given_up.load(Ordering::Relaxed);
    let Some(settings) = settings::settings().filter(|_| looked_after) else { return next(given) };
    if let Some(why) = obstacle(given) {
        log::once(&format!("Vulkan: a window keeps the program's own picture: {why}"));
        return next(given);
    }
    let passthrough = settings.rig.passthrough;
    let mut changed = *given;
    let wanted = if passthrough {
        vk::ImageUsageFlags::empty()
    } else {
        vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::TRANSFER_DST
    };
    let reads = settings.capture.is_some() || settings.publish.is_some();
    let read = if reads { vk::ImageUsageFlags::TRANSFER_SRC } else { vk::ImageUsageFlags::empty() };
    // SAFETY: the program's own call.
    let supported = unsafe { supported_usage(&device, given) };
    if !supported.contains(wanted | read) {
        log::once("Vulkan: a window keeps the program's own picture: its images cannot be drawn to or copied");
        return next(given);
    }
    changed.image_usage |= wanted | read;
    if !passthrough {
        // The correction makes views of the images at once, which needs the memory of the images.
        changed.flags &= !vk::SwapchainCreateFlagsKHR::DEFERRED_MEMORY_ALLOCATION_EXT;
    }
    let live = live::rig();
    let window = live.as_ref().map_or(settings.rig.window, |live| live.rig.window);
    // SAFETY: the program's own call.
    changed.present_mode = unsafe { swaps::present_mode(&device, given, window) };
    let mut barrier = vk::SwapchainPresentBarrierCreateInfoNV::default().present_barrier_enable(true);
    barrier.p_next = changed.p_next.cast_mut();
    // SAFETY: the program's own call.
    let joins = unsafe { swaps::joins(&device, given, window) };
    if joins {
        changed.p_next = (&raw const barrier).cast();
    }
    let mut result = next(&changed);
    if joins && result != vk::Result::SUCCESS {
        changed.p_next = given.p_next;
        // The first call has retired it, and a retired one must not be given again.
        changed.old_swapchain = vk::SwapchainKHR::null();
        result = next(&changed);
        if result == vk::Result::SUCCESS {
            log::once(swaps::NOT_LET);
        }
    }
    if result != vk::Result::SUCCESS {
        return result;
    }
    // SAFETY: the driver has just made it.
    unsafe { manage(&device, *swapchain, given, supported, settings) };
    vk::Result::SUCCESS
}

/// Takes charge of a new swapchain. If it cannot be corrected, its frames are still counted and
/// captured.
///
/// # Safety
/// The driver has just made it from `given`, with the usages that Cupola needs.
unsafe fn manage(
    device: &Device,
    made: vk::SwapchainKHR,
    given: &vk::SwapchainCreateInfoKHR<'_>,
    supported: vk::ImageUsageFlags,
    settings: &Settings,
) {
    let live = live::rig();
    let corrected = live.as_ref().filter(|_| !settings.rig.passthrough).map(|live| (live, settings));
    // SAFETY: objects of a live device.
    let built = crate::fence::guard(|| unsafe { build(device, made, given, supported, corrected) });
    match &built {
        Some(Ok(_)) => {}
        Some(Err(error)) => log::once(&format!("Vulkan: a window keeps the program's own picture: {}", error.message)),
        None => log::once("Vulkan: a window keeps the program's own picture after a failure"),
    }
    let built = built.and_then(std::result::Result::ok).or_else(|| {
        // SAFETY: as above.
        crate::fence::guard(|| unsafe { build(device, made, given, supported, None) })?.ok()
    });
    if let Some(built) = built {
        device.swapchains.all.locked().insert(made, Arc::new(Mutex::new(built)));
    }
}

/// Returns the supported usage of images of a new swapchain's surface; all usages if the driver
/// gives none. The driver is not asked again for a swapchain that replaces another: its answer
/// comes from the display server, and the longer the program's call takes until it reaches the
/// driver, the likelier the window has another size by then.
///
/// # Safety
/// The structure must be one that the program passes for this device.
unsafe fn supported_usage(device: &Device, info: &vk::SwapchainCreateInfoKHR<'_>) -> vk::ImageUsageFlags {
    if let Some(old) = device.swapchains.managed(info.old_swapchain) {
        return old.locked().supported;
    }
    let mut capabilities = vk::SurfaceCapabilitiesKHR::default();
    let ask = device.driver.instance.surface.get_physical_device_surface_capabilities_khr;
    // SAFETY: the program's surface.
    match unsafe { ask(device.driver.physical, info.surface, &mut capabilities) } {
        vk::Result::SUCCESS => capabilities.supported_usage_flags,
        _ => !vk::ImageUsageFlags::empty(),
    }
}

/// # Safety
/// The swapchain must have just been made on the device.
unsafe fn build(
    device: &Device,
    swapchain: vk::SwapchainKHR,
    info: &vk::SwapchainCreateInfoKHR<'_>,
    supported: vk::ImageUsageFlags,
    corrected: Option<(&Live, &Settings)>,
) -> Result<Swapchain> {
    // SAFETY: as promised.
    let real = unsafe { real_images(device, swapchain) }
        .map_err(|error| Error::new(ErrorKind::Graphics, format!("the driver does not return its images: {error}")))?;
    let stand_in = match corrected {
        None => {
            real.iter().for_each(|image| device.images.declare(*image, info.image_usage));
            None
        }
        Some((live, settings)) => {
            let size = (info.image_extent.width, info.image_extent.height);
            let read = info.image_usage.contains(vk::ImageUsageFlags::TRANSFER_SRC) || device.pipelines.write();
            let layout = match device.swapchains.layout(size, read).filter(|known| known.version == live.version) {
                Some(known) => known,
                None => {
                    let new = plan(device, &live.rig, size, read)?;
                    Arc::new(AtlasLayout { version: live.version, ..new })
                }
            };
            // SAFETY: as promised.
            let stand_in = unsafe { StandIn::new(device, info, &real, Arc::clone(&layout), settings.stats.is_some())? };
            if let Err(why) = device.images.follow(device, &layout) {
                device.show_flat(why);
            }
            Some(stand_in)
        }
    };
    let texel_format = TexelFormat::of(info.image_format).unwrap_or(TexelFormat::Rgba8);
    let version = corrected.map_or(0, |(live, _)| live.version);
    let (extent, publishing, failed) = (info.image_extent, None, false);
    Ok(Swapchain {
        extent,
        texel_format,
        supported,
        real,
        stand_in,
        publishing,
        failed,
        version,
        shown: version,
        coming: None,
        due: None,
    })
}

/// # Safety
/// The swapchain must belong to the device.
unsafe fn real_images(device: &Device, swapchain: vk::SwapchainKHR) -> VkResult<Vec<vk::Image>> {
    let ask = device.driver.swapchain.get_swapchain_images_khr;
    let (handle, mut count) = (device.driver.functions.handle(), 0);
    // SAFETY: gets the number first, and then that number of images.
    unsafe {
        ask(handle, swapchain, &mut count, std::ptr::null_mut()).result()?;
        let mut images = vec![vk::Image::null(); count as usize];
        ask(handle, swapchain, &mut count, images.as_mut_ptr()).result()?;
        Ok(images)
    }
}

/// `vkGetSwapchainImagesKHR`.
///
/// # Safety
/// Called by the program.
pub unsafe extern "system" fn images(
    handle: vk::Device,
    swapchain: vk::SwapchainKHR,
    count: *mut u32,
    images: *mut vk::Image,
) -> vk::Result {
    let Some(device) = device::get(handle) else { return vk::Result::ERROR_INITIALIZATION_FAILED };
    let Some(managed) = device.swapchains.managed(swapchain) else {
        // SAFETY: the program's own call.
        return unsafe { (device.driver.swapchain.get_swapchain_images_khr)(handle, swapchain, count, images) };
    };
    let managed = managed.locked();
    let all: Vec<vk::Image> = (0..managed.real.len()).filter_map(|index| managed.given(index)).collect();
    // SAFETY: `count` is the program's, and `images` has room for that number of images.
    unsafe {
        if images.is_null() {
            *count = all.len() as u32;
            return vk::Result::SUCCESS;
        }
        let copied = all.len().min(*count as usize);
        std::ptr::copy_nonoverlapping(all.as_ptr(), images, copied);
        *count = copied as u32;
        if copied < all.len() { vk::Result::INCOMPLETE } else { vk::Result::SUCCESS }
    }
}

/// `vkDestroySwapchainKHR`.
///
/// # Safety
/// Called by the program.
pub unsafe extern "system" fn destroy(
    handle: vk::Device,
    swapchain: vk::SwapchainKHR,
    allocator: *const vk::AllocationCallbacks<'_>,
) {
    let Some(device) = device::get(handle) else { return };
    let managed = device.swapchains.all.locked().remove(&swapchain);
    // SAFETY: the program has finished with the swapchain; Cupola's own commands are waited for.
    unsafe {
        (device.driver.swapchain.destroy_swapchain_khr)(handle, swapchain, allocator);
        if let Some(managed) = managed {
            let mut managed = managed.locked();
            managed.real.iter().for_each(|image| device.images.forget_swapchain_image(*image));
            if let Some(mut publishing) = managed.publishing.take() {
                publishing.destroy(&device.driver);
            }
            if let Some(mut stand_in) = managed.stand_in.take() {
                stand_in.destroy(&device);
            }
        }
    }
}
