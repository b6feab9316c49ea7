//! Images that Cupola makes for a swapchain.

use crate::backend::vk::Api;
use crate::error::{Error, ErrorKind};
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::own_image::OwnImage;
use crate::intercept::vk::state::swapchains::formats::TexelFormat;
use crate::intercept::vk::state::views::view_target::{ATLAS_FLAGS, ATLAS_USAGE};
use ash::vk;

/// Returns the error for an object that the driver refuses.
pub(super) fn refused(what: &str) -> impl Fn(vk::Result) -> Error + '_ {
    move |result| Error::new(ErrorKind::Graphics, format!("the driver refuses {what}: {result}"))
}

/// Returns the format with the same bits but without conversion of values.
pub(super) fn plain_format(format: vk::Format) -> vk::Format {
    match format {
        vk::Format::B8G8R8A8_SRGB => vk::Format::B8G8R8A8_UNORM,
        vk::Format::R8G8B8A8_SRGB => vk::Format::R8G8B8A8_UNORM,
        vk::Format::A8B8G8R8_SRGB_PACK32 => vk::Format::A8B8G8R8_UNORM_PACK32,
        other => other,
    }
}

/// Returns the description of an image like those of the swapchain, in `size`.
fn like<'a>(info: &vk::SwapchainCreateInfoKHR<'a>, (width, height): (u32, u32)) -> vk::ImageCreateInfo<'a> {
    let mut image = vk::ImageCreateInfo::default()
        .image_type(vk::ImageType::TYPE_2D)
        .format(info.image_format)
        .extent(vk::Extent3D { width, height, depth: 1 })
        .mip_levels(1)
        .array_layers(1)
        .samples(vk::SampleCountFlags::TYPE_1)
        .tiling(vk::ImageTiling::OPTIMAL)
        .sharing_mode(info.image_sharing_mode);
    image.queue_family_index_count = info.queue_family_index_count;
    image.p_queue_family_indices = info.p_queue_family_indices;
    image
}

/// Makes an image for the program in place of a real one.
///
/// # Safety
/// The device must be live.
pub(super) unsafe fn program_image(
    device: &Device,
    info: &vk::SwapchainCreateInfoKHR<'_>,
) -> ash::prelude::VkResult<OwnImage> {
    let mutable = info.flags.contains(vk::SwapchainCreateFlagsKHR::MUTABLE_FORMAT);
    let flags = vk::ImageCreateFlags::MUTABLE_FORMAT | vk::ImageCreateFlags::EXTENDED_USAGE;
    let image = like(info, (info.image_extent.width, info.image_extent.height))
        .flags(if mutable { flags } else { vk::ImageCreateFlags::empty() })
        .usage(info.image_usage | vk::ImageUsageFlags::TRANSFER_SRC);
    // SAFETY: as promised.
    unsafe { OwnImage::new(&device.driver, &image) }
}

/// Makes an image for the views. The program's render passes can draw into it, and the correction
/// reads it.
///
/// # Safety
/// The device must be live.
pub(super) unsafe fn atlas_image(
    device: &Device,
    info: &vk::SwapchainCreateInfoKHR<'_>,
    size: (u32, u32),
) -> ash::prelude::VkResult<OwnImage> {
    let image = like(info, size).flags(ATLAS_FLAGS).usage(ATLAS_USAGE);
    // SAFETY: as promised.
    unsafe { OwnImage::new(&device.driver, &image) }
}

/// Uses of [`own_target`].
const OWN_TARGET_USAGE: vk::ImageUsageFlags = vk::ImageUsageFlags::from_raw(
    vk::ImageUsageFlags::COLOR_ATTACHMENT.as_raw()
        | vk::ImageUsageFlags::TRANSFER_SRC.as_raw()
        | vk::ImageUsageFlags::TRANSFER_DST.as_raw(),
);

/// Returns the format of 16 bits for published pictures of windows of `format`, with the layout of
/// its texels; `None` if the device does not convert between the two.
pub(super) fn deep_format(api: &Api, format: vk::Format) -> Option<(vk::Format, TexelFormat)> {
    use vk::FormatFeatureFlags as Feature;
    let converted = Feature::BLIT_SRC | Feature::BLIT_DST;
    let drawn = converted | Feature::COLOR_ATTACHMENT | Feature::COLOR_ATTACHMENT_BLEND;
    let formats =
        [(vk::Format::R16G16B16A16_UNORM, TexelFormat::Rgba16), (vk::Format::R16G16B16A16_SFLOAT, TexelFormat::Half)];
    let is_converted = api.features(plain_format(format)).contains(converted);
    formats.into_iter().find(|(deep, _)| is_converted && api.features(*deep).contains(drawn))
}

/// Makes an image that the correction draws to, and that is then copied.
///
/// # Safety
/// The device must be live.
pub(super) unsafe fn own_target(
    device: &Device,
    format: vk::Format,
    vk::Extent2D { width, height }: vk::Extent2D,
) -> ash::prelude::VkResult<OwnImage> {
    let image = vk::ImageCreateInfo::default()
        .image_type(vk::ImageType::TYPE_2D)
        .format(format)
        .extent(vk::Extent3D { width, height, depth: 1 })
        .mip_levels(1)
        .array_layers(1)
        .samples(vk::SampleCountFlags::TYPE_1)
        .usage(OWN_TARGET_USAGE);
    // SAFETY: as promised.
    unsafe { OwnImage::new(&device.driver, &image) }
}
