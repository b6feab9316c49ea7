/*
 * A scene of shaders in a core context that is the same in each frame, until from frame CHANGES on something is not:
 * --mode says what. Whatever it is, the picture must follow.
 */
#include "common/app.h"
#include "common/program.h"

#include <GL/glx.h>
#include <pthread.h>
#include <stddef.h>
#include <string.h>

enum { CHANGES = 24, SIDE = 8, CORNERS = 8 };

static const char vertex[] =
    "#version 430 core\n"
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec4 tint;\n"
    "layout(std140, binding = 2) uniform Shade { vec4 shade; };\n"
    "uniform mat4 P;\n"
    "uniform vec2 shift;\n"
    "out vec4 colour;\n"
    "out vec2 place;\n"
    "void main() {\n"
    "    colour = tint * shade;\n"
    "    place = position.xy;\n"
    "    gl_Position = P * vec4(position + vec3(shift, 0.0), 1.0);\n"
    "}\n";
static const char fragment[] =
    "#version 430 core\n"
    "in vec4 colour;\n"
    "in vec2 place;\n"
    "uniform sampler2D picture;\n"
    "uniform float weights[3];\n"
    "out vec4 result;\n"
    "void main() {\n"
    "    float sum = weights[0] + weights[1] + weights[2];\n"
    "    result = vec4(mix(colour.rgb, texture(picture, place).rgb, 0.5) * sum, 1.0);\n"
    "}\n";
/* Every sample that is shaded is counted, and the count shows. */
static const char counting[] =
    "#version 430 core\n"
    "in vec4 colour;\n"
    "in vec2 place;\n"
    "layout(std430, binding = 0) buffer Count { uint count; };\n"
    "uniform sampler2D picture;\n"
    "uniform float weights[3];\n"
    "out vec4 result;\n"
    "void main() {\n"
    "    uint before = atomicAdd(count, 1u);\n"
    "    result = vec4(fract(float(before >> 14) / 7.0), colour.g + weights[0], texture(picture, place).b, 1.0);\n"
    "}\n";
static const char storing[] =
    "#version 430 core\n"
    "in vec4 colour;\n"
    "in vec2 place;\n"
    "layout(binding = 0, rgba8) uniform image2D store;\n"
    "uniform sampler2D picture;\n"
    "uniform float weights[3];\n"
    "out vec4 result;\n"
    "void main() {\n"
    "    vec4 old = imageLoad(store, ivec2(0));\n"
    "    imageStore(store, ivec2(0), old + vec4(0.0000005, 0.0, 0.0, 0.0) + vec4(0.01 * weights[0]));\n"
    "    result = vec4(old.rgb + 0.2 * colour.rgb + 0.1 * texture(picture, place).rgb, 1.0);\n"
    "}\n";
static const char flat_vertex[] =
    "#version 430 core\n"
    "out vec2 at;\n"
    "void main() {\n"
    "    at = vec2(gl_VertexID & 1, gl_VertexID >> 1);\n"
    "    gl_Position = vec4(at * 2.0 - 1.0, 0.0, 1.0);\n"
    "}\n";
static const char flat_fragment[] =
    "#version 430 core\n"
    "in vec2 at;\n"
    "out vec4 result;\n"
    "void main() { result = vec4(0.5 * at, 0.04, 0.04); }\n";

static const char *mode = "still";
/* A step of something that goes on: a little more of all that was there, and a new part. */
static const char step_fragment[] =
    "#version 430 core\n"
    "in vec2 at;\n"
    "uniform sampler2D before;\n"
    "out vec4 result;\n"
    "void main() { result = vec4(texture(before, at).rgb + 0.02 * vec3(at, 1.0), 1.0); }\n";

static GLuint program, painter, stepper, array, empty, buffer, indices, block, commands, source, store, count, textures[2],
    sampler, framebuffer, painted, turns[2], turned[2], depths[2];
static GLint projection, shift, weights;
static float places[CORNERS][3];
static float *mapped;
static GLXContext other;

static bool is(const char *name)
{
    return strcmp(mode, name) == 0;
}

static bool now(const app *a, const char *name)
{
    return a->frame >= CHANGES && is(name);
}

