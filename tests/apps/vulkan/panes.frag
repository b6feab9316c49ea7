#version 450
/* Fills a rectangle with its colour, or with a picture (SHOWN). */
#if defined(SHOWN)
layout(set = 0, binding = 0) uniform sampler2D picture;
#endif
layout(location = 0) in vec2 at;
layout(location = 1) flat in vec4 colour;
layout(location = 0) out vec4 result;

void main()
{
#if defined(SHOWN)
    result = texture(picture, at);
#else
    result = colour;
#endif
}
