/*
 * The C interface, without a window: embed SIZE YAW PITCH
 *
 * Draws the direction cube in a surfaceless context into off-screen targets: at three quarters of
 * the size by a callback (callback.ppm), then view by view (views.ppm). Also checks the answers to
 * wrong calls, that the context's state stays unchanged, and the exact directions. Exits with 1 if
 * anything was wrong.
 */
#include "common/cube.h"
#include "common/gl.h"
#include "common/image.h"
#include "common/matrix.h"
#include "common/mesh.h"
#include "common/shader.h"
#include "common/states.h"
#include "common/surfaceless.h"
#include "common/target.h"

#include <cupola.h>

#include <EGL/egl.h>
#include <math.h>
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

/* Checks that the call failed with this status and with a detail that contains `word`. */
static void refused(cupola_status found, cupola_status expected, const char *word, const char *call)
{
    char detail[1024] = "";
    cupola_last_error(detail, sizeof detail, NULL);
    if (found == expected && strstr(detail, word) != NULL)
        return;
    complaints++;
    fprintf(stderr, "wrong: %s gives status %d (expected %d) and \"%s\" (expected a word of \"%s\")\n", call,
            (int)found, (int)expected, detail, word);
}

#define REFUSED(call, status, word) refused(call, status, word, #call)

/* The scene. */
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

