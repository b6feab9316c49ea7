//! Vulkan: a program draws the views into images, and has the correction recorded into its command buffers.

use super::rig::cupola_rig;
use super::status::{call, check_size, cupola_status, name_of, null};
use crate::backend::vk::ash::vk;
use crate::backend::vk::{Api, Recording, SourceImage, TargetImage};
use crate::correct::{Arrangement, uniforms};
use crate::error::{Error, ErrorKind, Result};
use crate::rig::Rig;
use crate::runtime::embedded::vulkan::{EmbeddedVulkan, VulkanOptions};
use std::ffi::c_char;

// The names under which the header, which includes Vulkan's own, knows these types.
use vk::AccessFlags as VkAccessFlags;
use vk::CommandBuffer as VkCommandBuffer;
use vk::Device as VkDevice;
use vk::Format as VkFormat;
use vk::Image as VkImage;
use vk::ImageLayout as VkImageLayout;
use vk::ImageView as VkImageView;
use vk::Instance as VkInstance;
use vk::PhysicalDevice as VkPhysicalDevice;
use vk::PipelineStageFlags as VkPipelineStageFlags;

/// Vulkan's own; may be null.
pub type PFN_vkGetInstanceProcAddr = Option<vk::PFN_vkGetInstanceProcAddr>;

/// The views are tiles of one image: a viewport for each.
pub const CUPOLA_VK_ATLAS: u32 = 0;
/// The views are layers of one image, a 2D array, all of one size: for programs that draw all of them at once
/// (multiview). The smaller views are drawn at more than the planned resolution.
pub const CUPOLA_VK_LAYERS: u32 = 1;
/// Each view is an image.
pub const CUPOLA_VK_IMAGES: u32 = 2;

/// Cupola on a Vulkan device. Free it with `cupola_vk_destroy`, before the device.
///
/// Synchronisation: Cupola submits nothing and uses no queue. `cupola_vk_record` puts barriers before and after what it
/// records, so that within one queue nothing else is needed; between queues, and with a swapchain, the program's
/// semaphores and fences do what they do without Cupola. The images of a frame may be drawn into again when the fence of
/// the submission that read them is signalled; that is what `frames_in_flight` is for. Images belong to the queue family
/// of the options (`VK_SHARING_MODE_EXCLUSIVE`), or to all. While a command buffer is pending, or will be submitted
/// again, that Cupola recorded into, only `cupola_vk_record` and functions that only tell something may be called. The
/// first command buffer that is recorded after `cupola_vk_create` or `cupola_vk_resize` has to be submitted before others,
/// and once: it fills masks and tables.
pub struct cupola_vk {
    pub(super) embedded: EmbeddedVulkan,
}

/// What to make a `cupola_vk` from. No feature and no extension has to be enabled; Vulkan 1.0 will do.
#[repr(C)]
pub struct cupola_vk_options {
    /// `sizeof(cupola_vk_options)`.
    pub struct_size: usize,
    /// Finds the functions of `instance`.
    pub get_instance_proc_addr: PFN_vkGetInstanceProcAddr,
    /// The program's instance.
    pub instance: VkInstance,
    /// The device's.
    pub physical_device: VkPhysicalDevice,
    /// The program's device; it outlives the `cupola_vk`.
    pub device: VkDevice,
    /// Family of the queues that the command buffers are for; it can draw.
    pub queue_family: u32,
    /// How many frames may be on their way at the same time, 1…16: each has images of its own.
    pub frames_in_flight: u32,
    /// Width of the picture that all outputs share, pixels, 1…16384.
    pub width: u32,
    /// Height of the picture, pixels, 1…16384.
    pub height: u32,
    /// Format of the views of the images that are corrected into; UNORM or float, since what is written is encoded already.
    pub target_format: VkFormat,
    /// Format of the images that Cupola makes for the views: UNORM or float, holding encoded values.
    /// `VK_FORMAT_UNDEFINED`: the program brings its own (`cupola_vk_set_sources`).
    pub view_format: VkFormat,
    /// How the views lie in their images: `CUPOLA_VK_ATLAS`, `CUPOLA_VK_LAYERS` or `CUPOLA_VK_IMAGES`.
    pub arrangement: u32,
    /// Other than 0: the program's depth is 1 at the near plane and 0 at the far one.
    pub reversed_depth: u32,
}

