/*
 * The C interface of other versions, and the callback for messages, without a window:
 * embed_versions SIZE YAW PITCH
 *
 * Draws the direction cube as a program that was compiled with a later header, whose structs are
 * larger (later.ppm). Checks how the library handles fields that it does not know, which messages
 * the callback gets, and that it gets none after its removal. Exits with 1 if anything was wrong.
 */
#include "common/cube.h"
#include "common/gl.h"
#include "common/image.h"
#include "common/matrix.h"
#include "common/mesh.h"
#include "common/shader.h"
#include "common/surfaceless.h"
#include "common/target.h"

#include <cupola.h>

#include <EGL/egl.h>
#include <pthread.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int complaints;

static void check(bool good, const char *what)
{
    char detail[512] = "";
    if (good)
        return;
    complaints++;
    cupola_last_error(detail, sizeof detail, NULL);
    fprintf(stderr, "wrong: %s (last error: %s)\n", what, detail);
}

#define CHECK(condition) check(condition, #condition)

static bool last_error_has(const char *word)
{
    char detail[1024] = "";
    cupola_last_error(detail, sizeof detail, NULL);
    return strstr(detail, word) != NULL;
}

/* Structs of a later version. The library does not know the field at the end. */
typedef struct {
    cupola_gl_options known;
    double unknown;
} later_options;

typedef struct {
    cupola_gl_view known;
    double unknown[4];
} later_view;

typedef struct {
    cupola_blend known;
    uint64_t unknown;
} later_blend;

typedef struct {
    cupola_gl_statistics known;
    uint64_t unknown;
} later_statistics;

/* Messages that the callback received. */
typedef struct {
    pthread_mutex_t lock;
    int count, planned, inner;
} heard;

static void hear(cupola_log_level level, const char *message, void *user)
{
    heard *to = user;
    CHECK(level >= CUPOLA_LOG_ERROR && level <= CUPOLA_LOG_DEBUG && message[0] != 0 && strchr(message, '\n') == NULL);
    pthread_mutex_lock(&to->lock);
    to->count++;
    to->planned += level == CUPOLA_LOG_INFO && strstr(message, "rig fisheye: 64 x 64 pixels") != NULL;
    to->inner += cupola_set_log_callback(NULL, NULL) == CUPOLA_INVALID_STATE;
    pthread_mutex_unlock(&to->lock);
}

static const char vertex[] =
    "#version 330 core\n"
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec3 colour;\n"
    "uniform mat4 P;\n"
    "uniform mat4 MV;\n"
    "out vec3 shade;\n"
    "void main() { shade = colour; gl_Position = P * (MV * vec4(position, 1.0)); }\n";

static mesh cube;
static GLuint program;
static matrix4 modelview;

static void draw(const cupola_gl_view *view)
{
    glClearColor(0.25f, 0.25f, 0.25f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glEnable(GL_DEPTH_TEST);
    glUseProgram(program);
    glUniformMatrix4fv(glGetUniformLocation(program, "P"), 1, GL_FALSE, view->projection_matrix);
    glUniformMatrix4fv(glGetUniformLocation(program, "MV"), 1, GL_FALSE, modelview.m);
    mesh_bind(&cube);
    glDrawElements(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL);
}

/* Reads all views by the larger struct, and draws with it. */
static void draw_as_later_program(cupola_gl *dome, int size)
{
    uint32_t count = 0;
    CHECK(cupola_gl_view_count(dome, &count) == CUPOLA_OK && count > 0);
    target t = target_create(size, size);
    CHECK(cupola_gl_begin_frame(dome) == CUPOLA_OK);
    for (uint32_t index = 0; index < count; index++) {
        later_view view;
        memset(&view, 0xa5, sizeof view);
        view.known.struct_size = sizeof view;
        CHECK(cupola_gl_get_view(dome, index, CUBE_NEAR, CUBE_FAR, &view.known) == CUPOLA_OK);
        CHECK(view.known.struct_size == sizeof view && view.known.index == index);
        for (int i = 0; i < 4; i++)
            CHECK(view.unknown[i] == 0.0);
        CHECK(cupola_gl_begin_view(dome, index) == CUPOLA_OK);
        draw(&view.known);
        CHECK(cupola_gl_end_view(dome) == CUPOLA_OK);
    }
    CHECK(cupola_gl_end_frame(dome, t.framebuffer, 0, 0) == CUPOLA_OK);
    glBindFramebuffer(GL_FRAMEBUFFER, t.framebuffer);
    image picture = image_read_framebuffer(size, size);
    CHECK(image_write_ppm(&picture, "later.ppm"));
    image_free(&picture);
}

/* Values that were read can be written. A field that the library does not know must be 0. */
static void check_structs(cupola_gl *dome)
{
    later_blend blend;
    memset(&blend, 0xa5, sizeof blend);
    blend.known.struct_size = sizeof blend;
    CHECK(cupola_gl_get_blend(dome, 0, &blend.known) == CUPOLA_OK && blend.unknown == 0);
    CHECK(cupola_gl_set_blend(dome, 0, &blend.known) == CUPOLA_OK);
    blend.unknown = (uint64_t)1 << 40;
    CHECK(cupola_gl_set_blend(dome, 0, &blend.known) == CUPOLA_INVALID_ARGUMENT && last_error_has("does not know"));

    later_statistics statistics = {.known = {.struct_size = sizeof statistics}, .unknown = 7};
    CHECK(cupola_gl_get_statistics(dome, &statistics.known) == CUPOLA_OK && statistics.unknown == 0);
    /*
     * Sizes that are smaller than any version or absurd, and an address that no struct has. Nothing
     * may be written.
     */
    const size_t wrong[] = {0, 8, sizeof(cupola_gl_statistics) - 8, sizeof(cupola_gl_statistics) + 1, 1 << 20, SIZE_MAX};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        cupola_gl_statistics refused = {.struct_size = wrong[i], .frames = 99};
        CHECK(cupola_gl_get_statistics(dome, &refused) == CUPOLA_INVALID_ARGUMENT && last_error_has("struct_size"));
        CHECK(refused.struct_size == wrong[i] && refused.frames == 99);
    }
    char *shifted = (char *)&statistics + 1;
    CHECK(cupola_gl_get_statistics(dome, (cupola_gl_statistics *)(void *)shifted) == CUPOLA_INVALID_ARGUMENT);
    CHECK(last_error_has("address"));
}

