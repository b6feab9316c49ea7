/* Cupola on Vulkan, for programs that draw the views themselves.
 *
 * The conventions are those of cupola.h. This is a separate header so that programs without Vulkan
 * do not need Vulkan's header.
 *
 * Generated from src/ffi; do not edit.
 */

#ifndef CUPOLA_VK_H
#define CUPOLA_VK_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <vulkan/vulkan_core.h>
#include "cupola.h"

/*
 Arrangement of the views: tiles of one image, each with a viewport of its own.
 */
#define CUPOLA_VK_ATLAS 0

/*
 Arrangement of the views: layers of one image, a 2D array, all of one size, for programs that
 draw all views at once (multiview). The smaller views are drawn at more than the planned
 resolution.
 */
#define CUPOLA_VK_LAYERS 1

/*
 Arrangement of the views: each view is an image.
 */
#define CUPOLA_VK_IMAGES 2

/*
 A rig on a Vulkan device. Created by `cupola_vk_create` or `cupola_vk_create_projecting`,
 destroyed by `cupola_vk_destroy` before the device is.

 One thread at a time may use it. Several objects, on one device too, are independent.

 Synchronisation: the library submits nothing and uses no queue. `cupola_vk_record` records
 barriers before and after the correction, so that nothing else is needed within one queue;
 between queues, and with a swapchain, the program's semaphores and fences are the same as
 without Cupola. The images of a frame may be drawn again when the fence of the submission that
 read them is signalled; this is what `frames_in_flight` is for. Images belong to the queue
 family of the options (`VK_SHARING_MODE_EXCLUSIVE`) or are shared by all.

 "Idle" at a function means: no command buffer into which `cupola_vk_record` recorded is pending,
 and none will be submitted again.

 The first command buffer that is recorded after `cupola_vk_create` or `cupola_vk_resize` fills
 masks and tables: it has to be submitted before the others, and once.
 */
typedef struct cupola_vk cupola_vk;

/*
 Parameters of `cupola_vk_create`. No feature and no extension has to be enabled; Vulkan 1.0 is
 enough.
 */
typedef struct cupola_vk_options {
  /*
   `sizeof(cupola_vk_options)`.
   */
  size_t struct_size;
  /*
   Function that finds the functions of `instance`. Required.
   */
  PFN_vkGetInstanceProcAddr get_instance_proc_addr;
  /*
   Instance of the program. It outlives the `cupola_vk`.
   */
  VkInstance instance;
  /*
   Physical device of `device`.
   */
  VkPhysicalDevice physical_device;
  /*
   Device of the program. It outlives the `cupola_vk`.
   */
  VkDevice device;
  /*
   Family of the queues to which the program submits the command buffers; it supports graphics.
   */
  uint32_t queue_family;
  /*
   Number of frames that may be in flight at the same time, 1 to 16. Each has images of its
   own.
   */
  uint32_t frames_in_flight;
  /*
   Width in pixels of the picture that all outputs share, 1 to 16384.
   */
  uint32_t width;
  /*
   Height of that picture in pixels, 1 to 16384.
   */
  uint32_t height;
  /*
   Format of the image views of the targets: UNORM or float, since encoded values are written.
   */
  VkFormat target_format;
  /*
   Format of the images that the library creates for the views: UNORM or float, with encoded
   values. `VK_FORMAT_UNDEFINED` (0): the program brings its own images
   (`cupola_vk_set_sources`).
   */
  VkFormat view_format;
  /*
   `CUPOLA_VK_ATLAS`, `CUPOLA_VK_LAYERS` or `CUPOLA_VK_IMAGES`.
   */
  uint32_t arrangement;
  /*
   0: depth is 0 at the near plane and 1 at the far plane. Other than 0: the reverse.
   */
  uint32_t reversed_depth;
} cupola_vk_options;

/*
 View: perspective image of the scene that the program draws. All matrices are stored column by
 column.
 */
