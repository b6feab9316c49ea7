//! Types of the Vulkan interface.

use crate::backend::vk::ash::vk;
use crate::ffi::sized::{Growing, first_size};
use std::ffi::c_char;

// Names of these types in the header, which includes Vulkan's own.
pub(super) use vk::AccessFlags as VkAccessFlags;
pub(super) use vk::CommandBuffer as VkCommandBuffer;
pub(super) use vk::Device as VkDevice;
pub(super) use vk::Format as VkFormat;
pub(super) use vk::Image as VkImage;
pub(super) use vk::ImageLayout as VkImageLayout;
pub(super) use vk::ImageView as VkImageView;
pub(super) use vk::Instance as VkInstance;
pub(super) use vk::PhysicalDevice as VkPhysicalDevice;
pub(super) use vk::PipelineStageFlags as VkPipelineStageFlags;

/// Vulkan's own; may be null.
pub type PFN_vkGetInstanceProcAddr = Option<vk::PFN_vkGetInstanceProcAddr>;

/// Arrangement of the views: tiles of one image, each with a viewport of its own.
pub const CUPOLA_VK_ATLAS: u32 = 0;
/// Arrangement of the views: layers of one image, a 2D array, all of one size, for programs that
/// draw all views at once (multiview). The smaller views are drawn at more than the planned
/// resolution.
pub const CUPOLA_VK_LAYERS: u32 = 1;
/// Arrangement of the views: each view is an image.
pub const CUPOLA_VK_IMAGES: u32 = 2;

/// Parameters of `cupola_vk_create`. No feature and no extension has to be enabled; Vulkan 1.0 is
/// enough.
#[repr(C)]
pub struct cupola_vk_options {
    /// `sizeof(cupola_vk_options)`.
    pub struct_size: usize,
    /// Function that finds the functions of `instance`. Required.
    pub get_instance_proc_addr: PFN_vkGetInstanceProcAddr,
    /// Instance of the program. It outlives the `cupola_vk`.
    pub instance: VkInstance,
    /// Physical device of `device`.
    pub physical_device: VkPhysicalDevice,
    /// Device of the program. It outlives the `cupola_vk`.
    pub device: VkDevice,
    /// Family of the queues to which the program submits the command buffers; it supports graphics.
    pub queue_family: u32,
    /// Number of frames that may be in flight at the same time, 1 to 16. Each has images of its
    /// own.
    pub frames_in_flight: u32,
    /// Width in pixels of the picture that all outputs share, 1 to 16384.
    pub width: u32,
    /// Height of that picture in pixels, 1 to 16384.
    pub height: u32,
    /// Format of the image views of the targets: UNORM or float, since encoded values are written.
    pub target_format: VkFormat,
    /// Format of the images that the library creates for the views: UNORM or float, with encoded
    /// values. `VK_FORMAT_UNDEFINED` (0): the program brings its own images
    /// (`cupola_vk_set_sources`).
    pub view_format: VkFormat,
    /// `CUPOLA_VK_ATLAS`, `CUPOLA_VK_LAYERS` or `CUPOLA_VK_IMAGES`.
    pub arrangement: u32,
    /// 0: depth is 0 at the near plane and 1 at the far plane. Other than 0: the reverse.
    pub reversed_depth: u32,
}

// SAFETY: `repr(C)` with the size first; zero is valid for numbers, handles and optional functions.
unsafe impl Growing for cupola_vk_options {
    const FIRST_SIZE: usize = first_size!(cupola_vk_options, reversed_depth);
}

/// View: perspective image of the scene that the program draws. All matrices are stored column by
/// column.
#[repr(C)]
pub struct cupola_vk_view {
    /// `sizeof(cupola_vk_view)`.
    pub struct_size: usize,
    /// Index of the view, from 0.
    pub index: u32,
    /// Index of its image among those of a frame.
    pub image: u32,
    /// Array layer of that image.
    pub layer: u32,
    /// Left edge of the viewport, and of the scissor, in pixels from the left of the image.
    pub x: i32,
    /// Top edge of the viewport in pixels from the top of the image.
    pub y: i32,
    /// Width of the viewport in pixels.
    pub width: i32,
    /// Height of the viewport in pixels. It is positive: the matrices have y down.
    pub height: i32,
    /// Matrix from the program's camera axes (x right, y up, -z forward) to the clip space of the
    /// view (y down, depth 0 to 1): `frustum_matrix` times `rotation_matrix`. It replaces the
    /// program's projection matrix; the program's view matrix stays as it is, and with it the
    /// lighting.
    pub projection_matrix: [f32; 16],
    /// Matrix from the program's camera axes to the axes of the view, for programs that cull or
    /// draw a sky by view. It has a translation where the rig moves the camera and in the views of
    /// a stereo rig.
    pub rotation_matrix: [f32; 16],
    /// Matrix from the axes of the view to its clip space: an off-centre perspective matrix.
    pub frustum_matrix: [f32; 16],
    /// `projection_matrix` in double precision.
    pub projection_matrix_f64: [f64; 16],
    /// `rotation_matrix` in double precision.
    pub rotation_matrix_f64: [f64; 16],
    /// `frustum_matrix` in double precision.
    pub frustum_matrix_f64: [f64; 16],
    /// Name of the view (`front`, `left`, ...), UTF-8, NUL-terminated, cut to 31 bytes.
    pub name: [c_char; 32],
}

