//! The end of a frame: the picture is corrected, counted, captured and presented.

use super::device::{self, Device};
use super::frame::Frame;
use super::swapchain::{FLAT, Swapchain};
use crate::intercept::kept::{self, Kept};
use crate::intercept::{log, settings};
use crate::runtime::flat::FlatPicture;
use crate::runtime::report::{Picture, Statistics, ViewStatistics};
use ash::{prelude::VkResult, vk};
use std::sync::PoisonError;
use std::sync::atomic::Ordering;

/// `vkQueuePresentKHR`.
///
/// # Safety
/// Called by the program.
pub unsafe extern "system" fn present(queue: vk::Queue, info: *const vk::PresentInfoKHR<'_>) -> vk::Result {
    let Some(device) = device::get(queue) else { return vk::Result::ERROR_INITIALIZATION_FAILED };
    // SAFETY: the program's structure.
    let mut changed = unsafe { *info };
    let (frames, mut ready) = (device.frames.fetch_add(1, Ordering::Relaxed) + 1, Vec::new());
    let settings = settings::settings();
    let last = settings.is_some_and(|settings| settings.frames == Some(frames));
    // SAFETY: the program presents on this queue, so that no other thread uses it.
    let prepared = crate::fence::guard(|| unsafe { prepare(&device, queue, &changed, frames, last, &mut ready) });
    match prepared {
        Some(Ok(())) => {}
        Some(Err(error)) => log::once(&format!("Vulkan: a frame could not be corrected: {error}")),
        None => log::once("Vulkan: a frame could not be corrected after a failure"),
    }
    if !ready.is_empty() {
        // What the program's semaphores stand for, ours were signalled after.
        changed = changed.wait_semaphores(&ready);
    }
    // SAFETY: the program's own call; the structure differs in what is waited for.
    let result = unsafe { (device.swapchain.queue_present_khr)(queue, &changed) };
    if last {
        kept::end_program();
    }
    result
}

/// Corrects each image that is presented; `ready` gets what its presentation has to wait for.
///
/// # Safety
/// As for [`present`].
unsafe fn prepare(
    device: &Device,
    queue: vk::Queue,
    info: &vk::PresentInfoKHR<'_>,
    frames: u64,
    last: bool,
    ready: &mut Vec<vk::Semaphore>,
) -> VkResult<()> {
    let Some(settings) = settings::settings() else { return Ok(()) };
    let keep = (last || settings.frames.is_none())
        && (settings.capture.is_some() || settings.stats.is_some() || settings.capture_views.is_some());
    // SAFETY: the lengths and arrays of the program's structure; empty arrays may be null.
    let (swapchains, indices, mut waits) = unsafe {
        let list = |count: u32| count as usize;
        (
            slice(info.p_swapchains, list(info.swapchain_count)),
            slice(info.p_image_indices, list(info.swapchain_count)),
            slice(info.p_wait_semaphores, list(info.wait_semaphore_count)),
        )
    };
    let family = device.queues.lock().unwrap_or_else(PoisonError::into_inner).get(&queue).copied().unwrap_or(0);
    for (handle, &index) in swapchains.iter().zip(indices) {
        let Some(managed) = device.managed(*handle) else { continue };
        let mut managed = managed.lock().unwrap_or_else(PoisonError::into_inner);
        let pictures = keep && (settings.capture.is_some() || settings.capture_views.is_some());
        if managed.flat.is_some() || pictures {
            // SAFETY: as above.
            unsafe { copy(device, queue, family, &mut managed, index as usize, waits, ready)? };
            // The first copy waited for everything; what follows on the queue comes after it.
            waits = &[];
        }
        if keep {
            let (captures, views) = if pictures { captured(&mut managed, &settings.rig) } else { Default::default() };
            let statistics = settings.stats.is_some().then(|| statistics(device, &managed, &settings.rig.name, frames));
            kept::keep(Kept { statistics, pictures: captures, views });
        }
    }
    Ok(())
}

/// # Safety
/// `pointer` must point at `count` elements, or `count` be 0.
unsafe fn slice<'a, T>(pointer: *const T, count: usize) -> &'a [T] {
    if count == 0 || pointer.is_null() {
        return &[];
    }
    // SAFETY: as promised.
    unsafe { std::slice::from_raw_parts(pointer, count) }
}

