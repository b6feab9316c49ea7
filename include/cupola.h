/* Cupola: OpenGL and Vulkan programs on domes.
 *
 * Conventions:
 *
 * - Functions are called cupola_<type>_<verb>. Handles come first, results last. Each function
 *   returns a cupola_status, except those that return a version. cupola_last_error copies the
 *   message of an error.
 * - Any function may return CUPOLA_INVALID_ARGUMENT for a pointer that is null or misaligned, and
 *   CUPOLA_INTERNAL for a defect of the library. CUPOLA_OK is success and is listed only where
 *   nothing else is. Results are written on success only.
 * - Ownership: what a _create, _load or _parse function returns belongs to the caller, who passes
 *   it to _destroy or _free once. These accept null. Other pointers are not kept after the call.
 * - Threads: functions with different handles may be called at the same time from several threads,
 *   those with the same handle only where their comments say so. A handle may move from one thread
 *   to another.
 * - Structs that begin with struct_size may grow at their end in later versions. The caller sets
 *   struct_size to sizeof of its own struct and, in parameters, unused fields to 0. A library of
 *   another version serves it: missing fields count as 0; unknown fields of parameters have to be
 *   0, else the call returns CUPOLA_INVALID_ARGUMENT; unknown fields of results become 0, and
 *   struct_size stays. In every version 0 is the default of a field that was added after the first
 *   one.
 * - Texts are UTF-8 and NUL-terminated. Angles are in degrees, lengths in metres.
 *
 * Generated from src/ffi; do not edit.
 */

#ifndef CUPOLA_H
#define CUPOLA_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

/*
 Version of the binary interface. A program works with a library of the same number only.

 It grows when a function or a field is removed or changed, so that compiled programs have to be
 compiled again. Additions do not change it. History:

 - 1: since 0.1.
 */
#define CUPOLA_ABI_VERSION 1

/*
 Version of the interface's contents. A program works with a library of the same or a greater
 number.

 It grows with each addition. History:

 - 1: 0.1 as it was first published: rigs, exact directions, OpenGL (`cupola_gl_...`), blending,
   projecting shaders, and Vulkan (`cupola_vk_...`).
 - 2: `cupola_abi_version`, `cupola_api_version` and their macros; `cupola_set_log_callback`;
   structs of smaller and larger `struct_size` are served.
 */
#define CUPOLA_API_VERSION 2

/*
 Shape of a ramp: `3t^2 - 2t^3`.
 */
#define CUPOLA_RAMP_SMOOTHSTEP 0

/*
 Shape of a ramp: `1/2 - 1/2 cos(pi t)`.
 */
#define CUPOLA_RAMP_COSINE 1

/*
 Shape of a ramp: `(2t)^p / 2` for t up to 1/2, and its point reflection beyond.
 */
#define CUPOLA_RAMP_POWER 2

/*
 Angle from the pole of the dome.
 */
#define CUPOLA_ANGLE_POLAR 0

/*
 Angle around the pole of the dome.
 */
#define CUPOLA_ANGLE_AZIMUTH 1

/*
 Greatest number of ramps in angles of the dome.
 */
#define CUPOLA_MOST_RAMPS 8

/*
 Result of a call. `cupola_last_error` copies the message of an error. Numbers never change, and
 later versions may add some.
 */
typedef enum cupola_status {
  /*
   Success.
   */
  CUPOLA_OK = 0,
  /*
   An argument is null, misaligned, out of range or of a wrong size.
   */
  CUPOLA_INVALID_ARGUMENT = 1,
  /*
   A rig has a mistake: an unknown key or an impossible value.
   */
  CUPOLA_INVALID_RIG = 2,
  /*
   A file could not be read or written.
   */
  CUPOLA_IO = 3,
  /*
   The graphics driver lacks something that is needed, refused a request or lost its device.
   */
  CUPOLA_GRAPHICS = 4,
  /*
   The call is not allowed now, for example the end of a frame without its begin.
   */
  CUPOLA_INVALID_STATE = 5,
  /*
   A defect of the library. Objects that took part in the call can only be destroyed.
   */
  CUPOLA_INTERNAL = 6,
} cupola_status;

