/* 4x4 matrices of floats, column-major as OpenGL reads them. Angles are in degrees. */
#ifndef APPS_MATRIX_H
#define APPS_MATRIX_H

typedef struct {
    float m[16];
} matrix4;

matrix4 matrix_identity(void);

/* a * b: b is applied first. */
matrix4 matrix_multiply(matrix4 a, matrix4 b);

/* A symmetric perspective with the vertical field of view `fov`. */
matrix4 matrix_perspective(double fov, double aspect, double near, double far);

/*
 * From the world to the eye, for a camera at the origin that is turned right by `yaw`, then up by
 * `pitch`.
 */
matrix4 matrix_camera(double yaw, double pitch);

/* Uniform scale. */
matrix4 matrix_scale(double factor);
matrix4 matrix_transposed(matrix4 m);

/* Inverse matrix, by Gauss-Jordan elimination in 64 bits. */
matrix4 matrix_inverse(matrix4 m);

matrix4 matrix_translate(double x, double y, double z);

/*
 * Number of pixels of a picture whose direction has a negative x. `back` converts from clip
 * coordinates.
 */
unsigned pixels_to_the_left(const matrix4 *back, unsigned width, unsigned height);

#endif
