//! Finished pictures for other processes: which pictures of a frame are read, and when.

use crate::error::{Error, ErrorKind, Result};
use crate::intercept::process::publishing;
use crate::intercept::vk::state::device::Device;
use crate::intercept::vk::state::driver::Queue;
use crate::intercept::vk::state::swapchains::Swapchain;
use crate::intercept::vk::state::swapchains::publishing::Publishing;
use crate::intercept::vk::swapchain::images::deep_format;
use ash::vk;
use std::sync::Arc;

/// Reads the pictures of the frame that was just made in image `index`, after `waits`, and
/// publishes pictures that were read earlier. Returns the semaphore that the presentation has to
/// wait for.
///
/// # Errors
/// The driver's.
///
/// # Safety
/// No other thread may use the queue or present this swapchain; the submissions to the queue, and
/// `waits`, leave the image ready to be presented.
pub unsafe fn frame(
    device: &Device,
    queue: Queue,
    managed: &mut Swapchain,
    index: usize,
    waits: &[vk::Semaphore],
    number: u64,
) -> Result<Option<vk::Semaphore>> {
    let Some(&image) = managed.real.get(index).filter(|_| !managed.failed) else { return Ok(None) };
    let refused = |result: vk::Result| Error::new(ErrorKind::Graphics, result.to_string());
    let layout = managed.stand_in.as_ref().map(|stand_in| &stand_in.layout);
    let fits = |known: &Publishing| {
        known.layout.as_ref().map(Arc::as_ptr) == layout.map(Arc::as_ptr) && known.family == queue.family
    };
    if !managed.publishing.as_ref().is_some_and(fits) {
        // SAFETY: as promised. Presentations may still wait for the old semaphores until the device
        // is idle.
        unsafe {
            if let Some(mut old) = managed.publishing.take() {
                device.driver.functions.device_wait_idle().map_err(refused)?;
                old.destroy(&device.driver);
            }
            managed.publishing = Some(new(device, queue, managed).map_err(refused)?);
        }
    }
    let Some(publishing) = &mut managed.publishing else { return Ok(None) };
    publishing.publish(&device.driver, false);
    let beside = managed.stand_in.as_ref().map_or(&[][..], |stand_in| &stand_in.beside_images);
    let stamp = publishing::stamp(number, managed.shown);
    // SAFETY: as promised.
    let copied = unsafe { publishing.read(&device.driver, queue, (index, image, beside), waits, stamp) };
    let copied = copied.map_err(refused)?;
    if publishing::waits() {
        publishing.publish(&device.driver, true);
    }
    Ok(copied)
}

/// Makes the reader of the pictures for the current window.
///
/// # Safety
/// The device must be live.
unsafe fn new(device: &Device, queue: Queue, managed: &Swapchain) -> ash::prelude::VkResult<Publishing> {
    let whole = |(width, height)| vk::Rect2D { extent: vk::Extent2D { width, height }, ..Default::default() };
    let size = (managed.extent.width, managed.extent.height);
    let (images, format) = (managed.real.len(), managed.texel_format);
    let Some(stand_in) = &managed.stand_in else {
        let window = std::iter::once(("window".to_owned(), None, whole(size)));
        // SAFETY: as promised.
        return unsafe { Publishing::new(&device.driver, (None, queue.family, format), images, window) };
    };
    let rig = stand_in.layout.session.rig();
    let places = rig.layout(size);
    // The last image outside of the window is the window itself in 16 bits.
    let deep = stand_in.deep().map(|_| stand_in.beside.len());
    let format = match deep.and_then(|_| deep_format(&device.driver.api, stand_in.format)) {
        Some((_, deep)) => deep,
        None => format,
    };
    let shown = rig.published_outputs().map(|index| {
        let place = places[index];
        let offset = vk::Offset2D { x: place.x as i32, y: place.y as i32 };
        let extent = vk::Extent2D { width: place.width, height: place.height };
        (rig.outputs[index].name.clone(), deep, vk::Rect2D { offset, extent })
    });
    let beside = rig.beside.iter().enumerate().take(stand_in.beside.len());
    let beside =
        beside.map(|(number, output)| (output.name.clone(), Some(number), whole(output.size.unwrap_or_default())));
    let layout = Some(Arc::clone(&stand_in.layout));
    // SAFETY: as promised.
    unsafe { Publishing::new(&device.driver, (layout, queue.family, format), images, shown.chain(beside)) }
}