typedef struct cupola_vk_view {
  /*
   `sizeof(cupola_vk_view)`.
   */
  size_t struct_size;
  /*
   Index of the view, from 0.
   */
  uint32_t index;
  /*
   Index of its image among those of a frame.
   */
  uint32_t image;
  /*
   Array layer of that image.
   */
  uint32_t layer;
  /*
   Left edge of the viewport, and of the scissor, in pixels from the left of the image.
   */
  int32_t x;
  /*
   Top edge of the viewport in pixels from the top of the image.
   */
  int32_t y;
  /*
   Width of the viewport in pixels.
   */
  int32_t width;
  /*
   Height of the viewport in pixels. It is positive: the matrices have y down.
   */
  int32_t height;
  /*
   Matrix from the program's camera axes (x right, y up, -z forward) to the clip space of the
   view (y down, depth 0 to 1): `frustum_matrix` times `rotation_matrix`. It replaces the
   program's projection matrix; the program's view matrix stays as it is, and with it the
   lighting.
   */
  float projection_matrix[16];
  /*
   Matrix from the program's camera axes to the axes of the view, for programs that cull or
   draw a sky by view. It has a translation where the rig moves the camera and in the views of
   a stereo rig.
   */
  float rotation_matrix[16];
  /*
   Matrix from the axes of the view to its clip space: an off-centre perspective matrix.
   */
  float frustum_matrix[16];
  /*
   `projection_matrix` in double precision.
   */
  double projection_matrix_f64[16];
  /*
   `rotation_matrix` in double precision.
   */
  double rotation_matrix_f64[16];
  /*
   `frustum_matrix` in double precision.
   */
  double frustum_matrix_f64[16];
  /*
   Name of the view (`front`, `left`, ...), UTF-8, NUL-terminated, cut to 31 bytes.
   */
  char name[32];
} cupola_vk_view;

/*
 Counts since the creation of a `cupola_vk`.
 */
typedef struct cupola_vk_statistics {
  /*
   `sizeof(cupola_vk_statistics)`.
   */
  size_t struct_size;
  /*
   Number of recorded frames.
   */
  uint64_t frames;
  /*
   Number of frames since the last `cupola_vk_resize` whose time on the device is known. The
   time of a frame is known when the next frame with the same images is recorded. Always 0 on
   devices without timestamps.
   */
  uint64_t measured_frames;
  /*
   Sum of these times in nanoseconds.
   */
  uint64_t nanoseconds;
  /*
   The latest of these times in nanoseconds.
   */
  uint64_t last_nanoseconds;
} cupola_vk_statistics;

/*
 Source: image that holds views of a frame.
 */
typedef struct cupola_vk_source {
  /*
   `sizeof(cupola_vk_source)`.
   */
  size_t struct_size;
  /*
   The image, with `VK_IMAGE_USAGE_SAMPLED_BIT`. `VK_NULL_HANDLE`: no barrier is recorded for
   it, and the program makes it readable by fragment shaders in `layout`.
   */
  VkImage image;
  /*
   Image view of its first mip level: 2D; with `CUPOLA_VK_LAYERS` a 2D array of as many layers
   as there are views, from the first on.
   */
  VkImageView view;
  /*
   Format of the image view: UNORM or float, with encoded values.
   */
  VkFormat format;
  /*
   Width in pixels.
   */
  uint32_t width;
  /*
   Height in pixels.
   */
  uint32_t height;
  /*
   Layout of the image before and after the correction.
   */
  VkImageLayout layout;
  /*
   Pipeline stages that write the image before the correction and again after it.
   */
  VkPipelineStageFlags stages;
  /*
   Accesses of these stages.
   */
  VkAccessFlags access;
} cupola_vk_source;

/*
 Target: image into which a frame is corrected.
 */
