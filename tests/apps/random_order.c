/*
 * OpenGL 1.x in random order: state, draws, lists, stacks, copies and reads. Most calls are legal,
 * some are errors. The program writes all answers of OpenGL to a file (--answers), so that two runs
 * with the same --seed can be compared.
 *
 * The rectangles have their borders on borders of pixels, so that rounding does not decide which
 * pixels they cover.
 */
#include "common/app.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { STEPS = 60, LISTS = 4, SIZE = 256 };

static FILE *answers;
static unsigned long long state;
static int step, compiling, own_is_bound, matrix_depth[3], attribute_depth, client_depth, picture_known;
static GLuint lists, textures[2], framebuffer, target_texture, query;

/* xorshift64*, which gives the same numbers on every machine. */
static unsigned next_number(void)
{
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    return (unsigned)((state * 2685821657736338717ULL) >> 32);
}

static int below(int count)
{
    return (int)(next_number() % (unsigned)count);
}

static int coordinate(void)
{
    return 4 * below(SIZE / 4 + 1);
}

static float part(void)
{
    return (float)below(5) * 0.25f;
}

#define PICK(array) (array)[below((int)(sizeof(array) / sizeof((array)[0])))]

static void say(const char *what, int a, int b, int c, int d)
{
    fprintf(answers, "%d %s %d %d %d %d", step, what, a, b, c, d);
}

static void say_bytes(const char *what, const void *data, size_t size)
{
    const unsigned char *bytes = data;
    unsigned hash = 2166136261u;
    for (size_t i = 0; i < size; i++)
        hash = (hash ^ bytes[i]) * 16777619u;
    fprintf(answers, " %s %08x (%02x%02x%02x%02x)", what, hash, bytes[0], bytes[1], bytes[2], bytes[3]);
}

static const GLenum switches[] = {
    GL_SCISSOR_TEST, GL_DEPTH_TEST, GL_STENCIL_TEST, GL_BLEND, GL_ALPHA_TEST, GL_CULL_FACE, GL_COLOR_LOGIC_OP,
    GL_LIGHTING, GL_FOG, GL_DITHER, GL_CLIP_PLANE0, GL_NORMALIZE, GL_COLOR_MATERIAL, GL_POLYGON_OFFSET_FILL,
    GL_TEXTURE_2D, GL_POLYGON_STIPPLE, GL_DEPTH_CLAMP, GL_RASTERIZER_DISCARD,
};
static const GLenum comparisons[] = {GL_LESS, GL_LEQUAL, GL_GREATER, GL_ALWAYS, GL_EQUAL, GL_NOTEQUAL};
static const GLenum factors[] = {GL_ZERO, GL_ONE, GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA, GL_DST_COLOR, GL_SRC_COLOR};
static const GLenum operations[] = {GL_KEEP, GL_ZERO, GL_REPLACE, GL_INCR, GL_DECR, GL_INVERT};
static const GLenum window_buffers[] = {GL_BACK, GL_BACK_LEFT, GL_NONE, GL_BACK, GL_COLOR_ATTACHMENT0, GL_AUX0, GL_BACK};
static const GLenum modes[] = {GL_MODELVIEW, GL_PROJECTION, GL_TEXTURE};
static const GLenum attribute_bits[] = {
    GL_VIEWPORT_BIT, GL_SCISSOR_BIT, GL_ENABLE_BIT, GL_COLOR_BUFFER_BIT, GL_TRANSFORM_BIT, GL_LIST_BIT,
    GL_CURRENT_BIT, GL_DEPTH_BUFFER_BIT, GL_STENCIL_BUFFER_BIT, GL_POLYGON_BIT, GL_PIXEL_MODE_BIT, GL_LINE_BIT,
    GL_ALL_ATTRIB_BITS, GL_VIEWPORT_BIT | GL_SCISSOR_BIT | GL_TRANSFORM_BIT,
};

