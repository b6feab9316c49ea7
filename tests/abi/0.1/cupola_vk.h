/* Cupola on Vulkan: for programs that draw the views themselves.
 *
 * The grammar is that of cupola.h. A header of its own, so that programs without Vulkan need not have Vulkan's, and so
 * that handles have their own types whichever header comes first.
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
 The views are tiles of one image: a viewport for each.
 */
#define CUPOLA_VK_ATLAS 0

/*
 The views are layers of one image, a 2D array, all of one size: for programs that draw all of them at once
 (multiview). The smaller views are drawn at more than the planned resolution.
 */
#define CUPOLA_VK_LAYERS 1

/*
 Each view is an image.
 */
#define CUPOLA_VK_IMAGES 2

/*
 Cupola on a Vulkan device. Free it with `cupola_vk_destroy`, before the device.

 Synchronisation: Cupola submits nothing and uses no queue. `cupola_vk_record` puts barriers before and after what it
 records, so that within one queue nothing else is needed; between queues, and with a swapchain, the program's
 semaphores and fences do what they do without Cupola. The images of a frame may be drawn into again when the fence of
 the submission that read them is signalled; that is what `frames_in_flight` is for. Images belong to the queue family
 of the options (`VK_SHARING_MODE_EXCLUSIVE`), or to all. While a command buffer is pending, or will be submitted
 again, that Cupola recorded into, only `cupola_vk_record` and functions that only tell something may be called. The
 first command buffer that is recorded after `cupola_vk_create` or `cupola_vk_resize` has to be submitted before others,
 and once: it fills masks and tables.
 */
typedef struct cupola_vk cupola_vk;

/*
 What to make a `cupola_vk` from. No feature and no extension has to be enabled; Vulkan 1.0 will do.
 */
typedef struct cupola_vk_options {
  /*
   `sizeof(cupola_vk_options)`.
   */
  size_t struct_size;
  /*
   Finds the functions of `instance`.
   */
  PFN_vkGetInstanceProcAddr get_instance_proc_addr;
  /*
   The program's instance.
   */
  VkInstance instance;
  /*
   The device's.
   */
  VkPhysicalDevice physical_device;
  /*
   The program's device; it outlives the `cupola_vk`.
   */
  VkDevice device;
  /*
   Family of the queues that the command buffers are for; it can draw.
   */
  uint32_t queue_family;
  /*
   How many frames may be on their way at the same time, 1…16: each has images of its own.
   */
  uint32_t frames_in_flight;
  /*
   Width of the picture that all outputs share, pixels, 1…16384.
   */
  uint32_t width;
  /*
   Height of the picture, pixels, 1…16384.
   */
  uint32_t height;
  /*
   Format of the views of the images that are corrected into; UNORM or float, since what is written is encoded already.
   */
  VkFormat target_format;
  /*
   Format of the images that Cupola makes for the views: UNORM or float, holding encoded values.
   `VK_FORMAT_UNDEFINED`: the program brings its own (`cupola_vk_set_sources`).
   */
  VkFormat view_format;
  /*
   How the views lie in their images: `CUPOLA_VK_ATLAS`, `CUPOLA_VK_LAYERS` or `CUPOLA_VK_IMAGES`.
   */
  uint32_t arrangement;
  /*
   Other than 0: the program's depth is 1 at the near plane and 0 at the far one.
   */
  uint32_t reversed_depth;
} cupola_vk_options;

/*
 A view: what to draw, and where.
 */
typedef struct cupola_vk_view {
  /*
   `sizeof(cupola_vk_view)`.
   */
  size_t struct_size;
  /*
   Its number, from 0.
   */
  uint32_t index;
  /*
   Number of its image among those of a frame.
   */
  uint32_t image;
  /*
   Its layer in the image.
   */
  uint32_t layer;
  /*
   Left edge of its viewport, pixels from the left. Set the scissor to the same rectangle.
   */
  int32_t x;
  /*
   Top edge of its viewport, pixels from the top.
   */
  int32_t y;
  /*
   Width of its viewport, pixels.
   */
  int32_t width;
  /*
   Height of its viewport, pixels; positive: the matrices have y down already.
   */
  int32_t height;
  /*
   The program's camera axes (x right, y up, -z forward) → clip space of this view (y down, depth 0…1), column by
   column: use it in place of the program's own projection. It is `frustum_matrix` · `rotation_matrix`.
   */
  float projection_matrix[16];
  /*
   The program's camera axes → axes of the view, for programs that cull or draw a sky by view.
   */
  float rotation_matrix[16];
  /*
   Axes of the view → its clip space: a perspective matrix of the usual form, off-centre.
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
   Its name (`front`, `left`, …), NUL-terminated, cut to 31 bytes.
   */
  char name[32];
} cupola_vk_view;

/*
 An image that holds views.
 */
