#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
#include <GL/glext.h>

#include "gears_scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TURN 6.28318530717958647692f

static const char vertex_source[] =
    "#version 330 core\n"
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec3 normal;\n"
    "uniform mat4 projection;\n"
    "uniform mat4 modelview;\n"
    "out vec3 eye_normal;\n"
    "void main() {\n"
    "    eye_normal = mat3(modelview) * normal;\n"
    "    gl_Position = projection * (modelview * vec4(position, 1.0));\n"
    "}\n";
static const char fragment_source[] =
    "#version 330 core\n"
    "in vec3 eye_normal;\n"
    "uniform vec3 colour;\n"
    "out vec4 result;\n"
    "void main() {\n"
    "    float light = max(dot(normalize(eye_normal), normalize(vec3(0.3, 0.7, 0.6))), 0.0);\n"
    "    result = vec4(colour * (0.2 + 0.8 * light), 1.0);\n"
    "}\n";

/* Properties and positions of the gears. Lengths are in the world's units; the eye is at the origin. */
static const struct {
    float place[3], tilt, radius, speed, colour[3];
    int teeth;
} gears[GEARS] = {
    {{-3.1f, -2.0f, -9.0f}, 0.0f, 4.0f, 1.0f, {0.8f, 0.1f, 0.0f}, 20},
    {{3.1f, -2.0f, -9.0f}, 0.0f, 2.0f, -2.0f, {0.0f, 0.8f, 0.2f}, 10},
    {{0.0f, 5.0f, -3.0f}, 1.1f, 4.0f, 0.5f, {0.2f, 0.2f, 1.0f}, 24},
};

/* Grows as triangles are added. If memory runs out, it has no vertices. */
typedef struct {
    float *values;
    size_t count, room;
} vertices;

static void add_triangle(vertices *v, const float a[3], const float b[3], const float c[3])
{
    if (v->count + 18 > v->room) {
        size_t room = v->room == 0 ? 4096 : 2 * v->room;
        float *values = realloc(v->values, room * sizeof *values);
        if (values == NULL) {
            free(v->values);
            memset(v, 0, sizeof *v);
            return;
        }
        v->values = values;
        v->room = room;
    }
    float u[3], w[3];
    for (int i = 0; i < 3; i++) {
        u[i] = b[i] - a[i];
        w[i] = c[i] - a[i];
    }
    const float normal[3] = {u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]};
    const float *corners[3] = {a, b, c};
    for (int corner = 0; corner < 3; corner++) {
        memcpy(v->values + v->count, corners[corner], 3 * sizeof(float));
        memcpy(v->values + v->count + 3, normal, sizeof normal);
        v->count += 6;
    }
}

static void add_quad(vertices *v, const float a[3], const float b[3], const float c[3], const float d[3])
{
    add_triangle(v, a, b, c);
    add_triangle(v, a, c, d);
}

/* A point of a gear: distance from the axis, part of a turn, height. */
static void point(float result[3], float radius, float turn, float height)
{
    result[0] = radius * cosf(turn * TURN);
    result[1] = radius * sinf(turn * TURN);
    result[2] = height;
}

static vertices make_gear(float radius, int teeth)
{
    vertices v = {NULL, 0, 0};
    const float inner = 0.35f * radius, root = radius - 0.35f, half = 0.5f;
    for (int step = 0; step < 4 * teeth; step++) {
        /* Each tooth has four steps: rise, top, fall, gap. */
        const float rims[4][2] = {{root, radius}, {radius, radius}, {radius, root}, {root, root}};
        float from = (float)step / (4.0f * (float)teeth), to = (float)(step + 1) / (4.0f * (float)teeth);
        float first = rims[step % 4][0], second = rims[step % 4][1];
        float in[2][2][3], out[2][2][3];
        for (int side = 0; side < 2; side++) {
            float height = side == 0 ? -half : half;
            point(in[0][side], inner, from, height);
            point(in[1][side], inner, to, height);
            point(out[0][side], first, from, height);
            point(out[1][side], second, to, height);
        }
        add_quad(&v, in[0][1], out[0][1], out[1][1], in[1][1]);
        add_quad(&v, in[0][0], in[1][0], out[1][0], out[0][0]);
        add_quad(&v, out[0][0], out[1][0], out[1][1], out[0][1]);
        add_quad(&v, in[0][1], in[1][1], in[1][0], in[0][0]);
    }
    return v;
}

static GLuint compile(GLenum stage, const char *source)
{
    GLuint shader = glCreateShader(stage);
    glShaderSource(shader, 1, &source, NULL);
    glCompileShader(shader);
    return shader;
}