typedef struct cupola_vk_target {
  /*
   `sizeof(cupola_vk_target)`.
   */
  size_t struct_size;
  /*
   The image, with `VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT`.
   */
  VkImage image;
  /*
   2D image view of its first mip level and layer, of the options' `target_format`.
   */
  VkImageView view;
  /*
   Width in pixels.
   */
  uint32_t width;
  /*
   Height in pixels.
   */
  uint32_t height;
  /*
   Layout of the image before the correction. `VK_IMAGE_LAYOUT_UNDEFINED`: its contents are
   lost, and it is black where there is no output.
   */
  VkImageLayout initial_layout;
  /*
   Layout of the image after the correction, for example `VK_IMAGE_LAYOUT_PRESENT_SRC_KHR`.
   */
  VkImageLayout final_layout;
  /*
   Pipeline stages before the correction for which it waits; 0 for none. After an acquire: the
   stages at which the submission waits for the semaphore.
   */
  VkPipelineStageFlags before_stages;
  /*
   Write accesses of these stages.
   */
  VkAccessFlags before_access;
  /*
   Pipeline stages after the correction that wait for it; 0 for none.
   */
  VkPipelineStageFlags after_stages;
  /*
   Accesses of these stages.
   */
  VkAccessFlags after_access;
} cupola_vk_target;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 Plans the views of a rig and creates what they need on the program's device.

 # Parameters
 - `rig`: the rig. The library copies what it needs; the rig may be freed afterwards.
 - `options`: device, sizes and formats. Not kept; the handles in it are.
 - `vk`: receives the new object, on success only.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: a null pointer or handle, a value out of range, an sRGB format, a
   field that this version does not know, or a rig that corrects nothing (`identity`).
 - `CUPOLA_GRAPHICS`: the device cannot use a format, lacks a function or has no memory left.

 # Ownership
 The caller owns `*vk` and destroys it with `cupola_vk_destroy`.

 # Threads
 Any thread.

 # Safety
 `rig` is a live handle; `options` points to `options->struct_size` bytes, whose handles are live
 and belong together; `vk` is writable.
 */
cupola_status cupola_vk_create(const cupola_rig *rig,
                               const struct cupola_vk_options *options,
                               struct cupola_vk **vk);

/*
 Plans the views again for a picture of another size. Number and sizes of views and images may
 change. Sources and targets that the program set are forgotten, and the library's own images are
 created again.

 # Parameters
 - `vk`: the object, idle.
 - `width`, `height`: size of the picture in pixels, 1 to 16384.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: `vk` is null, or the size is out of range. Everything stays.
 - `CUPOLA_GRAPHICS`: the driver refused a request. Only another `cupola_vk_resize` or
   `cupola_vk_destroy` is useful afterwards.

 # Threads
 Any thread.

 # Safety
 `vk` is a live handle and idle.
 */
cupola_status cupola_vk_resize(struct cupola_vk *vk, uint32_t width, uint32_t height);

/*
 Returns the number of views. Only `cupola_vk_resize` changes it.

 # Parameters
 - `vk`: the object.
 - `count`: receives the number, at least 1.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: a null pointer.

 # Threads
 Any thread.

 # Safety
 `vk` is a live handle; `count` is writable.
 */
cupola_status cupola_vk_view_count(struct cupola_vk *vk, uint32_t *count);

/*
 Describes a view, for a camera with the given near and far planes.

 # Parameters
 - `vk`: the object.
 - `index`: index of the view, less than the number that `cupola_vk_view_count` returns.
 - `near`, `far`: distances of the planes in the program's units, 0 < near < far. `far` may be
   infinite.
 - `view`: receives the description. The caller sets `view->struct_size` before.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: a null pointer, a wrong `struct_size`, an index without a view, or
   wrong planes.

 # Threads
 Any thread.

 # Safety
 `vk` is a live handle; `view` points to `view->struct_size` writable bytes.
 */
cupola_status cupola_vk_get_view(struct cupola_vk *vk,
                                 uint32_t index,
                                 double near,
                                 double far,
                                 struct cupola_vk_view *view);

/*
 Records the correction of a frame into a command buffer. On an error nothing is recorded. No
 Vulkan object is created and no device memory allocated.

 Bound pipelines, descriptor sets, vertex buffers, viewports and scissors are undefined
 afterwards.

 # Parameters
 - `vk`: the object.
 - `command_buffer`: primary command buffer in the recording state, outside a render pass, for a
   queue of the options' family.
 - `frame`: index of the frame in flight whose sources are read, less than `frames_in_flight`.
 - `target`: index of the target, as set with `cupola_vk_set_targets`.
 - `x`, `y`: upper left corner of the picture in the target, in pixels. Parts outside are cut
   off.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: a null pointer or handle, or a frame or target that was not set.

 # Threads
 Any thread that may use the command buffer's pool.

 # Safety
 `vk` and `command_buffer` are live handles; when the command buffer is executed, all images are
 in the layouts that were given for them.
 */
