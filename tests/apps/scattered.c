/*
 * Small objects in all directions, at random places (--seed), drawn off screen: by Begin/End, a
 * display list, arrays in memory and in buffers, by the fixed-function pipeline and by shaders, as
 * triangles, wide lines and points. --mode selects how they are shown:
 *
 *   blit     drawn into a texture that is copied to the window (the default)
 *   samples  drawn into multisampled renderbuffers, resolved into a texture, shown by a textured
 *            quad
 *   chain    drawn into a texture, with two passes after it
 *   lamps    as chain; in between each lamp lights the texture where the lamp is on the screen, and
 *            a board in the scene shows the texture at other places
 *   ahead    as chain, with everything ahead of the viewer
 *   count    as ahead, while a query counts primitives
 *
 * --answers names a file for the pixels that the program reads of its texture.
 */
#include "common/app.h"
#include "common/program.h"

#include <math.h>
#include <string.h>

#define HEAD "#version 120\n"

static const char thing_vertex[] =
    HEAD "attribute vec3 position;\nuniform mat4 MVP;\nvoid main() { gl_Position = MVP * vec4(position, 1.0); }\n";
static const char thing_fragment[] = HEAD "uniform vec4 colour;\nvoid main() { gl_FragColor = colour; }\n";
/* Reads the fragment's place on the screen. */
static const char lamp_fragment[] =
    HEAD "uniform vec4 colour;\nuniform vec2 size;\nuniform sampler2D picture;\n"
         "void main() { gl_FragColor = colour * texture2D(picture, gl_FragCoord.xy / size); }\n";
static const char board_fragment[] =
    HEAD "uniform sampler2D picture;\nvoid main() { gl_FragColor = texture2D(picture, gl_TexCoord[0].xy); }\n";
static const char board_vertex[] =
    HEAD "void main() { gl_TexCoord[0] = gl_MultiTexCoord0; gl_Position = gl_ModelViewProjectionMatrix * gl_Vertex; }\n";
static const char pass_vertex[] =
    HEAD "attribute vec3 position;\nvarying vec2 place;\n"
         "void main() { place = 0.5 + 0.5 * position.xy; gl_Position = vec4(position, 1.0); }\n";
static const char pass_fragment[] = HEAD "varying vec2 place;\nuniform sampler2D picture;\n"
                                         "void main() { gl_FragColor = vec4(texture2D(picture, place).brg, 1.0); }\n";
static const char last_fragment[] = HEAD "varying vec2 place;\nuniform sampler2D picture;\n"
                                         "void main() { gl_FragColor = vec4(texture2D(picture, place).gbr, 1.0); }\n";

enum { THINGS = 120, LAMPS = 24, CORNERS = 12, WAYS = 7 };

/* A tetrahedron. */
static const float corners[CORNERS][3] = {
    {1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, 1, 1}, {-1, -1, 1}, {1, -1, -1},
    {1, 1, 1}, {-1, 1, -1}, {1, -1, -1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1},
};
static const float screen[4][3] = {{-1, -1, 0}, {1, -1, 0}, {-1, 1, 0}, {1, 1, 0}};
static const GLushort order[CORNERS] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11};

static const char *mode = "blit";
static unsigned long long state;
static GLuint list, buffers[3], framebuffers[3], textures[2], thing, lamp, board, pass, last;

/* xorshift64*, which gives the same numbers on every machine, 0...1. */
static double number(void)
{
    state ^= state >> 12;
    state ^= state << 25;
    state ^= state >> 27;
    return (double)((state * 2685821657736338717ULL) >> 40) / 16777216.0;
}

static int is(const char *name)
{
    return strcmp(mode, name) == 0;
}

static GLuint build(const char *first, const char *second)
{
    const shader_source stages[] = {{GL_VERTEX_SHADER, first}, {GL_FRAGMENT_SHADER, second}};
    return program_build(stages, 2);
}

static void make_texture(int i, int width, int height)
{
    glBindTexture(GL_TEXTURE_2D, textures[i]);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, NULL);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffers[i]);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, textures[i], 0);
}

static void make_renderbuffer(GLenum point, GLenum format, int samples, int width, int height)
{
    GLuint name;
    glGenRenderbuffers(1, &name);
    glBindRenderbuffer(GL_RENDERBUFFER, name);
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format, width, height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, point, GL_RENDERBUFFER, name);
}