typedef struct {
    GLenum name;
    const char *text;
    int count;
} question;
#define ASK(name, count) {name, #name, count}
static const question questions[] = {
    ASK(GL_VIEWPORT, 4), ASK(GL_SCISSOR_BOX, 4), ASK(GL_SCISSOR_TEST, 1), ASK(GL_DEPTH_RANGE, 2),
    ASK(GL_MATRIX_MODE, 1), ASK(GL_PROJECTION_MATRIX, 16), ASK(GL_MODELVIEW_MATRIX, 16), ASK(GL_TEXTURE_MATRIX, 16),
    ASK(GL_PROJECTION_STACK_DEPTH, 1), ASK(GL_MODELVIEW_STACK_DEPTH, 1), ASK(GL_ATTRIB_STACK_DEPTH, 1),
    ASK(GL_CLIENT_ATTRIB_STACK_DEPTH, 1), ASK(GL_COLOR_CLEAR_VALUE, 4), ASK(GL_DEPTH_CLEAR_VALUE, 1),
    ASK(GL_STENCIL_CLEAR_VALUE, 1), ASK(GL_COLOR_WRITEMASK, 4), ASK(GL_DEPTH_WRITEMASK, 1), ASK(GL_DEPTH_FUNC, 1),
    ASK(GL_STENCIL_WRITEMASK, 1), ASK(GL_STENCIL_FUNC, 1), ASK(GL_STENCIL_REF, 1), ASK(GL_STENCIL_FAIL, 1),
    ASK(GL_BLEND_SRC, 1), ASK(GL_BLEND_DST, 1), ASK(GL_LOGIC_OP_MODE, 1), ASK(GL_DRAW_BUFFER, 1),
    ASK(GL_READ_BUFFER, 1), ASK(GL_CURRENT_COLOR, 4), ASK(GL_CURRENT_NORMAL, 3), ASK(GL_CURRENT_TEXTURE_COORDS, 4),
    ASK(GL_CURRENT_RASTER_POSITION, 4), ASK(GL_CURRENT_RASTER_POSITION_VALID, 1), ASK(GL_CURRENT_RASTER_COLOR, 4),
    ASK(GL_LIST_MODE, 1), ASK(GL_ACTIVE_TEXTURE, 1),
    ASK(GL_LINE_WIDTH, 1), ASK(GL_POINT_SIZE, 1), ASK(GL_POLYGON_MODE, 2), ASK(GL_RED_BITS, 1), ASK(GL_ALPHA_BITS, 1),
    ASK(GL_DEPTH_BITS, 1), ASK(GL_STENCIL_BITS, 1), ASK(GL_SAMPLES, 1), ASK(GL_SAMPLE_BUFFERS, 1),
    ASK(GL_DOUBLEBUFFER, 1), ASK(GL_STEREO, 1), ASK(GL_AUX_BUFFERS, 1), ASK(GL_ACCUM_RED_BITS, 1),
    ASK(GL_RENDER_MODE, 1), ASK(GL_CURRENT_PROGRAM, 1), ASK(GL_ARRAY_BUFFER_BINDING, 1), ASK(GL_VERTEX_ARRAY, 1),
    ASK(GL_PACK_ALIGNMENT, 1), ASK(GL_UNPACK_ALIGNMENT, 1), ASK(GL_RASTERIZER_DISCARD, 1), ASK(GL_DEPTH_TEST, 1),
    ASK(GL_MAX_DRAW_BUFFERS, 1), ASK(GL_IMPLEMENTATION_COLOR_READ_FORMAT, 1), ASK(GL_CURRENT_SECONDARY_COLOR, 4),
    ASK(GL_CURRENT_FOG_COORD, 1), ASK(GL_EDGE_FLAG, 1), ASK(GL_ZOOM_X, 1),
};

/*
 * Names are compared with those that OpenGL gave, and are not written to the file, because Cupola
 * also creates names.
 */
static void ask_for_names(void)
{
    GLint drawn = 0, read = 0, list = 0, base = 0, texture = 0;
    glGetIntegerv(GL_TEXTURE_BINDING_2D, &texture);
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &drawn);
    glGetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &read);
    glGetIntegerv(GL_LIST_INDEX, &list);
    glGetIntegerv(GL_LIST_BASE, &base);
    fprintf(answers, "%d   framebuffers %d %d", step, drawn == 0 ? 0 : (GLuint)drawn == framebuffer ? 1 : 2,
            read == 0 ? 0 : (GLuint)read == framebuffer ? 1 : 2);
    fprintf(answers, " lists %d %d", list == 0 ? -1 : list - (GLint)lists, base == 0 ? -1 : base - (GLint)lists);
    fprintf(answers, " texture %d\n", texture == 0 ? 0 : (GLuint)texture == textures[0] ? 1 : (GLuint)texture == textures[1] ? 2 : 3);
}

