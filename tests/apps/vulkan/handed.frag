#version 450
/* The passed place as a colour. If its pieces contradict each other, the colour is inverted. */
struct Inner { vec2 x; float y; };
layout(location = 0) flat in int face;
layout(location = 1) in float a;
layout(location = 10, component = 1) flat in float tag;
layout(location = 1, component = 2) in vec2 b;
layout(location = 2) in mat2x3 m;
layout(location = 4) in float list[2];
layout(location = 6) in Block { vec3 c; flat uvec2 code; Inner inner; } block;
layout(location = 0) out vec4 result;

void main()
{
    vec3 p = vec3(a, b);
    vec3 off = abs(p - m[0]) + abs(2.0 * p - m[1]) + abs(p - vec3(a, list[0], list[1])) + abs(p - block.c.zyx) +
               abs(p - vec3(block.inner.x, block.inner.y));
    bool right = max(off.x, max(off.y, off.z)) < 4e-3;
    right = right && face >= 0 && face < 6 && tag == 0.5 * float(face) && block.code.y == uint(face);
    right = right && abs(p[face / 2] - (face % 2 == 1 ? 1.0 : -1.0)) < 4e-3;
#ifdef NUMBER
    uint shape = block.code.x;
    right = right && (shape == 0u ? gl_PrimitiveID / 2 == face : shape == 3u ? gl_PrimitiveID / 5 == face : gl_PrimitiveID < 5);
#endif
    result = vec4(right ? 0.5 + 0.5 * p : 0.5 - 0.5 * p, 1.0);
}
