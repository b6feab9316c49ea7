#version 450
/* Passes its input on, without dividing the triangle. */
layout(vertices = 3) out;
layout(location = 0) in vec3 given[];
layout(location = 0) out vec3 shade[];

void main()
{
    shade[gl_InvocationID] = given[gl_InvocationID];
    gl_out[gl_InvocationID].gl_Position = gl_in[gl_InvocationID].gl_Position;
    for (int i = 0; i < 3; i++)
        gl_TessLevelOuter[i] = 1.0;
    gl_TessLevelInner[0] = 1.0;
}
