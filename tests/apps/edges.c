/*
 * Direction test of surfaces with edges, as VTK draws them. A geometry shader gets positions in
 * clip space and computes from them the places of each triangle's sides in the window. Fragments
 * beyond a side are discarded. The triangles of the cube are so small that none that a view shows
 * reaches behind the eye of the view.
 */
#include "common/app.h"
#include "common/shader.h"

enum { CELLS = 12 };

static const char vertex[] =
    "#version 330 core\n"
    "uniform mat4 P, MV;\n"
    "out vec3 corner;\n"
    "const int cells = 12;\n"
    "const ivec2 corners[6] = ivec2[6](ivec2(0), ivec2(1, 0), ivec2(0, 1), ivec2(0, 1), ivec2(1, 0), ivec2(1));\n"
    "void main() {\n"
    "    int cell = gl_VertexID / 6, face = cell / (cells * cells);\n"
    "    ivec2 place = ivec2(cell % cells, cell / cells % cells) + corners[gl_VertexID % 6];\n"
    "    vec2 at = vec2(place) * 2.0 / float(cells) - 1.0;\n"
    "    float side = (face & 1) == 0 ? -1.0 : 1.0;\n"
    "    corner = face < 2 ? vec3(side, at) : face < 4 ? vec3(at.x, side, at.y) : vec3(at, side);\n"
    "    gl_Position = P * MV * vec4(corner, 1.0);\n"
    "}\n";
static const char geometry[] =
    "#version 330 core\n"
    "layout(triangles) in;\n"
    "layout(triangle_strip, max_vertices = 3) out;\n"
    "uniform vec2 size;\n"
    "uniform float width;\n"
    "in vec3 corner[];\n"
    "out vec3 shade;\n"
    "flat out vec3 sides[3];\n"
    "void main() {\n"
    "    vec2 places[4];\n"
    "    for (int i = 0; i < 3; i++)\n"
    "        places[i] = (gl_in[i].gl_Position.xy / gl_in[i].gl_Position.w * 0.5 + 0.5) * size;\n"
    "    places[3] = places[0];\n"
    "    vec2 one = places[1] - places[0], other = places[2] - places[0];\n"
    "    float turn = sign(one.x * other.y - one.y * other.x);\n"
    "    vec3 found[3];\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        vec2 along = normalize(places[i + 1] - places[i]);\n"
    "        vec2 inwards = turn * vec2(-along.y, along.x);\n"
    "        found[i] = vec3(inwards, -dot(inwards, places[i]));\n"
    "    }\n"
    "    for (int i = 0; i < 3; i++) {\n"
    "        shade = 0.5 + 0.5 * corner[i];\n"
    "        sides = found;\n"
    "        gl_Position = gl_in[i].gl_Position;\n"
    "        gl_Position.xy = gl_Position.xy - found[i].xy / size * width * gl_Position.w;\n"
    "        EmitVertex();\n"
    "    }\n"
    "    EndPrimitive();\n"
    "}\n";
static const char fragment[] =
    "#version 330 core\n"
    "in vec3 shade;\n"
    "flat in vec3 sides[3];\n"
    "out vec4 result;\n"
    "void main() {\n"
    "    for (int i = 0; i < 3; i++)\n"
    "        if (dot(sides[i], vec3(gl_FragCoord.xy, 1.0)) < -1.0) discard;\n"
    "    result = vec4(shade, 1.0);\n"
    "}\n";

static shader_pair pair;
static GLuint empty;

static void setup(app *a)
{
    (void)a;
    const shader_source stages[] = {
        {GL_VERTEX_SHADER, vertex}, {GL_GEOMETRY_SHADER, geometry}, {GL_FRAGMENT_SHADER, fragment}};
    pair = shader_pair_build(stages, 3, "P", "MV");
    glGenVertexArrays(1, &empty);
}

static void draw(app *a)
{
    app_clear();
    shader_pair_use(&pair, a);
    glUniform2f(glGetUniformLocation(pair.program, "size"), (float)a->window.width, (float)a->window.height);
    glBindVertexArray(empty);
    glDrawArrays(GL_TRIANGLES, 0, 6 * 6 * CELLS * CELLS);
}

int main(int argc, char **argv)
{
    static const app_program self = {"edges", API_GL_CORE, 3, 3, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
