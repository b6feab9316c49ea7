/*
 * OpenGL 4.5: the window's framebuffer by its name 0, viewports and scissors by index, and all
 * queries about a program's uniforms. All answers must be those of the program's own objects.
 */
#include "common/app.h"
#include "common/mesh.h"
#include "common/program.h"

#include <stddef.h>
#include <string.h>

static const char vertex[] =
    "#version 450 core\n"
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec3 colour;\n"
    "layout(std140, binding = 1) uniform Camera { mat4 P; mat4 MV; };\n"
    "uniform float zoom;\n"
    "out vec3 shade;\n"
    "void main() { shade = colour; gl_Position = P * (MV * vec4(zoom * position, 1.0)); }\n";
static const char fragment[] =
    "#version 450 core\nin vec3 shade;\nuniform float gain;\nout vec4 result;\n"
    "void main() { result = vec4(gain * shade, 1.0); }\n";

enum { UNIFORMS = 4 };
static mesh cube;
static GLuint program, own, texture, depth, block;

static void setup(app *a)
{
    const shader_source stages[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, fragment}};
    program = program_build(stages, 2);
    glProgramUniform1f(program, glGetUniformLocation(program, "zoom"), 1.0f);
    glProgramUniform1f(program, glGetUniformLocation(program, "gain"), 1.0f);
    cube = mesh_cube();
    glCreateBuffers(1, &block);
    matrix4 matrices[2] = {a->projection, a->modelview};
    glNamedBufferData(block, sizeof matrices, matrices, GL_STATIC_DRAW);
    glBindBufferBase(GL_UNIFORM_BUFFER, 1, block);
    glCreateFramebuffers(1, &own);
    glCreateTextures(GL_TEXTURE_2D, 1, &texture);
    glTextureStorage2D(texture, 1, GL_RGBA8, a->window.width, a->window.height);
    glCreateRenderbuffers(1, &depth);
    glNamedRenderbufferStorage(depth, GL_DEPTH_COMPONENT24, a->window.width, a->window.height);
    glNamedFramebufferTexture(own, GL_COLOR_ATTACHMENT0, texture, 0);
    glNamedFramebufferRenderbuffer(own, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth);
}

static void check_reflection(app *a)
{
    GLint count = 0, resources = 0;
    glGetProgramiv(program, GL_ACTIVE_UNIFORMS, &count);
    glGetProgramInterfaceiv(program, GL_UNIFORM, GL_ACTIVE_RESOURCES, &resources);
    app_check(a, count == UNIFORMS && resources == UNIFORMS, "%d and %d uniforms", count, resources);
    for (GLuint i = 0; i < UNIFORMS; i++) {
        char name[64], again[64];
        GLint size;
        GLenum kind;
        glGetActiveUniform(program, i, sizeof name, NULL, &size, &kind, name);
        glGetProgramResourceName(program, GL_UNIFORM, i, sizeof again, NULL, again);
        app_check(a, strncmp(name, "cupola", 6) != 0 && strcmp(name, again) == 0, "uniform %u is %s and %s", i, name,
                  again);
        const char *names[] = {name};
        GLuint index = 99;
        glGetUniformIndices(program, 1, names, &index);
        GLuint resource = glGetProgramResourceIndex(program, GL_UNIFORM, name);
        app_check(a, index == i && resource == i, "%s has index %u and %u instead of %u", name, index, resource, i);
        const GLenum what[] = {GL_LOCATION};
        GLint location = -9;
        glGetProgramResourceiv(program, GL_UNIFORM, i, 1, what, 1, NULL, &location);
        app_check(a, location == glGetUniformLocation(program, name), "%s is at %d", name, location);
    }
    GLint members[2] = {-1, -1};
    glGetActiveUniformBlockiv(program, 0, GL_UNIFORM_BLOCK_ACTIVE_UNIFORM_INDICES, members);
    for (int i = 0; i < 2; i++) {
        char name[64] = "";
        glGetActiveUniformName(program, (GLuint)members[i], sizeof name, NULL, name);
        app_check(a, strcmp(name, "P") == 0 || strcmp(name, "MV") == 0, "the block holds %s", name);
    }
    app_check_error(a, "after asking about uniforms");
}

static void check_window(app *a)
{
    GLfloat viewport[4];
    GLint type = 0, bound = -1, scissor[4];
    glGetFloati_v(GL_VIEWPORT, 0, viewport);
    app_check(a, viewport[2] == (float)a->window.width && viewport[0] == 0.0f, "the viewport is %g wide",
              (double)viewport[2]);
    glGetIntegeri_v(GL_SCISSOR_BOX, 0, scissor);
    app_check(a, scissor[0] == 5 && scissor[3] == 40, "the scissor is at %d", scissor[0]);
    app_check(a, !glIsEnabledi(GL_SCISSOR_TEST, 0), "the scissor test is on");
    app_check(a, glCheckNamedFramebufferStatus(0, GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE, "the window is no target");
    glGetNamedFramebufferAttachmentParameteriv(0, GL_BACK_LEFT, GL_FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE, &type);
    app_check(a, type == GL_FRAMEBUFFER_DEFAULT, "the window's buffer is of type 0x%x", (unsigned)type);
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &bound);
    app_check(a, bound == 0, "framebuffer %d is bound", bound);
    app_check_error(a, "after asking about the window");
}

static void draw(app *a)
{
    const float grey[] = {0.25f, 0.25f, 0.25f, 1.0f}, viewport[] = {0, 0, (float)a->window.width, (float)a->window.height};
    const int scissor[] = {5, 6, 30, 40};
    glEnable(GL_DEPTH_TEST);
    glViewportArrayv(0, 1, viewport);
    glScissorArrayv(0, 1, scissor);
    glDisablei(GL_SCISSOR_TEST, 0);
    glUseProgram(program);
    mesh_bind(&cube);

    /* The scene in a framebuffer of the program, which is cleared while the window is bound. */
    glClearNamedFramebufferfv(own, GL_COLOR, 0, grey);
    glClearNamedFramebufferfi(own, GL_DEPTH_STENCIL, 0, 1.0f, 0);
    glBindFramebuffer(GL_FRAMEBUFFER, own);
    glDrawElements(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL);
    image inside = image_read_framebuffer(a->window.width, a->window.height);
    app_check_cube_picture(a, &inside, "the own framebuffer");
    image_free(&inside);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);

    /* In the window, with a corner copied from the program's framebuffer. */
    glNamedFramebufferDrawBuffer(0, GL_BACK);
    glNamedFramebufferReadBuffer(0, GL_BACK);
    glClearNamedFramebufferfv(0, GL_COLOR, 0, grey);
    glClearNamedFramebufferfi(0, GL_DEPTH_STENCIL, 0, 1.0f, 0);
    glDrawElements(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL);
    glBlitNamedFramebuffer(own, 0, 0, 0, 60, 50, 0, 0, 60, 50, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    check_reflection(a);
    check_window(a);
    if (!app_is_first_read(a)) {
        image picture = image_read_framebuffer(a->window.width, a->window.height);
        app_check_cube_picture(a, &picture, "the window");
        image_free(&picture);
    }
}

int main(int argc, char **argv)
{
    static const app_program self = {"direct_state", API_GL_CORE, 4, 5, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
