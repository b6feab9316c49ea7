#version 450
/*
 * The direction test's cube. Its place is passed on in pieces of many types. `shape`: list, strips
 * or fans of triangles, list of lines or strips of lines (edges and a diagonal of each face). Flat
 * values are right only at the provoking vertex.
 */
layout(push_constant) uniform Camera { mat4 mvp; uint shape, last; };

struct Inner { vec2 x; float y; };
layout(location = 0) flat out int face;
layout(location = 1) out float a;
layout(location = 10, component = 1) flat out float tag;
layout(location = 1, component = 2) out vec2 b;
layout(location = 2) out mat2x3 m;
layout(location = 4) out float list[2];
layout(location = 6) out Block { vec3 c; flat uvec2 code; Inner inner; } block;
#if defined(CLIP)
out gl_PerVertex { vec4 gl_Position; float gl_ClipDistance[2]; };
#elif defined(CULL)
out gl_PerVertex { vec4 gl_Position; float gl_CullDistance[1]; };
#endif

const uint corners[24] = uint[](0, 2, 6, 4, 1, 5, 7, 3, 0, 4, 5, 1, 2, 3, 7, 6, 0, 1, 3, 2, 4, 6, 7, 5);
/* Number of vertices of a face, and their corners. */
const uint counts[5] = uint[](6, 4, 4, 10, 6);
const uint order[50] = uint[](0, 1, 2, 0, 2, 3, 0, 0, 0, 0, 0, 1, 3, 2, 0, 0, 0, 0, 0, 0, 0, 1, 2, 3, 0, 0, 0, 0, 0, 0,
                              0, 1, 1, 2, 2, 3, 3, 0, 0, 2, 0, 1, 2, 3, 0, 2, 0, 0, 0, 0);
/*
 * By shape: bits of the vertices of a face that are provoking, if the first vertex of a primitive
 * is provoking and if the last is.
 */
const uint first[5] = uint[](0x09, 0x03, 0x06, 0x155, 0x1f);
const uint final[5] = uint[](0x24, 0x0c, 0x0c, 0x2aa, 0x3e);

void main()
{
    uint vertex = uint(gl_VertexIndex) % counts[shape];
    int number = gl_VertexIndex / int(counts[shape]);
    uint corner = corners[4u * uint(number) + order[10u * shape + vertex]];
    vec3 p = vec3(corner & 1u, corner >> 1 & 1u, corner >> 2 & 1u) * 2.0 - 1.0;
    bool provoking = ((last != 0u ? final[shape] : first[shape]) >> vertex & 1u) != 0u;
    face = provoking ? number : -7;
    tag = provoking ? 0.5 * float(number) : 1e9;
    a = p.x;
    b = p.yz;
    m = mat2x3(p, 2.0 * p);
    list = float[](p.y, p.z);
    block.c = p.zyx;
    block.code = provoking ? uvec2(shape, number) : uvec2(77u);
    block.inner = Inner(p.xy, p.z);
    gl_Position = mvp * vec4(p, 1.0);
#if defined(CLIP)
    gl_ClipDistance[0] = 1.0;
    gl_ClipDistance[1] = p.x + 0.5;
#elif defined(CULL)
    gl_CullDistance[0] = 1.0;
#endif
}