static void draw(const cupola_gl_view *view, void *user)
{
    GLint viewport[4];
    glGetIntegerv(GL_VIEWPORT, viewport);
    CHECK(viewport[0] == view->x && viewport[1] == view->y);
    CHECK(viewport[2] == view->width && viewport[3] == view->height);
    CHECK(view->struct_size >= sizeof *view && memchr(view->name, 0, sizeof view->name) != NULL && view->name[0] != 0);
    for (int i = 0; i < 16; i++) {
        double product = 0.0;
        for (int k = 0; k < 4; k++)
            product += view->frustum_matrix_f64[4 * k + i % 4] * view->rotation_matrix_f64[4 * (i / 4) + k];
        CHECK(fabs(product - view->projection_matrix_f64[i]) < 1e-12);
        CHECK(fabs(view->projection_matrix_f64[i] - (double)view->projection_matrix[i]) < 1e-5);
    }
    glClearColor(0.25f, 0.25f, 0.25f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glEnable(GL_DEPTH_TEST);
    glUseProgram(program);
    glUniformMatrix4fv(glGetUniformLocation(program, "P"), 1, GL_FALSE, view->projection_matrix);
    glUniformMatrix4fv(glGetUniformLocation(program, "MV"), 1, GL_FALSE, modelview.m);
    mesh_bind(&cube);
    glDrawElements(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL);
    if (user != NULL)
        ++*(int *)user;
}

/* Area around the picture in the off-screen target, in pixels. Nothing may be written there. */
enum { LEFT = 10, BELOW = 20, BEYOND = 7 };

static target make_target(int size)
{
    target t = target_create(LEFT + size + BEYOND, BELOW + size + BEYOND);
    target_bind(&t);
    glClearColor(1.0f, 0.0f, 1.0f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT);
    return t;
}

static void write_picture(const target *t, int size, const char *file)
{
    glBindFramebuffer(GL_FRAMEBUFFER, t->framebuffer);
    image all = image_read_framebuffer(t->width, t->height), picture = image_new(size, size);
    for (int y = 0; y < t->height; y++) {
        for (int x = 0; x < t->width; x++) {
            const unsigned char *rgb = image_at(&all, x, y);
            int column = x - LEFT, row = y - BEYOND;
            if (column >= 0 && column < size && row >= 0 && row < size)
                memcpy(picture.rgb + 3 * (row * size + column), rgb, 3);
            else
                CHECK(rgb[0] == 255 && rgb[1] == 0 && rgb[2] == 255);
        }
    }
    CHECK(image_write_ppm(&picture, file));
    image_free(&all);
    image_free(&picture);
}

static void check_rigs(void)
{
    cupola_rig *const untouched = (cupola_rig *)&complaints;
    cupola_rig *rig = untouched;
    REFUSED(cupola_rig_load(NULL, &rig), CUPOLA_INVALID_ARGUMENT, "name_or_path");
    REFUSED(cupola_rig_load("fisheye", NULL), CUPOLA_INVALID_ARGUMENT, "rig");
    REFUSED(cupola_rig_load("fishey", &rig), CUPOLA_IO, "fisheye");
    REFUSED(cupola_rig_load("\xff", &rig), CUPOLA_INVALID_ARGUMENT, "UTF-8");
    REFUSED(cupola_rig_parse("[dome]\nradius = -1\n", ".", &rig), CUPOLA_INVALID_RIG, "radius");
    REFUSED(cupola_rig_parse("[dome", ".", &rig), CUPOLA_INVALID_RIG, "1");
    CHECK(rig == untouched);
    uint32_t count = 77;
    REFUSED(cupola_rig_output_count(NULL, &count), CUPOLA_INVALID_ARGUMENT, "rig");
    CHECK(count == 77);
    CHECK(cupola_rig_free(NULL) == CUPOLA_OK);

    /*
     * The detail is cut to the size of the buffer, its full length is returned, and a call that
     * succeeds keeps it.
     */
    char cut[5] = "....";
    size_t length = 0;
    CHECK(cupola_last_error(NULL, 0, &length) == CUPOLA_OK && length > 4);
    CHECK(cupola_last_error(cut, sizeof cut, NULL) == CUPOLA_OK && strlen(cut) == 4);
    uint32_t major = 99, minor = 99, patch = 99;
    CHECK(cupola_version(&major, &minor, &patch) == CUPOLA_OK && major < 99 && minor < 99 && patch < 99);
    CHECK(cupola_version(NULL, NULL, NULL) == CUPOLA_OK);
}

/* An equidistant half sphere around the viewing direction. */
static void check_directions(const cupola_rig *rig, int size)
{
    const double quarter = 0.5 * 3.14159265358979323846;
    for (int row = 0; row < size; row += 3) {
        for (int column = 0; column < size; column += 3) {
            double x = (column + 0.5) / size * 2.0 - 1.0, y = 1.0 - (row + 0.5) / size * 2.0, r = hypot(x, y);
            double found[3], wanted[3] = {sin(r * quarter) * x / r, sin(r * quarter) * y / r, -cos(r * quarter)};
            uint32_t pixels = (uint32_t)size;
            CHECK(cupola_map_direction(rig, 0, pixels, pixels, column + 0.5, row + 0.5, found) == CUPOLA_OK);
            for (int i = 0; i < 3; i++)
                CHECK(r <= 1.0 ? fabs(found[i] - wanted[i]) < 1e-12 : isnan(found[i]));
        }
    }
    double found[3] = {7, 8, 9};
    REFUSED(cupola_map_direction(NULL, 0, 8, 8, 1, 1, found), CUPOLA_INVALID_ARGUMENT, "rig");
    REFUSED(cupola_map_direction(rig, 0, 8, 8, 1, 1, NULL), CUPOLA_INVALID_ARGUMENT, "direction");
    REFUSED(cupola_map_direction(rig, 1, 8, 8, 1, 1, found), CUPOLA_INVALID_ARGUMENT, "output 1");
    REFUSED(cupola_map_direction(rig, 0, 0, 8, 1, 1, found), CUPOLA_INVALID_ARGUMENT, "0 ×");
    REFUSED(cupola_map_direction(rig, 0, 8, 8, NAN, 1, found), CUPOLA_INVALID_ARGUMENT, "NaN");
    CHECK(found[0] == 7 && found[1] == 8 && found[2] == 9);
}

static void check_creation(const cupola_rig *rig, cupola_gl_options right)
{
    cupola_gl *const untouched = (cupola_gl *)&complaints;
    cupola_gl *dome = untouched;
    cupola_gl_options wrong = right;
    REFUSED(cupola_gl_create(NULL, &right, &dome), CUPOLA_INVALID_ARGUMENT, "rig");
    REFUSED(cupola_gl_create(rig, NULL, &dome), CUPOLA_INVALID_ARGUMENT, "options");
    REFUSED(cupola_gl_create(rig, &right, NULL), CUPOLA_INVALID_ARGUMENT, "gl");
    wrong.struct_size = sizeof wrong - 1;
    REFUSED(cupola_gl_create(rig, &wrong, &dome), CUPOLA_INVALID_ARGUMENT, "struct_size");
    wrong = right;
    wrong.get_proc_address = NULL;
    REFUSED(cupola_gl_create(rig, &wrong, &dome), CUPOLA_INVALID_ARGUMENT, "get_proc_address");
    wrong = right;
    wrong.width = 0;
    REFUSED(cupola_gl_create(rig, &wrong, &dome), CUPOLA_INVALID_ARGUMENT, "0 ×");
    wrong.width = 20000;
    REFUSED(cupola_gl_create(rig, &wrong, &dome), CUPOLA_INVALID_ARGUMENT, "16384");
    cupola_rig *plain = NULL;
    CHECK(cupola_rig_load("identity", &plain) == CUPOLA_OK);
    REFUSED(cupola_gl_create(plain, &right, &dome), CUPOLA_INVALID_ARGUMENT, "identity");
    cupola_rig_free(plain);
    CHECK(dome == untouched);
    CHECK(cupola_gl_destroy(NULL) == CUPOLA_OK);
    CHECK(glGetError() == GL_NO_ERROR);
}

/* Calls that are not allowed between frames. */
static void check_blending(cupola_gl *dome)
{
    cupola_blend blend = { .struct_size = sizeof blend }, changed;

    REFUSED(cupola_gl_get_blend(dome, 1000, &blend), CUPOLA_INVALID_ARGUMENT, "output 1000");
    REFUSED(cupola_gl_get_blend(dome, 0, NULL), CUPOLA_INVALID_ARGUMENT, "blend");
    CHECK(cupola_gl_get_blend(dome, 0, &blend) == CUPOLA_OK && blend.ramp > 0 && blend.gamma > 0);
    changed = blend;
    changed.ramp = 0.7;
    REFUSED(cupola_gl_set_blend(dome, 0, &changed), CUPOLA_INVALID_ARGUMENT, "0.7");
    changed = blend;
    changed.shape = 9;
    REFUSED(cupola_gl_set_blend(dome, 0, &changed), CUPOLA_INVALID_ARGUMENT, "shape");
    changed = blend;
    changed.ramp_count = 9;
    REFUSED(cupola_gl_set_blend(dome, 0, &changed), CUPOLA_INVALID_ARGUMENT, "ramp_count");
    changed.ramp_count = 1;
    changed.ramps[0] = (cupola_angle_ramp){ CUPOLA_ANGLE_POLAR, CUPOLA_RAMP_POWER, 2.0, 80.0, 70.0 };
    changed.shape = CUPOLA_RAMP_COSINE;
    CHECK(cupola_gl_set_blend(dome, 0, &changed) == CUPOLA_OK);
    CHECK(cupola_gl_get_blend(dome, 0, &changed) == CUPOLA_OK && changed.ramp_count == 1);
    CHECK(changed.shape == CUPOLA_RAMP_COSINE && fabs(changed.ramps[0].zero - 80.0) < 1e-9);
    CHECK(cupola_gl_set_blend(dome, 0, &blend) == CUPOLA_OK);
}

static void check_idle(cupola_gl *dome)
{
    uint32_t count = 0, error = 0;
    cupola_gl_view view = {.struct_size = sizeof view};
    cupola_gl_statistics statistics = {.struct_size = sizeof statistics - 1};
    CHECK(cupola_gl_view_count(dome, &count) == CUPOLA_OK && count > 0);
    REFUSED(cupola_gl_view_count(NULL, &count), CUPOLA_INVALID_ARGUMENT, "gl");
    REFUSED(cupola_gl_view_count(dome, NULL), CUPOLA_INVALID_ARGUMENT, "count");
    REFUSED(cupola_gl_begin_frame(NULL), CUPOLA_INVALID_ARGUMENT, "gl");
    REFUSED(cupola_gl_begin_view(dome, 0), CUPOLA_INVALID_STATE, "frame");
    REFUSED(cupola_gl_end_view(dome), CUPOLA_INVALID_STATE, "view");
    REFUSED(cupola_gl_end_frame(dome, 0, 0, 0), CUPOLA_INVALID_STATE, "frame");
    REFUSED(cupola_gl_get_view(dome, count, 1, 2, &view), CUPOLA_INVALID_ARGUMENT, "no view");
    REFUSED(cupola_gl_get_view(dome, 0, 0, 2, &view), CUPOLA_INVALID_ARGUMENT, "near");
    REFUSED(cupola_gl_get_view(dome, 0, 2, 1, &view), CUPOLA_INVALID_ARGUMENT, "far");
    REFUSED(cupola_gl_get_view(dome, 0, NAN, 1, &view), CUPOLA_INVALID_ARGUMENT, "NaN");
    REFUSED(cupola_gl_get_view(dome, 0, 1, NAN, &view), CUPOLA_INVALID_ARGUMENT, "NaN");
    CHECK(cupola_gl_get_view(dome, 0, 1, INFINITY, &view) == CUPOLA_OK);
    view.struct_size = 8;
    REFUSED(cupola_gl_get_view(dome, 0, 1, 2, &view), CUPOLA_INVALID_ARGUMENT, "struct_size");
    REFUSED(cupola_gl_get_statistics(dome, &statistics), CUPOLA_INVALID_ARGUMENT, "struct_size");
    REFUSED(cupola_gl_draw_frame(dome, 1, 2, NULL, NULL, 0, 0, 0), CUPOLA_INVALID_ARGUMENT, "draw");
    REFUSED(cupola_gl_draw_frame(dome, 2, 1, draw, NULL, 0, 0, 0), CUPOLA_INVALID_ARGUMENT, "near");
    check_blending(dome);
    REFUSED(cupola_gl_take_error(dome, NULL), CUPOLA_INVALID_ARGUMENT, "error");
    CHECK(cupola_gl_take_error(dome, &error) == CUPOLA_OK && error == GL_NO_ERROR);
}

static void frame_by_callback(cupola_gl *dome, int size)
{
    uint32_t count = 0;
    int drawn = 0;
    CHECK(cupola_gl_view_count(dome, &count) == CUPOLA_OK);
    target t = make_target(size);
    CHECK(cupola_gl_draw_frame(dome, CUBE_NEAR, CUBE_FAR, draw, &drawn, t.framebuffer, LEFT, BELOW) == CUPOLA_OK);
    CHECK(drawn == (int)count);
    write_picture(&t, size, "callback.ppm");
}

/*
 * Draws a frame view by view, makes every call in a wrong order on the way, and sets unusual state
 * at the end.
 */
static void frame_by_views(cupola_gl *dome, int size)
{
    uint32_t count = 0;
    cupola_gl_statistics first = {.struct_size = sizeof first}, second = first;
    CHECK(cupola_gl_get_statistics(dome, &first) == CUPOLA_OK);
    CHECK(cupola_gl_resize(dome, (uint32_t)size, (uint32_t)size) == CUPOLA_OK);
    CHECK(cupola_gl_view_count(dome, &count) == CUPOLA_OK);
    target t = make_target(size);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
    states between = states_take();
    CHECK(cupola_gl_begin_frame(dome) == CUPOLA_OK);
    REFUSED(cupola_gl_begin_frame(dome), CUPOLA_INVALID_STATE, "frame");
    REFUSED(cupola_gl_resize(dome, 100, 100), CUPOLA_INVALID_STATE, "frame");
    REFUSED(cupola_gl_draw_frame(dome, 1, 2, draw, NULL, 0, 0, 0), CUPOLA_INVALID_STATE, "frame");
    REFUSED(cupola_gl_begin_view(dome, count), CUPOLA_INVALID_ARGUMENT, "no view");
    for (uint32_t index = 0; index < count; index++) {
        cupola_gl_view view = {.struct_size = sizeof view};
        CHECK(cupola_gl_get_view(dome, index, CUBE_NEAR, CUBE_FAR, &view) == CUPOLA_OK && view.index == index);
        CHECK(cupola_gl_begin_view(dome, index) == CUPOLA_OK);
        REFUSED(cupola_gl_begin_view(dome, index), CUPOLA_INVALID_STATE, "view");
        REFUSED(cupola_gl_end_frame(dome, 0, 0, 0), CUPOLA_INVALID_STATE, "view");
        CHECK(cupola_gl_end_view(dome) == CUPOLA_OK);
        complaints += states_compare(&between, "a view that nothing was drawn into");
        CHECK(cupola_gl_begin_view(dome, index) == CUPOLA_OK);
        draw(&view, NULL);
        CHECK(cupola_gl_end_view(dome) == CUPOLA_OK);
        REFUSED(cupola_gl_end_view(dome), CUPOLA_INVALID_STATE, "view");
        between = states_take();
    }
    GLint bound[2];
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &bound[0]);
    glGetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &bound[1]);
    CHECK((GLuint)bound[0] == t.framebuffer && bound[1] == 0);

    states_make_unusual(size, size);
    states unusual = states_take();
    glEnable(0xdead); /* an error of the program's own */
    CHECK(cupola_gl_end_frame(dome, t.framebuffer, LEFT, BELOW) == CUPOLA_OK);
    complaints += states_compare(&unusual, "the end of the frame");
    uint32_t error = 0;
    CHECK(glGetError() == GL_NO_ERROR);
    CHECK(cupola_gl_take_error(dome, &error) == CUPOLA_OK && error == GL_INVALID_ENUM);
    CHECK(cupola_gl_take_error(dome, &error) == CUPOLA_OK && error == GL_NO_ERROR);
    CHECK(cupola_gl_get_statistics(dome, &second) == CUPOLA_OK);
    CHECK(second.frames == first.frames + 1 && second.views == first.views + 2 * count && second.errors == 0);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    glPixelStorei(GL_PACK_ROW_LENGTH, 0);
    glPixelStorei(GL_PACK_SKIP_ROWS, 0);
    write_picture(&t, size, "views.ppm");
}

