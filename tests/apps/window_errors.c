/* Errors of a core context for wrong commands on its window, and its answers about programs. */
#include "common/app.h"
#include "common/program.h"

#include <string.h>

static GLuint program;

static void setup(app *a)
{
    (void)a;
    static const shader_source stages[] = {
        {GL_VERTEX_SHADER, "#version 330\nuniform mat4 m;\nin vec3 position;\n"
                           "void main() { gl_Position = m * vec4(position, 1.0); }\n"},
        {GL_FRAGMENT_SHADER, "#version 330\nout vec4 shown;\nvoid main() { shown = vec4(1.0); }\n"},
    };
    program = program_build(stages, 2);
}

static void expect(app *a, GLenum expected, const char *what)
{
    GLenum error = glGetError();
    app_check(a, error == expected, "%s: error 0x%x instead of 0x%x", what, error, expected);
}

static void draw(app *a)
{
    app_clear();
    static const GLenum attachment[] = {GL_COLOR_ATTACHMENT0}, twice[] = {GL_BACK_LEFT, GL_BACK_LEFT};
    static const GLenum several[] = {GL_FRONT_AND_BACK}, back[] = {GL_BACK_LEFT}, unknown[] = {7};
    glDrawBuffers(1, attachment);
    expect(a, GL_INVALID_OPERATION, "glDrawBuffers of an attachment");
    glDrawBuffers(2, twice);
    expect(a, GL_INVALID_OPERATION, "glDrawBuffers of one buffer twice");
    glDrawBuffers(1, several);
    expect(a, GL_INVALID_ENUM, "glDrawBuffers of several buffers by one name");
    GLenum many[65];
    GLint most = 0;
    for (int i = 0; i < 65; i++)
        many[i] = GL_BACK_LEFT;
    glGetIntegerv(GL_MAX_DRAW_BUFFERS, &most);
    glDrawBuffers(most + 1, many);
    expect(a, GL_INVALID_VALUE, "glDrawBuffers of too many buffers");
    glDrawBuffers(1, back);
    expect(a, GL_NO_ERROR, "glDrawBuffers");
    glInvalidateFramebuffer(GL_FRAMEBUFFER, 1, unknown);
    expect(a, GL_INVALID_ENUM, "glInvalidateFramebuffer of an unknown buffer");
    glInvalidateFramebuffer(GL_FRAMEBUFFER, -1, unknown);
    expect(a, GL_INVALID_VALUE, "glInvalidateFramebuffer of -1 buffers");
    glFramebufferParameteri(GL_FRAMEBUFFER, GL_FRAMEBUFFER_DEFAULT_WIDTH, 8);
    expect(a, GL_INVALID_OPERATION, "glFramebufferParameteri of the window");
    GLint doubled = -1;
    glGetFramebufferParameteriv(GL_FRAMEBUFFER, GL_DOUBLEBUFFER, &doubled);
    expect(a, GL_NO_ERROR, "glGetFramebufferParameteriv");
    app_check(a, doubled == 1, "GL_DOUBLEBUFFER of the framebuffer is %d", doubled);
    GLfloat before[4], after[4];
    static const GLfloat wrong[] = {0, 0, -1, 5};
    glGetFloati_v(GL_VIEWPORT, 0, before);
    glViewportIndexedf(0, 1, 2, -3, 4);
    expect(a, GL_INVALID_VALUE, "glViewportIndexedf of a negative width");
    glViewportIndexedfv(0, wrong);
    expect(a, GL_INVALID_VALUE, "glViewportIndexedfv of a negative width");
    glViewportArrayv(0, 1, wrong);
    expect(a, GL_INVALID_VALUE, "glViewportArrayv of a negative width");
    static const GLint box[] = {0, 0, 5, -1};
    glScissorIndexedv(0, box);
    expect(a, GL_INVALID_VALUE, "glScissorIndexedv of a negative height");
    glScissorArrayv(0, 1, box);
    expect(a, GL_INVALID_VALUE, "glScissorArrayv of a negative height");
    glGetFloati_v(GL_VIEWPORT, 0, after);
    app_check(a, memcmp(before, after, sizeof before) == 0, "a wrong viewport is set");

    GLint number = 0, formats[4] = {77, 77, 77, 77};
    glGetIntegerv(GL_NUM_PROGRAM_BINARY_FORMATS, &number);
    glGetIntegerv(GL_PROGRAM_BINARY_FORMATS, formats);
    app_check(a, number < 4 && formats[number] == 77, "there are more formats of binaries than %d", number);
    GLint length = -1;
    glGetProgramiv(program, GL_ACTIVE_UNIFORM_MAX_LENGTH, &length);
    app_check(a, length == 2, "the longest name of a uniform has %d characters", length);
    glGetProgramInterfaceiv(program, GL_UNIFORM, GL_MAX_NAME_LENGTH, &length);
    app_check(a, length == 2, "the longest name of a resource has %d characters", length);
    char name[8] = "unset";
    glGetProgramResourceName(program, GL_UNIFORM, GL_INVALID_INDEX, sizeof name, NULL, name);
    expect(a, GL_INVALID_VALUE, "glGetProgramResourceName of no index");
}

int main(int argc, char **argv)
{
    static const app_program self = {"window_errors", API_GL_CORE, 4, 5, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
