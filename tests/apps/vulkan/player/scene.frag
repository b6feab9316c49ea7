#version 450
/*
 * Colours of the player's pipelines: from the vertices, from a PICTURE, or from the PLACE in the
 * target.
 */
layout(set = 0, binding = 1) uniform sampler2D picture;
layout(location = 0) in vec4 shade;
layout(location = 1) in vec2 at;
layout(location = 0) out vec4 result;
layout(location = 1) out vec4 second;

void main()
{
#if defined(PICTURE)
    result = texture(picture, at) * shade;
#elif defined(PLACE)
    result = vec4(fract(gl_FragCoord.xy / 16.0), 0.25, 1.0);
#else
    result = shade;
#endif
    second = result.gbra;
}