bool scene_create(scene *s)
{
    memset(s, 0, sizeof *s);
    GLuint vertex = compile(GL_VERTEX_SHADER, vertex_source), fragment = compile(GL_FRAGMENT_SHADER, fragment_source);
    s->program = glCreateProgram();
    glAttachShader(s->program, vertex);
    glAttachShader(s->program, fragment);
    glLinkProgram(s->program);
    glDeleteShader(vertex);
    glDeleteShader(fragment);
    GLint linked = 0;
    glGetProgramiv(s->program, GL_LINK_STATUS, &linked);
    if (!linked) {
        char log[1024] = "";
        glGetProgramInfoLog(s->program, (GLsizei)sizeof log, NULL, log);
        fprintf(stderr, "the shaders do not link: %s\n", log);
        return false;
    }
    s->projection = glGetUniformLocation(s->program, "projection");
    s->modelview = glGetUniformLocation(s->program, "modelview");
    s->colour = glGetUniformLocation(s->program, "colour");

    glGenVertexArrays(GEARS, s->arrays);
    glGenBuffers(GEARS, s->buffers);
    for (int i = 0; i < GEARS; i++) {
        vertices v = make_gear(gears[i].radius, gears[i].teeth);
        s->vertices[i] = (GLsizei)(v.count / 6);
        glBindVertexArray(s->arrays[i]);
        glBindBuffer(GL_ARRAY_BUFFER, s->buffers[i]);
        glBufferData(GL_ARRAY_BUFFER, (GLsizeiptr)(v.count * sizeof(float)), v.values, GL_STATIC_DRAW);
        glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 6 * sizeof(float), NULL);
        glVertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, 6 * sizeof(float), (const char *)NULL + 3 * sizeof(float));
        glEnableVertexAttribArray(0);
        glEnableVertexAttribArray(1);
        free(v.values);
    }
    glBindVertexArray(0);
    return true;
}

void scene_camera(float view[16])
{
    /* The eye is at the origin and looks along -z. */
    for (int i = 0; i < 16; i++)
        view[i] = i % 5 == 0 ? 1.0f : 0.0f;
}

void scene_perspective(float projection[16], float field_of_view, float aspect)
{
    const float near = 0.5f, far = 100.0f, scale = 1.0f / tanf(field_of_view / 360.0f * 0.5f * TURN);
    memset(projection, 0, 16 * sizeof *projection);
    projection[0] = scale / aspect;
    projection[5] = scale;
    projection[10] = (far + near) / (near - far);
    projection[11] = -1.0f;
    projection[14] = 2.0f * far * near / (near - far);
}

/* result = a * b, column-major. */
static void multiply(float result[16], const float a[16], const float b[16])
{
    for (int column = 0; column < 4; column++) {
        for (int row = 0; row < 4; row++) {
            float sum = 0.0f;
            for (int k = 0; k < 4; k++)
                sum += a[4 * k + row] * b[4 * column + k];
            result[4 * column + row] = sum;
        }
    }
}

void scene_draw(const scene *s, double seconds, const float view[16], const float projection[16])
{
    glClearColor(0.02f, 0.03f, 0.06f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glEnable(GL_DEPTH_TEST);
    glUseProgram(s->program);
    glUniformMatrix4fv(s->projection, 1, GL_FALSE, projection);
    for (int i = 0; i < GEARS; i++) {
        float angle = (float)fmod(seconds * 0.1 * gears[i].speed, 1.0) * TURN;
        float c = cosf(angle), n = sinf(angle), ct = cosf(gears[i].tilt), st = sinf(gears[i].tilt);
        const float *p = gears[i].place;
        /* Turned about its own axis, then tilted about x, then moved to its position. */
        const float model[16] = {c,    n * ct, n * st, 0.0f, -n,   c * ct, c * st, 0.0f,
                                 0.0f, -st,    ct,     0.0f, p[0], p[1],   p[2],   1.0f};
        float modelview[16];
        multiply(modelview, view, model);
        glUniformMatrix4fv(s->modelview, 1, GL_FALSE, modelview);
        glUniform3fv(s->colour, 1, gears[i].colour);
        glBindVertexArray(s->arrays[i]);
        glDrawArrays(GL_TRIANGLES, 0, s->vertices[i]);
    }
    glBindVertexArray(0);
    glUseProgram(0);
}

void scene_destroy(scene *s)
{
    glDeleteVertexArrays(GEARS, s->arrays);
    glDeleteBuffers(GEARS, s->buffers);
    glDeleteProgram(s->program);
    memset(s, 0, sizeof *s);
}
