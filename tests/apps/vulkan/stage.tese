#version 450
layout(triangles) in;
layout(location = 0) in vec3 given[];
layout(location = 0) out vec3 shade;

void main()
{
    vec3 at = gl_TessCoord;
    shade = at.x * given[0] + at.y * given[1] + at.z * given[2];
    gl_Position = at.x * gl_in[0].gl_Position + at.y * gl_in[1].gl_Position + at.z * gl_in[2].gl_Position;
}