/* Function of preload/allocations.c, if that library is loaded. */
extern void steady_frame(void) __attribute__((weak));

/* The viewer moves to another place. */
static void frame_of_another_viewer(cupola_gl *dome, int size)
{
    const double elsewhere[3] = {2.0, -0.5, 1.0}, outside[3] = {0.0, 6.0, 0.0}, nowhere[3] = {NAN, 0.0, 0.0};
    const double middle[3] = {0.0, 0.0, 0.0};
    CHECK(cupola_gl_resize(dome, (uint32_t)size, (uint32_t)size) == CUPOLA_OK);
    REFUSED(cupola_gl_set_viewer(dome, outside, 0, 0, 0), CUPOLA_INVALID_ARGUMENT, "viewer.position");
    REFUSED(cupola_gl_set_viewer(dome, nowhere, 0, 0, 0), CUPOLA_INVALID_ARGUMENT, "finite");
    REFUSED(cupola_gl_set_viewer(dome, NULL, 0, 0, 0), CUPOLA_INVALID_ARGUMENT, "position");
    REFUSED(cupola_gl_set_viewer(NULL, elsewhere, 0, 0, 0), CUPOLA_INVALID_ARGUMENT, "gl");
    CHECK(cupola_gl_begin_frame(dome) == CUPOLA_OK);
    REFUSED(cupola_gl_set_viewer(dome, elsewhere, 0, 0, 0), CUPOLA_INVALID_STATE, "frame");
    target unused = make_target(size);
    CHECK(cupola_gl_end_frame(dome, unused.framebuffer, LEFT, BELOW) == CUPOLA_OK);
    CHECK(cupola_gl_set_viewer(dome, elsewhere, 0, 0, 0) == CUPOLA_OK);
    target t = make_target(size);
    CHECK(cupola_gl_draw_frame(dome, CUBE_NEAR, CUBE_FAR, draw, NULL, t.framebuffer, LEFT, BELOW) == CUPOLA_OK);
    write_picture(&t, size, "moved.ppm");
    CHECK(cupola_gl_set_viewer(dome, middle, 0, 0, 0) == CUPOLA_OK);
    CHECK(cupola_gl_resize(dome, (uint32_t)size / 2, (uint32_t)size / 2) == CUPOLA_OK);
}