static void ask_everything(void)
{
    ask_for_names();
    for (size_t i = 0; i < sizeof questions / sizeof questions[0]; i++) {
        double values[16] = {0};
        glGetDoublev(questions[i].name, values);
        fprintf(answers, "%d   %s", step, questions[i].text);
        for (int k = 0; k < questions[i].count; k++)
            fprintf(answers, " %.6g", values[k]);
        fprintf(answers, "\n");
    }
    for (size_t i = 0; i < sizeof switches / sizeof switches[0]; i++)
        fprintf(answers, "%d   switch 0x%x %d\n", step, switches[i], glIsEnabled(switches[i]));
    fprintf(answers, "%d   error 0x%x\n", step, glGetError());
}

static void corners(int x0, int y0, int x1, int y1, float z)
{
    /*
     * In perspective the coordinates grow with the distance, so that each corner stays at its
     * pixel.
     */
    glVertex3f((float)x0 * -z, (float)y0 * -z, z);
    glVertex3f((float)x1 * -z, (float)y0 * -z, z);
    glVertex3f((float)x1 * -z, (float)y1 * -z, z);
    glVertex3f((float)x0 * -z, (float)y1 * -z, z);
}

static void rectangle(void)
{
    int x = coordinate(), y = coordinate(), u = coordinate(), v = coordinate(), way = below(4);
    float z = -(float)(1 << below(4));
    say("rectangle", x, y, u, v);
    switch (way) {
    case 0:
        glBegin(GL_QUADS);
        glColor4f(part(), part(), part(), part());
        corners(x, y, u, v, z);
        if (below(2))
            glColor4f(part(), part(), part(), part());
        glEnd();
        break;
    case 1:
        glRecti(x, y, u, v);
        break;
    default: {
        float positions[12] = {(float)x * -z, (float)y * -z, z, (float)u * -z, (float)y * -z, z,
                               (float)u * -z, (float)v * -z, z, (float)x * -z, (float)v * -z, z};
        static const GLubyte order[4] = {0, 1, 2, 3};
        glColor4f(part(), part(), part(), part());
        glEnableClientState(GL_VERTEX_ARRAY);
        glVertexPointer(3, GL_FLOAT, 0, positions);
        if (way == 2)
            glDrawArrays(GL_QUADS, 0, 4);
        else
            glDrawElements(GL_QUADS, 4, GL_UNSIGNED_BYTE, order);
        glVertexPointer(3, GL_FLOAT, 0, NULL);
        glDisableClientState(GL_VERTEX_ARRAY);
    }
    }
}

static void projection(void)
{
    int kind = below(4);
    say("projection", kind, 0, 0, 0);
    glMatrixMode(GL_PROJECTION);
    if (kind == 0) {
        glLoadIdentity();
        glOrtho(0, SIZE, 0, SIZE, -32, 32);
    } else if (kind == 1) {
        glLoadIdentity();
        glFrustum(0, SIZE, 0, SIZE, 1, 16);
    } else if (kind == 2 && matrix_depth[1] < 1 && !compiling) {
        glPushMatrix();
        matrix_depth[1]++;
    } else if (matrix_depth[1] > 0 && !compiling) {
        glPopMatrix();
        matrix_depth[1]--;
    }
    glMatrixMode(PICK(modes));
}

static void model(void)
{
    int kind = below(5);
    say("model", kind, 0, 0, 0);
    glMatrixMode(GL_MODELVIEW);
    if (kind == 0)
        glLoadIdentity();
    else if (kind == 1)
        glTranslatef((float)(4 * (below(17) - 8)), (float)(4 * (below(17) - 8)), 0.0f);
    else if (kind == 2 && matrix_depth[0] < 8 && !compiling)
        glPushMatrix(), matrix_depth[0]++;
    else if (kind == 3 && matrix_depth[0] > 0 && !compiling)
        glPopMatrix(), matrix_depth[0]--;
    glMatrixMode(PICK(modes));
}

