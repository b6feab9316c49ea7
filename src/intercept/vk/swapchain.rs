//! Swapchains: the program draws into images of ours; the real ones get the corrected picture.

use super::device::{self, Device};
use super::frame::Frame;
use crate::intercept::{log, settings};
use crate::runtime::flat::FlatPicture;
use ash::{prelude::VkResult, vk};
use std::sync::{Arc, Mutex, PoisonError};

/// A swapchain of the program.
pub struct Swapchain {
    /// Size of its images.
    pub extent: vk::Extent2D,
    /// Blue comes first in memory.
    pub blue_first: bool,
    /// The real images.
    pub real: Vec<vk::Image>,
    /// The images that the program has in their place; empty where it has the real ones.
    own: Vec<(vk::Image, vk::DeviceMemory)>,
    /// What becomes of the program's picture; `None`: it is shown as it is.
    pub flat: Option<FlatPicture>,
    /// For copies; made at the first one.
    pub frame: Option<Frame>,
}

impl Swapchain {
    /// The image that the program has as number `index`.
    pub fn given(&self, index: usize) -> Option<vk::Image> {
        if self.own.is_empty() { self.real.get(index).copied() } else { self.own.get(index).map(|own| own.0) }
    }

    /// # Safety
    /// The device must have finished with everything.
    unsafe fn destroy(&mut self, device: &Device) {
        // SAFETY: as promised.
        unsafe {
            for (image, memory) in self.own.drain(..) {
                device.functions.destroy_image(image, None);
                device.functions.free_memory(memory, None);
            }
            if let Some(frame) = self.frame.take() {
                frame.destroy(device);
            }
        }
    }
}

/// Whether the pixels have four bytes with one colour each, and whether blue comes first.
fn blue_first(format: vk::Format) -> Option<bool> {
    match format {
        vk::Format::B8G8R8A8_UNORM | vk::Format::B8G8R8A8_SRGB => Some(true),
        vk::Format::R8G8B8A8_UNORM
        | vk::Format::R8G8B8A8_SRGB
        | vk::Format::A8B8G8R8_UNORM_PACK32
        | vk::Format::A8B8G8R8_SRGB_PACK32 => Some(cfg!(target_endian = "big")),
        _ => None,
    }
}

/// Why a swapchain is left alone.
fn obstacle(info: &vk::SwapchainCreateInfoKHR<'_>) -> Option<String> {
    if blue_first(info.image_format).is_none() {
        return Some(format!("images of VkFormat {}; supported are 8-bit RGBA and BGRA", info.image_format.as_raw()));
    }
    if info.image_array_layers != 1 || info.flags.contains(vk::SwapchainCreateFlagsKHR::PROTECTED) {
        return Some("layered or protected images".to_owned());
    }
    let shared = [vk::PresentModeKHR::SHARED_DEMAND_REFRESH, vk::PresentModeKHR::SHARED_CONTINUOUS_REFRESH];
    shared.contains(&info.present_mode).then(|| "images that are shown while they are drawn".to_owned())
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
    // SAFETY: the program's own call; the structure differs in its usage only.
    let next = |info: &vk::SwapchainCreateInfoKHR<'_>| unsafe {
        (device.swapchain.create_swapchain_khr)(handle, info, allocator, swapchain)
    };
    let Some(settings) = settings::settings().filter(|_| device.active) else { return next(given) };
    if let Some(why) = obstacle(given) {
        log::once(&format!("Vulkan: a window keeps the program's own picture: {why}"));
        return next(given);
    }
    let passthrough = settings.rig.passthrough;
    let mut changed = *given;
    changed.image_usage |= match passthrough {
        true if settings.capture.is_some() => vk::ImageUsageFlags::TRANSFER_SRC,
        true => vk::ImageUsageFlags::empty(),
        false => vk::ImageUsageFlags::TRANSFER_DST,
    };
    let result = next(&changed);
    if result != vk::Result::SUCCESS {
        return result;
    }
    // SAFETY: the driver has just made it.
    let made = unsafe { *swapchain };
    let size = (given.image_extent.width, given.image_extent.height);
    let built = crate::fence::guard(|| {
        let flat = if passthrough { None } else { Some(FlatPicture::new(&settings.rig, size)?) };
        // SAFETY: objects of a live device.
        unsafe { build(&device, made, given, flat) }.map_err(|error| {
            crate::Error::new(crate::ErrorKind::Graphics, format!("the driver refuses images in its place: {error}"))
        })
    });
    match built {
        Some(Ok(built)) => {
            let mut all = device.swapchains.lock().unwrap_or_else(PoisonError::into_inner);
            all.insert(made, Arc::new(Mutex::new(built)));
            if !passthrough {
                log::once(FLAT);
            }
        }
        Some(Err(error)) => log::once(&format!("Vulkan: a window keeps the program's own picture: {}", error.message)),
        None => log::once("Vulkan: a window keeps the program's own picture after a failure"),
    }
    vk::Result::SUCCESS
}