/* In the callback no call is allowed. Sets 2 if the object is not destroyed. */
static void draw_and_destroy(const cupola_gl_view *view, void *user)
{
    cupola_gl *dome = user;
    (void)view;
    REFUSED(cupola_gl_destroy(dome), CUPOLA_INVALID_STATE, "draw");
    REFUSED(cupola_gl_begin_frame(dome), CUPOLA_INVALID_STATE, "frame");
}

/*
 * Calls without the context, with another one, and with framebuffers that do not exist or are
 * incomplete.
 */
static void check_contexts(const cupola_rig *rig, cupola_gl_options options)
{
    EGLDisplay display = eglGetCurrentDisplay();
    EGLContext own = eglGetCurrentContext(), other;
    const double elsewhere[3] = {0.5, 0.0, 0.0};
    cupola_gl *dome = NULL, *none = NULL, *lost = NULL;
    GLuint empty = 0;
    EGLint config_id = 0, count = 0;
    EGLConfig config = NULL;
    CHECK(cupola_gl_create(rig, &options, &dome) == CUPOLA_OK && cupola_gl_create(rig, &options, &lost) == CUPOLA_OK);
    target t = target_create((int)options.width, (int)options.height);
    REFUSED(cupola_gl_draw_frame(dome, 1, 2, draw, NULL, 12345, 0, 0), CUPOLA_INVALID_ARGUMENT, "12345");
    REFUSED(cupola_gl_draw_frame(dome, 1, 2, draw, NULL, 0, 0, 0), CUPOLA_INVALID_ARGUMENT, "no window");
    glGenFramebuffers(1, &empty);
    glBindFramebuffer(GL_FRAMEBUFFER, empty);
    REFUSED(cupola_gl_draw_frame(dome, 1, 2, draw, NULL, empty, 0, 0), CUPOLA_INVALID_ARGUMENT, "complete");
    glDeleteFramebuffers(1, &empty);
    CHECK(cupola_gl_begin_frame(dome) == CUPOLA_OK);
    REFUSED(cupola_gl_end_frame(dome, 12345, 0, 0), CUPOLA_INVALID_ARGUMENT, "12345");
    CHECK(cupola_gl_end_frame(dome, t.framebuffer, 0, 0) == CUPOLA_OK); /* the frame had not ended */
    CHECK(cupola_gl_draw_frame(dome, 1, 2, draw_and_destroy, dome, t.framebuffer, 0, 0) == CUPOLA_OK);

    CHECK(eglQueryContext(display, own, EGL_CONFIG_ID, &config_id));
    const EGLint wanted[] = {EGL_CONFIG_ID, config_id, EGL_NONE}, version[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_NONE};
    eglChooseConfig(display, wanted, &config, 1, &count);
    other = eglCreateContext(display, count == 1 ? config : NULL, own, version);
    CHECK(other != EGL_NO_CONTEXT);
    for (int way = 0; way < 2; way++) {
        const char *word = way == 0 ? "no OpenGL context" : "another OpenGL context";
        CHECK(eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, way == 0 ? EGL_NO_CONTEXT : other));
        REFUSED(cupola_gl_begin_frame(dome), CUPOLA_INVALID_STATE, word);
        REFUSED(cupola_gl_draw_frame(dome, 1, 2, draw, NULL, t.framebuffer, 0, 0), CUPOLA_INVALID_STATE, word);
        REFUSED(cupola_gl_resize(dome, 64, 64), CUPOLA_INVALID_STATE, word);
        REFUSED(cupola_gl_set_viewer(dome, elsewhere, 0, 0, 0), CUPOLA_INVALID_STATE, word);
        if (way == 0) {
            REFUSED(cupola_gl_create(rig, &options, &none), CUPOLA_INVALID_STATE, word);
            REFUSED(cupola_gl_destroy(lost), CUPOLA_INVALID_STATE, word);
        }
    }
    CHECK(eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, own));
    eglDestroyContext(display, other);
    CHECK(cupola_gl_draw_frame(dome, 1, 2, draw, NULL, t.framebuffer, 0, 0) == CUPOLA_OK);
    CHECK(cupola_gl_destroy(dome) == CUPOLA_OK && none == NULL);
    CHECK(glGetError() == GL_NO_ERROR);
}