static void read_pixels(void)
{
    static unsigned char pixels[64 * 64 * 4];
    int x = below(SIZE - 64), y = below(SIZE - 64), kind = below(3);
    say("read", x, y, kind, 0);
    if (compiling)
        return;
    memset(pixels, 0, sizeof pixels);
    if (kind == 0)
        glReadPixels(x, y, 64, 64, GL_RGB, GL_UNSIGNED_BYTE, pixels);
    else if (kind == 1)
        glReadPixels(x, y, 64, 64, GL_STENCIL_INDEX, GL_UNSIGNED_BYTE, pixels);
    else
        glReadPixels(x, y, 64, 64, GL_DEPTH_COMPONENT, GL_UNSIGNED_SHORT, pixels);
    say_bytes("pixels", pixels, sizeof pixels);
}

static void copy(void)
{
    static unsigned char pixels[32 * 32 * 4];
    int x = below(SIZE - 32), y = below(SIZE - 32);
    say("copy", x, y, 0, 0);
    glBindTexture(GL_TEXTURE_2D, textures[0]);
    if (below(2))
        glCopyTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, x, y, 32, 32, 0);
    else
        glCopyTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, x, y, 32, 32);
    if (!compiling) {
        memset(pixels, 0, sizeof pixels);
        glGetTexImage(GL_TEXTURE_2D, 0, GL_RGB, GL_UNSIGNED_BYTE, pixels);
        say_bytes("texels", pixels, 32 * 32 * 3);
    }
    glBindTexture(GL_TEXTURE_2D, textures[1]);
}

static void raster(void)
{
    static const GLubyte bits[8] = {0xff, 0x81, 0xbd, 0xa5, 0xa5, 0xbd, 0x81, 0xff};
    static unsigned char pixels[16 * 16 * 4];
    int kind = below(6), x = coordinate(), y = coordinate();
    say("raster", kind, x, y, 0);
    /* Pixels are copied only from whole pixels, because drivers round halves differently. */
    switch (kind) {
    case 0:
        glRasterPos3f((float)x + 0.5f, (float)y + 0.5f, -1.0f);
        break;
    case 1:
        glWindowPos2i(x, y);
        break;
    case 2:
        glBitmap(8, 8, 0.0f, 0.0f, 12.0f, 4.0f, bits);
        break;
    case 3:
        for (size_t i = 0; i < sizeof pixels; i++)
            pixels[i] = (unsigned char)(i * 7);
        glDrawPixels(16, 16, GL_RGBA, GL_UNSIGNED_BYTE, pixels);
        break;
    case 4:
        glWindowPos2i(below(SIZE), below(SIZE));
        glCopyPixels(below(SIZE - 32), below(SIZE - 32), 32, 32, GL_COLOR);
        break;
    default:
        glPixelZoom((float)(1 + below(2)), (float)(1 + below(2)));
    }
}

static void blend(void)
{
    GLenum source = PICK(factors), destination = PICK(factors);
    say("blend", (int)source, (int)destination, 0, 0);
    glBlendFunc(source, destination);
}

static void depth_and_stencil(void)
{
    GLenum comparison = PICK(comparisons), fail = PICK(operations), pass = PICK(operations);
    int reference = below(4), which = below(6);
    say("tests", (int)comparison, (int)fail, (int)pass, which);
    if (which == 0)
        glDepthFunc(comparison);
    else if (which == 1)
        glDepthMask((GLboolean)below(2));
    else if (which == 2)
        glDepthRange(0.25 * below(2), 1.0 - 0.25 * below(2));
    else if (which == 3)
        glStencilFunc(comparison, reference, 0xff);
    else if (which == 4)
        glStencilOp(fail, PICK(operations), pass);
    else
        glStencilMask(below(2) ? 0xff : 0x0f);
}

