/* Cupola: existing OpenGL programs on domes.
 *
 * Grammar: every function is cupola_<type>_<verb> and returns a cupola_status; handles come first,
 * outputs last, and outputs are written only on success. _free and _destroy accept NULL. Structs that
 * may grow begin with struct_size. Strings are UTF-8. A handle may be used by one thread at a time.
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
 A ramp `3t² − 2t³`.
 */
#define CUPOLA_RAMP_SMOOTHSTEP 0

/*
 A ramp `½ − ½·cos(πt)`.
 */
#define CUPOLA_RAMP_COSINE 1

/*
 A ramp of two halves of a power.
 */
#define CUPOLA_RAMP_POWER 2

/*
 An angle from the dome's pole.
 */
#define CUPOLA_ANGLE_POLAR 0

/*
 An angle around the dome's pole.
 */
#define CUPOLA_ANGLE_AZIMUTH 1

/*
 Most ramps in angles of the dome.
 */
#define CUPOLA_MOST_RAMPS 8

/*
 What became of a call. The numbers never change.
 */
typedef enum cupola_status {
  /*
   Done.
   */
  CUPOLA_OK = 0,
  /*
   An argument is null, out of range or of the wrong size.
   */
  CUPOLA_INVALID_ARGUMENT = 1,
  /*
   A rig says something impossible, unknown or misspelt.
   */
  CUPOLA_INVALID_RIG = 2,
  /*
   A file could not be read or written.
   */
  CUPOLA_IO = 3,
  /*
   The graphics driver lacks something that is needed, or refused a request.
   */
  CUPOLA_GRAPHICS = 4,
  /*
   A call came in the wrong order.
   */
  CUPOLA_INVALID_STATE = 5,
  /*
   A defect of Cupola itself.
   */
  CUPOLA_INTERNAL = 6,
} cupola_status;

/*
 Cupola on an OpenGL context. Free it with `cupola_gl_destroy`, with the same context current.
 */
typedef struct cupola_gl cupola_gl;

/*
 A rig: what stands where. Immutable; free it with `cupola_rig_free`.
 */
typedef struct cupola_rig cupola_rig;

/*
 A function of OpenGL, to be cast to its own type.
 */
typedef void (*cupola_gl_function)(void);

/*
 Finds an OpenGL function by its name, like `glXGetProcAddressARB`, `eglGetProcAddress` or
 `glfwGetProcAddress`; must find core functions too.
 */
typedef cupola_gl_function (*cupola_gl_get_proc_address)(const char *name);

/*
 What to make a `cupola_gl` from.
 */
typedef struct cupola_gl_options {
  /*
   `sizeof(cupola_gl_options)`.
   */
  size_t struct_size;
  /*
   Finds the OpenGL functions of the current context.
   */
  cupola_gl_get_proc_address get_proc_address;
  /*
   Width of the picture that all outputs share (the window's), pixels, 1…16384.
   */
  uint32_t width;
  /*
   Height of the picture, pixels, 1…16384.
   */
  uint32_t height;
} cupola_gl_options;

/*
 A view: what to draw, and where.
 */
