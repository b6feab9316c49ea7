#version 450
/* The direction test's cube: a corner has the colour of its position. */
#if defined(BLOCK)
layout(set = 0, binding = 0) uniform Camera { mat4 mvp; };
#elif defined(COLUMNS)
layout(push_constant) uniform Camera { vec4 x, y, z, w; };
#define mvp mat4(x, y, z, w)
#else
layout(push_constant) uniform Camera { mat4 mvp; };
#endif
layout(location = 0) out vec3 shade;

const uint corners[36] = uint[](0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3, 0, 4, 5, 0, 5, 1,
                                2, 3, 7, 2, 7, 6, 0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5);

void main()
{
    uint corner = corners[gl_VertexIndex];
    vec3 position = vec3(corner & 1u, corner >> 1 & 1u, corner >> 2 & 1u) * 2.0 - 1.0;
    shade = 0.5 + 0.5 * position;
    gl_Position = mvp * vec4(position, 1.0);
}