/// A view: what to draw, and where.
#[repr(C)]
pub struct cupola_vk_view {
    /// `sizeof(cupola_vk_view)`.
    pub struct_size: usize,
    /// Its number, from 0.
    pub index: u32,
    /// Number of its image among those of a frame.
    pub image: u32,
    /// Its layer in the image.
    pub layer: u32,
    /// Left edge of its viewport, pixels from the left. Set the scissor to the same rectangle.
    pub x: i32,
    /// Top edge of its viewport, pixels from the top.
    pub y: i32,
    /// Width of its viewport, pixels.
    pub width: i32,
    /// Height of its viewport, pixels; positive: the matrices have y down already.
    pub height: i32,
    /// The program's camera axes (x right, y up, -z forward) → clip space of this view (y down, depth 0…1), column by
    /// column: use it in place of the program's own projection. It is `frustum_matrix` · `rotation_matrix`.
    pub projection_matrix: [f32; 16],
    /// The program's camera axes → axes of the view, for programs that cull or draw a sky by view.
    pub rotation_matrix: [f32; 16],
    /// Axes of the view → its clip space: a perspective matrix of the usual form, off-centre.
    pub frustum_matrix: [f32; 16],
    /// `projection_matrix` in double precision.
    pub projection_matrix_f64: [f64; 16],
    /// `rotation_matrix` in double precision.
    pub rotation_matrix_f64: [f64; 16],
    /// `frustum_matrix` in double precision.
    pub frustum_matrix_f64: [f64; 16],
    /// Its name (`front`, `left`, …), NUL-terminated, cut to 31 bytes.
    pub name: [c_char; 32],
}

/// An image that holds views.
#[repr(C)]
pub struct cupola_vk_source {
    /// `sizeof(cupola_vk_source)`.
    pub struct_size: usize,
    /// The image, which has `VK_IMAGE_USAGE_SAMPLED_BIT`. `VK_NULL_HANDLE`: no barrier is recorded for it, and it can be
    /// read in `layout` as it is.
    pub image: VkImage,
    /// A view of its first level: 2D; of layers a 2D array, of the first and as many as there are views.
    pub view: VkImageView,
    /// The view's format: UNORM or float, holding encoded values.
    pub format: VkFormat,
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// The layout in which the image is when it is corrected, and in which it is left.
    pub layout: VkImageLayout,
    /// The stages that wrote it, and will write it next.
    pub stages: VkPipelineStageFlags,
    /// The accesses by which they do.
    pub access: VkAccessFlags,
}

/// An image that is corrected into.
#[repr(C)]
pub struct cupola_vk_target {
    /// `sizeof(cupola_vk_target)`.
    pub struct_size: usize,
    /// The image, which has `VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT`.
    pub image: VkImage,
    /// A 2D view of its first level and layer, of the options' `target_format`.
    pub view: VkImageView,
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
    /// The layout in which it is found. `VK_IMAGE_LAYOUT_UNDEFINED`: what was in it is lost, and black where no output is.
    pub initial_layout: VkImageLayout,
    /// The layout in which it is left, `VK_IMAGE_LAYOUT_PRESENT_SRC_KHR` for instance.
    pub final_layout: VkImageLayout,
    /// The stages that come before and have to be waited for; 0: none. After an acquire, the stages at which the
    /// submission waits for the semaphore.
    pub before_stages: VkPipelineStageFlags,
    /// The accesses by which they wrote.
    pub before_access: VkAccessFlags,
    /// The stages that come after and have to wait; 0: none.
    pub after_stages: VkPipelineStageFlags,
    /// The accesses that they will make.
    pub after_access: VkAccessFlags,
}

/// Counts since a `cupola_vk` was made.
#[repr(C)]
pub struct cupola_vk_statistics {
    /// `sizeof(cupola_vk_statistics)`.
    pub struct_size: usize,
    /// Frames recorded.
    pub frames: u64,
    /// Frames since the last `cupola_vk_resize` of which is known how long the device took to correct them; a frame's
    /// time is known when the next one with the same images is recorded. Always 0 on devices without timestamps.
    pub measured_frames: u64,
    /// The time of all of them, nanoseconds.
    pub nanoseconds: u64,
    /// The time of the latest of them, nanoseconds.
    pub last_nanoseconds: u64,
}

/// The handle behind a pointer.
///
/// # Safety
/// `vk` is null or a live handle that no other thread uses now.
pub(super) unsafe fn handle<'a>(vk: *mut cupola_vk) -> Result<&'a mut cupola_vk> {
    // SAFETY: as promised above.
    unsafe { vk.as_mut() }.ok_or_else(|| null("vk"))
}