/*
 * A picture that is already projected: more red to the right, more green upwards, blue everywhere.
 */
static void draw_projected(const cupola_gl_view *view, void *user)
{
    CHECK(strcmp(view->name, "content") == 0);
    glEnable(GL_SCISSOR_TEST);
    for (int quarter = 0; quarter < 4; quarter++) {
        int right = quarter % 2, up = quarter / 2;
        glScissor(view->x + right * view->width / 2, view->y + up * view->height / 2, view->width / 2, view->height / 2);
        glClearColor((float)right, (float)up, 1.0f, 1.0f);
        glClear(GL_COLOR_BUFFER_BIT);
    }
    glDisable(GL_SCISSOR_TEST);
    ++*(int *)user;
}

/* A rig with content has one view. A domemaster shows it as it was drawn. */
static void frame_of_content(int size)
{
    const char *text = "[content]\nkind = \"domemaster\"\n[[output]]\nkind = \"domemaster\"\n";
    cupola_gl_options options = {sizeof options, eglGetProcAddress, (uint32_t)size, (uint32_t)size};
    cupola_rig *rig = NULL;
    cupola_gl *dome = NULL;
    uint32_t count = 0;
    int drawn = 0;
    CHECK(cupola_rig_parse(text, ".", &rig) == CUPOLA_OK);
    CHECK(cupola_gl_create(rig, &options, &dome) == CUPOLA_OK);
    cupola_rig_free(rig);
    CHECK(cupola_gl_view_count(dome, &count) == CUPOLA_OK && count == 1);
    target t = target_create(size, size);
    CHECK(cupola_gl_draw_frame(dome, 1, 2, draw_projected, &drawn, t.framebuffer, 0, 0) == CUPOLA_OK && drawn == 1);
    glBindFramebuffer(GL_FRAMEBUFFER, t.framebuffer);
    image shown = image_read_framebuffer(size, size);
    for (int y = 0; y < size; y++) {
        for (int x = 0; x < size; x++) {
            double right = x + 0.5 - 0.5 * size, up = 0.5 * size - y - 0.5, radius = hypot(right, up);
            const unsigned char *rgb = image_at(&shown, x, y);
            if (radius > 0.5 * size + 1.0)
                CHECK(rgb[0] + rgb[1] + rgb[2] == 0);
            else if (radius < 0.5 * size - 1.0 && fabs(right) > 1.0 && fabs(up) > 1.0)
                CHECK(rgb[0] == (right > 0.0 ? 255 : 0) && rgb[1] == (up > 0.0 ? 255 : 0) && rgb[2] == 255);
        }
    }
    image_free(&shown);
    CHECK(cupola_gl_destroy(dome) == CUPOLA_OK);
}