/// Gets the program's picture and, where it is corrected, puts the outcome into the real image.
///
/// # Safety
/// As for [`present`].
unsafe fn copy(
    device: &Device,
    queue: vk::Queue,
    family: u32,
    managed: &mut Swapchain,
    index: usize,
    waits: &[vk::Semaphore],
    ready: &mut Vec<vk::Semaphore>,
) -> VkResult<()> {
    let (Some(given), Some(&real)) = (managed.given(index), managed.real.get(index)) else { return Ok(()) };
    let images = managed.real.len();
    // SAFETY: as above; no copy is pending.
    unsafe {
        if managed.frame.as_ref().is_some_and(|frame| frame.family() != family)
            && let Some(old) = managed.frame.take()
        {
            device.functions.device_wait_idle()?;
            old.destroy(device);
        }
        if managed.frame.is_none() {
            managed.frame = Some(Frame::new(device, family, managed.extent, images)?);
        }
        let Some(frame) = &mut managed.frame else { return Ok(()) };
        let Some(signal) = frame.ready(index) else { return Ok(()) };
        match &managed.flat {
            None => frame.read(device, queue, given, waits, Some(signal))?,
            Some(flat) => {
                frame.read(device, queue, given, waits, None)?;
                let (program, window) = frame.pictures();
                flat.draw(program, window);
                frame.write(device, queue, real, &[], signal)?;
            }
        }
        ready.push(signal);
    }
    Ok(())
}

/// The outputs of the frame that was just copied, and the program's own picture.
fn captured(managed: &mut Swapchain, rig: &crate::rig::Rig) -> (Vec<Picture>, Vec<Picture>) {
    let (width, height, blue_first) = (managed.extent.width, managed.extent.height, managed.blue_first);
    let outputs = managed.flat.as_ref().map(FlatPicture::outputs);
    let corrected = outputs.is_some();
    let name = rig.outputs.first().map_or("window", |output| &output.name);
    let outputs = outputs.unwrap_or_else(|| vec![(name.to_owned(), [0, 0, width, height])]);
    let Some(frame) = &mut managed.frame else { return Default::default() };
    let (program, window) = frame.pictures();
    let shown: &[u8] = if corrected { window } else { program };
    let cut = |bytes: &[u8], name: &str, rect: [u32; 4]| picture(bytes, width, blue_first, name, rect);
    let captures = outputs.iter().map(|(name, rect)| cut(shown, name, *rect)).collect();
    (captures, vec![cut(program, "program", [0, 0, width, height])])
}

/// A rectangle (from the top left) of a picture with rows of `stride` pixels from the top.
fn picture(bytes: &[u8], stride: u32, blue_first: bool, name: &str, [x, y, width, height]: [u32; 4]) -> Picture {
    let mut rgba = Vec::with_capacity(width as usize * height as usize * 4);
    for row in (y..y + height).rev() {
        let start = (row as usize * stride as usize + x as usize) * 4;
        for pixel in bytes[start..start + width as usize * 4].chunks_exact(4) {
            let [first, green, third] = [pixel[0], pixel[1], pixel[2]];
            let (red, blue) = if blue_first { (third, first) } else { (first, third) };
            rgba.extend([red, green, blue, 255]);
        }
    }
    Picture { name: name.to_owned(), width, height, rgba }
}

fn statistics(device: &Device, managed: &Swapchain, rig: &str, frames: u64) -> Statistics {
    let vk::Extent2D { width, height } = managed.extent;
    let view = ViewStatistics { name: "program".to_owned(), width, height, ..ViewStatistics::default() };
    Statistics {
        frames,
        rig: rig.to_owned(),
        driver: device.driver.clone(),
        views: vec![view],
        notes: managed.flat.iter().map(|_| FLAT.to_owned()).collect(),
        ..Statistics::default()
    }
}

#[cfg(test)]
mod tests {
    use super::picture;

    #[test]
    fn a_rectangle_is_cut_and_turned() {
        // 2 × 3 pixels, each with its number in every channel but for the order.
        let bytes: Vec<u8> = (0..6).flat_map(|n| [n, 10 + n, 20 + n, 99]).collect();
        let cut = picture(&bytes, 2, true, "a", [1, 1, 1, 2]);
        assert_eq!(cut.rgba, [25, 15, 5, 255, 23, 13, 3, 255], "rows from the bottom, red first");
        assert_eq!(picture(&bytes, 2, false, "a", [0, 0, 1, 1]).rgba, [0, 10, 20, 255]);
    }
}
