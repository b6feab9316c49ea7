/*
 * A program whose own shader projects to the output. It uses the C interface and has no window:
 * embed_vertex SIZE YAW PITCH
 *
 * Draws the cells of the direction cube into a domemaster in one pass (vertex.ppm), and into views
 * with the same shader (fragment.ppm). Exits with 1 if anything was wrong.
 */
#include "common/cell_array.h"
#include "common/cube.h"
#include "common/gl.h"
#include "common/image.h"
#include "common/matrix.h"
#include "common/shader.h"
#include "common/surfaceless.h"
#include "common/target.h"

#include <cupola.h>

#include <EGL/egl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

static bool good = true;

static void check(bool right, const char *what)
{
    char detail[512] = "";
    if (right)
        return;
    good = false;
    cupola_last_error(detail, sizeof detail, NULL);
    fprintf(stderr, "wrong: %s (last error: %s)\n", what, detail);
}

#define CHECK(condition) check(condition, #condition)

static const char head[] = "#version 330 core\n";
static const char body[] =
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec3 colour;\n"
    "uniform mat4 P;\n"
    "uniform mat4 MV;\n"
    "out vec3 shade;\n"
    "void main() { shade = colour; gl_Position = cupola_fix(P * (MV * vec4(position, 1.0))); }\n";

static GLuint program;
static cell_array built;
static matrix4 projection, modelview;
static cupola_gl *dome;

static void build_program(void)
{
    size_t length = 0;
    CHECK(cupola_gl_projection_source(0, NULL, 0, &length) == CUPOLA_OK && length > 0);
    char *text = malloc(sizeof head + sizeof body + length);
    if (text == NULL)
        abort();
    int end = sprintf(text, "%s", head);
    CHECK(cupola_gl_projection_source(0, text + end, length + 1, NULL) == CUPOLA_OK);
    sprintf(text + end + (int)length, "%s", body);
    const shader_source stages[] = {{GL_VERTEX_SHADER, text}, {GL_FRAGMENT_SHADER, shader_shade}};
    program = program_build(stages, 2);
    free(text);
}

static void draw(const cupola_gl_view *view, void *user)
{
    float vectors[32];
    (void)user;
    CHECK(cupola_gl_get_projection(dome, view->index, projection.m, vectors) == CUPOLA_OK);
    glClearColor(0.25f, 0.25f, 0.25f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glEnable(GL_DEPTH_TEST);
    glUseProgram(program);
    glUniformMatrix4fv(glGetUniformLocation(program, "P"), 1, GL_FALSE, projection.m);
    glUniformMatrix4fv(glGetUniformLocation(program, "MV"), 1, GL_FALSE, modelview.m);
    glUniform4fv(glGetUniformLocation(program, "cupola_view"), 8, vectors);
    glBindVertexArray(built.array);
    glDrawElements(GL_TRIANGLES, built.index_count, GL_UNSIGNED_INT, NULL);
}

/*
 * Draws a frame view by view, since calls of the same handle are not allowed in the callback form.
 */
static void frame(const char *method, int size, uint32_t expected_views, const char *file)
{
    char text[256];
    cupola_gl_options options = {sizeof options, eglGetProcAddress, (uint32_t)size, (uint32_t)size};
    cupola_rig *rig = NULL;
    uint32_t count = 0;
    snprintf(text, sizeof text, "[dome]\ntilt = 90.0\n[[output]]\nkind = \"domemaster\"\nmethod = \"%s\"\n", method);
    CHECK(cupola_rig_parse(text, "", &rig) == CUPOLA_OK);
    CHECK(cupola_gl_create_projecting(rig, &options, &dome) == CUPOLA_OK);
    cupola_rig_free(rig);
    if (dome == NULL)
        exit(1);
    CHECK(cupola_gl_view_count(dome, &count) == CUPOLA_OK && (expected_views == 0 ? count > 1 : count == expected_views));
    float vectors[32];
    matrix4 flat = projection;
    flat.m[11] = 0.0f;
    flat.m[15] = 1.0f;
    CHECK(cupola_gl_get_projection(dome, count, projection.m, vectors) == CUPOLA_INVALID_ARGUMENT);
    CHECK(cupola_gl_get_projection(dome, 0, flat.m, vectors) == CUPOLA_INVALID_ARGUMENT);
    CHECK(cupola_gl_get_projection(dome, 0, NULL, vectors) == CUPOLA_INVALID_ARGUMENT);
    target t = target_create(size, size);
    CHECK(cupola_gl_begin_frame(dome) == CUPOLA_OK);
    for (uint32_t index = 0; index < count; index++) {
        cupola_gl_view view = {.struct_size = sizeof view};
        CHECK(cupola_gl_get_view(dome, index, CUBE_NEAR, CUBE_FAR, &view) == CUPOLA_OK);
        CHECK(cupola_gl_begin_view(dome, index) == CUPOLA_OK);
        draw(&view, NULL);
        CHECK(cupola_gl_end_view(dome) == CUPOLA_OK);
    }
    CHECK(cupola_gl_end_frame(dome, t.framebuffer, 0, 0) == CUPOLA_OK);
    glBindFramebuffer(GL_FRAMEBUFFER, t.framebuffer);
    image picture = image_read_framebuffer(size, size);
    CHECK(image_write_ppm(&picture, file));
    image_free(&picture);
    CHECK(cupola_gl_destroy(dome) == CUPOLA_OK);
    dome = NULL;
}

int main(int argc, char **argv)
{
    if (argc != 4) {
        fprintf(stderr, "usage: %s SIZE YAW PITCH\n", argv[0]);
        return 2;
    }
    const int size = atoi(argv[1]);
    projection = matrix_perspective(90.0, 1.0, CUBE_NEAR, CUBE_FAR);
    modelview = matrix_multiply(matrix_camera(atof(argv[2]), atof(argv[3])), matrix_scale(CUBE_SCALE));
    surfaceless_open();
    build_program();
    built = cell_array_new(false, false);
    frame("vertex", size, 1, "vertex.ppm");
    frame("fragment", size, 0, "fragment.ppm");
    CHECK(glGetError() == GL_NO_ERROR);
    return good ? 0 : 1;
}
