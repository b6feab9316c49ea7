//! Vulkan: the images that hold the views, and those that are corrected into.

use super::cupola_vk;
use super::types::{cupola_vk_source, cupola_vk_target};
use crate::backend::vk::{SourceImage, TargetImage};
use crate::error::{Error, ErrorKind};
use crate::ffi::argument::Place;
use crate::ffi::handle::Handle;
use crate::ffi::sized::{SizedPlace, read_array};
use crate::ffi::status::{call, cupola_status};

/// Returns the number of images that hold the views of a frame: the number of views with
/// `CUPOLA_VK_IMAGES`, otherwise 1.
///
/// # Parameters
/// - `vk`: the object.
/// - `count`: receives the number.
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
pub unsafe extern "C" fn cupola_vk_image_count(vk: *mut cupola_vk, count: *mut u32) -> cupola_status {
    call(|| {
        // SAFETY: as this function's contract.
        let (vk, count) = unsafe { (cupola_vk::borrow(vk)?, Place::new(count, "count")?) };
        count.set(vk.embedded.image_sizes().len() as u32);
        Ok(())
    })
}

/// Returns the size of an image that holds views. Images that the program brings have to have this
/// size. Only `cupola_vk_resize` changes it.
///
/// # Parameters
/// - `vk`: the object.
/// - `index`: index of the image among those of a frame.
/// - `width`, `height`: receive the size in pixels.
/// - `layers`: receives the number of array layers.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: a null pointer, or an index without an image.
///
/// # Threads
/// Any thread.
///
/// # Safety
/// `vk` is a live handle; `width`, `height` and `layers` are writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_vk_image_size(
    vk: *mut cupola_vk,
    index: u32,
    width: *mut u32,
    height: *mut u32,
    layers: *mut u32,
) -> cupola_status {
    call(|| {
        // SAFETY: as this function's contract.
        let vk = unsafe { cupola_vk::borrow(vk) }?;
        let sizes = vk.embedded.image_sizes();
        let size = sizes.get(index as usize).ok_or_else(|| {
            let message = format!("there is no image {index}; a frame has {}, counted from 0", sizes.len());
            Error::new(ErrorKind::InvalidArgument, message)
        })?;
        // SAFETY: as this function's contract.
        let (width, height, layers) =
            unsafe { (Place::new(width, "width")?, Place::new(height, "height")?, Place::new(layers, "layers")?) };
        width.set(size.width);
        height.set(size.height);
        layers.set(size.layers);
        Ok(())
    })
}

/// Describes an image that the library created for the views of a frame. The program draws into it
/// and leaves it in its `layout`. The image can be a colour attachment, be cleared and be copied.
///
/// # Parameters
/// - `vk`: the object.
/// - `frame`: index of the frame in flight.
/// - `index`: index of the image among those of a frame.
/// - `source`: receives the description. The caller sets `source->struct_size` before.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: a null pointer, a wrong `struct_size`, or an image that the library
///   did not create.
///
/// # Ownership
/// The image and its view belong to the library. They live until `cupola_vk_resize`,
/// `cupola_vk_set_sources` or `cupola_vk_destroy`.
///
/// # Threads
/// Any thread.
///
/// # Safety
/// `vk` is a live handle; `source` points to `source->struct_size` writable bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_vk_get_source(
    vk: *mut cupola_vk,
    frame: u32,
    index: u32,
    source: *mut cupola_vk_source,
) -> cupola_status {
    call(|| {
        // SAFETY: as this function's contract.
        let (vk, source) = unsafe { (cupola_vk::borrow(vk)?, SizedPlace::new(source, "source")?) };
        let found = vk.embedded.images(frame as usize).get(index as usize).ok_or_else(|| {
            let message = format!("Cupola made no image {index} for frame {frame}");
            Error::new(ErrorKind::InvalidArgument, message)
        })?;
        source.set(&cupola_vk_source {
            struct_size: size_of::<cupola_vk_source>(),
            image: found.image,
            view: found.view,
            format: found.format,
            width: found.extent.0,
            height: found.extent.1,
            layout: found.layout,
            stages: found.stages,
            access: found.access,
        });
        Ok(())
    })
}

/// Sets the images into which the program draws the views. The library's own images are destroyed.
///
/// # Parameters
/// - `vk`: the object, idle.
/// - `count`: number of `sources`: `frames_in_flight` times the number that `cupola_vk_image_count`
///   returns.
/// - `sources`: the images of the first frame, then those of the second, and so on. The structs lie
///   `sources->struct_size` bytes apart. Not kept; the handles in them are.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: a null pointer or handle, a wrong `struct_size`, a field that this
///   version does not know, or a wrong number, size, layout or sRGB format.
/// - `CUPOLA_GRAPHICS`: the device cannot sample the format, or the driver refused a request.
///
/// # Ownership
/// The images belong to the program. They live until other sources are set, `cupola_vk_resize` or
/// `cupola_vk_destroy`.
///
/// # Threads
/// Any thread.
///
/// # Safety
/// `vk` is a live handle and idle; `sources` points to `count` structs of `sources->struct_size`
/// bytes with live handles.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_vk_set_sources(
    vk: *mut cupola_vk,
    count: u32,
    sources: *const cupola_vk_source,
) -> cupola_status {
    call(|| {
        // SAFETY: as this function's contract.
        let (vk, sources) = unsafe { (cupola_vk::borrow_mut(vk)?, read_array(sources, count, "sources")?) };
        let image = |source: &cupola_vk_source| SourceImage {
            image: source.image,
            view: source.view,
            format: source.format,
            extent: (source.width, source.height),
            layout: source.layout,
            stages: source.stages,
            access: source.access,
        };
        vk.embedded.set_sources(&sources.iter().map(image).collect::<Vec<_>>())
    })
}

/// Sets the images from which `cupola_vk_record` chooses its target, for example those of a
/// swapchain.
///
/// # Parameters
/// - `vk`: the object, idle.
/// - `count`: number of `targets`.
/// - `targets`: the images. The structs lie `targets->struct_size` bytes apart. Not kept; the
///   handles in them are.
///
/// # Returns
/// - `CUPOLA_INVALID_ARGUMENT`: a null pointer or handle, a wrong `struct_size`, a field that this
///   version does not know, or a wrong size or layout.
/// - `CUPOLA_GRAPHICS`: the driver refused a request.
///
/// # Ownership
/// The images belong to the program. They live until other targets are set, `cupola_vk_resize` or
/// `cupola_vk_destroy`.
///
/// # Threads
/// Any thread.
///
/// # Safety
/// `vk` is a live handle and idle; `targets` points to `count` structs of `targets->struct_size`
/// bytes with live handles.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_vk_set_targets(
    vk: *mut cupola_vk,
    count: u32,
    targets: *const cupola_vk_target,
) -> cupola_status {
    call(|| {
        // SAFETY: as this function's contract.
        let (vk, targets) = unsafe { (cupola_vk::borrow_mut(vk)?, read_array(targets, count, "targets")?) };
        let format = vk.embedded.target_format();
        let image = |target: &cupola_vk_target| TargetImage {
            image: target.image,
            view: target.view,
            format,
            extent: (target.width, target.height),
            initial_layout: target.initial_layout,
            final_layout: target.final_layout,
            before: (target.before_stages, target.before_access),
            after: (target.after_stages, target.after_access),
        };
        vk.embedded.set_targets(&targets.iter().map(image).collect::<Vec<_>>())
    })
}