static void texels(unsigned char rgba[SIDE * SIDE][4], int by)
{
    for (int i = 0; i < SIDE * SIDE; i++) {
        bool on = ((i % SIDE / 2 + i / SIDE / 2 + by) & 1) != 0;
        rgba[i][0] = on ? 255 : 30;
        rgba[i][1] = (unsigned char)(30 * (i % SIDE));
        rgba[i][2] = on ? 30 : 220;
        rgba[i][3] = 255;
    }
}

static void new_texture(GLuint name, int by)
{
    unsigned char rgba[SIDE * SIDE][4];
    texels(rgba, by);
    glBindTexture(GL_TEXTURE_2D, name);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, SIDE, SIDE, 0, GL_RGBA, GL_UNSIGNED_BYTE, rgba);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
}

static void setup(app *a)
{
    if (a->mode != NULL)
        mode = a->mode;
    const char *colouring = is("counted") ? counting : is("stored") ? storing : fragment;
    const shader_source stages[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, colouring}};
    const shader_source flats[] = {{GL_VERTEX_SHADER, flat_vertex}, {GL_FRAGMENT_SHADER, flat_fragment}};
    program = program_build(stages, 2);
    painter = program_build(flats, 2);
    const shader_source steps[] = {{GL_VERTEX_SHADER, flat_vertex}, {GL_FRAGMENT_SHADER, step_fragment}};
    stepper = program_build(steps, 2);
    projection = glGetUniformLocation(program, "P");
    shift = glGetUniformLocation(program, "shift");
    weights = glGetUniformLocation(program, "weights");
    for (int i = 0; i < CORNERS; i++) {
        places[i][0] = (i & 1 ? 1.0f : -1.0f) + (i < 4 ? -1.2f : 1.2f);
        places[i][1] = i & 2 ? 1.0f : -1.0f;
        places[i][2] = -5.0f;
    }
    glGenVertexArrays(1, &array);
    glGenVertexArrays(1, &empty);
    GLuint *names[] = {&buffer, &indices, &block, &commands, &source, &count};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        glGenBuffers(1, names[i]);
    glBindVertexArray(array);
    glBindBuffer(GL_ARRAY_BUFFER, buffer);
    if (is("persistent")) {
        const GLbitfield how = GL_MAP_WRITE_BIT | GL_MAP_PERSISTENT_BIT | GL_MAP_COHERENT_BIT;
        glBufferStorage(GL_ARRAY_BUFFER, sizeof places, places, how);
        mapped = glMapBufferRange(GL_ARRAY_BUFFER, 0, sizeof places, how);
    } else {
        glBufferData(GL_ARRAY_BUFFER, sizeof places, places, GL_DYNAMIC_DRAW);
    }
    glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, NULL);
    glEnableVertexAttribArray(0);
    static const unsigned short corners[12] = {0, 1, 2, 1, 3, 2, 4, 5, 6, 5, 7, 6};
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, sizeof corners, corners, GL_DYNAMIC_DRAW);
    static const float light[4] = {0.9f, 0.8f, 0.7f, 1.0f}, dark[4] = {0.2f, 0.3f, 0.9f, 1.0f};
    glBindBuffer(GL_UNIFORM_BUFFER, block);
    glBufferData(GL_UNIFORM_BUFFER, sizeof light, light, GL_DYNAMIC_DRAW);
    glBindBufferBase(GL_UNIFORM_BUFFER, 2, block);
    glBindBuffer(GL_COPY_READ_BUFFER, source);
    glBufferData(GL_COPY_READ_BUFFER, sizeof dark, dark, GL_STATIC_DRAW);
    static const GLuint command[5] = {6, 1, 6, 0, 0};
    glBindBuffer(GL_DRAW_INDIRECT_BUFFER, commands);
    glBufferData(GL_DRAW_INDIRECT_BUFFER, sizeof command, command, GL_DYNAMIC_DRAW);
    glGenTextures(2, textures);
    new_texture(textures[1], 1);
    new_texture(textures[0], 0);
    glGenSamplers(1, &sampler);
    glSamplerParameteri(sampler, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glGenTextures(1, &painted);
    glBindTexture(GL_TEXTURE_2D, painted);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, SIDE, SIDE, 0, GL_RGBA, GL_UNSIGNED_BYTE, NULL);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, painted, 0);
    glClearColor(0.0f, 0.0f, 0.0f, 0.0f);
    glClear(GL_COLOR_BUFFER_BIT);
    glGenFramebuffers(2, turns);
    glGenTextures(2, turned);
    glGenRenderbuffers(2, depths);
    for (int i = 0; i < 2; i++) {
        glBindTexture(GL_TEXTURE_2D, turned[i]);
        glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, SIDE, SIDE, 0, GL_RGBA, GL_UNSIGNED_BYTE, NULL);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
        glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
        glBindRenderbuffer(GL_RENDERBUFFER, depths[i]);
        glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, SIDE, SIDE);
        glBindFramebuffer(GL_FRAMEBUFFER, turns[i]);
        glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, turned[i], 0);
        glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depths[i]);
        glClear(GL_COLOR_BUFFER_BIT);
    }
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glBindTexture(GL_TEXTURE_2D, textures[0]);
    if (is("counted")) {
        static const GLuint zero;
        glBindBuffer(GL_SHADER_STORAGE_BUFFER, count);
        glBufferData(GL_SHADER_STORAGE_BUFFER, sizeof zero, &zero, GL_DYNAMIC_COPY);
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, count);
    }
    if (is("stored")) {
        glGenTextures(1, &store);
        glBindTexture(GL_TEXTURE_2D, store);
        static const unsigned char black[4];
        glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, 1, 1, 0, GL_RGBA, GL_UNSIGNED_BYTE, black);
        glBindTexture(GL_TEXTURE_2D, textures[0]);
        glBindImageTexture(0, store, 0, GL_FALSE, 0, GL_READ_WRITE, GL_RGBA8);
    }
    if (is("other_context") || is("other_thread")) {
        static const int version[] = {0x2091, 4, 0x2092, 3, 0x9126, 1, 0};
        typedef GLXContext (*creator)(Display *, GLXFBConfig, GLXContext, Bool, const int *);
        creator create = (creator)glXGetProcAddress((const GLubyte *)"glXCreateContextAttribsARB");
        other = create(a->window.display, a->window.config, a->window.context, True, version);
        app_check(a, other != NULL, "there is no second context");
    }
}

