#version 450
layout(location = 0) in vec3 shade;
layout(location = 0) out vec4 result;

/* Fragments beside the window are discarded. */
void main()
{
    if (gl_FragCoord.x > 256.0 || any(greaterThan(gl_FragCoord.xy, vec2(256.0))))
        discard;
    result = vec4(shade, 1.0);
}
