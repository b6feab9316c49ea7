#version 450
/*
 * Vertices of the player's pipelines: of a cube with a matrix that is PUSHED or in a BLOCK, of a
 * vertex buffer (INPUT), or of a triangle over the whole picture.
 */
layout(push_constant) uniform Push { mat4 matrix; vec4 tint; } pushed;
layout(set = 0, binding = 0) uniform Camera { mat4 matrix; } camera;
#ifdef INPUT
layout(location = 0) in vec4 place;
#endif
layout(location = 0) out vec4 shade;
layout(location = 1) out vec2 at;

const uint corners[36] = uint[](0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3, 0, 4, 5, 0, 5, 1,
                                2, 3, 7, 2, 7, 6, 0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5);

void main()
{
    gl_PointSize = 1.0;
#if defined(PUSHED) || defined(BLOCK)
    uint corner = corners[gl_VertexIndex];
    vec3 position = vec3(corner & 1u, corner >> 1 & 1u, corner >> 2 & 1u) * 2.0 - 1.0;
    shade = vec4(0.5 + 0.5 * position, 1.0) * pushed.tint;
    at = position.xy;
#ifdef BLOCK
    gl_Position = camera.matrix * vec4(position, 1.0);
#else
    gl_Position = pushed.matrix * vec4(position, 1.0);
#endif
#elif defined(INPUT)
    shade = abs(place) * pushed.tint;
    at = place.xy;
    gl_Position = pushed.matrix * vec4(place.xyz, 1.0);
#else
    at = vec2(gl_VertexIndex << 1 & 2, gl_VertexIndex & 2);
    shade = vec4(at, 0.5, 1.0) * pushed.tint;
    gl_Position = vec4(2.0 * at - 1.0, 0.0, 1.0);
#endif
}
