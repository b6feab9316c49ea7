//! Vulkan: a program draws the views into images, and has the correction recorded into its command
//! buffers.

pub mod images;
pub mod projection;
pub mod types;

use self::types::*;
use super::argument::{Place, null};
use super::handle::Handle;
use super::rig::cupola_rig;
use super::sized::{self, SizedPlace};
use super::status::{call, cupola_status};
use super::view::{Matrices, name_of};
use crate::backend::vk::ash::vk::Handle as _;
use crate::backend::vk::{Api, Recording};
use crate::correct::{Arrangement, UpperLeftRect};
use crate::error::{Error, ErrorKind, Result};
use crate::rig::Rig;
use crate::runtime::embedded::vulkan::{EmbeddedVulkan, VulkanOptions};

/// A rig on a Vulkan device. Created by `cupola_vk_create` or `cupola_vk_create_projecting`,
/// destroyed by `cupola_vk_destroy` before the device is.
///
/// One thread at a time may use it. Several objects, on one device too, are independent.
///
/// Synchronisation: the library submits nothing and uses no queue. `cupola_vk_record` records
/// barriers before and after the correction, so that nothing else is needed within one queue;
/// between queues, and with a swapchain, the program's semaphores and fences are the same as
/// without Cupola. The images of a frame may be drawn again when the fence of the submission that
/// read them is signalled; this is what `frames_in_flight` is for. Images belong to the queue
/// family of the options (`VK_SHARING_MODE_EXCLUSIVE`) or are shared by all.
///
/// "Idle" at a function means: no command buffer into which `cupola_vk_record` recorded is pending,
/// and none will be submitted again.
///
/// The first command buffer that is recorded after `cupola_vk_create` or `cupola_vk_resize` fills
/// masks and tables: it has to be submitted before the others, and once.
pub struct cupola_vk {
    embedded: EmbeddedVulkan,
}

impl Handle for cupola_vk {
    const NAME: &'static str = "vk";
}

fn options_of(options: &cupola_vk_options) -> Result<VulkanOptions> {
    let arrangement = match options.arrangement {
        CUPOLA_VK_ATLAS => Arrangement::Atlas,
        CUPOLA_VK_LAYERS => Arrangement::Layers,
        CUPOLA_VK_IMAGES => Arrangement::Images,
        other => {
            let message = format!("`options.arrangement` is {other}; expected one of CUPOLA_VK_ATLAS, …");
            return Err(Error::new(ErrorKind::InvalidArgument, message));
        }
    };
    Ok(VulkanOptions {
        size: (options.width, options.height),
        queue_family: options.queue_family,
        frames: options.frames_in_flight as usize,
        target_format: options.target_format,
        view_format: options.view_format,
        arrangement,
        reversed_depth: options.reversed_depth != 0,
    })
}

/// Plans the views of a rig and creates what they need on the program's device.
///
/// # Parameters
/// - `rig`: the rig. The library copies what it needs; the rig may be freed afterwards.
/// - `options`: device, sizes and formats. Not kept; the handles in it are.
/// - `vk`: receives the new object, on success only.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: a null pointer or handle, a value out of range, an sRGB format, a
///   field that this version does not know, or a rig that corrects nothing (`identity`).
/// - `CUPOLA_GRAPHICS`: the device cannot use a format, lacks a function or has no memory left.
///
/// # Ownership
/// The caller owns `*vk` and destroys it with `cupola_vk_destroy`.
///
/// # Threads
/// Any thread.
///
/// # Safety
/// `rig` is a live handle; `options` points to `options->struct_size` bytes, whose handles are live
/// and belong together; `vk` is writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_vk_create(
    rig: *const cupola_rig,
    options: *const cupola_vk_options,
    vk: *mut *mut cupola_vk,
) -> cupola_status {
    // SAFETY: as this function's contract.
    call(|| unsafe { create(rig, options, vk, EmbeddedVulkan::new) })
}

/// Creates a handle; `plan` plans the views.
///
/// # Safety
/// As for `cupola_vk_create`.
unsafe fn create(
    rig: *const cupola_rig,
    options: *const cupola_vk_options,
    vk: *mut *mut cupola_vk,
    plan: fn(Api, &Rig, VulkanOptions) -> Result<EmbeddedVulkan>,
) -> Result<()> {
    // SAFETY: as this function's contract.
    let (rig, options, vk) =
        unsafe { (cupola_rig::borrow(rig)?, sized::read(options, "options")?, Place::new(vk, "vk")?) };
    let find = options.get_instance_proc_addr.ok_or_else(|| null("options.get_instance_proc_addr"))?;
    let wanted = options_of(&options)?;
    // SAFETY: live handles that belong together, by this function's contract.
    let api = unsafe { Api::from_handles(find, options.instance, options.physical_device, options.device) }?;
    let api = api.with_cache(crate::runtime::cache::of_process());
    cupola_vk { embedded: plan(api, &rig.rig, wanted)? }.give(vk);
    Ok(())
}

/// Plans the views again for a picture of another size. Number and sizes of views and images may
/// change. Sources and targets that the program set are forgotten, and the library's own images are
/// created again.
///
/// # Parameters
/// - `vk`: the object, idle.
/// - `width`, `height`: size of the picture in pixels, 1 to 16384.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: `vk` is null, or the size is out of range. Everything stays.
/// - `CUPOLA_GRAPHICS`: the driver refused a request. Only another `cupola_vk_resize` or
///   `cupola_vk_destroy` is useful afterwards.
///
/// # Threads
/// Any thread.
///
/// # Safety
/// `vk` is a live handle and idle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_vk_resize(vk: *mut cupola_vk, width: u32, height: u32) -> cupola_status {
    // SAFETY: as this function's contract.
    call(|| unsafe { cupola_vk::borrow_mut(vk) }?.embedded.resize((width, height)))
}

