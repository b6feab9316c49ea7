//! Images of Cupola, and barriers for them.

use crate::backend::vk::{COLOR, Use};
use crate::intercept::vk::state::driver::Driver;
use ash::prelude::VkResult;
use ash::vk;

/// An image with its own memory.
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
        // SAFETY: makes objects of Cupola; after a failure, the objects made so far are destroyed.
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

    /// Makes a view of its colour.
    ///
    /// # Errors
    /// The driver's.
    ///
    /// # Safety
    /// The device must be live, the format compatible with the image.
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
        // SAFETY: as promised; both are objects of Cupola.
        unsafe {
            driver.functions.destroy_image(self.image, None);
            driver.functions.free_memory(self.memory, None);
        }
    }
}

/// Makes a view of the colour of any image.
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

/// Any earlier content, which is lost.
pub const ANYTHING: Use = at_any_time(vk::ImageLayout::UNDEFINED, vk::AccessFlags::empty());
/// Layout for presentation, after any writes.
pub const PRESENTED: Use = left_in(vk::ImageLayout::PRESENT_SRC_KHR);
/// Read by a copy.
pub const COPIED_FROM: Use = at_any_time(vk::ImageLayout::TRANSFER_SRC_OPTIMAL, vk::AccessFlags::TRANSFER_READ);
/// Written by a copy or a clear.
pub const COPIED_TO: Use = at_any_time(vk::ImageLayout::TRANSFER_DST_OPTIMAL, vk::AccessFlags::TRANSFER_WRITE);

/// Returns the use after any writes that left the image in this layout.
pub const fn left_in(layout: vk::ImageLayout) -> Use {
    at_any_time(layout, vk::AccessFlags::MEMORY_WRITE)
}

/// Returns the use before any reads or writes that expect this layout.
pub const fn ready_in(layout: vk::ImageLayout) -> Use {
    let access = vk::AccessFlags::MEMORY_READ.as_raw() | vk::AccessFlags::MEMORY_WRITE.as_raw();
    at_any_time(layout, vk::AccessFlags::from_raw(access))
}

/// Changes these aspects of an image from one use to another.
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

/// Changes an image's colour from one use to another.
///
/// # Safety
/// The image must be in the layout of `from`; the command buffer is being recorded, outside of a
/// render pass.
pub unsafe fn barrier(driver: &Driver, buffer: vk::CommandBuffer, image: vk::Image, from: Use, to: Use) {
    // SAFETY: as promised.
    unsafe { crate::backend::vk::barrier(&driver.functions, buffer, (image, 1), from, to) };
}
