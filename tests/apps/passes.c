/*
 * Direction test in a core 4.5 context for the many ways to draw a scene off screen and then show
 * it, one for each --mode. In each way the window shows the cube's own colours.
 */
#include "common/app.h"
#include "common/mesh.h"
#include "common/program.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define HEAD "#version 450 core\n"
#define FULL_SCREEN \
    HEAD "out vec2 place;\n" \
         "void main() {\n" \
         "    place = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0;\n" \
         "    gl_Position = vec4(place * 2.0 - 1.0, 0.0, 1.0);\n" \
         "}\n"
#define PICTURE HEAD "in vec2 place;\nout vec4 result;\nlayout(binding = 0) uniform sampler2D picture;\n"

static const char vertex[] = HEAD "layout(location = 0) in vec3 position;\n"
                                  "layout(location = 1) in vec3 colour;\n"
                                  "uniform mat4 MVP;\n"
                                  "out vec3 shade;\n"
                                  "void main() { shade = colour; gl_Position = MVP * vec4(position, 1.0); }\n";
static const char fragment[] = HEAD "in vec3 shade;\nout vec4 result;\nvoid main() { result = vec4(shade, 1.0); }\n";
/* Writes each component to a separate buffer. */
static const char fragment_apart[] =
    HEAD "in vec3 shade;\nlayout(location = 0) out vec4 red;\nlayout(location = 1) out vec4 green;\n"
         "layout(location = 2) out vec4 blue;\n"
         "void main() { red = vec4(shade.r); green = vec4(shade.g); blue = vec4(shade.b); }\n";
/*
 * A second pass over the scene. It reads its colours from the first pass by its place on the
 * screen.
 */
static const char fragment_light[] =
    HEAD "in vec3 shade;\nout vec4 result;\nlayout(binding = 0) uniform sampler2D picture;\n"
         "void main() { result = texelFetch(picture, ivec2(gl_FragCoord.xy), 0); }\n";

static const char show[] = PICTURE "uniform vec2 part;\nvoid main() { result = vec4(texture(picture, place * part).rgb, 1.0); }\n";
static const char show_rectangle[] =
    HEAD "in vec2 place;\nout vec4 result;\nlayout(binding = 0) uniform sampler2DRect picture;\n"
         "void main() { result = vec4(texture(picture, place * textureSize(picture)).rgb, 1.0); }\n";
static const char show_half_each[] =
    PICTURE "layout(binding = 1) uniform sampler2D smaller;\n"
            "void main() { result = 0.5 * (texture(picture, place) + texture(smaller, place)); }\n";
static const char show_levels[] =
    PICTURE "void main() { result = 0.5 * (textureLod(picture, place, 0.0) + textureLod(picture, place, 1.0)); }\n";
/* The cube is everywhere, so each depth must be between the middle and the far plane. */
static const char show_depth[] =
    PICTURE "layout(binding = 1) uniform sampler2D depths;\n"
            "void main() {\n"
            "    float depth = texture(depths, place).r;\n"
            "    result = depth > 0.5 && depth < 1.0 ? texture(picture, place) : vec4(1.0, 0.0, 1.0, 1.0);\n"
            "}\n";
static const char show_apart[] =
    HEAD "out vec4 result;\nlayout(binding = 0) uniform sampler2D red;\nlayout(binding = 1) uniform sampler2D green;\n"
         "layout(binding = 2) uniform sampler2D blue;\n"
         "void main() {\n"
         "    ivec2 at = ivec2(gl_FragCoord.xy);\n"
         "    result = vec4(texelFetch(red, at, 0).r, texelFetch(green, at, 0).r, texelFetch(blue, at, 0).r, 1.0);\n"
         "}\n";
static const char show_samples[] =
    HEAD "out vec4 result;\nlayout(binding = 0) uniform sampler2DMS picture;\n"
         "void main() {\n"
         "    result = vec4(0.0);\n"
         "    for (int i = 0; i < 4; i++) result += 0.25 * texelFetch(picture, ivec2(gl_FragCoord.xy), i);\n"
         "}\n";
static const char change[] = PICTURE "void main() { result = vec4(texture(picture, place).brg, 1.0); }\n";
static const char undo[] = PICTURE "void main() { result = vec4(texture(picture, place).gbr, 1.0); }\n";

enum { TARGETS = 4 };
static const char *mode = "plain";
static mesh cube;
static GLuint scene, scene_apart, light, empty, framebuffers[TARGETS], textures[TARGETS], depth;
static GLuint last, half_each, levels, depths, apart, samples, rectangle, changes, undoes;

static int is(const char *name)
{
    return strcmp(mode, name) == 0;
}

