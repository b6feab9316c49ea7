#version 450
/*
 * One triangle over the whole picture. MATRICES: with the camera's matrix, as in engines that give
 * it to every shader. PART: a shader that samples reads this part of the picture.
 */
#ifdef MATRICES
layout(push_constant) uniform Camera { mat4 projection; } camera;
layout(location = 1) out vec4 seen;
#endif
layout(location = 0) out vec2 at;

void main()
{
    const vec2 corner = vec2(gl_VertexIndex << 1 & 2, gl_VertexIndex & 2);
#ifdef PART
    at = corner * PART;
#else
    at = corner;
#endif
#ifdef MATRICES
    seen = camera.projection * vec4(at, -5.0, 1.0);
#endif
    gl_Position = vec4(2.0 * corner - 1.0, 0.0, 1.0);
}