static void *set_and_remove(void *user)
{
    for (int i = 0; i < 100; i++) {
        CHECK(cupola_set_log_callback(hear, user) == CUPOLA_OK);
        CHECK(cupola_set_log_callback(NULL, NULL) == CUPOLA_OK);
    }
    return NULL;
}

static void check_messages(cupola_gl *dome)
{
    heard *to = calloc(1, sizeof *to);
    pthread_mutex_init(&to->lock, NULL);
    CHECK(cupola_set_log_callback(hear, to) == CUPOLA_OK);
    CHECK(cupola_gl_resize(dome, 64, 64) == CUPOLA_OK);
    CHECK(to->planned == 1 && to->count >= 1 && to->inner == to->count);
    CHECK(cupola_set_log_callback(NULL, NULL) == CUPOLA_OK);
    int before = to->count;
    CHECK(cupola_gl_resize(dome, 80, 80) == CUPOLA_OK);
    CHECK(to->count == before);
    /* Messages while another thread sets and removes the callback. */
    pthread_t thread;
    CHECK(pthread_create(&thread, NULL, set_and_remove, to) == 0);
    CHECK(cupola_gl_resize(dome, 64, 64) == CUPOLA_OK);
    CHECK(cupola_gl_resize(dome, 80, 80) == CUPOLA_OK);
    CHECK(pthread_join(thread, NULL) == 0);
    pthread_mutex_destroy(&to->lock);
    memset(to, 0xff, sizeof *to);
    free(to);
    CHECK(cupola_gl_resize(dome, 64, 64) == CUPOLA_OK);
}

int main(int argc, char **argv)
{
    if (argc != 4) {
        fprintf(stderr, "usage: %s SIZE YAW PITCH\n", argv[0]);
        return 2;
    }
    int size = atoi(argv[1]);
    modelview = matrix_multiply(matrix_camera(atof(argv[2]), atof(argv[3])), matrix_scale(CUBE_SCALE));
    CHECK(cupola_abi_version() == CUPOLA_ABI_VERSION && cupola_api_version() == CUPOLA_API_VERSION);
    CHECK(CUPOLA_ABI_VERSION >= 1 && CUPOLA_API_VERSION >= 2);

    cupola_rig *rig = NULL;
    cupola_gl *dome = NULL;
    CHECK(cupola_rig_load("fisheye", &rig) == CUPOLA_OK);
    surfaceless_open();
    const shader_source stages[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, shader_shade}};
    program = program_build(stages, 2);
    cube = mesh_cube();
    later_options options = {{sizeof options, eglGetProcAddress, (uint32_t)size, (uint32_t)size}, 0.5};
    CHECK(cupola_gl_create(rig, &options.known, &dome) == CUPOLA_INVALID_ARGUMENT && dome == NULL);
    CHECK(last_error_has("`options` sets a field that this version does not know: byte 30 is not 0"));
    options.unknown = 0.0;
    CHECK(cupola_gl_create(rig, &options.known, &dome) == CUPOLA_OK);
    cupola_rig_free(rig);
    if (dome == NULL)
        return 1;
    draw_as_later_program(dome, size);
    check_structs(dome);
    check_messages(dome);
    CHECK(cupola_gl_destroy(dome) == CUPOLA_OK);
    CHECK(glGetError() == GL_NO_ERROR);
    return complaints == 0 ? 0 : 1;
}
