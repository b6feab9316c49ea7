/* The scene of both examples: three gears around the eye, lit from above. Include OpenGL first. */
#ifndef GEARS_SCENE_H
#define GEARS_SCENE_H

#include <stdbool.h>

enum { GEARS = 3 };

typedef struct {
    GLuint program, arrays[GEARS], buffers[GEARS];
    GLsizei vertices[GEARS];
    GLint projection, modelview, colour;
} scene;

/* Creates the scene on the current context, which must have OpenGL 3.3 or later. Prints a message and returns false if
 * that fails. */
bool scene_create(scene *s);

/* The camera: world to eye axes, column-major. */
void scene_camera(float view[16]);

/* A symmetric perspective, column-major; the vertical field of view is in degrees. */
void scene_perspective(float projection[16], float field_of_view, float aspect);

/* Clears the bound framebuffer's viewport and draws the gears in their positions after `seconds`. */
void scene_draw(const scene *s, double seconds, const float view[16], const float projection[16]);

void scene_destroy(scene *s);

#endif
