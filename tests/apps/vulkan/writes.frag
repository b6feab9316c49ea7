#version 450
/* Each fragment is counted in a buffer and in an image. */
layout(binding = 0) buffer Counts { uint vertices, fragments, places[36]; } counts;
layout(binding = 1, r32ui) uniform uimage2D sums;
layout(location = 0) in vec3 direction;
layout(location = 0) out vec4 result;

void main()
{
    uint number = atomicAdd(counts.fragments, 1u);
    imageAtomicAdd(sums, ivec2(1, 2), 1u);
    imageStore(sums, ivec2(2, 2), uvec4(7u));
    /* The number flows into the colour, but is too small to be seen. */
    result = vec4(direction * 0.5 + 0.5 + vec3(float(number) * 1e-12), 1.0);
}