static void clears(void)
{
    static const GLbitfield bits[] = {GL_COLOR_BUFFER_BIT, GL_DEPTH_BUFFER_BIT, GL_STENCIL_BUFFER_BIT,
                                      GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT};
    GLbitfield mask = PICK(bits);
    say("clear", (int)mask, 0, 0, 0);
    glClearColor(part(), part(), part(), part());
    glClearDepth(part());
    glClearStencil(below(4));
    glClear(mask);
}

static void window_space(void)
{
    int x = 4 * below(16), y = 4 * below(16), width = 4 * below(65), height = 4 * below(65), kind = below(4);
    say("window space", kind, x, y, 0);
    if (kind == 0)
        glViewport(0, 0, SIZE, SIZE);
    else if (kind == 1)
        glViewport(x, y, SIZE / 2, SIZE / 2);
    else
        glScissor(x, y, width, height);
}

static void switching(void)
{
    GLenum which = PICK(switches);
    int on = below(2) && which != GL_RASTERIZER_DISCARD;
    say("switch", (int)which, on, 0, 0);
    if (on)
        glEnable(which);
    else
        glDisable(which);
}

static void buffers(void)
{
    GLenum buffer = PICK(window_buffers);
    int kind = below(2);
    say("buffer", kind, (int)buffer, 0, 0);
    if (kind == 0)
        glDrawBuffer(buffer);
    else if (buffer != GL_NONE)
        glReadBuffer(buffer);
}

static void masks(void)
{
    int bits = below(16);
    say("mask", bits, 0, 0, 0);
    glColorMask(bits & 1, bits & 2 ? 1 : 0, bits & 4 ? 1 : 0, bits & 8 ? 1 : 0);
}

static void attributes(void)
{
    int kind = below(4);
    say("attributes", kind, 0, 0, 0);
    /*
     * Draw buffers belong to a framebuffer, so attributes must not be pushed with one framebuffer
     * bound and popped with another.
     */
    if (own_is_bound)
        return;
    if (kind == 0 && attribute_depth < 14 && !compiling) {
        glPushAttrib(PICK(attribute_bits));
        attribute_depth++;
    } else if (kind == 1 && !compiling) {
        glPopAttrib(); /* an error if the stack is empty */
        attribute_depth -= attribute_depth > 0;
    } else if (kind == 2 && client_depth < 8 && !compiling) {
        glPushClientAttrib(GL_CLIENT_ALL_ATTRIB_BITS);
        client_depth++;
    } else if (kind == 3 && client_depth > 0 && !compiling) {
        glPopClientAttrib();
        client_depth--;
    }
}

static void listing(void)
{
    int kind = below(4);
    GLuint list = lists + (GLuint)below(LISTS);
    say("list", kind, (int)(list - lists), 0, 0);
    if (compiling && below(4) == 0) {
        glEndList();
        compiling = 0;
    } else if (!compiling && kind == 0) {
        glNewList(list, below(2) ? GL_COMPILE : GL_COMPILE_AND_EXECUTE);
        compiling = 1;
    } else if (!compiling && kind == 1) {
        GLubyte names[3] = {(GLubyte)below(LISTS), (GLubyte)below(LISTS), (GLubyte)below(LISTS)};
        glListBase(lists);
        glCallLists(3, GL_UNSIGNED_BYTE, names);
    } else if (!compiling) {
        glCallList(list);
    }
}

static void mode(void)
{
    GLenum which = PICK(modes);
    say("mode", (int)which, 0, 0, 0);
    glMatrixMode(which);
}

static void bind(GLuint name)
{
    glBindFramebuffer(GL_FRAMEBUFFER, name);
    own_is_bound = name != 0;
}

static void own_framebuffer(void)
{
    int kind = below(5), x = below(SIZE - 64), y = below(SIZE - 64);
    say("framebuffer", kind, x, y, 0);
    if (compiling)
        return;
    if (kind == 0) {
        bind(framebuffer);
    } else if (kind == 1) {
        glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
        glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
        glBlitFramebuffer(x, y, x + 64, y + 64, 0, 0, 64, 64, GL_COLOR_BUFFER_BIT, GL_NEAREST);
        bind(0);
    } else if (kind == 2) {
        bind(0);
        glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer);
        glBlitFramebuffer(0, 0, 64, 64, x, y, x + 64, y + 64, GL_COLOR_BUFFER_BIT, GL_NEAREST);
        glBindFramebuffer(GL_READ_FRAMEBUFFER, 0);
    } else {
        bind(0);
    }
}

