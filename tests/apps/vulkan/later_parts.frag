#version 450
/* The cube's colour in two images. */
layout(location = 0) in vec3 shade;
layout(location = 0) out vec4 first;
layout(location = 1) out vec4 second;

void main()
{
    first = vec4(shade.rg, 0.0, 1.0);
    second = vec4(0.0, 0.0, shade.b, 1.0);
}