typedef struct cupola_gl_view {
  /*
   `sizeof(cupola_gl_view)`.
   */
  size_t struct_size;
  /*
   Its number, from 0.
   */
  uint32_t index;
  /*
   Left edge of its tile in the atlas, pixels from the left.
   */
  int32_t x;
  /*
   Bottom edge of its tile, pixels from the bottom.
   */
  int32_t y;
  /*
   Width of its tile, pixels.
   */
  int32_t width;
  /*
   Height of its tile, pixels.
   */
  int32_t height;
  /*
   The program's camera axes → clip space of this view, column by column: use it in place of the
   program's own projection. The program's view matrix, and so its lighting, stays as it is.
   It is `frustum_matrix` · `rotation_matrix`.
   */
  float projection_matrix[16];
  /*
   The program's camera axes → axes of the view, for programs that cull or draw a sky by view. It moves, too, where
   the rig moves the camera or the view is for one of two eyes.
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
} cupola_gl_view;

/*
 Draws the program's scene into the view that is begun. `user` is the program's own.
 */
typedef void (*cupola_gl_draw)(const struct cupola_gl_view *view, void *user);

/*
 Counts since a `cupola_gl` was made.
 */
typedef struct cupola_gl_statistics {
  /*
   `sizeof(cupola_gl_statistics)`.
   */
  size_t struct_size;
  /*
   Frames ended.
   */
  uint64_t frames;
  /*
   Views begun.
   */
  uint64_t views;
  /*
   OpenGL errors that Cupola's own calls caused; 0 unless something is wrong.
   */
  uint64_t errors;
} cupola_gl_statistics;

/*
 A ramp in an angle of the dome.
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
   The power, 0.5…4, of `CUPOLA_RAMP_POWER`.
   */
  double power;
  /*
   Where the weight is 0, degrees.
   */
  double zero;
  /*
   Where the weight is 1, degrees.
   */
  double full;
} cupola_angle_ramp;

/*
 How an output is blended: the keys of `[output.blend]` in a rig file.
 */
typedef struct cupola_blend {
  /*
   `sizeof(cupola_blend)`.
   */
  size_t struct_size;
  /*
   Not 0: the light is shared where projectors overlap.
   */
  uint32_t overlap;
  /*
   Shape of the ramp at the borders: `CUPOLA_RAMP_SMOOTHSTEP`, `CUPOLA_RAMP_COSINE` or `CUPOLA_RAMP_POWER`.
   */
  uint32_t shape;
  /*
   The power, 0.5…4, of `CUPOLA_RAMP_POWER`.
   */
  double power;
  /*
   Width of that ramp as a part of the picture's width and height, 1e-6…0.5.
   */
  double ramp;
  /*
   Exponent of the picture's claim on a point, 1…2.
   */
  double exponent;
  /*
   Exponent of the display's response, 1…4.
   */
  double gamma;
  /*
   Light added to black, 0…1 (excluded); without effect where the rig file has a picture of black.
   */
  double black_level;
  /*
   White over black, at least 10; 0: not evened out.
   */
  double contrast;
  /*
   Bits to dither for, 6…16; 0: not dithered.
   */
  uint32_t dither;
  /*
   1: the display has the response of sRGB; 2: those of the rig, which `gamma` does not describe; 0: `gamma`.
   */
  uint32_t srgb;
  /*
   How many of `ramps` there are.
   */
  size_t ramp_count;
  /*
   Ramps in angles of the dome.
   */
  struct cupola_angle_ramp ramps[8];
} cupola_blend;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/*
 Copies the detail of the last error of this thread, cut to `size` bytes with its NUL.

 `buffer`: room for `size` bytes, or null to ask only for the length. `length` (may be null): the
 whole detail's length in bytes without the NUL. Before any error the detail is empty. The detail
 stays until the next error.

 # Safety
 `buffer` has room for `size` bytes or is null; `length` is null or writable.
 */
enum cupola_status cupola_last_error(char *buffer, size_t size, size_t *length);

/*
 The version of the library, major, minor and patch; each pointer may be null.

 # Safety
 Each pointer is null or writable.
 */
enum cupola_status cupola_version(uint32_t *major, uint32_t *minor, uint32_t *patch);

/*
 Loads a rig from a preset's name or a file.

 # Safety
 `name_or_path` is NUL-terminated; `rig` is writable.
 */
enum cupola_status cupola_rig_load(const char *name_or_path, struct cupola_rig **rig);

/*
 Reads a rig from the text of a rig file. Masks and pictures of black are looked up in `directory`.

 # Safety
 `toml` and `directory` are NUL-terminated; `rig` is writable.
 */
enum cupola_status cupola_rig_parse(const char *toml,
                                    const char *directory,
                                    struct cupola_rig **rig);

/*
 How many outputs a rig has.

 # Safety
 `rig` is a live handle or null; `count` is writable or null.
 */
