/*
 * Draws from vertex arrays that are changed in random order between the draws, with every kind of
 * call. The program writes OpenGL's answers to a file (--answers), so that two runs with the same
 * --seed can be compared. Their pictures can be compared, too.
 *
 * Each buffer has small squares, each in another direction from the viewer. If a draw is taken for
 * one from another array or from an earlier content, it is expected at a wrong place.
 */
#include "common/app.h"
#include "common/program.h"

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { STEPS = 240, BUFFERS = 16, ARRAYS = 4, DIRECTIONS = 6, VERTICES = 64, SHORTS = 512, CORNERS = 4 };

/* Vertices as four floats, followed by the same as four shorts. */
typedef struct {
    float floats[VERTICES][4];
    int16_t shorts[SHORTS][4];
} content;

static const char vertex[] = "#version 120\nattribute vec4 position;\n"
                             "void main() { gl_FrontColor = gl_Color; gl_Position = gl_ModelViewProjectionMatrix * position; }\n";
static const char fragment[] = "#version 120\nvoid main() { gl_FragColor = gl_Color; }\n";

static const GLushort order[] = {0, 1, 2, 3, 4, 5, 6, 7};
static content contents[DIRECTIONS];
static FILE *answers;
static unsigned long long state;
static int step, pushed;
static GLuint buffers[BUFFERS], arrays[ARRAYS], indices[2], program;

/* xorshift64*, which gives the same numbers on every machine. */
static int below(int count)
{
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    return (int)((unsigned)((state * 2685821657736338717ULL) >> 32) % (unsigned)count);
}

static GLuint some_buffer(void)
{
    return buffers[below(BUFFERS)];
}

/* Offset from which vertices are completely inside a buffer, whatever the format is. */
static GLintptr some_offset(void)
{
    return 64 * below(DIRECTIONS) + (below(8) ? 0 : (GLintptr)offsetof(content, shorts));
}

static GLsizei some_stride(void)
{
    return below(8) ? 16 : 32;
}

/* Sometimes a size that OpenGL refuses. */
static GLint some_size(void)
{
    return below(16) ? 2 + below(3) : 5;
}

static GLenum some_type(void)
{
    return below(8) ? GL_FLOAT : GL_SHORT;
}

static const void *in_buffer(GLintptr offset)
{
    return (const char *)NULL + offset;
}

static void fill(GLuint buffer)
{
    glBindBuffer(GL_ARRAY_BUFFER, buffer);
    glBufferData(GL_ARRAY_BUFFER, sizeof contents[0], &contents[below(DIRECTIONS)], GL_STATIC_DRAW);
}

static int bound_array(void)
{
    GLint bound = 0;
    glGetIntegerv(GL_VERTEX_ARRAY_BINDING, &bound);
    return bound;
}

/* Mostly the array in use. */
static GLuint some_array(void)
{
    int bound = bound_array();
    return bound != 0 && below(4) ? (GLuint)bound : arrays[below(ARRAYS)];
}

static void pointers(void)
{
    GLintptr offset = some_offset();
    if (below(4)) {
        glBindBuffer(GL_ARRAY_BUFFER, some_buffer());
        if (below(2))
            glVertexPointer(some_size(), some_type(), below(16) ? some_stride() : -16, in_buffer(offset));
        else
            glVertexAttribPointer(0, some_size(), some_type(), GL_FALSE, below(16) ? some_stride() : -16, in_buffer(offset));
    } else {
        /* Arrays in memory, which vertex array objects cannot have. */
        glBindBuffer(GL_ARRAY_BUFFER, 0);
        glVertexPointer(3, GL_FLOAT, 16, contents[below(DIRECTIONS)].floats[below(4)]);
    }
}

static void switches(void)
{
    int on = below(8) > 0;
    switch (below(4)) {
    case 0:
        on ? glEnableVertexAttribArray(0) : glDisableVertexAttribArray(0);
        break;
    case 1:
        on ? glEnableVertexArrayAttrib(some_array(), 0) : glDisableVertexArrayAttrib(some_array(), 0);
        break;
    case 2:
        on ? glEnableVertexArrayEXT(some_array(), GL_VERTEX_ARRAY)
           : glDisableVertexArrayEXT(some_array(), GL_VERTEX_ARRAY);
        break;
    default:
        on ? glEnableClientState(GL_VERTEX_ARRAY) : glDisableClientState(GL_VERTEX_ARRAY);
    }
}

static void bindings(void)
{
    GLuint list[2] = {some_buffer(), some_buffer()};
    GLintptr offsets[2] = {some_offset(), some_offset()};
    GLsizei strides[2] = {some_stride(), some_stride()};
    switch (below(8)) {
    case 0:
        glVertexAttribFormat(0, some_size(), some_type(), GL_FALSE, (GLuint)(64 * below(2)));
        break;
    case 1:
        glVertexAttribBinding(0, (GLuint)below(3));
        break;
    case 2:
        glVertexBindingDivisor((GLuint)below(3), (GLuint)(below(8) == 0));
        break;
    case 3:
        glVertexAttribDivisor(0, (GLuint)(below(8) == 0));
        break;
    case 4:
        glBindVertexBuffers(0, 2, list, offsets, strides);
        break;
    default:
        /* 9999 is the name of no buffer. */
        glBindVertexBuffer((GLuint)below(3), below(16) ? list[0] : 9999, offsets[0], strides[0]);
    }
}

