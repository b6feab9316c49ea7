#version 450
/* Passes that read what an earlier pass drew: at the place of the fragment on the screen, or by texture coordinates. */
layout(set = 0, binding = 0) uniform sampler2D picture;
layout(set = 0, binding = 1) uniform sampler2D second;
layout(set = 0, binding = 2) uniform sampler2D depths;
layout(push_constant) uniform Screen { layout(offset = 64) vec2 size; } screen;
layout(location = 0) in vec2 at;
layout(location = 0) out vec4 result;

#if defined(HANDED)
vec4 texel(sampler2D of, ivec2 place)
{
    return texelFetch(of, min(place, textureSize(of, 0) - 1), 0);
}
#endif

void main()
{
#if defined(FETCH)
    result = texelFetch(picture, ivec2(gl_FragCoord.xy), 0);
#elif defined(DIVIDED)
    result = texture(picture, gl_FragCoord.xy / vec2(textureSize(picture, 0)));
#elif defined(GIVEN)
    result = texture(picture, gl_FragCoord.xy / screen.size);
#elif defined(HANDED)
    result = texel(picture, ivec2(gl_FragCoord.xy));
#elif defined(SCALED)
    vec2 part = gl_FragCoord.xy / screen.size;
    result = texelFetch(picture, ivec2(part * vec2(textureSize(picture, 0))), 0);
#elif defined(DEFERRED)
    ivec2 place = ivec2(gl_FragCoord.xy);
    result = vec4(texelFetch(picture, place, 0).rg, texelFetch(second, place, 0).b, 1.0);
    if (texelFetch(depths, place, 0).r == 1.0)
        result = vec4(0.0, 0.0, 0.0, 1.0);
#elif defined(DEPTHS)
    result = texture(depths, at).r < 1.0 ? texture(picture, at) : vec4(0.0, 0.0, 0.0, 1.0);
#else
    result = texture(picture, at);
#endif
}