typedef struct cupola_vk_source {
  /*
   `sizeof(cupola_vk_source)`.
   */
  size_t struct_size;
  /*
   The image, which has `VK_IMAGE_USAGE_SAMPLED_BIT`. `VK_NULL_HANDLE`: no barrier is recorded for it, and it can be
   read in `layout` as it is.
   */
  VkImage image;
  /*
   A view of its first level: 2D; of layers a 2D array, of the first and as many as there are views.
   */
  VkImageView view;
  /*
   The view's format: UNORM or float, holding encoded values.
   */
  VkFormat format;
  /*
   Width, pixels.
   */
  uint32_t width;
  /*
   Height, pixels.
   */
  uint32_t height;
  /*
   The layout in which the image is when it is corrected, and in which it is left.
   */
  VkImageLayout layout;
  /*
   The stages that wrote it, and will write it next.
   */
  VkPipelineStageFlags stages;
  /*
   The accesses by which they do.
   */
  VkAccessFlags access;
} cupola_vk_source;

/*
 An image that is corrected into.
 */
typedef struct cupola_vk_target {
  /*
   `sizeof(cupola_vk_target)`.
   */
  size_t struct_size;
  /*
   The image, which has `VK_IMAGE_USAGE_COLOR_ATTACHMENT_BIT`.
   */
  VkImage image;
  /*
   A 2D view of its first level and layer, of the options' `target_format`.
   */
  VkImageView view;
  /*
   Width, pixels.
   */
  uint32_t width;
  /*
   Height, pixels.
   */
  uint32_t height;
  /*
   The layout in which it is found. `VK_IMAGE_LAYOUT_UNDEFINED`: what was in it is lost, and black where no output is.
   */
  VkImageLayout initial_layout;
  /*
   The layout in which it is left, `VK_IMAGE_LAYOUT_PRESENT_SRC_KHR` for instance.
   */
  VkImageLayout final_layout;
  /*
   The stages that come before and have to be waited for; 0: none. After an acquire, the stages at which the
   submission waits for the semaphore.
   */
  VkPipelineStageFlags before_stages;
  /*
   The accesses by which they wrote.
   */
  VkAccessFlags before_access;
  /*
   The stages that come after and have to wait; 0: none.
   */
  VkPipelineStageFlags after_stages;
  /*
   The accesses that they will make.
   */
  VkAccessFlags after_access;
} cupola_vk_target;

/*
 Counts since a `cupola_vk` was made.
 */
typedef struct cupola_vk_statistics {
  /*
   `sizeof(cupola_vk_statistics)`.
   */
  size_t struct_size;
  /*
   Frames recorded.
   */
  uint64_t frames;
  /*
   Frames since the last `cupola_vk_resize` of which is known how long the device took to correct them; a frame's
   time is known when the next one with the same images is recorded. Always 0 on devices without timestamps.
   */
  uint64_t measured_frames;
  /*
   The time of all of them, nanoseconds.
   */
  uint64_t nanoseconds;
  /*
   The time of the latest of them, nanoseconds.
   */
  uint64_t last_nanoseconds;
} cupola_vk_statistics;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 Plans `rig` and makes what it needs on the program's device. The rig may be freed afterwards.

 # Safety
 `rig` is a live handle; `options` points at a struct of `struct_size` bytes, whose handles are live and belong
 together; `vk` is writable.
 */
cupola_status cupola_vk_create(const cupola_rig *rig,
                               const struct cupola_vk_options *options,
                               struct cupola_vk **vk);

/*
 Plans anew for pictures of another size. Sources and targets that the program set are forgotten, and images that
 Cupola made are made anew. If the rig cannot be planned for that size, everything stays; after
 `CUPOLA_GRAPHICS` only another `cupola_vk_resize` or `cupola_vk_destroy` is of use.

 # Safety
 `vk` is a live handle, and no command buffer pending that was recorded with it.
 */
cupola_status cupola_vk_resize(struct cupola_vk *vk,
                               uint32_t width,
                               uint32_t height);

/*
 How many views there are. It changes only with `cupola_vk_resize`.

 # Safety
 `vk` is a live handle; `count` is writable.
 */
cupola_status cupola_vk_view_count(struct cupola_vk *vk, uint32_t *count);

/*
 Describes a view for a camera with these planes (0 < near < far; far may be infinite), in the program's own units.
 Set `view->struct_size` before.

 # Safety
 `vk` is a live handle; `view` points at a struct of `view->struct_size` bytes.
 */
cupola_status cupola_vk_get_view(struct cupola_vk *vk,
                                 uint32_t index,
                                 double near,
                                 double far,
                                 struct cupola_vk_view *view);

/*
 How many images hold the views of a frame: as many as there are views with `CUPOLA_VK_IMAGES`, otherwise one.

 # Safety
 `vk` is a live handle; `count` is writable.
 */
cupola_status cupola_vk_image_count(struct cupola_vk *vk,
                                    uint32_t *count);