static void triangles(void)
{
    glBegin(GL_TRIANGLES);
    for (int i = 0; i < CORNERS; i++)
        glVertex3fv(corners[i]);
    glEnd();
}

static void setup(app *a)
{
    int width = a->window.width, height = a->window.height;
    if (a->mode != NULL)
        mode = a->mode;
    thing = build(thing_vertex, thing_fragment);
    lamp = build(thing_vertex, lamp_fragment);
    board = build(board_vertex, board_fragment);
    pass = build(pass_vertex, pass_fragment);
    last = build(pass_vertex, last_fragment);
    list = glGenLists(1);
    glNewList(list, GL_COMPILE);
    glColor3f(1.0f, 0.9f, 0.8f);
    triangles();
    glEndList();
    glGenBuffers(3, buffers);
    glBindBuffer(GL_ARRAY_BUFFER, buffers[0]);
    glBufferData(GL_ARRAY_BUFFER, sizeof corners, corners, GL_STATIC_DRAW);
    glBindBuffer(GL_ARRAY_BUFFER, buffers[1]);
    glBufferData(GL_ARRAY_BUFFER, sizeof screen, screen, GL_STATIC_DRAW);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[2]);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, sizeof order, order, GL_STATIC_DRAW);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, 0);
    glGenFramebuffers(3, framebuffers);
    glGenTextures(2, textures);
    make_texture(1, width, height);
    make_texture(0, width, height);
    if (is("samples")) {
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffers[2]);
        make_renderbuffer(GL_COLOR_ATTACHMENT0, GL_RGBA8, 4, width, height);
        make_renderbuffer(GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT24, 4, width, height);
    } else {
        make_renderbuffer(GL_DEPTH_ATTACHMENT, GL_DEPTH24_STENCIL8, 0, width, height);
    }
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
}

/* Model-view matrix of an object somewhere around the viewer. */
static matrix4 somewhere(const app *a, double size)
{
    double turn = 6.2831853 * number(), up = 2.0 * number() - 1.0, distance = 6.0 + 8.0 * number();
    double level = sqrt(1.0 - up * up);
    double x = level * sin(turn), y = up, z = level * cos(turn);
    if (is("ahead") || is("count")) {
        x *= 0.2;
        y *= 0.2;
        z = -1.0;
    }
    matrix4 place = matrix_translate(distance * x, distance * y, distance * z);
    /* Some objects are much larger than others, so that they are in several views. */
    return matrix_multiply(a->view, matrix_multiply(place, matrix_scale(size * (number() < 0.1 ? 6.0 : 1.0))));
}

static void use(const app *a, GLuint program, matrix4 modelview, const float colour[4])
{
    matrix4 mvp = matrix_multiply(a->projection, modelview);
    glUseProgram(program);
    glUniformMatrix4fv(glGetUniformLocation(program, "MVP"), 1, GL_FALSE, mvp.m);
    glUniform4fv(glGetUniformLocation(program, "colour"), 1, colour);
    glBindBuffer(GL_ARRAY_BUFFER, buffers[0]);
    glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, NULL);
    glEnableVertexAttribArray(0);
}

static void done(void)
{
    glDisableVertexAttribArray(0);
    glDisableClientState(GL_VERTEX_ARRAY);
    glBindBuffer(GL_ARRAY_BUFFER, 0);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, 0);
    glUseProgram(0);
}

/* Draws an object and returns its number of primitives. */
static GLuint draw_thing(const app *a)
{
    int way = (int)(WAYS * number());
    const float colour[4] = {(float)number(), (float)number(), (float)number(), 1.0f};
    matrix4 modelview = somewhere(a, 0.3 + 0.5 * number());
    glMatrixMode(GL_MODELVIEW);
    glLoadMatrixf(modelview.m);
    /* Other objects keep the colour that the list set, although few views showed the list. */
    if (number() < 0.5)
        glColor4fv(colour);
    switch (way) {
    case 0:
        triangles();
        break;
    case 1:
        glCallList(list);
        break;
    case 2:
        glVertexPointer(3, GL_FLOAT, 0, corners);
        glEnableClientState(GL_VERTEX_ARRAY);
        glDrawArrays(GL_TRIANGLES, 0, CORNERS);
        break;
    case 3:
        glBindBuffer(GL_ARRAY_BUFFER, buffers[0]);
        glVertexPointer(3, GL_FLOAT, 0, NULL);
        glEnableClientState(GL_VERTEX_ARRAY);
        glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[2]);
        glDrawElements(GL_TRIANGLES, CORNERS, GL_UNSIGNED_SHORT, NULL);
        break;
    case 4:
        use(a, thing, modelview, colour);
        glDrawArrays(GL_TRIANGLES, 0, CORNERS);
        break;
    case 5:
        use(a, thing, modelview, colour);
        glDrawArrays(GL_LINE_STRIP, 0, CORNERS);
        break;
    default:
        use(a, thing, modelview, colour);
        glDrawArrays(GL_POINTS, 0, CORNERS);
    }
    done();
    return way < 5 ? CORNERS / 3 : way == 5 ? CORNERS - 1 : CORNERS;
}

