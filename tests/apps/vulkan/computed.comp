#version 450
/*
 * Steps of compute shaders from the cube's picture, which has inverted colours, to the window's
 * picture.
 */
layout(local_size_x = 8, local_size_y = 8) in;
layout(set = 0, binding = 0) uniform sampler2D picture;
#if defined(ANY)
layout(set = 0, binding = 1) uniform writeonly image2D result;
#else
layout(set = 0, binding = 1, rgba8) uniform writeonly image2D result;
#endif
layout(set = 0, binding = 2) uniform sampler2D depths;
layout(set = 0, binding = 3) uniform sampler2D second;
layout(set = 0, binding = 4, rgba8) uniform image2D source;
layout(set = 0, binding = 5) buffer Numbers { uint sum, expected; float factor; float values[]; } numbers;
layout(set = 0, binding = 6) uniform Camera { mat4 inverse_all; } camera;
layout(push_constant) uniform Screen { vec2 size; } screen;

vec4 inverted(vec4 colour)
{
    return vec4(1.0 - colour.rgb, 1.0);
}

/*
 * Colour of a place on the cube. A place that is computed with the matrix of another view is not on
 * the cube.
 */
vec4 on_cube(vec4 p)
{
    p /= p.w;
    float far = max(max(abs(p.x), abs(p.y)), abs(p.z));
    return abs(far - 1.0) < 0.01 ? vec4(0.5 + 0.5 * p.xyz, 1.0) : vec4(0.0);
}

void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy);
#if defined(JUDGE)
    if (gl_LocalInvocationIndex == 0) {
        float beside = abs(float(numbers.sum) - float(numbers.expected));
        numbers.factor = beside < 0.02 * screen.size.x * screen.size.y ? 1.0 : 0.5;
        numbers.sum = 0;
    }
#elif defined(COUNT)
    if (all(lessThan(at, textureSize(picture, 0))) && texelFetch(picture, at, 0).r > 0.5)
        atomicAdd(numbers.sum, 1);
#elif defined(PLACES)
    if (all(lessThan(at, textureSize(picture, 0))))
        numbers.values[at.y * textureSize(picture, 0).x + at.x] = texelFetch(picture, at, 0).r;
#elif defined(SAME)
    if (all(lessThan(at, imageSize(source))))
        imageStore(source, at, inverted(imageLoad(source, at)));
#elif defined(PUSHED)
    if (all(lessThan(vec2(at), screen.size)))
        imageStore(result, at, inverted(textureLod(picture, (vec2(at) + 0.5) / screen.size, 0.0)));
#else
    ivec2 size = imageSize(result);
    if (any(greaterThanEqual(at, size)))
        return;
#if defined(STORED)
    imageStore(result, at, inverted(imageLoad(source, at)));
#elif defined(SWAPPED)
    imageStore(result, at, inverted(texelFetch(picture, at, 0)).bgra);
#elif defined(HALVE)
    imageStore(result, at, textureLod(picture, (vec2(at) + 0.5) / vec2(size), 0.0));
#elif defined(COPIED)
    imageStore(result, at, texelFetch(picture, at, 0));
#elif defined(BLENDED)
    imageStore(result, at, mix(texelFetch(second, at, 0), inverted(texelFetch(picture, at, 0)), 0.9));
#elif defined(MIXED)
    vec4 small = textureLod(second, (vec2(at) + 0.5) / vec2(size), 0.0);
    imageStore(result, at, 0.5 * (texelFetch(picture, at, 0) + small));
#elif defined(JOIN)
    vec4 small = textureLod(second, (vec2(at) + 0.5) / vec2(size), 0.0);
    imageStore(result, at, inverted(0.5 * (texelFetch(picture, at, 0) + small)));
#elif defined(DEPTHS)
    imageStore(result, at, texelFetch(depths, at, 0).r < 1.0 ? inverted(texelFetch(picture, at, 0)) : vec4(0.0));
#elif defined(EXPOSE)
    imageStore(result, at, vec4(numbers.factor * inverted(texelFetch(picture, at, 0)).rgb, 1.0));
#elif defined(VALUES)
    imageStore(result, at, inverted(vec4(numbers.values[at.y * size.x + at.x])));
#elif defined(LIGHT)
    vec2 place = 2.0 * (vec2(at) + 0.5) / vec2(size) - 1.0;
    imageStore(result, at, on_cube(camera.inverse_all * vec4(place, texelFetch(depths, at, 0).r, 1.0)));
#else
    imageStore(result, at, inverted(texelFetch(picture, at, 0)));
#endif
#endif
}
