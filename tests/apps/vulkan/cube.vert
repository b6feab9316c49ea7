#version 450
/*
 * The direction test's cube: a corner has the colour of its position. With CELLS its faces are
 * divided as in ../common/cells.c: into triangles (instance 0), on a ball with the cube's colours
 * (1), in inverted colours around that ball (2), or into points in the middle of the cells (3).
 * With ARRAY the matrix is an array of columns, with ROWS an array of rows. With ROW_VECTOR the
 * matrix stands after the vector. With INSTANCE it is an attribute (four with COLUMNS), with ADDRESS behind an address,
 * which is in a block with BLOCK; with SUM the shader adds a number to it. With PROJECTING Cupola's functions are inserted before.
 */
#if defined(ADDRESS)
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_buffer_reference_uvec2 : require
layout(buffer_reference, std430, buffer_reference_align = 16) readonly buffer Camera { vec4 before; mat4 mvp; };
#if defined(BLOCK)
layout(set = 0, binding = 0) uniform Frame { Camera camera; };
#define mvp camera.mvp
#elif defined(SUM)
layout(push_constant) uniform Frame { layout(offset = 8) uvec2 camera; uint more; };
#define mvp Camera(uvec2(camera.x + more, camera.y)).mvp
#else
layout(push_constant) uniform Frame { layout(offset = 8) Camera camera; };
#define mvp camera.mvp
#endif
#elif defined(INSTANCE) && defined(COLUMNS)
layout(location = 3) in vec4 x;
layout(location = 4) in vec4 y;
layout(location = 5) in vec4 z;
layout(location = 6) in vec4 w;
#define mvp mat4(x, y, z, w)
#elif defined(INSTANCE)
layout(location = 3) in mat4 mvp;
#elif defined(BLOCK)
layout(set = 0, binding = 0) uniform Camera { mat4 mvp; };
#elif defined(COLUMNS)
layout(push_constant) uniform Camera { vec4 x, y, z, w; };
#define mvp mat4(x, y, z, w)
#elif defined(ARRAY) || defined(ROWS)
layout(push_constant) uniform Camera { vec4 mvp[4]; };
#else
layout(push_constant) uniform Camera { mat4 mvp; };
#endif
layout(location = 0) out vec3 shade;

const uint corners[36] = uint[](0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3, 0, 4, 5, 0, 5, 1,
                                2, 3, 7, 2, 7, 6, 0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5);

#ifdef CELLS
const uint side = 64u;

void main()
{
    bool points = gl_InstanceIndex == 3;
    uint cell = points ? uint(gl_VertexIndex) : uint(gl_VertexIndex) / 6u;
    uint corner = points ? 0u : uint[](0u, 1u, 2u, 2u, 1u, 3u)[gl_VertexIndex % 6];
    vec2 place = vec2(cell % side, cell / side % side) + (points ? vec2(0.5) : vec2(corner & 1u, corner >> 1));
    uint face = cell / (side * side), axis = face / 2u;
    vec3 position;
    position[axis] = face % 2u == 1u ? 1.0 : -1.0;
    position[(axis + 1u) % 3u] = 2.0 * place.x / float(side) - 1.0;
    position[(axis + 2u) % 3u] = 2.0 * place.y / float(side) - 1.0;
    shade = 0.5 + (gl_InstanceIndex == 2 ? -0.5 : 0.5) * position;
    gl_PointSize = 1.0;
    float size = gl_InstanceIndex == 1 ? 1.0 / length(position) : gl_InstanceIndex == 2 ? 3.0 : 1.0;
    gl_Position = mvp * vec4(size * position, 1.0);
#ifdef PROJECTING
    gl_Position = cupola_fix(gl_Position);
#endif
}
#else
void main()
{
    uint corner = corners[gl_VertexIndex];
    vec3 position = vec3(corner & 1u, corner >> 1 & 1u, corner >> 2 & 1u) * 2.0 - 1.0;
    shade = 0.5 + 0.5 * position;
#if defined(ARRAY)
    gl_Position = mvp[0] * position.x + mvp[1] * position.y + mvp[2] * position.z + mvp[3];
#elif defined(ROWS)
    vec4 p = vec4(position, 1.0);
    gl_Position = vec4(dot(p, mvp[0]), dot(p, mvp[1]), dot(p, mvp[2]), dot(p, mvp[3]));
#elif defined(ROW_VECTOR)
    gl_Position = vec4(position, 1.0) * mvp;
#else
    gl_Position = mvp * vec4(position, 1.0);
#endif
}
#endif
