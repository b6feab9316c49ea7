#version 450
/* A rectangle: its left, upper, right and lower border in clip coordinates, and its colour. */
layout(push_constant) uniform Rectangle { vec4 borders; vec4 colour; } rectangle;
layout(location = 0) out vec2 at;
layout(location = 1) flat out vec4 colour;

void main()
{
    const int corners[6] = int[](0, 1, 2, 2, 1, 3);
    int corner = corners[gl_VertexIndex];
    at = vec2(corner & 1, corner >> 1);
    colour = rectangle.colour;
    gl_Position = vec4(mix(rectangle.borders.xy, rectangle.borders.zw, at), 0.0, 1.0);
}