enum cupola_status cupola_rig_output_count(const struct cupola_rig *rig, uint32_t *count);

/*
 Frees a rig; null is allowed. What was made from it lives on.

 # Safety
 `rig` is a live handle or null; it must not be used again.
 */
enum cupola_status cupola_rig_free(struct cupola_rig *rig);

/*
 The direction that a pixel of an output shows, exactly: a unit vector in the eye axes of the
 program's camera (x right, y up, -z forward), or three NaN where the pixel shows nothing.

 `output`: counted from 0. `width`, `height`: the output's size in pixels. `column`, `row`: the
 point in pixels from the top left; pixel centres are at + 0.5.

 # Safety
 `rig` is a live handle; `direction` has room for three doubles.
 */
enum cupola_status cupola_map_direction(const struct cupola_rig *rig,
                                        uint32_t output,
                                        uint32_t width,
                                        uint32_t height,
                                        double column,
                                        double row,
                                        double *direction);

/*
 Plans `rig` and makes what it needs on the current context: OpenGL 3.3 or OpenGL ES 3.0 at least,
 with a window or without (surfaceless). The rig may be freed afterwards.

 # Safety
 `rig` is a live handle; `options` points at a struct of `struct_size` bytes; `gl` is writable; a
 context is current whose functions `get_proc_address` finds.
 */
enum cupola_status cupola_gl_create(const struct cupola_rig *rig,
                                    const struct cupola_gl_options *options,
                                    struct cupola_gl **gl);

/*
 Plans anew for pictures of another size; between frames. On an error the old size stays.

 # Safety
 `gl` is a live handle whose context is current.
 */
enum cupola_status cupola_gl_resize(struct cupola_gl *gl, uint32_t width, uint32_t height);

/*
 Moves and turns the viewer, whose correct point of view the pictures have; between frames. `position`: metres
 from the dome's centre, x right, y up, z backward; degrees, to the right, up, clockwise. As `cupola_gl_resize` this
 plans anew and may change number and place of views; it takes about as long as making a `cupola_gl`, so
 that it is for a viewer who sits down elsewhere, not for one who is tracked. On an error the old viewer stays.

 # Safety
 `gl` is a live handle whose context is current; `position` points at three numbers.
 */
enum cupola_status cupola_gl_set_viewer(struct cupola_gl *gl,
                                        const double *position,
                                        double yaw,
                                        double pitch,
                                        double roll);

/*
 How many views there are. It changes only with `cupola_gl_resize` and `cupola_gl_set_viewer`.

 # Safety
 `gl` is a live handle; `count` is writable.
 */
enum cupola_status cupola_gl_view_count(struct cupola_gl *gl, uint32_t *count);

/*
 Describes a view for a camera with these planes (0 < near < far; far may be infinite), in the
 program's own units. Set `view->struct_size` before.

 # Safety
 `gl` is a live handle; `view` points at a struct of `view->struct_size` bytes.
 */
enum cupola_status cupola_gl_get_view(struct cupola_gl *gl,
                                      uint32_t index,
                                      double near,
                                      double far,
                                      struct cupola_gl_view *view);

/*
 Begins a frame.

 # Safety
 `gl` is a live handle whose context is current.
 */
enum cupola_status cupola_gl_begin_frame(struct cupola_gl *gl);

/*
 Begins a view: its tile is bound for drawing, with viewport and scissor on it. Clear it and draw
 the scene with the view's matrices; to draw into a framebuffer of your own in between, bind what
 was bound again.

 # Safety
 `gl` is a live handle whose context is current.
 */
enum cupola_status cupola_gl_begin_view(struct cupola_gl *gl, uint32_t index);

/*
 Ends a view: framebuffer bindings, viewport and scissor are as before it.

 # Safety
 `gl` is a live handle whose context is current.
 */
enum cupola_status cupola_gl_end_view(struct cupola_gl *gl);