cupola_status cupola_vk_record(struct cupola_vk *vk,
                               VkCommandBuffer command_buffer,
                               uint32_t frame,
                               uint32_t target,
                               int32_t x,
                               int32_t y);

/*
 Returns counts since the creation of the object.

 # Parameters
 - `vk`: the object.
 - `statistics`: receives the counts. The caller sets `statistics->struct_size` before.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: a null pointer, or a wrong `struct_size`.

 # Threads
 Any thread.

 # Safety
 `vk` is a live handle; `statistics` points to `statistics->struct_size` writable bytes.
 */
cupola_status cupola_vk_get_statistics(struct cupola_vk *vk,
                                       struct cupola_vk_statistics *statistics);

/*
 Destroys an object and everything that it created on the device.

 # Parameters
 - `vk`: the object, idle, or null, which does nothing.

 # Returns
 `CUPOLA_OK`, or `CUPOLA_INTERNAL`.

 # Threads
 Any thread.

 # Safety
 `vk` is null, or a live handle that is idle and whose device is live. It must not be used
 afterwards.
 */
cupola_status cupola_vk_destroy(struct cupola_vk *vk);

/*
 Returns the number of images that hold the views of a frame: the number of views with
 `CUPOLA_VK_IMAGES`, otherwise 1.

 # Parameters
 - `vk`: the object.
 - `count`: receives the number.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: a null pointer.

 # Threads
 Any thread.

 # Safety
 `vk` is a live handle; `count` is writable.
 */
cupola_status cupola_vk_image_count(struct cupola_vk *vk, uint32_t *count);

/*
 Returns the size of an image that holds views. Images that the program brings have to have this
 size. Only `cupola_vk_resize` changes it.

 # Parameters
 - `vk`: the object.
 - `index`: index of the image among those of a frame.
 - `width`, `height`: receive the size in pixels.
 - `layers`: receives the number of array layers.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: a null pointer, or an index without an image.

 # Threads
 Any thread.

 # Safety
 `vk` is a live handle; `width`, `height` and `layers` are writable.
 */
cupola_status cupola_vk_image_size(struct cupola_vk *vk,
                                   uint32_t index,
                                   uint32_t *width,
                                   uint32_t *height,
                                   uint32_t *layers);

/*
 Describes an image that the library created for the views of a frame. The program draws into it
 and leaves it in its `layout`. The image can be a colour attachment, be cleared and be copied.

 # Parameters
 - `vk`: the object.
 - `frame`: index of the frame in flight.
 - `index`: index of the image among those of a frame.
 - `source`: receives the description. The caller sets `source->struct_size` before.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: a null pointer, a wrong `struct_size`, or an image that the library
   did not create.

 # Ownership
 The image and its view belong to the library. They live until `cupola_vk_resize`,
 `cupola_vk_set_sources` or `cupola_vk_destroy`.

 # Threads
 Any thread.

 # Safety
 `vk` is a live handle; `source` points to `source->struct_size` writable bytes.
 */
cupola_status cupola_vk_get_source(struct cupola_vk *vk,
                                   uint32_t frame,
                                   uint32_t index,
                                   struct cupola_vk_source *source);

/*
 Sets the images into which the program draws the views. The library's own images are destroyed.

 # Parameters
 - `vk`: the object, idle.
 - `count`: number of `sources`: `frames_in_flight` times the number that `cupola_vk_image_count`
   returns.
 - `sources`: the images of the first frame, then those of the second, and so on. The structs lie
   `sources->struct_size` bytes apart. Not kept; the handles in them are.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: a null pointer or handle, a wrong `struct_size`, a field that this
   version does not know, or a wrong number, size, layout or sRGB format.
 - `CUPOLA_GRAPHICS`: the device cannot sample the format, or the driver refused a request.

 # Ownership
 The images belong to the program. They live until other sources are set, `cupola_vk_resize` or
 `cupola_vk_destroy`.

 # Threads
 Any thread.

 # Safety
 `vk` is a live handle and idle; `sources` points to `count` structs of `sources->struct_size`
 bytes with live handles.
 */