/// Returns the number of views. Only `cupola_vk_resize` changes it.
///
/// # Parameters
/// - `vk`: the object.
/// - `count`: receives the number, at least 1.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: a null pointer.
///
/// # Threads
/// Any thread.
///
/// # Safety
/// `vk` is a live handle; `count` is writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_vk_view_count(vk: *mut cupola_vk, count: *mut u32) -> cupola_status {
    call(|| {
        // SAFETY: as this function's contract.
        let (vk, count) = unsafe { (cupola_vk::borrow(vk)?, Place::new(count, "count")?) };
        count.set(vk.embedded.view_count() as u32);
        Ok(())
    })
}

/// Describes a view, for a camera with the given near and far planes.
///
/// # Parameters
/// - `vk`: the object.
/// - `index`: index of the view, less than the number that `cupola_vk_view_count` returns.
/// - `near`, `far`: distances of the planes in the program's units, 0 < near < far. `far` may be
///   infinite.
/// - `view`: receives the description. The caller sets `view->struct_size` before.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: a null pointer, a wrong `struct_size`, an index without a view, or
///   wrong planes.
///
/// # Threads
/// Any thread.
///
/// # Safety
/// `vk` is a live handle; `view` points to `view->struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_vk_get_view(
    vk: *mut cupola_vk,
    index: u32,
    near: f64,
    far: f64,
    view: *mut cupola_vk_view,
) -> cupola_status {
    call(|| {
        // SAFETY: as this function's contract.
        let (vk, view) = unsafe { (cupola_vk::borrow(vk)?, SizedPlace::new(view, "view")?) };
        let found = vk.embedded.view(index as usize, near, far)?;
        let UpperLeftRect { x, y, width, height } = found.tile;
        let matrices = Matrices::new(found.frustum, found.rotation);
        view.set(&cupola_vk_view {
            struct_size: size_of::<cupola_vk_view>(),
            index,
            image: found.image as u32,
            layer: found.layer as u32,
            x,
            y,
            width,
            height,
            projection_matrix: matrices.projection,
            rotation_matrix: matrices.rotation,
            frustum_matrix: matrices.frustum,
            projection_matrix_f64: matrices.projection_f64,
            rotation_matrix_f64: matrices.rotation_f64,
            frustum_matrix_f64: matrices.frustum_f64,
            name: name_of(&found.name),
        });
        Ok(())
    })
}

/// Records the correction of a frame into a command buffer. On an error nothing is recorded. No
/// Vulkan object is created and no device memory allocated.
///
/// Bound pipelines, descriptor sets, vertex buffers, viewports and scissors are undefined
/// afterwards.
///
/// # Parameters
/// - `vk`: the object.
/// - `command_buffer`: primary command buffer in the recording state, outside a render pass, for a
///   queue of the options' family.
/// - `frame`: index of the frame in flight whose sources are read, less than `frames_in_flight`.
/// - `target`: index of the target, as set with `cupola_vk_set_targets`.
/// - `x`, `y`: upper left corner of the picture in the target, in pixels. Parts outside are cut
///   off.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: a null pointer or handle, or a frame or target that was not set.
///
/// # Threads
/// Any thread that may use the command buffer's pool.
///
/// # Safety
/// `vk` and `command_buffer` are live handles; when the command buffer is executed, all images are
/// in the layouts that were given for them.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_vk_record(
    vk: *mut cupola_vk,
    command_buffer: VkCommandBuffer,
    frame: u32,
    target: u32,
    x: i32,
    y: i32,
) -> cupola_status {
    call(|| {
        // SAFETY: as this function's contract.
        let vk = unsafe { cupola_vk::borrow_mut(vk) }?;
        if command_buffer.is_null() {
            return Err(null("command_buffer"));
        }
        // SAFETY: a live command buffer that is being recorded, by this function's contract.
        let recording = unsafe { Recording::new(command_buffer) };
        vk.embedded.record(&recording, frame as usize, target as usize, (x, y))
    })
}

/// Returns counts since the creation of the object.
///
/// # Parameters
/// - `vk`: the object.
/// - `statistics`: receives the counts. The caller sets `statistics->struct_size` before.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: a null pointer, or a wrong `struct_size`.
///
/// # Threads
/// Any thread.
///
/// # Safety
/// `vk` is a live handle; `statistics` points to `statistics->struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_vk_get_statistics(
    vk: *mut cupola_vk,
    statistics: *mut cupola_vk_statistics,
) -> cupola_status {
    call(|| {
        // SAFETY: as this function's contract.
        let (vk, statistics) = unsafe { (cupola_vk::borrow(vk)?, SizedPlace::new(statistics, "statistics")?) };
        let timing = vk.embedded.timing();
        statistics.set(&cupola_vk_statistics {
            struct_size: size_of::<cupola_vk_statistics>(),
            frames: vk.embedded.frames(),
            measured_frames: timing.corrections,
            nanoseconds: timing.total as u64,
            last_nanoseconds: timing.last as u64,
        });
        Ok(())
    })
}

/// Destroys an object and everything that it created on the device.
///
/// # Parameters
/// - `vk`: the object, idle, or null, which does nothing.
///
/// # Returns
/// `CUPOLA_OK`, or `CUPOLA_INTERNAL`.
///
/// # Threads
/// Any thread.
///
/// # Safety
/// `vk` is null, or a live handle that is idle and whose device is live. It must not be used
/// afterwards.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_vk_destroy(vk: *mut cupola_vk) -> cupola_status {
    call(|| {
        // SAFETY: as this function's contract.
        if let Some(vk) = unsafe { cupola_vk::take(vk) } {
            vk.embedded.destroy();
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests;