/*
 Importance of a message. Numbers never change, and later versions may add some.
 */
typedef enum cupola_log_level {
  /*
   A defect of the library.
   */
  CUPOLA_LOG_ERROR = 1,
  /*
   The picture may be wrong or worse than expected.
   */
  CUPOLA_LOG_WARNING = 2,
  /*
   Actions of the library, at creation and when sizes change.
   */
  CUPOLA_LOG_INFO = 3,
  /*
   Details for developers.
   */
  CUPOLA_LOG_DEBUG = 4,
} cupola_log_level;

/*
 A rig on an OpenGL context. Created by `cupola_gl_create` or `cupola_gl_create_projecting`,
 destroyed by `cupola_gl_destroy`.

 One thread at a time may use it. Functions that say "context current" need the context on which
 the object was created, current in the calling thread.
 */
typedef struct cupola_gl cupola_gl;

/*
 A rig: description of screen, viewer and outputs (projectors, domemasters, windows). Created by
 `cupola_rig_load` or `cupola_rig_parse`, freed by `cupola_rig_free`. It does not change; several
 threads may use it at the same time.
 */
typedef struct cupola_rig cupola_rig;

/*
 Receives a message of the library (see `cupola_set_log_callback`).

 `message` is UTF-8 without a newline at its end, NUL-terminated, valid during the call. `user`
 is the pointer that was passed to `cupola_set_log_callback`.

 The callback may be called from any thread, and from several at the same time. It returns
 normally: a `longjmp` or a C++ exception out of it is undefined behaviour. It may call functions
 of the library, except `cupola_set_log_callback` and those with a handle that is in use by the
 call from which the message comes; messages of these calls are discarded.
 */
typedef void (*cupola_log_callback)(enum cupola_log_level level, const char *message, void *user);

/*
 Function of OpenGL. Cast it to its own type before the call.
 */
typedef void (*cupola_gl_function)(void);

/*
 Returns the address of an OpenGL function, or NULL where the context has none of that name.

 `name` is NUL-terminated and valid during the call. The function has to find functions of OpenGL
 1.0 too, as `glXGetProcAddressARB`, `eglGetProcAddress` and `glfwGetProcAddress` do.
 */
typedef cupola_gl_function (*cupola_gl_get_proc_address)(const char *name);

/*
 Parameters of `cupola_gl_create`.
 */
typedef struct cupola_gl_options {
  /*
   `sizeof(cupola_gl_options)`.
   */
  size_t struct_size;
  /*
   Function that finds the OpenGL functions of the current context. Required.
   */
  cupola_gl_get_proc_address get_proc_address;
  /*
   Width in pixels of the picture that all outputs share (the window's width), 1 to 16384.
   */
  uint32_t width;
  /*
   Height of that picture in pixels, 1 to 16384.
   */
  uint32_t height;
} cupola_gl_options;

/*
 View: perspective image of the scene that the program draws. All matrices are stored column by
 column.
 */