cupola_status cupola_vk_set_sources(struct cupola_vk *vk,
                                    uint32_t count,
                                    const struct cupola_vk_source *sources);

/*
 Sets the images from which `cupola_vk_record` chooses its target, for example those of a
 swapchain.

 # Parameters
 - `vk`: the object, idle.
 - `count`: number of `targets`.
 - `targets`: the images. The structs lie `targets->struct_size` bytes apart. Not kept; the
   handles in them are.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: a null pointer or handle, a wrong `struct_size`, a field that this
   version does not know, or a wrong size or layout.
 - `CUPOLA_GRAPHICS`: the driver refused a request.

 # Ownership
 The images belong to the program. They live until other targets are set, `cupola_vk_resize` or
 `cupola_vk_destroy`.

 # Threads
 Any thread.

 # Safety
 `vk` is a live handle and idle; `targets` points to `count` structs of `targets->struct_size`
 bytes with live handles.
 */
cupola_status cupola_vk_set_targets(struct cupola_vk *vk,
                                    uint32_t count,
                                    const struct cupola_vk_target *targets);

/*
 Does what `cupola_vk_create` does, for a program that draws all views with the functions of
 `cupola_vk_projection_source`.

 An output with the method `vertex` or `primitive` then has one view, which is its own picture
 (pixel for pixel, except where layers have to be alike or the rig's `quality` asks for more);
 the matrices of `cupola_vk_get_view` do not apply to it. Edges between vertices stay straight,
 so the program's models have to be fine.

 # Parameters
 As for `cupola_vk_create`.

 # Returns
 As for `cupola_vk_create`.

 # Ownership
 The caller owns `*vk` and destroys it with `cupola_vk_destroy`.

 # Threads
 Any thread.

 # Safety
 As for `cupola_vk_create`.
 */
cupola_status cupola_vk_create_projecting(const cupola_rig *rig,
                                          const struct cupola_vk_options *options,
                                          struct cupola_vk **vk);

/*
 Copies GLSL for the last shader stage before rasterisation: a uniform block with `vec4
 cupola_view[8]` (std140), and `vec4 cupola_fix(vec4)`, which turns the value for `gl_Position`,
 computed with the program's own projection, into that of the view. The text belongs between
 `#version` (450 at least) and `main`.

 # Parameters
 - `set`, `binding`: descriptor set and binding of the uniform block.
 - `buffer`: room for `size` bytes, or null to get the length only. The text is cut to fit, with
   its NUL.
 - `size`: size of the buffer in bytes.
 - `length`: receives the length of the whole text in bytes without its NUL; may be null.

 # Returns
 `CUPOLA_OK`, or `CUPOLA_INTERNAL`.

 # Threads
 Any thread.

 # Safety
 `buffer` has room for `size` bytes or is null; `length` is null or writable.
 */
cupola_status cupola_vk_projection_source(uint32_t set,
                                          uint32_t binding,
                                          char *buffer,
                                          size_t size,
                                          size_t *length);

/*
 Computes the 8 vectors of `cupola_view` for a view. They depend on the view, on the matrix and
 on the size of the picture.

 # Parameters
 - `vk`: the object.
 - `index`: index of the view.
 - `matrix`: 16 numbers, column by column: the perspective matrix with which the program draws,
   to Vulkan's clip space with y down.
 - `vectors`: receives 32 numbers.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: a null pointer, an index without a view, or a matrix that is no
   perspective.

 # Threads
 Any thread.

 # Safety
 `vk` is a live handle; `matrix` points to 16 numbers, `vectors` to room for 32.
 */
cupola_status cupola_vk_get_projection(struct cupola_vk *vk,
                                       uint32_t index,
                                       const float *matrix,
                                       float *vectors);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* CUPOLA_VK_H */