static void by_name(void)
{
    GLuint array = some_array(), list[2] = {some_buffer(), some_buffer()};
    GLintptr offsets[2] = {some_offset(), some_offset()};
    GLsizei strides[2] = {some_stride(), some_stride()};
    switch (below(9)) {
    case 0:
        glVertexArrayAttribFormat(array, 0, some_size(), some_type(), GL_FALSE, (GLuint)(64 * below(2)));
        break;
    case 1:
        glVertexArrayAttribBinding(array, 0, (GLuint)below(3));
        break;
    case 2:
        glVertexArrayBindingDivisor(array, (GLuint)below(3), (GLuint)(below(8) == 0));
        break;
    case 3:
        glVertexArrayElementBuffer(array, indices[below(2)]);
        break;
    case 4:
        glVertexArrayVertexBuffers(array, 0, 2, list, offsets, strides);
        break;
    case 5:
        glVertexArrayVertexOffsetEXT(array, list[0], some_size(), some_type(), strides[0], offsets[0]);
        break;
    case 6:
        glVertexArrayVertexAttribOffsetEXT(array, list[0], 0, some_size(), some_type(), GL_FALSE, strides[0], offsets[0]);
        break;
    default:
        glVertexArrayVertexBuffer(array, (GLuint)below(3), list[0], offsets[0], strides[0]);
    }
}

static void interleaved(void)
{
    static const GLenum formats[] = {GL_V3F, GL_C4UB_V3F, GL_T4F_V4F, GL_T2F_N3F_V3F, GL_T4F_C4F_N3F_V4F};
    GLenum format = below(16) ? formats[below(5)] : GL_FLOAT;
    glBindBuffer(GL_ARRAY_BUFFER, some_buffer());
    glInterleavedArrays(format, below(4) ? 64 : 0, in_buffer(64 * below(4)));
    glDisableClientState(GL_COLOR_ARRAY);
    glDisableClientState(GL_NORMAL_ARRAY);
    glDisableClientState(GL_TEXTURE_COORD_ARRAY);
}

static void stack(void)
{
    if (pushed < 8 && below(2)) {
        below(2) ? glPushClientAttrib(GL_CLIENT_ALL_ATTRIB_BITS) : glPushClientAttribDefaultEXT(GL_CLIENT_VERTEX_ARRAY_BIT);
        pushed++;
    } else if (pushed > 0) {
        glPopClientAttrib();
        pushed--;
    }
}

static void objects(void)
{
    int which = below(16), number = below(BUFFERS);
    /* If an object is deleted while it is on the stack, the result depends on the driver. */
    if (which < 2 && pushed > 0)
        return;
    if (which == 0) {
        glDeleteBuffers(1, &buffers[number]);
        glGenBuffers(1, &buffers[number]);
        fill(buffers[number]);
    } else if (which == 1) {
        number %= ARRAYS;
        glDeleteVertexArrays(1, &arrays[number]);
        glCreateVertexArrays(1, &arrays[number]);
    } else if (which < 4) {
        fill(buffers[number]);
    } else if (which < 7) {
        glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, below(3) ? indices[below(2)] : 0);
    } else if (which < 9) {
        below(2) ? glEnable(GL_PRIMITIVE_RESTART) : glDisable(GL_PRIMITIVE_RESTART);
    } else {
        /* 9999 is the name of no array. */
        glBindVertexArray(below(16) ? below(4) ? arrays[below(ARRAYS)] : 0 : 9999);
    }
}

static void (*const changes[])(void) = {pointers, pointers, switches, bindings, by_name, interleaved, stack, objects, objects};

/*
 * Place of a name in a list, from 1 on. Names are not written to the file, because Cupola also
 * creates names.
 */
static int place(GLint name, const GLuint *list, int count)
{
    for (int i = 0; i < count; i++)
        if (list[i] == (GLuint)name)
            return i + 1;
    return name == 0 ? 0 : -1;
}

/*
 * Switches off an array that would be read outside of its buffer, and writes OpenGL's answers about
 * the arrays to the file. Draws with a shader have positions from a generic attribute, others from
 * glVertexPointer. Mostly the array that is on is used.
 */
