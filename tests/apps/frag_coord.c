/*
 * A cube around the eye. Its fragments read their place in the window. `--mode` is the name of a
 * form and of its effect:
 *
 *   clip-FORM      is the direction test. Fragments outside of the window are discarded.
 *   gradient-FORM  shows the place in the window, from 0 to 1, in red and green.
 *
 * Forms: core, old (GLSL 1.20), upper (rows from above, pixel centres at integers), pipeline
 * (separable programs), part (the viewport is the upper right quarter of the window), off (drawn to
 * a texture that a triangle shows).
 */
#include "common/app.h"
#include "common/mesh.h"
#include "common/program.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CORE "#version 410 core\n"
#define VERTEX \
    CORE "layout(location = 0) in vec3 position;\nlayout(location = 1) in vec3 colour;\n" \
         "layout(location = 0) out vec3 shade;\nuniform mat4 MVP;\nout gl_PerVertex { vec4 gl_Position; };\n" \
         "void main() { shade = colour; gl_Position = MVP * vec4(position, 1.0); }\n"
/* The shader discards fragments beside the window, like a scissor. */
#define MAIN(shade, at, result) \
    "void main() {\n" \
    "    vec2 at = (" at ") / size;\n" \
    "    if (any(lessThan(at, low)) || any(greaterThan(at, vec2(1.0)))) discard;\n" \
    "    " result " = gradient > 0.5 ? vec4(at, 0.0, 1.0) : vec4(" shade ", 1.0);\n" \
    "}\n"
#define UNIFORMS "uniform vec2 size, low;\nuniform float gradient;\n"
#define FRAGMENT "layout(location = 0) in vec3 shade;\nout vec4 result;\n" UNIFORMS

static const char fragment[] = CORE FRAGMENT MAIN("shade", "gl_FragCoord.xy", "result");
static const char upper[] =
    CORE "layout(origin_upper_left, pixel_center_integer) in vec4 gl_FragCoord;\n" FRAGMENT
        MAIN("shade", "vec2(gl_FragCoord.x + 0.5, size.y - gl_FragCoord.y - 0.5)", "result");
static const char old_vertex[] =
    "#version 120\nattribute vec3 position, colour;\nvarying vec3 shade;\nuniform mat4 MVP;\n"
    "void main() { shade = colour; gl_Position = MVP * vec4(position, 1.0); }\n";
static const char old_fragment[] =
    "#version 120\n#define PLACE gl_FragCoord\nvarying vec3 shade;\n" UNIFORMS MAIN("shade", "PLACE.xy", "gl_FragColor");
static const char screen_vertex[] =
    CORE "out vec2 at;\nvoid main() { at = vec2(gl_VertexID & 1, gl_VertexID >> 1); gl_Position = vec4(4.0 * at - 1.0, 0.0, 1.0); at *= 2.0; }\n";
static const char screen_fragment[] =
    CORE "in vec2 at;\nuniform sampler2D picture;\nout vec4 result;\nvoid main() { result = texture(picture, at); }\n";

static mesh cube;
static GLuint programs[2], screen, pipeline, framebuffer, texture, renderbuffer, empty;
static bool gradient, part;

static GLuint build(const char *vertex, const char *text)
{
    const shader_source stages[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, text}};
    return program_build(stages, 2);
}

static GLuint separable(GLenum stage, const char *text)
{
    GLint linked = 0;
    const GLuint program = glCreateShaderProgramv(stage, 1, &text);
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    if (!linked) {
        fprintf(stderr, "a separable program does not link\n");
        exit(1);
    }
    return program;
}

static void make_framebuffer(const app *a)
{
    glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glGenTextures(1, &texture);
    glBindTexture(GL_TEXTURE_2D, texture);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, a->window.width, a->window.height, 0, GL_RGBA, GL_UNSIGNED_BYTE, NULL);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
    glGenRenderbuffers(1, &renderbuffer);
    glBindRenderbuffer(GL_RENDERBUFFER, renderbuffer);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, a->window.width, a->window.height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, renderbuffer);
    glGenVertexArrays(1, &empty);
    screen = build(screen_vertex, screen_fragment);
}

static void setup(app *a)
{
    const char *form = a->mode == NULL ? NULL : strchr(a->mode, '-');
    if (form == NULL) {
        fprintf(stderr, "--mode is missing\n");
        exit(2);
    }
    gradient = strncmp(a->mode, "gradient", 8) == 0;
    form++;
    part = strcmp(form, "part") == 0;
    cube = mesh_cube();
    if (strcmp(form, "pipeline") == 0) {
        programs[0] = separable(GL_VERTEX_SHADER, VERTEX);
        programs[1] = separable(GL_FRAGMENT_SHADER, fragment);
        glGenProgramPipelines(1, &pipeline);
        glUseProgramStages(pipeline, GL_VERTEX_SHADER_BIT, programs[0]);
        glUseProgramStages(pipeline, GL_FRAGMENT_SHADER_BIT, programs[1]);
        return;
    }
    if (strcmp(form, "old") == 0)
        programs[0] = build(old_vertex, old_fragment);
    else
        programs[0] = build(VERTEX, strcmp(form, "upper") == 0 ? upper : fragment);
    programs[1] = programs[0];
    if (strcmp(form, "off") == 0)
        make_framebuffer(a);
}

static void draw(app *a)
{
    const int width = a->window.width, height = a->window.height;
    const matrix4 m = matrix_multiply(a->projection, a->modelview);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    app_clear();
    glUseProgram(pipeline == 0 ? programs[0] : 0);
    if (pipeline != 0)
        glBindProgramPipeline(pipeline);
    if (part)
        glViewport(width / 2, height / 2, width / 2, height / 2);
    glProgramUniformMatrix4fv(programs[0], glGetUniformLocation(programs[0], "MVP"), 1, GL_FALSE, m.m);
    const GLuint fragments = programs[1];
    const float low = part ? 0.5f : 0.0f;
    glProgramUniform2f(fragments, glGetUniformLocation(fragments, "size"), (float)width, (float)height);
    glProgramUniform2f(fragments, glGetUniformLocation(fragments, "low"), low, low);
    glProgramUniform1f(fragments, glGetUniformLocation(fragments, "gradient"), gradient ? 1.0f : 0.0f);
    mesh_bind(&cube);
    glDrawElements(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL);
    if (framebuffer != 0) {
        glBindFramebuffer(GL_FRAMEBUFFER, 0);
        glDisable(GL_DEPTH_TEST);
        glUseProgram(screen);
        glBindVertexArray(empty);
        glDrawArrays(GL_TRIANGLES, 0, 3);
        glEnable(GL_DEPTH_TEST);
    }
}

int main(int argc, char **argv)
{
    static const app_program self = {"frag_coord", API_GL_COMPATIBILITY, 4, 5, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