int main(int argc, char **argv)
{
    if (argc != 4 && argc != 5) {
        fprintf(stderr, "usage: %s SIZE YAW PITCH [FRAMES]\n", argv[0]);
        return 2;
    }
    int size = atoi(argv[1]);
    modelview = matrix_multiply(matrix_camera(atof(argv[2]), atof(argv[3])), matrix_scale(CUBE_SCALE));
    uint32_t smaller = (uint32_t)(size / 4 * 3);
    cupola_gl_options options = {sizeof options, eglGetProcAddress, smaller, smaller};
    cupola_rig *rig = NULL;
    cupola_gl *dome = NULL;
    uint32_t outputs = 0;
    check_rigs();
    CHECK(cupola_rig_load("fisheye", &rig) == CUPOLA_OK);
    CHECK(cupola_rig_output_count(rig, &outputs) == CUPOLA_OK && outputs == 1);
    check_directions(rig, size);

    surfaceless_open();
    const shader_source stages[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, shader_shade}};
    program = program_build(stages, 2);
    cube = mesh_cube();
    check_creation(rig, options);
    frame_of_content(size);
    check_contexts(rig, options);
    target steady = target_create(size, size);
    CHECK(cupola_gl_create(rig, &options, &dome) == CUPOLA_OK);
    cupola_rig_free(rig); /* objects that were made from the rig stay valid */
    if (dome == NULL)
        return 1;
    check_idle(dome);
    frame_by_callback(dome, (int)smaller);
    frame_of_another_viewer(dome, size);
    frame_by_views(dome, size);
    for (int frame = 0; argc == 5 && frame < atoi(argv[4]); frame++) {
        CHECK(cupola_gl_draw_frame(dome, CUBE_NEAR, CUBE_FAR, draw, NULL, steady.framebuffer, 0, 0) == CUPOLA_OK);
        if (steady_frame != NULL)
            steady_frame();
    }
    CHECK(cupola_gl_destroy(dome) == CUPOLA_OK);
    CHECK(glGetError() == GL_NO_ERROR);
    return complaints == 0 ? 0 : 1;
}
