#version 450
layout(location = 0) in vec3 shade;
layout(location = 0) out vec4 result;

/* Shows the place in the window, from 0 to 1. */
vec2 place()
{
    return gl_FragCoord.xy / 256.0;
}

void main()
{
    result = vec4(place(), min(shade.x, 0.0), 1.0);
}