/*
 Ends a frame: corrects the views into `framebuffer` (0 = the window) with its lower left corner at
 (x, y). All other state of the context is left as it was; an error that was pending before is kept
 for `cupola_gl_take_error`, since asking OpenGL for errors takes them away.

 # Safety
 `gl` is a live handle whose context is current; `framebuffer` is complete.
 */
enum cupola_status cupola_gl_end_frame(struct cupola_gl *gl,
                                       uint32_t framebuffer,
                                       int32_t x,
                                       int32_t y);

/*
 A whole frame: begins it, begins each view, has the program draw it, ends it.

 # Safety
 As for the functions that it stands for; `draw` may use the pointer to the view only while it runs,
 and must not call functions of the same `cupola_gl`.
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
 The OpenGL error that the program had pending at the end of a frame (0 = none), once.

 # Safety
 `gl` is a live handle; `error` is writable.
 */
enum cupola_status cupola_gl_take_error(struct cupola_gl *gl, uint32_t *error);

/*
 Counts so far. Set `statistics->struct_size` before.

 # Safety
 `gl` is a live handle; `statistics` points at a struct of its `struct_size` bytes.
 */
enum cupola_status cupola_gl_get_statistics(struct cupola_gl *gl,
                                            struct cupola_gl_statistics *statistics);

/*
 Deletes everything, on the context and off it; null is allowed.

 # Safety
 `gl` is a live handle whose context is current, or null; it must not be used again.
 */
enum cupola_status cupola_gl_destroy(struct cupola_gl *gl);

/*
 As `cupola_gl_create`, for a program that draws all views by the functions of `cupola_gl_projection_source`. An
 output with the method `vertex` or `primitive` then has one view, which is its own picture, pixel for pixel; the matrices of
 `cupola_gl_get_view` do not lead there. Edges between vertices stay straight: the program's models have to be fine.

 # Safety
 As for `cupola_gl_create`.
 */
enum cupola_status cupola_gl_create_projecting(const struct cupola_rig *rig,
                                               const struct cupola_gl_options *options,
                                               struct cupola_gl **gl);

/*
 GLSL for the last stage before rasterisation: `uniform vec4 cupola_view[8]` and `vec4 cupola_fix(vec4)`, which takes
 what the program would give to `gl_Position`, with its own projection, to the view. It stands after `#version` and
 before `main`, and needs GLSL 1.20 or ESSL 3.00 (`for_es` not 0).

 `buffer`: room for `size` bytes, or null to ask only for the length. `length` (may be null): the whole text's length
 in bytes without the NUL. What does not fit is cut.

 # Safety
 `buffer` has room for `size` bytes or is null; `length` is null or writable.
 */
enum cupola_status cupola_gl_projection_source(int32_t for_es,
                                               char *buffer,
                                               size_t size,
                                               size_t *length);

/*
 The 8 vectors of `cupola_view` for a view, if the program draws with the perspective `matrix` (16 numbers, column by
 column). They change with the view, with the matrix and with the size.

 # Safety
 `gl` is a live handle; `matrix` points at 16 numbers, `vectors` at room for 32.
 */
enum cupola_status cupola_gl_get_projection(struct cupola_gl *gl,
                                            uint32_t index,
                                            const float *matrix,
                                            float *vectors);

/*
 How an output (numbered as in the rig, from 0) is blended now. Set `blend->struct_size` before.

 # Safety
 `gl` is a live handle; `blend` points at a struct of `blend->struct_size` bytes.
 */
enum cupola_status cupola_gl_get_blend(struct cupola_gl *gl,
                                       uint32_t output,
                                       struct cupola_blend *blend);

/*
 Blends an output otherwise from the next frame on; between frames. Shaders are made anew, which takes
 milliseconds; views stay. On an error everything stays.

 # Safety
 `gl` is a live handle whose context is current; `blend` points at a struct of `blend->struct_size` bytes.
 */
enum cupola_status cupola_gl_set_blend(struct cupola_gl *gl,
                                       uint32_t output,
                                       const struct cupola_blend *blend);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* CUPOLA_H */
