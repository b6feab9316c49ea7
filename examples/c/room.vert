#version 450
/* A point of a wall; its position is also its colour. Compiled twice, with and without MULTIVIEW. */
#ifdef MULTIVIEW
#extension GL_EXT_multiview : require
layout(set = 0, binding = 0) uniform Cameras { mat4 cameras[6]; };
#else
layout(push_constant) uniform Camera { mat4 camera; };
#endif
layout(location = 0) in vec3 position;
layout(location = 0) out vec3 colour;

void main()
{
#ifdef MULTIVIEW
    mat4 camera = cameras[gl_ViewIndex];
#endif
    colour = 0.5 + 0.5 * position;
    gl_Position = camera * vec4(10.0 * position, 1.0);
}
