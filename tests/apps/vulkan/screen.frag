#version 450
/*
 * Shows a picture unchanged, or one colour (FILLED), or colours of the place: by an input (GRADIENT) or
 * by FragCoord in a window of 256 × 256 pixels (PLACED). PART: nothing beside this part is read.
 */
#if !defined(FILLED) && !defined(GRADIENT) && !defined(PLACED)
layout(set = 0, binding = 0) uniform sampler2D picture;
#endif
#if defined(PLACE)
layout(origin_upper_left) in vec4 gl_FragCoord;
#elif defined(BOTH)
layout(set = 0, binding = 1) uniform sampler2D other;
#endif
layout(location = 0) in vec2 at;
layout(location = 0) out vec4 result;

void main()
{
#if defined(FILLED)
    result = vec4(0.2, 0.6, 0.4, 1.0);
#elif defined(GRADIENT)
    result = vec4(at, 0.25, 1.0);
#elif defined(PLACED)
    result = vec4(gl_FragCoord.xy / 256.0, 0.25, 1.0);
#elif defined(PART)
    result = texture(picture, min(at, PART - 0.5 / vec2(textureSize(picture, 0))));
#elif defined(PLACE)
    result = texelFetch(picture, ivec2(gl_FragCoord.xy), 0);
#else
    result = texture(picture, at);
#endif
#if defined(BOTH)
    /* Reading the other picture changes nothing, because no texel of it is above 1. */
    if (texture(other, at).r > 2.0)
        result = vec4(1.0);
#endif
}
