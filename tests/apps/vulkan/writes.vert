#version 450
/* The direction test's cube. Each vertex is counted in a buffer. */
layout(push_constant) uniform Camera { mat4 mvp; };
layout(binding = 0) buffer Counts { uint vertices, fragments, places[36]; } counts;
layout(location = 0) out vec3 direction;

const uint corners[24] = uint[](0, 2, 6, 4, 1, 5, 7, 3, 0, 4, 5, 1, 2, 3, 7, 6, 0, 1, 3, 2, 4, 6, 7, 5);
const uint order[6] = uint[](0, 1, 2, 0, 2, 3);

void main()
{
    atomicAdd(counts.vertices, 1u);
    counts.places[gl_VertexIndex] += 1u;
    uint corner = corners[4 * (gl_VertexIndex / 6) + order[gl_VertexIndex % 6]];
    direction = vec3(corner & 1u, corner >> 1 & 1u, corner >> 2 & 1u) * 2.0 - 1.0;
    gl_Position = mvp * vec4(direction, 1.0);
}
