/* Direction test whose last stage before rasterisation is a tessellation evaluation shader, which projects. */
#include "common/app.h"
#include "common/mesh.h"
#include "common/shader.h"

static const char vertex[] =
    "#version 400 core\n"
    "layout(location = 0) in vec3 position;\n"
    "out vec3 corner;\n"
    "void main() { corner = position; }\n";
static const char control[] =
    "#version 400 core\n"
    "layout(vertices = 3) out;\n"
    "in vec3 corner[];\n"
    "out vec3 patch_corner[];\n"
    "void main() {\n"
    "    patch_corner[gl_InvocationID] = corner[gl_InvocationID];\n"
    "    gl_TessLevelOuter[0] = gl_TessLevelOuter[1] = gl_TessLevelOuter[2] = 4.0;\n"
    "    gl_TessLevelInner[0] = 3.0;\n"
    "}\n";
static const char evaluation[] =
    "#version 400 core\n"
    "layout(triangles, equal_spacing) in;\n"
    "uniform mat4 P;\n"
    "uniform mat4 MV;\n"
    "in vec3 patch_corner[];\n"
    "out vec3 shade;\n"
    "void main() {\n"
    "    vec3 place = gl_TessCoord.x * patch_corner[0] + gl_TessCoord.y * patch_corner[1]\n"
    "               + gl_TessCoord.z * patch_corner[2];\n"
    "    shade = 0.5 + 0.5 * place;\n"
    "    gl_Position = P * (MV * vec4(place, 1.0));\n"
    "}\n";
static const char fragment[] =
    "#version 400 core\nin vec3 shade;\nout vec4 result;\nvoid main() { result = vec4(shade, 1.0); }\n";

static mesh cube;
static shader_pair pair;

static void setup(app *a)
{
    (void)a;
    const shader_source stages[] = {
        {GL_VERTEX_SHADER, vertex},
        {GL_TESS_CONTROL_SHADER, control},
        {GL_TESS_EVALUATION_SHADER, evaluation},
        {GL_FRAGMENT_SHADER, fragment},
    };
    pair = shader_pair_build(stages, 4, "P", "MV");
    cube = mesh_cube();
    glPatchParameteri(GL_PATCH_VERTICES, 3);
}

static void draw(app *a)
{
    app_clear();
    shader_pair_use(&pair, a);
    mesh_bind(&cube);
    glDrawElements(GL_PATCHES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL);
}

int main(int argc, char **argv)
{
    static const app_program self = {"tessellation", API_GL_CORE, 4, 0, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