// SAFETY: `repr(C)` with the size first; numbers only.
unsafe impl Growing for cupola_vk_view {
    const FIRST_SIZE: usize = first_size!(cupola_vk_view, name);
}

/// Source: image that holds views of a frame.
#[repr(C)]
pub struct cupola_vk_source {
    /// `sizeof(cupola_vk_source)`.
    pub struct_size: usize,
    /// The image, with `VK_IMAGE_USAGE_SAMPLED_BIT`. `VK_NULL_HANDLE`: no barrier is recorded for
    /// it, and the program makes it readable by fragment shaders in `layout`.
    pub image: VkImage,
    /// Image view of its first mip level: 2D; with `CUPOLA_VK_LAYERS` a 2D array of as many layers
    /// as there are views, from the first on.
    pub view: VkImageView,
    /// Format of the image view: UNORM or float, with encoded values.
    pub format: VkFormat,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Layout of the image before and after the correction.
    pub layout: VkImageLayout,
    /// Pipeline stages that write the image before the correction and again after it.
    pub stages: VkPipelineStageFlags,
    /// Accesses of these stages.
    pub access: VkAccessFlags,
}

// SAFETY: `repr(C)` with the size first; numbers and handles only.
unsafe impl Growing for cupola_vk_source {
    const FIRST_SIZE: usize = first_size!(cupola_vk_source, access);
}

/// Target: image into which a frame is corrected.
#[repr(C)]
pub struct cupola_vk_target {
    /// `sizeof(cupola_vk_target)`.
    pub struct_size: usize,
    /// The image, with `VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT`.
    pub image: VkImage,
    /// 2D image view of its first mip level and layer, of the options' `target_format`.
    pub view: VkImageView,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Layout of the image before the correction. `VK_IMAGE_LAYOUT_UNDEFINED`: its contents are
    /// lost, and it is black where there is no output.
    pub initial_layout: VkImageLayout,
    /// Layout of the image after the correction, for example `VK_IMAGE_LAYOUT_PRESENT_SRC_KHR`.
    pub final_layout: VkImageLayout,
    /// Pipeline stages before the correction for which it waits; 0 for none. After an acquire: the
    /// stages at which the submission waits for the semaphore.
    pub before_stages: VkPipelineStageFlags,
    /// Write accesses of these stages.
    pub before_access: VkAccessFlags,
    /// Pipeline stages after the correction that wait for it; 0 for none.
    pub after_stages: VkPipelineStageFlags,
    /// Accesses of these stages.
    pub after_access: VkAccessFlags,
}

// SAFETY: `repr(C)` with the size first; numbers and handles only.
unsafe impl Growing for cupola_vk_target {
    const FIRST_SIZE: usize = first_size!(cupola_vk_target, after_access);
}

/// Counts since the creation of a `cupola_vk`.
#[repr(C)]
pub struct cupola_vk_statistics {
    /// `sizeof(cupola_vk_statistics)`.
    pub struct_size: usize,
    /// Number of recorded frames.
    pub frames: u64,
    /// Number of frames since the last `cupola_vk_resize` whose time on the device is known. The
    /// time of a frame is known when the next frame with the same images is recorded. Always 0 on
    /// devices without timestamps.
    pub measured_frames: u64,
    /// Sum of these times in nanoseconds.
    pub nanoseconds: u64,
    /// The latest of these times in nanoseconds.
    pub last_nanoseconds: u64,
}

// SAFETY: `repr(C)` with the size first; numbers only.
unsafe impl Growing for cupola_vk_statistics {
    const FIRST_SIZE: usize = first_size!(cupola_vk_statistics, last_nanoseconds);
}
