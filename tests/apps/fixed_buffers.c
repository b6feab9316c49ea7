/*
 * Small objects straight ahead and behind, drawn from buffers by the fixed-function pipeline, and
 * by a shader that uses its matrices.
 */
#include "common/fixed.h"
#include "common/program.h"

#include <stddef.h>

static const char vertex[] = "#version 120\nvarying vec3 shade;\nvoid main() { shade = gl_Color.rgb; gl_Position = ftransform(); }\n";
static const char fragment[] = "#version 120\nvarying vec3 shade;\nvoid main() { gl_FragColor = vec4(shade, 1.0); }\n";

static const float corners[][3] = {{-0.8f, -0.3f, -5}, {-0.2f, -0.3f, -5}, {-0.5f, 0.3f, -5},
                                   {0.2f, -0.3f, -5},  {0.8f, -0.3f, -5},  {0.5f, 0.3f, -5}};
static const unsigned short indices[] = {3, 4, 5};
static GLuint program;

static void setup(app *a)
{
    (void)a;
    const shader_source stages[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, fragment}};
    GLuint buffers[2];
    program = program_build(stages, 2);
    glGenBuffers(2, buffers);
    glBindBuffer(GL_ARRAY_BUFFER, buffers[0]);
    glBufferData(GL_ARRAY_BUFFER, sizeof corners, corners, GL_STATIC_DRAW);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[1]);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, sizeof indices, indices, GL_STATIC_DRAW);
    glVertexPointer(3, GL_FLOAT, 0, NULL);
    glEnableClientState(GL_VERTEX_ARRAY);
}

static void draw(app *a)
{
    app_clear();
    glMatrixMode(GL_PROJECTION);
    glLoadMatrixf(a->projection.m);
    glMatrixMode(GL_MODELVIEW);
    for (int pass = 0; pass < 4; pass++) {
        glUseProgram(pass & 1 ? program : 0);
        glLoadIdentity();
        /* Draws once ahead, and once behind the eye, where no view of the rig fisheye shows it. */
        glTranslatef(0.0f, pass & 1 ? 1.0f : -1.0f, pass & 2 ? 10.0f : 0.0f);
        glColor3f(1.0f, 0.5f, 0.0f);
        glDrawArrays(GL_TRIANGLES, 0, 3);
        glColor3f(0.0f, 0.5f, 1.0f);
        glDrawElements(GL_TRIANGLES, 3, GL_UNSIGNED_SHORT, NULL);
    }
    glUseProgram(0);
}

int main(int argc, char **argv)
{
    static const app_program self = {"fixed_buffers", API_GL_COMPATIBILITY, 0, 0, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
