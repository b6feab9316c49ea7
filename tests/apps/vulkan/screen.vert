#version 450
/* One triangle over all of the picture. */
layout(location = 0) out vec2 at;

void main()
{
    at = vec2(gl_VertexIndex << 1 & 2, gl_VertexIndex & 2);
    gl_Position = vec4(2.0 * at - 1.0, 0.0, 1.0);
}