/// The elements of an array whose `struct_size` comes first; they lie as far apart as the first one says.
///
/// # Safety
/// `first` is null or points at `count` structs of `*first` bytes, each of which begins with its size.
unsafe fn elements<'a, T>(first: *const T, count: u32, name: &str) -> Result<Vec<&'a T>> {
    if first.is_null() {
        return Err(null(name));
    }
    // SAFETY: the size comes first, in a struct that C aligns as Rust does; an empty array is not looked at.
    let size = if count == 0 { size_of::<T>() } else { unsafe { *first.cast::<usize>() } };
    check_size(size, size_of::<T>(), name)?;
    if !size.is_multiple_of(align_of::<T>()) {
        let message = format!("`{name}.struct_size` is {size}; right would be sizeof(*{name})");
        return Err(Error::new(ErrorKind::InvalidArgument, message));
    }
    // SAFETY: as promised above.
    Ok((0..count as usize).map(|index| unsafe { &*first.byte_add(index * size) }).collect())
}

fn options_of(options: &cupola_vk_options) -> Result<VulkanOptions> {
    let arrangement = match options.arrangement {
        CUPOLA_VK_ATLAS => Arrangement::Atlas,
        CUPOLA_VK_LAYERS => Arrangement::Layers,
        CUPOLA_VK_IMAGES => Arrangement::Images,
        other => {
            let message = format!("`options.arrangement` is {other}; right would be one of CUPOLA_VK_ATLAS, …");
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

/// Plans `rig` and makes what it needs on the program's device. The rig may be freed afterwards.
///
/// # Safety
/// `rig` is a live handle; `options` points at a struct of `struct_size` bytes, whose handles are live and belong
/// together; `vk` is writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_vk_create(
    rig: *const cupola_rig,
    options: *const cupola_vk_options,
    vk: *mut *mut cupola_vk,
) -> cupola_status {
    // SAFETY: as promised above.
    call(|| unsafe { create(rig, options, vk, EmbeddedVulkan::new) })
}

/// What `cupola_vk_create` and `cupola_vk_create_projecting` do; `make` plans.
///
/// # Safety
/// As for `cupola_vk_create`.
pub(super) unsafe fn create(
    rig: *const cupola_rig,
    options: *const cupola_vk_options,
    vk: *mut *mut cupola_vk,
    make: fn(Api, &Rig, VulkanOptions) -> Result<EmbeddedVulkan>,
) -> Result<()> {
    // SAFETY: as promised above.
    let rig = unsafe { &rig.as_ref().ok_or_else(|| null("rig"))?.rig };
    if options.is_null() || vk.is_null() {
        return Err(null(if options.is_null() { "options" } else { "vk" }));
    }
    // SAFETY: the size comes first; the rest is read only if it is there.
    check_size(unsafe { (*options).struct_size }, size_of::<cupola_vk_options>(), "options")?;
    // SAFETY: as large as it must be.
    let options = unsafe { &*options };
    let find = options.get_instance_proc_addr.ok_or_else(|| null("options.get_instance_proc_addr"))?;
    let wanted = options_of(options)?;
    // SAFETY: as promised above.
    let api = unsafe { Api::from_handles(find, options.instance, options.physical_device, options.device) }?;
    let api = api.with_cache(crate::runtime::cache::of_process());
    let embedded = make(api, rig, wanted)?;
    // SAFETY: writable, as promised above.
    unsafe { *vk = Box::into_raw(Box::new(cupola_vk { embedded })) };
    Ok(())
}

/// Plans anew for pictures of another size. Sources and targets that the program set are forgotten, and images that
/// Cupola made are made anew. If the rig cannot be planned for that size, everything stays; after
/// `CUPOLA_GRAPHICS` only another `cupola_vk_resize` or `cupola_vk_destroy` is of use.
///
/// # Safety
/// `vk` is a live handle, and no command buffer pending that was recorded with it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_vk_resize(vk: *mut cupola_vk, width: u32, height: u32) -> cupola_status {
    // SAFETY: as promised above.
    call(|| unsafe { handle(vk) }?.embedded.resize((width, height)))
}

/// How many views there are. It changes only with `cupola_vk_resize`.
///
/// # Safety
/// `vk` is a live handle; `count` is writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_vk_view_count(vk: *mut cupola_vk, count: *mut u32) -> cupola_status {
    call(|| {
        // SAFETY: as promised above.
        let (vk, count) = unsafe { (handle(vk)?, count.as_mut().ok_or_else(|| null("count"))?) };
        *count = vk.embedded.view_count() as u32;
        Ok(())
    })
}

