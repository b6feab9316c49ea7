/*
 * The scene of every direction test: the inside of the cube [-1, 1]^3 around the eye.
 *
 * A vertex has the colour 0.5 + 0.5 * position. This is linear in the position, so that perspective
 * interpolation is exact and each pixel's colour gives the direction that the pixel shows: for the
 * unit direction d it is 0.5 + 0.5 * d / max(|d.x|, |d.y|, |d.z|).
 */
#ifndef APPS_CUBE_H
#define APPS_CUBE_H

enum { CUBE_CORNERS = 8, CUBE_INDICES = 36 };

/* The programs draw the cube larger by this factor, between their near and far planes. */
#define CUBE_SCALE 10.0
#define CUBE_NEAR 0.25
#define CUBE_FAR 100.0

/* Corner i is at x = bit 0, y = bit 1, z = bit 2 of i (0: -1, 1: +1). */
extern const float cube_positions[CUBE_CORNERS][3];
extern const float cube_colours[CUBE_CORNERS][3];

/* Two triangles for each face; faces in the order -x +x -y +y -z +z. */
extern const unsigned short cube_indices[CUBE_INDICES];

#endif
