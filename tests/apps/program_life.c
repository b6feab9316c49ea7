/*
 * State of a program in use: it stays after its deletion, keeps its subroutines, and the source
 * that was compiled is linked.
 */
#include "common/app.h"
#include "common/probe.h"

#include <string.h>

static GLuint deleted, chosen, recompiled;

static GLuint shader(app *a, GLenum stage, const char *source)
{
    GLuint name = glCreateShader(stage);
    glShaderSource(name, 1, &source, NULL);
    glCompileShader(name);
    GLint good = 0;
    glGetShaderiv(name, GL_COMPILE_STATUS, &good);
    app_check(a, good, "a shader does not compile");
    return name;
}

static GLuint link_program(app *a, GLuint vertex, GLuint fragment)
{
    GLuint name = glCreateProgram();
    glAttachShader(name, vertex);
    glAttachShader(name, fragment);
    glBindAttribLocation(name, 0, "position");
    glLinkProgram(name);
    GLint good = 0;
    glGetProgramiv(name, GL_LINK_STATUS, &good);
    app_check(a, good, "a program does not link");
    return name;
}

static const char *const vertex_text =
    "#version 400\nuniform mat4 matrix;\nin vec2 position;\nvoid main() { gl_Position = matrix * vec4(position, 0.0, 1.0); }\n";
static const char *const vertex_elsewhere =
    "#version 400\nin vec2 position;\nvoid main() { gl_Position = vec4(9.0); }\n";
static const char *const green = "#version 400\nout vec4 colour;\nvoid main() { colour = vec4(0.0, 1.0, 0.0, 1.0); }\n";
static const char *const subroutines =
    "#version 400\nout vec4 colour;\nsubroutine vec4 kind();\nsubroutine uniform kind paint;\n"
    "subroutine(kind) vec4 red() { return vec4(1.0, 0.0, 0.0, 1.0); }\n"
    "subroutine(kind) vec4 blue() { return vec4(0.0, 0.0, 1.0, 1.0); }\n"
    "void main() { colour = paint(); }\n";

static void set_matrix(GLuint name)
{
    static const float identity[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    glUseProgram(name);
    glUniformMatrix4fv(glGetUniformLocation(name, "matrix"), 1, GL_FALSE, identity);
}

static void setup(app *a)
{
    GLuint array, buffer;
    static const float corners[] = {-1, -1, 1, -1, -1, 1, 1, 1};
    glGenVertexArrays(1, &array);
    glBindVertexArray(array);
    glGenBuffers(1, &buffer);
    glBindBuffer(GL_ARRAY_BUFFER, buffer);
    glBufferData(GL_ARRAY_BUFFER, sizeof corners, corners, GL_STATIC_DRAW);
    glVertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, 0, NULL);
    glEnableVertexAttribArray(0);

    GLuint vertex = shader(a, GL_VERTEX_SHADER, vertex_text);
    chosen = link_program(a, vertex, shader(a, GL_FRAGMENT_SHADER, subroutines));
    set_matrix(chosen);

    /* The compiled source is linked, not a source that was set later. */
    GLuint changed = shader(a, GL_VERTEX_SHADER, vertex_text);
    glShaderSource(changed, 1, &vertex_elsewhere, NULL);
    recompiled = link_program(a, changed, shader(a, GL_FRAGMENT_SHADER, green));
    set_matrix(recompiled);
    char text[256];
    GLsizei length = 0;
    glGetShaderSource(changed, sizeof text, &length, text);
    app_check(a, strcmp(text, vertex_elsewhere) == 0, "the source of a shader is not the last one");

    deleted = link_program(a, vertex, shader(a, GL_FRAGMENT_SHADER, green));
    set_matrix(deleted);
}

static void draw(app *a)
{
    GLint status = -1;
    glClearColor(1.0f, 0.0f, 1.0f, 1.0f);
    if (a->frame < 2) {
        /* The program is in use, so it is only marked for deletion. */
        if (a->frame == 0)
            glDeleteProgram(deleted);
        glGetProgramiv(deleted, GL_DELETE_STATUS, &status);
        app_check(a, status == 1 && glIsProgram(deleted), "a deleted program in use has the status %d", status);
        glClear(GL_COLOR_BUFFER_BIT);
        glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
        probe(a, 30, 30, 0, 1, 0, "a deleted program");
    } else if (a->frame == 2) {
        glUseProgram(chosen);
        app_check(a, !glIsProgram(deleted), "a deleted program still exists");
        GLuint blue = glGetSubroutineIndex(chosen, GL_FRAGMENT_SHADER, "blue");
        glUniformSubroutinesuiv(GL_FRAGMENT_SHADER, 1, &blue);
    }
    if (a->frame == 2 || a->frame == 3) {
        glClear(GL_COLOR_BUFFER_BIT);
        glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
        probe(a, 30, 30, 0, 0, 1, "subroutines");
    }
    if (a->frame == 4) {
        glUseProgram(recompiled);
        glClear(GL_COLOR_BUFFER_BIT);
        glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
        probe(a, 30, 30, 0, 1, 0, "a source that was not compiled");
    }
}

int main(int argc, char **argv)
{
    static const app_program self = {"program_life", API_GL_CORE, 4, 0, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