/// What the log and the statistics say of a Vulkan program.
pub const FLAT: &str =
    "Vulkan: the program's picture is shown flat, on the panel; its draws are not issued for each view";

/// # Safety
/// The swapchain must have just been made on the device.
unsafe fn build(
    device: &Device,
    swapchain: vk::SwapchainKHR,
    info: &vk::SwapchainCreateInfoKHR<'_>,
    flat: Option<FlatPicture>,
) -> VkResult<Swapchain> {
    // SAFETY: as promised.
    unsafe {
        let mut built = Swapchain {
            extent: info.image_extent,
            blue_first: blue_first(info.image_format).unwrap_or_default(),
            real: real_images(device, swapchain)?,
            own: Vec::new(),
            flat,
            frame: None,
        };
        if built.flat.is_some() {
            for _ in 0..built.real.len() {
                match own_image(device, info) {
                    Ok(own) => built.own.push(own),
                    Err(error) => {
                        built.destroy(device);
                        return Err(error);
                    }
                }
            }
        }
        Ok(built)
    }
}

/// # Safety
/// The swapchain must belong to the device.
unsafe fn real_images(device: &Device, swapchain: vk::SwapchainKHR) -> VkResult<Vec<vk::Image>> {
    let ask = device.swapchain.get_swapchain_images_khr;
    let (handle, mut count) = (device.functions.handle(), 0);
    // SAFETY: asks for the number, then for as many.
    unsafe {
        ask(handle, swapchain, &mut count, std::ptr::null_mut()).result()?;
        let mut images = vec![vk::Image::null(); count as usize];
        ask(handle, swapchain, &mut count, images.as_mut_ptr()).result()?;
        Ok(images)
    }
}

/// An image for the program in the place of a real one.
///
/// # Safety
/// The device must be live.
unsafe fn own_image(device: &Device, info: &vk::SwapchainCreateInfoKHR<'_>) -> VkResult<(vk::Image, vk::DeviceMemory)> {
    let functions = &device.functions;
    let flags = if info.flags.contains(vk::SwapchainCreateFlagsKHR::MUTABLE_FORMAT) {
        vk::ImageCreateFlags::MUTABLE_FORMAT | vk::ImageCreateFlags::EXTENDED_USAGE
    } else {
        vk::ImageCreateFlags::empty()
    };
    let vk::Extent2D { width, height } = info.image_extent;
    let mut image = vk::ImageCreateInfo::default()
        .flags(flags)
        .image_type(vk::ImageType::TYPE_2D)
        .format(info.image_format)
        .extent(vk::Extent3D { width, height, depth: 1 })
        .mip_levels(1)
        .array_layers(1)
        .samples(vk::SampleCountFlags::TYPE_1)
        .tiling(vk::ImageTiling::OPTIMAL)
        .usage(info.image_usage | vk::ImageUsageFlags::TRANSFER_SRC)
        .sharing_mode(info.image_sharing_mode);
    image.queue_family_index_count = info.queue_family_index_count;
    image.p_queue_family_indices = info.p_queue_family_indices;
    // SAFETY: makes objects of ours; what was made before a failure is destroyed.
    unsafe {
        let image = functions.create_image(&image, None)?;
        let needs = functions.get_image_memory_requirements(image);
        let kind = device.memory_type(needs.memory_type_bits, vk::MemoryPropertyFlags::DEVICE_LOCAL).unwrap_or(0);
        let allocation = vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(kind);
        let memory =
            functions.allocate_memory(&allocation, None).inspect_err(|_| functions.destroy_image(image, None))?;
        match functions.bind_image_memory(image, memory, 0) {
            Ok(()) => Ok((image, memory)),
            Err(error) => {
                functions.destroy_image(image, None);
                functions.free_memory(memory, None);
                Err(error)
            }
        }
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
    let Some(managed) = device.managed(swapchain) else {
        // SAFETY: the program's own call.
        return unsafe { (device.swapchain.get_swapchain_images_khr)(handle, swapchain, count, images) };
    };
    let managed = managed.lock().unwrap_or_else(PoisonError::into_inner);
    let all: Vec<vk::Image> = (0..managed.real.len()).filter_map(|index| managed.given(index)).collect();
    // SAFETY: `count` is the program's, and `images` has room for as many as it says.
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
    let managed = device.swapchains.lock().unwrap_or_else(PoisonError::into_inner).remove(&swapchain);
    // SAFETY: the program has finished with the swapchain, and each copy of ours was waited for.
    unsafe {
        (device.swapchain.destroy_swapchain_khr)(handle, swapchain, allocator);
        if let Some(managed) = managed {
            managed.lock().unwrap_or_else(PoisonError::into_inner).destroy(&device);
        }
    }
}