static void upload(void)
{
    unsigned char rgba[SIDE * SIDE][4];
    texels(rgba, 1);
    glBindTexture(GL_TEXTURE_2D, textures[0]);
    glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, SIDE, SIDE, GL_RGBA, GL_UNSIGNED_BYTE, rgba);
    glFinish();
}

/* A thread that loads textures, without a window. */
static void *load(void *argument)
{
    const app *a = argument;
    if (glXMakeCurrent(a->window.display, None, other)) {
        upload();
        glXMakeCurrent(a->window.display, None, NULL);
    }
    return NULL;
}

/* Each of two textures becomes what the other was, and a little more; `only`: the second from a texture that stays. */
static void take_turns(const app *a, bool only)
{
    glViewport(0, 0, SIDE, SIDE);
    glUseProgram(stepper);
    glBindVertexArray(empty);
    glBindSampler(0, 0);
    for (int i = only ? 1 : 0; i < 2; i++) {
        glBindFramebuffer(GL_FRAMEBUFFER, turns[i]);
        glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
        glDisable(GL_DEPTH_TEST);
        glBindTexture(GL_TEXTURE_2D, only ? textures[now(a, "off_screen") ? 1 : 0] : turned[1 - i]);
        glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
    }
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glViewport(0, 0, a->window.width, a->window.height);
    glBindTexture(GL_TEXTURE_2D, turned[1]);
}

