#version 450
/* Passes its input on. */
layout(triangles) in;
layout(triangle_strip, max_vertices = 3) out;
layout(location = 0) in vec3 given[];
layout(location = 0) out vec3 shade;

void main()
{
    for (int i = 0; i < 3; i++) {
        shade = given[i];
        gl_Position = gl_in[i].gl_Position;
        EmitVertex();
    }
}
