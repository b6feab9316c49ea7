#version 450
/* One triangle over the whole picture, with the directions of its corners. */
layout(set = 0, binding = 3) uniform Camera { vec4 tint; mat4 inverse_all; } camera;
layout(location = 0) out vec3 direction;

void main()
{
    vec2 at = 2.0 * vec2(gl_VertexIndex << 1 & 2, gl_VertexIndex & 2) - 1.0;
    vec4 near = camera.inverse_all * vec4(at, 0.0, 1.0);
    direction = near.xyz / near.w;
    gl_Position = vec4(at, 0.0, 1.0);
}