/* What happens between frames, or before the draws, from frame CHANGES on. */
static void change(app *a)
{
    static const float dark[4] = {0.2f, 0.3f, 0.9f, 1.0f};
    float moved[CORNERS][3];
    memcpy(moved, places, sizeof moved);
    for (int i = 0; i < CORNERS; i++)
        moved[i][1] += 0.7f;
    unsigned char rgba[SIDE * SIDE][4];
    texels(rgba, 1);
    if (is("sub_data"))
        glBufferSubData(GL_ARRAY_BUFFER, 0, sizeof moved, moved);
    if (is("data"))
        glBufferData(GL_ARRAY_BUFFER, sizeof moved, moved, GL_DYNAMIC_DRAW);
    if (is("mapped")) {
        memcpy(glMapBuffer(GL_ARRAY_BUFFER, GL_WRITE_ONLY), moved, sizeof moved);
        glUnmapBuffer(GL_ARRAY_BUFFER);
    }
    if (is("persistent"))
        memcpy(mapped, moved, sizeof moved);
    if (is("block"))
        glBufferSubData(GL_UNIFORM_BUFFER, 0, sizeof dark, dark);
    if (is("named_block"))
        glNamedBufferSubData(block, 0, sizeof dark, dark);
    if (is("copied"))
        glCopyBufferSubData(GL_COPY_READ_BUFFER, GL_UNIFORM_BUFFER, 0, 0, sizeof dark);
    if (is("indices")) {
        static const unsigned short less[3] = {0, 0, 0};
        glBufferSubData(GL_ELEMENT_ARRAY_BUFFER, 0, sizeof less, less);
    }
    if (is("indirect")) {
        static const GLuint three = 3;
        glBufferSubData(GL_DRAW_INDIRECT_BUFFER, 0, sizeof three, &three);
    }
    if (is("texels"))
        glTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, SIDE, SIDE, GL_RGBA, GL_UNSIGNED_BYTE, rgba);
    if (is("named_texels"))
        glTextureSubImage2D(textures[0], 0, 0, 0, SIDE, SIDE, GL_RGBA, GL_UNSIGNED_BYTE, rgba);
    if (is("sampler"))
        glSamplerParameteri(sampler, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    if (is("program_uniform")) {
        static const float three[3] = {0.1f, 0.1f, 0.2f};
        glProgramUniform1fv(program, weights, 3, three);
    }
    if (is("other_context")) {
        glXMakeCurrent(a->window.display, a->window.window, other);
        upload();
        glXMakeCurrent(a->window.display, a->window.window, a->window.context);
    }
    if (is("other_thread")) {
        pthread_t thread;
        app_check(a, pthread_create(&thread, NULL, load, a) == 0, "there is no thread");
        pthread_join(thread, NULL);
    }
}

static void draw(app *a)
{
    if (a->frame >= CHANGES)
        change(a);
    if (is("painted_over")) {
        /* Off screen each frame adds to what the last ones left. */
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
        glViewport(0, 0, SIDE, SIDE);
        glDisable(GL_DEPTH_TEST);
        glEnable(GL_BLEND);
        glBlendFunc(GL_ONE, GL_ONE);
        glUseProgram(painter);
        glBindVertexArray(empty);
        glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
        glDisable(GL_BLEND);
        glBindFramebuffer(GL_FRAMEBUFFER, 0);
        glViewport(0, 0, a->window.width, a->window.height);
        glBindTexture(GL_TEXTURE_2D, painted);
    }
    if (is("in_turns"))
        take_turns(a, false);
    if (is("off_screen"))
        take_turns(a, true);
    app_clear();
    glUseProgram(program);
    glBindVertexArray(array);
    glBindSampler(0, sampler);
    if (!is("painted_over") && !is("in_turns") && !is("off_screen"))
        glBindTexture(GL_TEXTURE_2D, textures[now(a, "texture") ? 1 : 0]);
    glUniformMatrix4fv(projection, 1, GL_FALSE, a->projection.m);
    glUniform2f(shift, 0.0f, now(a, "uniform") ? 0.8f : 0.0f);
    if (!is("program_uniform")) {
        const float three[3] = {0.4f, 0.3f, now(a, "uniforms") ? 0.0f : 0.3f};
        glUniform1fv(weights, 3, three);
    }
    glVertexAttrib4f(1, 1.0f, now(a, "attribute") ? 0.1f : 0.9f, 0.5f, 1.0f);
    if (is("several")) {
        const GLint firsts[2] = {0, now(a, "several") ? 5 : 3};
        static const GLsizei three[2] = {3, 3};
        glMultiDrawArrays(GL_TRIANGLES, firsts, three, 2);
        return;
    }
    glDrawElements(GL_TRIANGLES, 6, GL_UNSIGNED_SHORT, NULL);
    if (is("indirect"))
        glDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_SHORT, NULL);
    else
        glDrawElements(GL_TRIANGLES, now(a, "count") ? 3 : 6, GL_UNSIGNED_SHORT, (const char *)NULL + 12);
    if (now(a, "one_more"))
        glDrawElementsBaseVertex(GL_TRIANGLES, 3, GL_UNSIGNED_SHORT, NULL, 2);
}

int main(int argc, char **argv)
{
    static const app_program self = {"still_shaders", API_GL_CORE, 4, 5, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
