#version 450
/*
 * Passes that read the picture of an earlier pass: at the fragment's place on the screen, or by
 * texture coordinates.
 */
layout(set = 0, binding = 0) uniform sampler2D picture;
layout(set = 0, binding = 1) uniform sampler2D second;
layout(set = 0, binding = 2) uniform sampler2D depths;
layout(push_constant) uniform Screen { layout(offset = 64) vec2 size; } screen;
/* Matrices of the camera, from and to places on the cube. */
layout(set = 0, binding = 3) uniform Camera {
    vec4 tint;
    mat4 inverse_all, all, lamp;
    layout(row_major) mat4 inverse_rows;
    mat4 several[2], inverse_projection, inverse_view;
} camera;
#if defined(PLACE) || defined(VOLUME)
layout(location = 0) in vec3 shade;
#elif defined(DIRECTION)
layout(location = 0) in vec3 direction;
#else
layout(location = 0) in vec2 at;
#endif
layout(location = 0) out vec4 result;

#if defined(HANDED)
vec4 texel(sampler2D of, ivec2 place)
{
    return texelFetch(of, min(place, textureSize(of, 0) - 1), 0);
}
#endif

/* Colour of the cube in a direction. */
vec4 colour(vec3 d)
{
    d /= max(max(abs(d.x), abs(d.y)), abs(d.z));
    return vec4(0.5 + 0.5 * d, 1.0);
}

/*
 * Colour of a place on the cube. A place that is computed with the matrix of another view is not on
 * the cube.
 */
vec4 on_cube(vec4 p)
{
    p /= p.w;
    float far = max(max(abs(p.x), abs(p.y)), abs(p.z));
    return abs(far - 1.0) < 0.01 ? colour(p.xyz) : vec4(0.0);
}

void main()
{
#if defined(SKY)
    result = colour((camera.inverse_all * vec4(2.0 * at - 1.0, 1.0, 1.0)).xyz);
#elif defined(SKY_ROWS)
    result = colour((camera.inverse_rows * vec4(2.0 * at - 1.0, 1.0, 1.0)).xyz);
#elif defined(SKY_INVERTED)
    result = colour((inverse(camera.several[1]) * vec4(2.0 * at - 1.0, 1.0, 1.0)).xyz);
#elif defined(SKY_APART)
    result = colour(mat3(camera.inverse_view) * (camera.inverse_projection * vec4(2.0 * at - 1.0, 1.0, 1.0)).xyz);
#elif defined(SKY_FORCED)
    vec4 eye = camera.inverse_projection * vec4(2.0 * at - 1.0, 1.0, 1.0);
    result = colour((camera.inverse_view * vec4(eye.xy, -1.0, 0.0)).xyz);
#elif defined(SKY_COLUMNS)
    vec2 c = 2.0 * at - 1.0;
    vec4 d = camera.inverse_all[0] * c.x + camera.inverse_all[1] * c.y + camera.inverse_all[2] + camera.inverse_all[3];
    result = colour(vec3(d.xy, camera.inverse_all[0][2] * c.x + camera.inverse_all[1].z * c.y +
                                   camera.inverse_all[2].z + camera.inverse_all[3][2]));
#elif defined(DIRECTION)
    result = colour(direction);
#elif defined(LIGHT)
    float depth = texelFetch(depths, ivec2(gl_FragCoord.xy), 0).r;
    result = on_cube(camera.inverse_all * vec4(2.0 * at - 1.0, depth, 1.0));
#elif defined(LIGHT_BACK)
    /* Computes the place from the pixel, and the pixel from the place. */
    float depth = texelFetch(depths, ivec2(gl_FragCoord.xy), 0).r;
    vec4 p = camera.inverse_rows * vec4(2.0 * at - 1.0, depth, 1.0);
    vec4 c = camera.all * (p / p.w);
    vec2 back = 0.5 + 0.5 * c.xy / c.w;
    result = distance(back, at) * screen.size.x < 0.05 ? texture(picture, back) : vec4(0.0);
#elif defined(PLACE)
    /*
     * Discards fragments that are not at the pixel that they compute. The result of the lamp's
     * matrix is not used.
     */
    vec4 c = camera.all * vec4(2.0 * shade - 1.0, 1.0), d = camera.lamp * vec4(2.0 * shade - 1.0, 1.0);
    vec2 seen = screen.size * (0.5 + 0.5 * c.xy / c.w);
    if (distance(seen, gl_FragCoord.xy) > 0.02 || d.x == 1e9)
        discard;
    result = vec4(shade, 1.0);
#elif defined(VOLUME)
    /* Does what a light that covers a part of the scene does. */
    ivec2 place = ivec2(gl_FragCoord.xy);
    result = texelFetch(depths, place, 0).r < 1.0 ? texelFetch(picture, place, 0) : vec4(0.0);
#elif defined(FETCH)
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