static void look(void)
{
    GLint on = 0, buffer = 0, conventional = 0, elements = 0;
    void *pointer = NULL, *start = NULL;
    glGetVertexAttribiv(0, GL_VERTEX_ATTRIB_ARRAY_ENABLED, &on);
    glGetVertexAttribiv(0, GL_VERTEX_ATTRIB_ARRAY_BUFFER_BINDING, &buffer);
    glGetVertexAttribPointerv(0, GL_VERTEX_ATTRIB_ARRAY_POINTER, &pointer);
    glGetIntegerv(GL_VERTEX_ARRAY_BUFFER_BINDING, &conventional);
    glGetIntegerv(GL_ELEMENT_ARRAY_BUFFER_BINDING, &elements);
    glGetPointerv(GL_VERTEX_ARRAY_POINTER, &start);
    const char *first = (const char *)contents, *last = (const char *)(contents + DIRECTIONS);
    int ours = (const char *)start >= first && (const char *)start < last && bound_array() == 0;
    fprintf(answers, "%d array %d: %d %d, %d %d, %d\n", step, place(bound_array(), arrays, ARRAYS), on,
            place(buffer, buffers, BUFFERS), glIsEnabled(GL_VERTEX_ARRAY), place(conventional, buffers, BUFFERS),
            place(elements, indices, 2));
    if (on && buffer == 0)
        glDisableVertexAttribArray(0);
    if (conventional == 0 && !ours)
        glDisableClientState(GL_VERTEX_ARRAY);
    glUseProgram((below(8) > 0) == (on && buffer != 0) ? program : 0);
}

static void draw_something(void)
{
    int first = 4 * below(2), way = below(3);
    GLint elements = 0;
    glLoadIdentity();
    glRotatef((float)(45 * below(8)), 0.0f, 1.0f, 0.0f);
    glRotatef((float)(30 * (below(3) - 1)), 1.0f, 0.0f, 0.0f);
    glColor3f(0.25f * (float)below(5), 0.25f * (float)below(5), 1.0f);
    glGetIntegerv(GL_ELEMENT_ARRAY_BUFFER_BINDING, &elements);
    const void *from = elements ? in_buffer(0) : order;
    if (way == 0)
        glDrawArrays(GL_TRIANGLE_STRIP, first, CORNERS);
    else if (way == 1)
        glDrawElements(GL_TRIANGLE_STRIP, CORNERS, GL_UNSIGNED_SHORT, from);
    else
        glDrawElementsBaseVertex(GL_TRIANGLES, CORNERS - 1, GL_UNSIGNED_SHORT, from, first);
}

static void setup(app *a)
{
    const shader_source stages[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, fragment}};
    state = 0x9e3779b97f4a7c15ULL * (a->seed + 1ULL) + 1ULL;
    answers = a->answers != NULL ? fopen(a->answers, "w") : stdout;
    if (answers == NULL || strstr((const char *)glGetString(GL_EXTENSIONS), "GL_EXT_direct_state_access") == NULL) {
        fprintf(stderr, "it takes a file that can be written, and GL_EXT_direct_state_access\n");
        exit(1);
    }
    program = program_build(stages, 2);
    for (int i = 0; i < DIRECTIONS; i++) {
        for (int v = 0; v < VERTICES; v++) {
            int direction = (i + v / CORNERS) % DIRECTIONS;
            float *at = contents[i].floats[v];
            for (int k = 0; k < 3; k++)
                at[k] = 0.125f * (float)(below(17) - 8);
            at[direction / 2] += direction % 2 ? 6.0f : -6.0f;
            at[3] = 1.0f;
        }
        for (int v = 0; v < SHORTS; v++)
            for (int k = 0; k < 4; k++)
                contents[i].shorts[v][k] = (int16_t)(k == 3 ? 1 : (k == i / 2 ? 6 : 1) + below(2));
    }
    glGenBuffers(BUFFERS, buffers);
    glCreateVertexArrays(ARRAYS, arrays);
    for (int i = 0; i < BUFFERS; i++)
        fill(buffers[i]);
    /*
     * One buffer of indices begins at another vertex, so that the choice of the buffer is visible.
     */
    glCreateBuffers(2, indices);
    glNamedBufferData(indices[0], sizeof order, order, GL_STATIC_DRAW);
    glNamedBufferData(indices[1], sizeof order - 4 * sizeof order[0], order + 4, GL_STATIC_DRAW);
    for (int i = 0; i < ARRAYS; i++) {
        glBindVertexArray(arrays[i]);
        glBindBuffer(GL_ARRAY_BUFFER, some_buffer());
        glVertexAttribPointer(0, 4, GL_FLOAT, GL_FALSE, 16, NULL);
        glEnableVertexAttribArray(0);
        glVertexPointer(3, GL_FLOAT, 16, NULL);
        glEnableClientState(GL_VERTEX_ARRAY);
    }
    glPrimitiveRestartIndex(3);
}

static void draw(app *a)
{
    app_clear();
    glDisable(GL_DEPTH_TEST);
    glMatrixMode(GL_PROJECTION);
    glLoadMatrixf(a->projection.m);
    glMatrixMode(GL_MODELVIEW);
    for (int i = 0; i < STEPS; i++, step++) {
        for (int count = below(3); count > 0; count--) {
            changes[below((int)(sizeof changes / sizeof changes[0]))]();
            fprintf(answers, "%d error 0x%x\n", step, glGetError());
        }
        look();
        draw_something();
        fprintf(answers, "%d drawn, error 0x%x\n", step, glGetError());
    }
    fflush(answers);
}

int main(int argc, char **argv)
{
    static const app_program self = {"random_arrays", API_GL_COMPATIBILITY, 4, 5, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