typedef struct cupola_gl_view {
  /*
   `sizeof(cupola_gl_view)`.
   */
  size_t struct_size;
  /*
   Index of the view, from 0.
   */
  uint32_t index;
  /*
   Left edge of the view's tile, in pixels from the left of the atlas.
   */
  int32_t x;
  /*
   Bottom edge of the tile, in pixels from the bottom of the atlas.
   */
  int32_t y;
  /*
   Width of the tile in pixels.
   */
  int32_t width;
  /*
   Height of the tile in pixels.
   */
  int32_t height;
  /*
   Matrix from the program's camera axes (x right, y up, -z forward) to the clip space of the
   view: `frustum_matrix` times `rotation_matrix`. It replaces the program's projection matrix;
   the program's view matrix stays as it is, and with it the lighting.
   */
  float projection_matrix[16];
  /*
   Matrix from the program's camera axes to the axes of the view, for programs that cull or
   draw a sky by view. It has a translation where the rig moves the camera and in the views of
   a stereo rig.
   */
  float rotation_matrix[16];
  /*
   Matrix from the axes of the view to its clip space: an off-centre perspective matrix as that
   of `glFrustum`.
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
} cupola_gl_view;

/*
 Counts since the creation of a `cupola_gl`.
 */
typedef struct cupola_gl_statistics {
  /*
   `sizeof(cupola_gl_statistics)`.
   */
  size_t struct_size;
  /*
   Number of ended frames.
   */
  uint64_t frames;
  /*
   Number of begun views.
   */
  uint64_t views;
  /*
   Number of OpenGL errors that calls of the library caused. Anything but 0 is a defect.
   */
  uint64_t errors;
} cupola_gl_statistics;

/*
 Ramp in an angle of the dome. The struct is an element of `cupola_blend` and never grows.
 */
typedef struct cupola_angle_ramp {
  /*
   `CUPOLA_ANGLE_POLAR` or `CUPOLA_ANGLE_AZIMUTH`.
   */
  uint32_t angle;
  /*
   `CUPOLA_RAMP_SMOOTHSTEP`, `CUPOLA_RAMP_COSINE` or `CUPOLA_RAMP_POWER`.
   */
  uint32_t shape;
  /*
   Power p of `CUPOLA_RAMP_POWER`, 0.5 to 4; 1 is a straight line. Other shapes ignore it.
   */
  double power;
  /*
   Angle at which the weight is 0, in degrees.
   */
  double zero;
  /*
   Angle at which the weight is 1, in degrees.
   */
  double full;
} cupola_angle_ramp;

/*
 Blending of an output: the keys of `[output.blend]` in a rig file.
 */
typedef struct cupola_blend {
  /*
   `sizeof(cupola_blend)`.
   */
  size_t struct_size;
  /*
   Other than 0: projectors share the light where they overlap. For projectors only.
   */
  uint32_t overlap;
  /*
   Shape of the ramp at the borders of the picture: `CUPOLA_RAMP_SMOOTHSTEP`,
   `CUPOLA_RAMP_COSINE` or `CUPOLA_RAMP_POWER`.
   */
  uint32_t shape;
  /*
   Power p of `CUPOLA_RAMP_POWER`, 0.5 to 4. Other shapes ignore it.
   */
  double power;
  /*
   Width of that ramp as a part of the picture's width and height, 1e-6 to 0.5.
   */
  double ramp;
  /*
   Exponent of the picture's raw weight, 1 to 2.
   */
  double exponent;
  /*
   Exponent of the display's response, 1 to 4. Ignored where `srgb` is not 0.
   */
  double gamma;
  /*
   Light added to black, 0 (included) to 1 (excluded). Ignored where the rig has a picture of
   black.
   */
  double black_level;
  /*
   Light of white divided by that of black, at least 10; 0: overlaps of black are not evened
   out.
   */
  double contrast;
  /*
   Number of bits for which the picture is dithered, 6 to 16; 0 for no dithering.
   */
  uint32_t dither;
  /*
   Response of the display. 0: the power `gamma`. 1: sRGB. 2: the responses in the rig, of each
   channel or measured; only an output that has them accepts it.
   */
  uint32_t srgb;
  /*
   Number of elements of `ramps` that are used, 0 to `CUPOLA_MOST_RAMPS`.
   */
  size_t ramp_count;
  /*
   Ramps in angles of the dome.
   */
  struct cupola_angle_ramp ramps[8];
} cupola_blend;

/*
 Draws the program's scene into the current view (see `cupola_gl_draw_frame`).

 `view` is valid during the call; its `struct_size` is that of the library, which may be larger
 or smaller than the program's. `user` is the pointer that was passed to `cupola_gl_draw_frame`.
 */
typedef void (*cupola_gl_draw)(const struct cupola_gl_view *view, void *user);

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 Returns the `CUPOLA_ABI_VERSION` of the library. The macro is that of the header with which the
 program was compiled. If the two differ, the program must not use the library.

 # Threads
 Any thread.
 */
uint32_t cupola_abi_version(void);

/*
 Returns the `CUPOLA_API_VERSION` of the library. The library lacks functions and fields of later
 versions.

 # Threads
 Any thread.
 */
uint32_t cupola_api_version(void);

/*
 Returns the version of the library's package: major, minor and patch. To find out what the
 library can do, use `cupola_api_version`.

 # Parameters
 - `major`, `minor`, `patch`: receive the numbers; each may be null.

 # Returns
 `CUPOLA_OK`.

 # Threads
 Any thread.

 # Safety
 Each pointer is null or writable.
 */
enum cupola_status cupola_version(uint32_t *major, uint32_t *minor, uint32_t *patch);

/*
 Copies the message of the last error of the calling thread. It is empty before the first error
 and stays until the next one; success does not change it.

 # Parameters
 - `buffer`: room for `size` bytes, or null to get the length only. The message is cut to fit,
   with its NUL.
 - `size`: size of the buffer in bytes.
 - `length`: receives the length of the whole message in bytes without its NUL; may be null.

 # Returns
 `CUPOLA_OK`.

 # Threads
 Any thread. Each thread has a last error of its own.

 # Safety
 `buffer` has room for `size` bytes or is null; `length` is null or writable.
 */
enum cupola_status cupola_last_error(char *buffer, size_t size, size_t *length);

/*
 Loads a rig from a preset or from a file.

 # Parameters
 - `name_or_path`: name of a preset (`fisheye`, `planetarium-6`, ...) or path of a rig file,
   UTF-8.
 - `rig`: receives the new rig, on success only.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: a null pointer, or a text that is not UTF-8.
 - `CUPOLA_IO`: there is no such preset and no such file, or the file cannot be read.
 - `CUPOLA_INVALID_RIG`: the file has mistakes; `cupola_last_error` names all of them with their
   lines.

 # Ownership
 The caller owns `*rig` and frees it with `cupola_rig_free`.

 # Threads
 Any thread.

 # Safety
 `name_or_path` is NUL-terminated; `rig` is writable.
 */
enum cupola_status cupola_rig_load(const char *name_or_path, struct cupola_rig **rig);

/*
 Reads a rig from a text in the format of rig files (TOML).

 # Parameters
 - `toml`: the text, UTF-8.
 - `directory`: folder in which the files that the text names (masks, pictures of black, models)
   are looked up, UTF-8.
 - `rig`: receives the new rig, on success only.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: a null pointer, or a text that is not UTF-8.
 - `CUPOLA_IO`: a file that the text names cannot be read.
 - `CUPOLA_INVALID_RIG`: the text has mistakes; `cupola_last_error` names all of them with their
   lines.

 # Ownership
 The caller owns `*rig` and frees it with `cupola_rig_free`.

 # Threads
 Any thread.

 # Safety
 `toml` and `directory` are NUL-terminated; `rig` is writable.
 */
enum cupola_status cupola_rig_parse(const char *toml,
                                    const char *directory,
                                    struct cupola_rig **rig);

/*
 Returns the number of outputs of a rig.

 # Parameters
 - `rig`: the rig.
 - `count`: receives the number.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: a null pointer.

 # Threads
 Any thread, and several at the same time with the same rig.

 # Safety
 `rig` is a live handle; `count` is writable.
 */
enum cupola_status cupola_rig_output_count(const struct cupola_rig *rig, uint32_t *count);

/*
 Frees a rig. Objects that were created from it stay.

 # Parameters
 - `rig`: the rig, or null, which does nothing.

 # Returns
 `CUPOLA_OK`.

 # Threads
 Any thread; no other thread may use the rig at the same time.

 # Safety
 `rig` is a live handle or null. It must not be used afterwards.
 */
enum cupola_status cupola_rig_free(struct cupola_rig *rig);

/*
 Sets the function that receives the messages of the library, or removes it. There is one for the
 whole process.

 Without a callback, warnings of an injected library (`cupola run`) go to standard error and to
 the file that `CUPOLA_LOG` names; other messages are discarded. With a callback, it receives all
 of them instead.

 # Parameters
 - `callback`: the function, or null to remove the current one.
 - `user`: passed to the callback; may be null.

 # Returns
 - `CUPOLA_INVALID_STATE`: called from the callback, or the program is written in Rust and has a
   logger of its own.

 # Ownership
 `user` belongs to the program. It has to live until this function has returned from setting
 another callback or from the removal: from then on the earlier callback is not running and will
 not be called again.

 # Threads
 Any thread. The function waits until calls of the earlier callback have returned; so the caller
 must not hold a lock that this callback needs.

 # Safety
 `callback` can be called from any thread with `user`.
 */
enum cupola_status cupola_set_log_callback(cupola_log_callback callback, void *user);

/*
 Computes the direction that a pixel of an output shows, in double precision and without a GPU.

 # Parameters
 - `rig`: the rig.
 - `output`: index of the output, from 0.
 - `width`, `height`: size of the output in pixels, at least 1.
 - `column`, `row`: point in pixels from the top left corner; centres of pixels are at + 0.5.
 - `direction`: receives 3 numbers: a unit vector in the axes of the program's camera (x right, y
   up, -z forward), or 3 NaN where the point shows nothing.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: a null pointer, an output that does not exist, a size of 0, or a
   point that is not finite.

 # Threads
 Any thread, and several at the same time with the same rig.

 # Safety
 `rig` is a live handle; `direction` has room for 3 numbers.
 */
enum cupola_status cupola_map_direction(const struct cupola_rig *rig,
                                        uint32_t output,
                                        uint32_t width,
                                        uint32_t height,
                                        double column,
                                        double row,
                                        double *direction);

/*
 Plans the views of a rig and creates what they need on the current context, which must be OpenGL
 3.3 or OpenGL ES 3.0 at least, with a window or without one (surfaceless).

 # Parameters
 - `rig`: the rig. The library copies what it needs; the rig may be freed afterwards.
 - `options`: size of the picture, and the function that finds OpenGL's functions. Not kept.
 - `gl`: receives the new object, on success only.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: a null pointer, a size out of range, a field that this version does
   not know, or a rig that corrects nothing (`identity`).
 - `CUPOLA_INVALID_STATE`: no context is current in this thread.
 - `CUPOLA_GRAPHICS`: the context is too old, lacks a function or has no memory left.

 # Ownership
 The caller owns `*gl` and destroys it with `cupola_gl_destroy`.

 # Threads
 Context current. Several objects, in several threads, are independent.

 # Safety
 `rig` is a live handle; `options` points to `options->struct_size` bytes; `gl` is writable; a
 context is current whose functions `get_proc_address` finds.
 */
enum cupola_status cupola_gl_create(const struct cupola_rig *rig,
                                    const struct cupola_gl_options *options,
                                    struct cupola_gl **gl);

/*
 Plans the views again for a picture of another size. Number and tiles of the views may change.
 On an error the old size stays.

 # Parameters
 - `gl`: the object, outside a frame.
 - `width`, `height`: size of the picture in pixels, 1 to 16384.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: `gl` is null, or the size is out of range.
 - `CUPOLA_INVALID_STATE`: a frame has begun and not ended, or the context is not current.
 - `CUPOLA_GRAPHICS`: the driver refused a request.

 # Threads
 Context current.

 # Safety
 `gl` is a live handle.
 */
enum cupola_status cupola_gl_resize(struct cupola_gl *gl, uint32_t width, uint32_t height);

/*
 Moves and turns the viewer, for whose place the picture is correct, and plans the views again.
 Number and tiles of the views may change. On an error the old viewer stays.

 This takes about as long as `cupola_gl_create`: it is for a viewer who takes another seat, not
 for a tracked one.

 # Parameters
 - `gl`: the object, outside a frame.
 - `position`: 3 numbers, metres from the centre of the dome: x right, y up, z backward.
 - `yaw`, `pitch`, `roll`: degrees to the right, up, and clockwise.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: a null pointer, or a viewer outside the screen or not finite.
 - `CUPOLA_INVALID_STATE`: a frame has begun and not ended, or the context is not current.
 - `CUPOLA_GRAPHICS`: the driver refused a request.

 # Threads
 Context current.

 # Safety
 `gl` is a live handle; `position` points to 3 numbers.
 */
enum cupola_status cupola_gl_set_viewer(struct cupola_gl *gl,
                                        const double *position,
                                        double yaw,
                                        double pitch,
                                        double roll);

/*
 Returns the number of views. Only `cupola_gl_resize` and `cupola_gl_set_viewer` change it.

 # Parameters
 - `gl`: the object.
 - `count`: receives the number, at least 1.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: a null pointer.

 # Threads
 Any thread; no context is needed.

 # Safety
 `gl` is a live handle; `count` is writable.
 */
enum cupola_status cupola_gl_view_count(struct cupola_gl *gl, uint32_t *count);

/*
 Describes a view, for a camera with the given near and far planes.

 # Parameters
 - `gl`: the object.
 - `index`: index of the view, less than the number that `cupola_gl_view_count` returns.
 - `near`, `far`: distances of the planes in the program's units, 0 < near < far. `far` may be
   infinite.
 - `view`: receives the description. The caller sets `view->struct_size` before.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: a null pointer, a wrong `struct_size`, an index without a view, or
   wrong planes.

 # Threads
 Any thread; no context is needed.

 # Safety
 `gl` is a live handle; `view` points to `view->struct_size` writable bytes.
 */
enum cupola_status cupola_gl_get_view(struct cupola_gl *gl,
                                      uint32_t index,
                                      double near,
                                      double far,
                                      struct cupola_gl_view *view);

/*
 Returns counts since the creation of the object.

 # Parameters
 - `gl`: the object.
 - `statistics`: receives the counts. The caller sets `statistics->struct_size` before.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: a null pointer, or a wrong `struct_size`.

 # Threads
 Any thread; no context is needed.

 # Safety
 `gl` is a live handle; `statistics` points to `statistics->struct_size` writable bytes.
 */
enum cupola_status cupola_gl_get_statistics(struct cupola_gl *gl,
                                            struct cupola_gl_statistics *statistics);

/*
 Destroys an object and everything that it created on the context.

 # Parameters
 - `gl`: the object, or null, which does nothing.

 # Returns
 - `CUPOLA_INVALID_STATE`: called in `draw` of `cupola_gl_draw_frame`; the object lives on. Or
   its context is not current; the object is destroyed, and what it made on the context is left
   to the end of the context.

 # Threads
 Context current.

 # Safety
 `gl` is a live handle or null. It must not be used afterwards, unless it was refused in `draw`.
 */
enum cupola_status cupola_gl_destroy(struct cupola_gl *gl);

/*
 Returns the blending of an output.

 # Parameters
 - `gl`: the object.
 - `output`: index of the output in the rig, from 0.
 - `blend`: receives the values. The caller sets `blend->struct_size` before.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: a null pointer, a wrong `struct_size`, or an output that does not
   exist.

 # Threads
 Any thread; no context is needed.

 # Safety
 `gl` is a live handle; `blend` points to `blend->struct_size` writable bytes.
 */
enum cupola_status cupola_gl_get_blend(struct cupola_gl *gl,
                                       uint32_t output,
                                       struct cupola_blend *blend);

/*
 Changes the blending of an output from the next frame on. The views stay. Shaders are compiled
 again, which takes milliseconds. On an error everything stays.

 To change single values, read all with `cupola_gl_get_blend` first.

 # Parameters
 - `gl`: the object, outside a frame.
 - `output`: index of the output in the rig, from 0.
 - `blend`: the values. Not kept.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: a null pointer, a wrong `struct_size`, a field that this version
   does not know, an output that does not exist, a value out of its range, or `overlap` for an
   output that is no projector.
 - `CUPOLA_INVALID_STATE`: a frame has begun and not ended.
 - `CUPOLA_GRAPHICS`: the driver refused a request.

 # Threads
 Context current.

 # Safety
 `gl` is a live handle; `blend` points to `blend->struct_size` bytes.
 */
enum cupola_status cupola_gl_set_blend(struct cupola_gl *gl,
                                       uint32_t output,
                                       const struct cupola_blend *blend);

/*
 Begins a frame.

 # Parameters
 - `gl`: the object, outside a frame.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: `gl` is null.
 - `CUPOLA_INVALID_STATE`: a frame has begun and not ended, or the context is not current.

 # Threads
 Context current.

 # Safety
 `gl` is a live handle.
 */
enum cupola_status cupola_gl_begin_frame(struct cupola_gl *gl);

/*
 Begins a view: binds its tile for drawing and sets viewport and scissor to it. The program then
 clears the tile and draws the scene with the view's matrices. A program that draws into a
 framebuffer of its own in between binds the earlier one again.

 # Parameters
 - `gl`: the object, inside a frame and outside a view.
 - `index`: index of the view, less than the number that `cupola_gl_view_count` returns. A view
   may be drawn more than once in a frame.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: `gl` is null, or there is no such view.
 - `CUPOLA_INVALID_STATE`: no frame has begun, a view has begun and not ended, or the context is
   not current.

 # Threads
 Context current.

 # Safety
 `gl` is a live handle.
 */
enum cupola_status cupola_gl_begin_view(struct cupola_gl *gl, uint32_t index);

/*
 Ends a view: framebuffer bindings, viewport and scissor become what they were before it.

 # Parameters
 - `gl`: the object, inside a view.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: `gl` is null.
 - `CUPOLA_INVALID_STATE`: no view has begun.

 # Threads
 Context current.

 # Safety
 `gl` is a live handle.
 */
enum cupola_status cupola_gl_end_view(struct cupola_gl *gl);

/*
 Ends a frame: corrects the views into a framebuffer. All state of the context is the same
 afterwards. An OpenGL error that was pending is kept for `cupola_gl_take_error`.

 # Parameters
 - `gl`: the object, inside a frame and outside a view.
 - `framebuffer`: name of a complete framebuffer, 0 for the window.
 - `x`, `y`: lower left corner of the picture in the framebuffer, in pixels.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: `gl` is null, or the context has no such framebuffer, or it is not
   complete. The frame has not ended then.
 - `CUPOLA_INVALID_STATE`: no frame has begun, a view has not ended, or the context is not
   current.

 # Threads
 Context current.

 # Safety
 `gl` is a live handle.
 */
enum cupola_status cupola_gl_end_frame(struct cupola_gl *gl,
                                       uint32_t framebuffer,
                                       int32_t x,
                                       int32_t y);

/*
 Draws a whole frame: begins it, calls `draw` for each view between its begin and its end, and
 ends it.

 # Parameters
 - `gl`: the object, outside a frame.
 - `near`, `far`: as for `cupola_gl_get_view`.
 - `draw`: draws the scene into one view. It must not call functions with the same `gl`, and it
   returns normally: a `longjmp` or a C++ exception out of it is undefined behaviour.
 - `user`: passed to `draw`; may be null.
 - `framebuffer`, `x`, `y`: as for `cupola_gl_end_frame`.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: `gl` or `draw` is null, the planes are wrong, or the context has no
   such framebuffer. `draw` was not called.
 - `CUPOLA_INVALID_STATE`: a frame has begun and not ended, or the context is not current.

 # Threads
 Context current. `draw` is called in the calling thread, before this function returns.

 # Safety
 `gl` is a live handle; `draw` and `user` fit each other.
 */
enum cupola_status cupola_gl_draw_frame(struct cupola_gl *gl,
                                        double near,
                                        double far,
                                        cupola_gl_draw draw,
                                        void *user,
                                        uint32_t framebuffer,
                                        int32_t x,
                                        int32_t y);

/*
 Returns the OpenGL error that the program had pending at the end of a frame, and forgets it. Of
 several frames the oldest error is kept.

 # Parameters
 - `gl`: the object.
 - `error`: receives the error code, `GL_NO_ERROR` (0) where there is none.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: a null pointer.

 # Threads
 Any thread; no context is needed.

 # Safety
 `gl` is a live handle; `error` is writable.
 */
enum cupola_status cupola_gl_take_error(struct cupola_gl *gl, uint32_t *error);

/*
 Does what `cupola_gl_create` does, for a program that draws all views with the functions of
 `cupola_gl_projection_source`.

 An output with the method `vertex` or `primitive` then has one view, which is its own picture,
 pixel for pixel; the matrices of `cupola_gl_get_view` do not apply to it. Edges between vertices
 stay straight, so the program's models have to be fine.

 # Parameters
 As for `cupola_gl_create`.

 # Returns
 As for `cupola_gl_create`.

 # Ownership
 The caller owns `*gl` and destroys it with `cupola_gl_destroy`.

 # Threads
 Context current.

 # Safety
 As for `cupola_gl_create`.
 */
enum cupola_status cupola_gl_create_projecting(const struct cupola_rig *rig,
                                               const struct cupola_gl_options *options,
                                               struct cupola_gl **gl);

/*
 Copies GLSL for the last shader stage before rasterisation: `uniform vec4 cupola_view[8]`, and
 `vec4 cupola_fix(vec4)`, which turns the value for `gl_Position`, computed with the program's
 own projection, into that of the view. The text belongs between `#version` (GLSL 1.20 or ESSL
 3.00 at least) and `main`.

 # Parameters
 - `for_es`: 0 for GLSL, any other value for ESSL.
 - `buffer`: room for `size` bytes, or null to get the length only. The text is cut to fit, with
   its NUL.
 - `size`: size of the buffer in bytes.
 - `length`: receives the length of the whole text in bytes without its NUL; may be null.

 # Returns
 `CUPOLA_OK`, or `CUPOLA_INTERNAL`.

 # Threads
 Any thread; no context is needed.

 # Safety
 `buffer` has room for `size` bytes or is null; `length` is null or writable.
 */
enum cupola_status cupola_gl_projection_source(int32_t for_es,
                                               char *buffer,
                                               size_t size,
                                               size_t *length);

/*
 Computes the 8 vectors of the uniform `cupola_view` for a view. They depend on the view, on the
 matrix and on the size of the picture.

 # Parameters
 - `gl`: the object.
 - `index`: index of the view.
 - `matrix`: 16 numbers, column by column: the perspective matrix with which the program draws.
 - `vectors`: receives 32 numbers.

 # Returns
 - `CUPOLA_INVALID_ARGUMENT`: a null pointer, an index without a view, or a matrix that is no
   perspective.

 # Threads
 Any thread; no context is needed.

 # Safety
 `gl` is a live handle; `matrix` points to 16 numbers, `vectors` to room for 32.
 */
enum cupola_status cupola_gl_get_projection(struct cupola_gl *gl,
                                            uint32_t index,
                                            const float *matrix,
                                            float *vectors);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* CUPOLA_H */