/// Describes a view for a camera with these planes (0 < near < far; far may be infinite), in the program's own units.
/// Set `view->struct_size` before.
///
/// # Safety
/// `vk` is a live handle; `view` points at a struct of `view->struct_size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_vk_get_view(
    vk: *mut cupola_vk,
    index: u32,
    near: f64,
    far: f64,
    view: *mut cupola_vk_view,
) -> cupola_status {
    call(|| {
        // SAFETY: as promised above.
        let vk = unsafe { handle(vk) }?;
        if view.is_null() {
            return Err(null("view"));
        }
        // SAFETY: the size comes first; the rest is written only if it is there.
        check_size(unsafe { (*view).struct_size }, size_of::<cupola_vk_view>(), "view")?;
        let found = vk.embedded.view(index as usize, near, far)?;
        let [x, y, width, height] = found.tile;
        let projection = found.frustum * found.rotation;
        let described = cupola_vk_view {
            struct_size: size_of::<cupola_vk_view>(),
            index,
            image: found.image as u32,
            layer: found.layer as u32,
            x,
            y,
            width,
            height,
            projection_matrix: uniforms::matrix(&projection),
            rotation_matrix: uniforms::matrix(&found.rotation),
            frustum_matrix: uniforms::matrix(&found.frustum),
            projection_matrix_f64: projection.to_cols_array(),
            rotation_matrix_f64: found.rotation.to_cols_array(),
            frustum_matrix_f64: found.frustum.to_cols_array(),
            name: name_of(&found.name),
        };
        // SAFETY: as large as it must be.
        unsafe { *view = described };
        Ok(())
    })
}

/// How many images hold the views of a frame: as many as there are views with `CUPOLA_VK_IMAGES`, otherwise one.
///
/// # Safety
/// `vk` is a live handle; `count` is writable.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_vk_image_count(vk: *mut cupola_vk, count: *mut u32) -> cupola_status {
    call(|| {
        // SAFETY: as promised above.
        let (vk, count) = unsafe { (handle(vk)?, count.as_mut().ok_or_else(|| null("count"))?) };
        *count = vk.embedded.image_sizes().len() as u32;
        Ok(())
    })
}

/// How large image `index` of a frame is or, where the program brings it, has to be: width and height in pixels, and
/// layers. It changes only with `cupola_vk_resize`.
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
        // SAFETY: as promised above.
        let vk = unsafe { handle(vk) }?;
        let sizes = vk.embedded.image_sizes();
        let size = sizes.get(index as usize).ok_or_else(|| {
            let message = format!("there is no image {index}; a frame has {}, counted from 0", sizes.len());
            Error::new(ErrorKind::InvalidArgument, message)
        })?;
        // SAFETY: as promised above.
        let places = unsafe { [width.as_mut(), height.as_mut(), layers.as_mut()] };
        let [Some(width), Some(height), Some(layers)] = places else { return Err(null("width, height or layers")) };
        (*width, *height, *layers) = (size.width, size.height, size.layers);
        Ok(())
    })
}

/// Describes image `index` of frame `frame` that Cupola made: draw the views into it, and leave it in its `layout`.
/// It can be drawn to, cleared and copied. Set `source->struct_size` before.
///
/// # Safety
/// `vk` is a live handle; `source` points at a struct of `source->struct_size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_vk_get_source(
    vk: *mut cupola_vk,
    frame: u32,
    index: u32,
    source: *mut cupola_vk_source,
) -> cupola_status {
    call(|| {
        // SAFETY: as promised above.
        let vk = unsafe { handle(vk) }?;
        if source.is_null() {
            return Err(null("source"));
        }
        // SAFETY: the size comes first; the rest is written only if it is there.
        check_size(unsafe { (*source).struct_size }, size_of::<cupola_vk_source>(), "source")?;
        let found = vk.embedded.images(frame as usize).get(index as usize).ok_or_else(|| {
            let message = format!("Cupola made no image {index} for frame {frame}");
            Error::new(ErrorKind::InvalidArgument, message)
        })?;
        // SAFETY: as large as it must be.
        unsafe {
            *source = cupola_vk_source {
                struct_size: size_of::<cupola_vk_source>(),
                image: found.image,
                view: found.view,
                format: found.format,
                width: found.extent.0,
                height: found.extent.1,
                layout: found.layout,
                stages: found.stages,
                access: found.access,
            };
        }
        Ok(())
    })
}