/*
 How large image `index` of a frame is or, where the program brings it, has to be: width and height in pixels, and
 layers. It changes only with `cupola_vk_resize`.

 # Safety
 `vk` is a live handle; `width`, `height` and `layers` are writable.
 */
cupola_status cupola_vk_image_size(struct cupola_vk *vk,
                                   uint32_t index,
                                   uint32_t *width,
                                   uint32_t *height,
                                   uint32_t *layers);

/*
 Describes image `index` of frame `frame` that Cupola made: draw the views into it, and leave it in its `layout`.
 It can be drawn to, cleared and copied. Set `source->struct_size` before.

 # Safety
 `vk` is a live handle; `source` points at a struct of `source->struct_size` bytes.
 */
cupola_status cupola_vk_get_source(struct cupola_vk *vk,
                                   uint32_t frame,
                                   uint32_t index,
                                   struct cupola_vk_source *source);

/*
 Says which images the program draws the views into: `cupola_vk_image_count` for the first frame, then for the second,
 and so on for all `frames_in_flight`. Images that Cupola made are destroyed.

 # Safety
 `vk` is a live handle, and no command buffer pending that was recorded with it; `sources` points at `count` structs
 of `sources->struct_size` bytes, whose handles are live as long as the `cupola_vk`, or others are set.
 */
cupola_status cupola_vk_set_sources(struct cupola_vk *vk,
                                    uint32_t count,
                                    const struct cupola_vk_source *sources);

/*
 Says which images are corrected into, for `cupola_vk_record` to choose from: those of a swapchain for instance.

 # Safety
 As for `cupola_vk_set_sources`.
 */
cupola_status cupola_vk_set_targets(struct cupola_vk *vk,
                                    uint32_t count,
                                    const struct cupola_vk_target *targets);

/*
 Records the correction of frame `frame`'s images into target `target`, the left upper corner of the picture at (x, y)
 of it; what lies outside is cut off. On an error nothing is recorded. It makes no object of Vulkan and allocates none
 of its memory. Bound pipelines, descriptor sets, vertex buffers, viewports and scissors are other ones afterwards.

 # Safety
 `vk` is a live handle; the command buffer is being recorded, outside a render pass, for a queue of the options'
 family; all images are in the layouts that were said when it is executed.
 */
cupola_status cupola_vk_record(struct cupola_vk *vk,
                               VkCommandBuffer command_buffer,
                               uint32_t frame,
                               uint32_t target,
                               int32_t x,
                               int32_t y);

/*
 Counts so far. Set `statistics->struct_size` before.

 # Safety
 `vk` is a live handle; `statistics` points at a struct of its `struct_size` bytes.
 */
cupola_status cupola_vk_get_statistics(struct cupola_vk *vk,
                                       struct cupola_vk_statistics *statistics);

/*
 Destroys everything on the device; null is allowed.

 # Safety
 `vk` is a live handle whose device is live, with no command buffer pending that was recorded with it, or null; it
 must not be used again.
 */
cupola_status cupola_vk_destroy(struct cupola_vk *vk);

/*
 As `cupola_vk_create`, for a program that draws all views by the functions of `cupola_vk_projection_source`. An
 output with the method `vertex` or `primitive` then has one view, which is its own picture (pixel for pixel, but where layers have to be
 alike or the rig's `quality` asks for more); the matrices of `cupola_vk_get_view` do not lead there. Edges between vertices stay straight: the program's models have to be fine.

 # Safety
 As for `cupola_vk_create`.
 */
cupola_status cupola_vk_create_projecting(const cupola_rig *rig,
                                          const struct cupola_vk_options *options,
                                          struct cupola_vk **vk);

/*
 GLSL for the last stage before rasterisation: a uniform block with `vec4 cupola_view[8]` (std140) in descriptor set
 `set` at `binding`, and `vec4 cupola_fix(vec4)`, which takes what the program would give to `gl_Position`, with its own
 projection, to the view. It stands after `#version` (450 or later) and before `main`.

 `buffer`: room for `size` bytes, or null to ask only for the length. `length` (may be null): the whole text's length
 in bytes without the NUL. What does not fit is cut.

 # Safety
 `buffer` has room for `size` bytes or is null; `length` is null or writable.
 */
cupola_status cupola_vk_projection_source(uint32_t set,
                                          uint32_t binding,
                                          char *buffer,
                                          size_t size,
                                          size_t *length);

/*
 The 8 vectors of `cupola_view` for a view, if the program draws with the perspective `matrix` (16 numbers, column by
 column; Vulkan's clip space with y down). They change with the view, with the matrix and with the size.

 # Safety
 `vk` is a live handle; `matrix` points at 16 numbers, `vectors` at room for 32.
 */
cupola_status cupola_vk_get_projection(struct cupola_vk *vk,
                                       uint32_t index,
                                       const float *matrix,
                                       float *vectors);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* CUPOLA_VK_H */
