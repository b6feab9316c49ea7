#version 450
/* Writes a picture from another picture and from numbers, and changes the numbers. */
layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant) uniform Push { mat4 matrix; vec4 tint; } pushed;
layout(set = 0, binding = 1) uniform sampler2D picture;
layout(set = 0, binding = 2) buffer Numbers { uint numbers[]; };
layout(set = 0, binding = 3, rgba8) uniform writeonly image2D result;

void main()
{
    ivec2 at = ivec2(gl_GlobalInvocationID.xy), size = imageSize(result);
    if (all(lessThan(at, size))) {
        uint index = uint(at.y * size.x + at.x) % 64u;
        imageStore(result, at, texelFetch(picture, at % textureSize(picture, 0), 0) * pushed.tint + vec4(numbers[index] % 3u) / 8.0);
    }
    if (gl_WorkGroupID == uvec3(0))
        numbers[64u + gl_LocalInvocationIndex] += gl_LocalInvocationIndex;
}