/// Says which images the program draws the views into: `cupola_vk_image_count` for the first frame, then for the second,
/// and so on for all `frames_in_flight`. Images that Cupola made are destroyed.
///
/// # Safety
/// `vk` is a live handle, and no command buffer pending that was recorded with it; `sources` points at `count` structs
/// of `sources->struct_size` bytes, whose handles are live as long as the `cupola_vk`, or others are set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_vk_set_sources(
    vk: *mut cupola_vk,
    count: u32,
    sources: *const cupola_vk_source,
) -> cupola_status {
    call(|| {
        // SAFETY: as promised above.
        let (vk, sources) = unsafe { (handle(vk)?, elements(sources, count, "sources")?) };
        let image = |source: &cupola_vk_source| SourceImage {
            image: source.image,
            view: source.view,
            format: source.format,
            extent: (source.width, source.height),
            layout: source.layout,
            stages: source.stages,
            access: source.access,
        };
        vk.embedded.set_sources(&sources.into_iter().map(image).collect::<Vec<_>>())
    })
}

/// Says which images are corrected into, for `cupola_vk_record` to choose from: those of a swapchain for instance.
///
/// # Safety
/// As for `cupola_vk_set_sources`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_vk_set_targets(
    vk: *mut cupola_vk,
    count: u32,
    targets: *const cupola_vk_target,
) -> cupola_status {
    call(|| {
        // SAFETY: as promised above.
        let (vk, targets) = unsafe { (handle(vk)?, elements(targets, count, "targets")?) };
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
        vk.embedded.set_targets(&targets.into_iter().map(image).collect::<Vec<_>>())
    })
}

/// Records the correction of frame `frame`'s images into target `target`, the left upper corner of the picture at (x, y)
/// of it; what lies outside is cut off. On an error nothing is recorded. It makes no object of Vulkan and allocates none
/// of its memory. Bound pipelines, descriptor sets, vertex buffers, viewports and scissors are other ones afterwards.
///
/// # Safety
/// `vk` is a live handle; the command buffer is being recorded, outside a render pass, for a queue of the options'
/// family; all images are in the layouts that were said when it is executed.
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
        // SAFETY: as promised above.
        let vk = unsafe { handle(vk) }?;
        if command_buffer == VkCommandBuffer::null() {
            return Err(null("command_buffer"));
        }
        // SAFETY: as promised above.
        let recording = unsafe { Recording::new(command_buffer) };
        vk.embedded.record(&recording, frame as usize, target as usize, (x, y))
    })
}

/// Counts so far. Set `statistics->struct_size` before.
///
/// # Safety
/// `vk` is a live handle; `statistics` points at a struct of its `struct_size` bytes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_vk_get_statistics(
    vk: *mut cupola_vk,
    statistics: *mut cupola_vk_statistics,
) -> cupola_status {
    call(|| {
        // SAFETY: as promised above.
        let vk = unsafe { handle(vk) }?;
        if statistics.is_null() {
            return Err(null("statistics"));
        }
        let size = size_of::<cupola_vk_statistics>();
        // SAFETY: the size comes first; the rest is written only if it is there.
        check_size(unsafe { (*statistics).struct_size }, size, "statistics")?;
        let timing = vk.embedded.timing();
        let counts = cupola_vk_statistics {
            struct_size: size,
            frames: vk.embedded.frames(),
            measured_frames: timing.corrections,
            nanoseconds: timing.total as u64,
            last_nanoseconds: timing.last as u64,
        };
        // SAFETY: as large as it must be.
        unsafe { *statistics = counts };
        Ok(())
    })
}

/// Destroys everything on the device; null is allowed.
///
/// # Safety
/// `vk` is a live handle whose device is live, with no command buffer pending that was recorded with it, or null; it
/// must not be used again.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn cupola_vk_destroy(vk: *mut cupola_vk) -> cupola_status {
    call(|| {
        if !vk.is_null() {
            // SAFETY: the handle came from Box::into_raw in `cupola_vk_create`.
            unsafe { Box::from_raw(vk) }.embedded.destroy();
        }
        Ok(())
    })
}

#[cfg(test)]
mod tests;
