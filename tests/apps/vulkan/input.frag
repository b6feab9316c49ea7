#version 450
/* Shows the colour that an earlier subpass drew at the same pixel. */
layout(input_attachment_index = 0, set = 0, binding = 0) uniform subpassInput picture;
layout(location = 0) out vec4 result;

void main()
{
    result = subpassLoad(picture);
}
