//! Images of Cupola, and barriers for them.

use crate::backend::vk::{COLOR, Use};
use crate::intercept::vk::state::driver::Driver;
use ash::prelude::VkResult;
use ash::vk;

/// An image with memory of its own.
#[derive(Clone, Copy)]
pub struct OwnImage {
    /// The image.
    pub image: vk::Image,
    memory: vk::DeviceMemory,
}

impl OwnImage {
    /// Makes an image in the device's memory.
    ///
    /// # Errors
    /// The driver's.
    ///
    /// # Safety
    /// The device must be live, `info` valid.
    pub unsafe fn new(driver: &Driver, info: &vk::ImageCreateInfo<'_>) -> VkResult<Self> {
        let functions = &driver.functions;
        // SAFETY: makes objects of Cupola; what was made before a failure is destroyed.
        unsafe {
            let image = functions.create_image(info, None)?;
            let needs = functions.get_image_memory_requirements(image);
            let kind = driver.memory_type(needs.memory_type_bits, vk::MemoryPropertyFlags::DEVICE_LOCAL).unwrap_or(0);
            let allocation = vk::MemoryAllocateInfo::default().allocation_size(needs.size).memory_type_index(kind);
            let memory =
                functions.allocate_memory(&allocation, None).inspect_err(|_| functions.destroy_image(image, None))?;
            let own = Self { image, memory };
            functions.bind_image_memory(image, memory, 0).inspect_err(|_| own.destroy(driver))?;
            Ok(own)
        }
    }

    /// A view of its colour.
    ///
    /// # Errors
    /// The driver's.
    ///
    /// # Safety
    /// The device must be live, the format one that the image can be seen with.
    pub unsafe fn view(
        &self,
        driver: &Driver,
        format: vk::Format,
        components: vk::ComponentMapping,
    ) -> VkResult<vk::ImageView> {
        // SAFETY: as promised.
        unsafe { color_view(driver, self.image, format, components) }
    }

    /// # Safety
    /// The device must have finished with it.
    pub unsafe fn destroy(&self, driver: &Driver) {
        // SAFETY: as promised; both are ours.
        unsafe {
            driver.functions.destroy_image(self.image, None);
            driver.functions.free_memory(self.memory, None);
        }
    }
}

/// A view of the colour of any image.
///
/// # Errors
/// The driver's.
///
/// # Safety
/// As for [`OwnImage::view`].
pub unsafe fn color_view(
    driver: &Driver,
    image: vk::Image,
    format: vk::Format,
    components: vk::ComponentMapping,
) -> VkResult<vk::ImageView> {
    let info = vk::ImageViewCreateInfo::default()
        .image(image)
        .view_type(vk::ImageViewType::TYPE_2D)
        .format(format)
        .components(components)
        .subresource_range(COLOR);
    // SAFETY: as promised.
    unsafe { driver.functions.create_image_view(&info, None) }
}

/// The colour of the first level and layer, for copies.
pub const COLOR_LAYER: vk::ImageSubresourceLayers = vk::ImageSubresourceLayers {
    aspect_mask: vk::ImageAspectFlags::COLOR,
    mip_level: 0,
    base_array_layer: 0,
    layer_count: 1,
};

/// A use in all stages.
const fn at_any_time(layout: vk::ImageLayout, access: vk::AccessFlags) -> Use {
    Use { layout, stages: vk::PipelineStageFlags::ALL_COMMANDS, access }
}

/// Any former content; it is lost.
pub const ANYTHING: Use = at_any_time(vk::ImageLayout::UNDEFINED, vk::AccessFlags::empty());
/// As an image is that will be presented, after whatever wrote it.
pub const PRESENTED: Use = left_in(vk::ImageLayout::PRESENT_SRC_KHR);
/// A copy reads it.
pub const COPIED_FROM: Use = at_any_time(vk::ImageLayout::TRANSFER_SRC_OPTIMAL, vk::AccessFlags::TRANSFER_READ);
/// A copy or a clear writes it.
pub const COPIED_TO: Use = at_any_time(vk::ImageLayout::TRANSFER_DST_OPTIMAL, vk::AccessFlags::TRANSFER_WRITE);

/// Whatever wrote it left it in this layout.
pub const fn left_in(layout: vk::ImageLayout) -> Use {
    at_any_time(layout, vk::AccessFlags::MEMORY_WRITE)
}

/// Whatever reads or writes it next finds it in this layout.
pub const fn ready_in(layout: vk::ImageLayout) -> Use {
    let access = vk::AccessFlags::MEMORY_READ.as_raw() | vk::AccessFlags::MEMORY_WRITE.as_raw();
    at_any_time(layout, vk::AccessFlags::from_raw(access))
}

/// Takes these aspects of an image from a use to another.
///
/// # Safety
/// As for [`barrier`].
pub unsafe fn barrier_of(
    driver: &Driver,
    buffer: vk::CommandBuffer,
    (image, aspects): (vk::Image, vk::ImageAspectFlags),
    from: Use,
    to: Use,
) {
    let change = vk::ImageMemoryBarrier::default()
        .image(image)
        .old_layout(from.layout)
        .new_layout(to.layout)
        .src_access_mask(from.access)
        .dst_access_mask(to.access)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .subresource_range(vk::ImageSubresourceRange { aspect_mask: aspects, ..COLOR });
    let flags = vk::DependencyFlags::empty();
    // SAFETY: as promised.
    unsafe { driver.functions.cmd_pipeline_barrier(buffer, from.stages, to.stages, flags, &[], &[], &[change]) };
}

/// Takes an image's colour from a use to another.
///
/// # Safety
/// The image must be in that layout, the command buffer being recorded outside a render pass.
pub unsafe fn barrier(driver: &Driver, buffer: vk::CommandBuffer, image: vk::Image, from: Use, to: Use) {
    // SAFETY: as promised.
    unsafe { crate::backend::vk::barrier(&driver.functions, buffer, (image, 1), from, to) };
}