static void counted(void)
{
    int kind = below(2);
    GLuint passed = 0;
    say("count", kind, 0, 0, 0);
    if (compiling)
        return;
    GLenum what = kind ? GL_SAMPLES_PASSED : GL_PRIMITIVES_GENERATED;
    glBeginQuery(what, query);
    rectangle();
    glEndQuery(what);
    glGetQueryObjectuiv(query, GL_QUERY_RESULT, &passed);
    glDeleteQueries(1, &query);
    glGenQueries(1, &query);
    fprintf(answers, " counted %u", passed);
}

static void (*const actions[])(void) = {
    rectangle, rectangle, rectangle, rectangle, projection, model, read_pixels, copy, raster, raster, blend,
    depth_and_stencil, depth_and_stencil, clears, window_space, window_space, switching, switching, buffers, masks,
    attributes, listing, listing, mode, own_framebuffer, counted,
};

static void setup(app *a)
{
    state = 0x9e3779b97f4a7c15ULL * (a->seed + 1ULL) + 1ULL;
    answers = a->answers != NULL ? fopen(a->answers, "w") : stdout;
    if (answers == NULL || a->window.width != SIZE || a->window.height != SIZE) {
        fprintf(stderr, "it takes --size %dx%d and a file that can be written\n", SIZE, SIZE);
        exit(1);
    }
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    lists = glGenLists(LISTS);
    for (GLuint i = 0; i < LISTS; i++) {
        glNewList(lists + i, GL_COMPILE);
        glEndList();
    }
    glGenTextures(2, textures);
    glBindTexture(GL_TEXTURE_2D, textures[1]);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, 2, 2, 0, GL_RGB, GL_UNSIGNED_BYTE, "0123456789abcdef");
    glBindTexture(GL_TEXTURE_2D, textures[0]);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, 32, 32, 0, GL_RGB, GL_UNSIGNED_BYTE, NULL);
    glGenTextures(1, &target_texture);
    glBindTexture(GL_TEXTURE_2D, target_texture);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, SIZE, SIZE, 0, GL_RGBA, GL_UNSIGNED_BYTE, NULL);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glBindTexture(GL_TEXTURE_2D, 0);
    glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, target_texture, 0);
    glClear(GL_COLOR_BUFFER_BIT);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glGenQueries(1, &query);
    glMatrixMode(GL_PROJECTION);
    glFrustum(0, SIZE, 0, SIZE, 1, 16);
    glMatrixMode(GL_MODELVIEW);
    glClearDepth(1.0);
}

static void draw(app *a)
{
    (void)a;
    /*
     * The content of a back buffer after a swap depends on the driver, so a frame begins with a
     * clear.
     */
    bind(0);
    glPushAttrib(GL_ALL_ATTRIB_BITS);
    glDrawBuffer(GL_BACK);
    glDisable(GL_SCISSOR_TEST);
    glColorMask(1, 1, 1, 1);
    glDepthMask(1);
    glStencilMask(0xff);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
    glPopAttrib();
    if (!picture_known) {
        /* Cupola may answer the first read from other pictures than the program's own. */
        unsigned char pixel[4];
        glReadPixels(0, 0, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, pixel);
        picture_known = 1;
    }
    for (int i = 0; i < STEPS; i++, step++) {
        actions[below((int)(sizeof actions / sizeof actions[0]))]();
        /* Cupola executes a list that is also executed at once only when the list is complete. */
        if (!compiling)
            fprintf(answers, " error 0x%x", glGetError());
        fprintf(answers, "\n");
        if (!compiling)
            ask_everything();
    }
    if (compiling) {
        glEndList();
        compiling = 0;
        fprintf(answers, "%d the frame's end error 0x%x\n", step, glGetError());
    }
    fflush(answers);
}

int main(int argc, char **argv)
{
    static const app_program self = {"random_order", API_GL_COMPATIBILITY, 0, 0, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