/* A board in the scene that shows the texture. */
static void draw_board(const app *a)
{
    glUseProgram(board);
    glLoadMatrixf(matrix_multiply(a->view, matrix_translate(0.0, 1.0, -8.0)).m);
    glBegin(GL_TRIANGLE_STRIP);
    for (int i = 0; i < 4; i++) {
        glTexCoord2f(0.5f + 0.5f * screen[i][0], 0.5f + 0.5f * screen[i][1]);
        glVertex3fv(screen[i]);
    }
    glEnd();
    glUseProgram(0);
}

static void fill(GLuint framebuffer, GLuint program, GLuint texture)
{
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glDisable(GL_DEPTH_TEST);
    glUseProgram(program);
    glBindTexture(GL_TEXTURE_2D, texture);
    glBindBuffer(GL_ARRAY_BUFFER, buffers[1]);
    glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, NULL);
    glEnableVertexAttribArray(0);
    glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
    done();
}

static void light(const app *a)
{
    glEnable(GL_BLEND);
    glBlendFunc(GL_ONE, GL_ONE);
    for (int i = 0; i < LAMPS; i++) {
        const float colour[4] = {0.3f, 0.2f, 0.15f, 0.0f};
        use(a, lamp, somewhere(a, 1.2), colour);
        glUniform2f(glGetUniformLocation(lamp, "size"), (float)a->window.width, (float)a->window.height);
        glDrawArrays(GL_TRIANGLES, 0, CORNERS);
        done();
    }
    glDisable(GL_BLEND);
    draw_board(a);
}

static void draw(app *a)
{
    int width = a->window.width, height = a->window.height;
    state = 0x9e3779b97f4a7c15ULL * (a->seed + 1ULL) + 1ULL;
    glBindTexture(GL_TEXTURE_2D, 0);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffers[is("samples") ? 2 : 0]);
    app_clear();
    glMatrixMode(GL_PROJECTION);
    glLoadMatrixf(a->projection.m);
    glLineWidth(5.0f);
    glPointSize(7.0f);
    GLuint primitives = 0, query = 0, counted = 0;
    if (is("count")) {
        glGenQueries(1, &query);
        glBeginQuery(GL_PRIMITIVES_GENERATED, query);
    }
    for (int i = 0; i < THINGS; i++)
        primitives += draw_thing(a);
    if (is("count")) {
        glEndQuery(GL_PRIMITIVES_GENERATED);
        glGetQueryObjectuiv(query, GL_QUERY_RESULT, &counted);
        glDeleteQueries(1, &query);
        app_check(a, counted == primitives, "%u primitives were counted instead of %u", counted, primitives);
    }
    if (is("samples")) {
        glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffers[2]);
        glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffers[0]);
        glBlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffers[0]);
    }
    if (a->answers != NULL) {
        image picture = image_read_framebuffer(width, height);
        app_check(a, image_write_ppm(&picture, a->answers), "cannot write %s", a->answers);
        image_free(&picture);
    }
    if (is("blit")) {
        glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffers[0]);
        glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
        glBlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
        glBindFramebuffer(GL_FRAMEBUFFER, 0);
    } else {
        fill(framebuffers[1], pass, textures[0]);
        if (is("lamps"))
            light(a);
        fill(0, last, textures[1]);
    }
}

int main(int argc, char **argv)
{
    static const app_program self = {"scattered", API_GL_COMPATIBILITY, 0, 0, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