static GLuint build(const char *first, const char *second)
{
    const shader_source stages[] = {{GL_VERTEX_SHADER, first}, {GL_FRAGMENT_SHADER, second}};
    return program_build(stages, 2);
}

static void specify(int i, GLenum target, GLenum format, int width, int height)
{
    glDeleteTextures(1, &textures[i]);
    glCreateTextures(target, 1, &textures[i]);
    if (target == GL_TEXTURE_2D_MULTISAMPLE) {
        glTextureStorage2DMultisample(textures[i], 4, format, width, height, GL_TRUE);
        return;
    }
    glTextureStorage2D(textures[i], is("mipmap") ? 4 : 1, format, width, height);
    glTextureParameteri(textures[i], GL_TEXTURE_MIN_FILTER, is("mipmap") ? GL_LINEAR_MIPMAP_NEAREST : GL_LINEAR);
    glTextureParameteri(textures[i], GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTextureParameteri(textures[i], GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

static void attach(int i, GLenum target, int width, int height)
{
    /* 8 bits would be rounded in each pass, and the errors would add up. */
    specify(i, target, is("bloom") || is("mipmap") ? GL_RGBA16F : GL_RGBA8, width, height);
    glNamedFramebufferTexture(framebuffers[i], GL_COLOR_ATTACHMENT0, textures[i], 0);
}

static void attach_depth(int i, int width, int height, int count)
{
    glCreateRenderbuffers(1, &depth);
    if (count > 0)
        glNamedRenderbufferStorageMultisample(depth, count, GL_DEPTH_COMPONENT24, width, height);
    else
        glNamedRenderbufferStorage(depth, GL_DEPTH24_STENCIL8, width, height);
    glNamedFramebufferRenderbuffer(framebuffers[i], GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth);
}

static void setup(app *a)
{
    int width = a->window.width, height = a->window.height;
    if (a->mode != NULL)
        mode = a->mode;
    scene = build(vertex, fragment);
    scene_apart = build(vertex, fragment_apart);
    light = build(vertex, fragment_light);
    last = build(FULL_SCREEN, show);
    glProgramUniform2f(last, glGetUniformLocation(last, "part"), 1.0f, 1.0f);
    half_each = build(FULL_SCREEN, show_half_each);
    levels = build(FULL_SCREEN, show_levels);
    depths = build(FULL_SCREEN, show_depth);
    apart = build(FULL_SCREEN, show_apart);
    samples = build(FULL_SCREEN, show_samples);
    rectangle = build(FULL_SCREEN, show_rectangle);
    changes = build(FULL_SCREEN, change);
    undoes = build(FULL_SCREEN, undo);
    cube = mesh_cube();
    glCreateVertexArrays(1, &empty);
    glCreateFramebuffers(TARGETS, framebuffers);
    int wide = is("twice") ? 2 * width : is("power") ? 1024 : width;
    int high = is("twice") ? 2 * height : is("power") ? 512 : height;
    if (is("resolve") || is("resolve_to_window")) {
        GLuint colour;
        glCreateRenderbuffers(1, &colour);
        glNamedRenderbufferStorageMultisample(colour, 4, GL_RGBA8, width, height);
        glNamedFramebufferRenderbuffer(framebuffers[0], GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, colour);
        attach_depth(0, width, height, 4);
        attach(1, GL_TEXTURE_2D, width, height);
        return;
    }
    if (is("samples")) {
        attach(0, GL_TEXTURE_2D_MULTISAMPLE, width, height);
        attach_depth(0, width, height, 4);
        return;
    }
    attach(0, is("rectangle") ? GL_TEXTURE_RECTANGLE : GL_TEXTURE_2D, wide, high);
    attach(1, GL_TEXTURE_2D, is("bloom") ? width / 2 : width, is("bloom") ? height / 2 : height);
    attach(2, GL_TEXTURE_2D, is("bloom") ? width / 4 : width, is("bloom") ? height / 4 : height);
    if (is("depth")) {
        specify(3, GL_TEXTURE_2D, GL_DEPTH_COMPONENT24, width, height);
        glNamedFramebufferTexture(framebuffers[0], GL_DEPTH_ATTACHMENT, textures[3], 0);
    } else {
        attach_depth(0, wide, high, 0);
    }
    if (is("apart")) {
        const GLenum buffers[] = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1, GL_COLOR_ATTACHMENT2};
        glNamedFramebufferTexture(framebuffers[0], GL_COLOR_ATTACHMENT1, textures[1], 0);
        glNamedFramebufferTexture(framebuffers[0], GL_COLOR_ATTACHMENT2, textures[2], 0);
        glNamedFramebufferDrawBuffers(framebuffers[0], 3, buffers);
    }
}

static void draw_cube(app *a, GLuint program)
{
    matrix4 mvp = matrix_multiply(a->projection, a->modelview);
    glUseProgram(program);
    glUniformMatrix4fv(glGetUniformLocation(program, "MVP"), 1, GL_FALSE, mvp.m);
    mesh_bind(&cube);
    glDrawElements(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL);
}

static void fill(GLuint framebuffer, GLuint program, int width, int height)
{
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glViewport(0, 0, width, height);
    glDisable(GL_DEPTH_TEST);
    glUseProgram(program);
    glBindVertexArray(empty);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

static void fill_part(app *a, float across, float up)
{
    glUseProgram(last);
    glUniform2f(glGetUniformLocation(last, "part"), across, up);
    fill(0, last, a->window.width, a->window.height);
}

/* The program must read its own picture, whatever the dome shows. */
static void check_own_picture(app *a)
{
    if (app_is_first_read(a))
        return;
    image picture = image_read_framebuffer(a->window.width, a->window.height);
    app_check_cube_picture(a, &picture, "the own framebuffer");
    image_free(&picture);
}

static void draw(app *a)
{
    int width = a->window.width, height = a->window.height;
    int twice = is("twice") ? 2 : 1;
    if (is("respecified") && a->frame % 3 == 1)
        attach(0, GL_TEXTURE_2D, width, height);
    glViewport(0, 0, twice * width, twice * height);
    if (!is("copied_window") && !is("copied_flat"))
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffers[0]);
    if (is("attached_again"))
        glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, textures[0], 0);
    app_clear();
    if (is("copied_flat"))
        fill(0, last, width, height);
    else
        draw_cube(a, is("apart") ? scene_apart : scene);
    glBindTextureUnit(0, textures[0]);
    if (is("resolve")) {
        glBlitNamedFramebuffer(framebuffers[0], framebuffers[1], 0, 0, width, height, 0, 0, width, height,
                               GL_COLOR_BUFFER_BIT, GL_NEAREST);
        glBindTextureUnit(0, textures[1]);
        fill_part(a, 1.0f, 1.0f);
    } else if (is("resolve_to_window") || is("blit")) {
        glBlitNamedFramebuffer(framebuffers[0], 0, 0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT,
                               GL_NEAREST);
        glBindFramebuffer(GL_FRAMEBUFFER, 0);
    } else if (is("bloom")) {
        fill(framebuffers[1], last, width / 2, height / 2);
        glBindTextureUnit(0, textures[1]);
        fill(framebuffers[2], last, width / 4, height / 4);
        glBindTextureUnit(0, textures[0]);
        glBindTextureUnit(1, textures[2]);
        fill(0, half_each, width, height);
    } else if (is("mipmap")) {
        glGenerateTextureMipmap(textures[0]);
        fill(0, levels, width, height);
    } else if (is("depth")) {
        glBindTextureUnit(1, textures[3]);
        fill(0, depths, width, height);
    } else if (is("apart")) {
        glBindTextureUnit(1, textures[1]);
        glBindTextureUnit(2, textures[2]);
        fill(0, apart, width, height);
    } else if (is("light")) {
        glBindFramebuffer(GL_FRAMEBUFFER, framebuffers[1]);
        glClear(GL_COLOR_BUFFER_BIT);
        draw_cube(a, light);
        glBindTextureUnit(0, textures[1]);
        fill_part(a, 1.0f, 1.0f);
    } else if (is("samples")) {
        fill(0, samples, width, height);
    } else if (is("rectangle")) {
        fill(0, rectangle, width, height);
    } else if (is("power")) {
        fill_part(a, (float)width / 1024.0f, (float)height / 512.0f);
    } else if (is("copied") || is("copied_window") || is("copied_flat")) {
        glBindTextureUnit(0, textures[1]);
        glCopyTextureSubImage2D(textures[1], 0, 0, 0, 0, 0, width, height);
        fill(framebuffers[2], changes, width, height);
        glBindTextureUnit(0, textures[2]);
        fill(0, undoes, width, height);
    } else if (is("attached_again")) {
        /* One framebuffer for all passes. */
        glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, textures[1], 0);
        fill(framebuffers[0], changes, width, height);
        glBindTextureUnit(0, textures[1]);
        fill(0, undoes, width, height);
    } else {
        if (is("read"))
            check_own_picture(a);
        fill_part(a, 1.0f, 1.0f);
    }
}

int main(int argc, char **argv)
{
    static const app_program self = {"passes", API_GL_CORE, 4, 5, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
