/*
 * The cube drawn with a program pipeline: a separable program for each stage. Matrices are set
 * while no program is in use.
 */
#include "common/app.h"
#include "common/mesh.h"

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

static const char vertex[] =
    "#version 410 core\n"
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec3 colour;\n"
    "uniform mat4 matrices[2];\n"
    "layout(location = 0) out vec3 shade;\n"
    "out gl_PerVertex { vec4 gl_Position; };\n"
    "void main() { shade = colour; gl_Position = matrices[1] * (matrices[0] * vec4(position, 1.0)); }\n";
static const char fragment[] =
    "#version 410 core\nlayout(location = 0) in vec3 shade;\nout vec4 result;\nvoid main() { result = vec4(shade, 1.0); }\n";

static mesh cube;
static GLuint stages[2], pipeline;

static GLuint build(GLenum stage, const char *source)
{
    GLint linked = 0;
    GLuint program = glCreateShaderProgramv(stage, 1, &source);
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    if (!linked) {
        fprintf(stderr, "a separable program does not link\n");
        exit(1);
    }
    return program;
}

static void setup(app *a)
{
    (void)a;
    cube = mesh_cube();
    stages[0] = build(GL_VERTEX_SHADER, vertex);
    stages[1] = build(GL_FRAGMENT_SHADER, fragment);
    glGenProgramPipelines(1, &pipeline);
    glUseProgramStages(pipeline, GL_VERTEX_SHADER_BIT, stages[0]);
    glUseProgramStages(pipeline, GL_FRAGMENT_SHADER_BIT, stages[1]);
    glActiveShaderProgram(pipeline, stages[0]);
}

static void draw(app *a)
{
    app_clear();
    glUseProgram(0);
    glBindProgramPipeline(pipeline);
    mesh_bind(&cube);
    matrix4 matrices[2] = {a->modelview, a->projection};
    glUniformMatrix4fv(glGetUniformLocation(stages[0], "matrices"), 2, GL_FALSE, matrices[0].m);
    glDrawElements(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL);
    if (!app_is_first_read(a)) {
        image picture = image_read_framebuffer(a->window.width, a->window.height);
        app_check_cube_picture(a, &picture, "the window");
        image_free(&picture);
    }
}

int main(int argc, char **argv)
{
    static const app_program self = {"separable", API_GL_CORE, 4, 1, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
