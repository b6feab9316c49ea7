/*
 * The background of backdrop.c in OpenGL ES 3: a triangle without depth, whose colours depend on the
 * place in the picture, and the small cube far ahead. Off screen, or with --mode window in the window
 * itself. --mode text: a small triangle is drawn to the window before the cube, instead of the
 * background.
 */
#include "common/app.h"
#include "common/mesh.h"
#include "common/program.h"

#include <string.h>

#define HEAD "#version 300 es\nprecision highp float;\n"

static const char vertex[] = HEAD "layout(location = 0) in vec3 position;\n"
                                  "uniform mat4 MVP;\n"
                                  "out vec3 shade;\n"
                                  "void main() { shade = 0.5 + 0.5 * position; gl_Position = MVP * vec4(position, 1.0); }\n";
static const char screen_vertex[] = HEAD "uniform float size;\n"
                                         "out vec3 shade;\n"
                                         "void main() {\n"
                                         "    vec2 place = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0;\n"
                                         "    shade = vec3(place, 0.25);\n"
                                         "    gl_Position = vec4((place * 2.0 - 1.0) * size, 0.0, 1.0);\n"
                                         "}\n";
static const char fragment[] = HEAD "in vec3 shade;\n"
                                    "out vec4 result;\n"
                                    "void main() { result = vec4(shade, 1.0); }\n";
static const char show_fragment[] = HEAD "in vec3 shade;\n"
                                         "uniform sampler2D picture;\n"
                                         "out vec4 result;\n"
                                         "void main() { result = vec4(texture(picture, shade.xy).rgb, 1.0); }\n";

static mesh cube;
static GLuint scene, screen, show, framebuffer, colour, depth, empty;
static bool direct, text;

static void setup(app *a)
{
    text = a->mode != NULL && strcmp(a->mode, "text") == 0;
    direct = text || (a->mode != NULL && strcmp(a->mode, "window") == 0);
    const shader_source of_scene[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, fragment}};
    const shader_source of_screen[] = {{GL_VERTEX_SHADER, screen_vertex}, {GL_FRAGMENT_SHADER, fragment}};
    const shader_source of_show[] = {{GL_VERTEX_SHADER, screen_vertex}, {GL_FRAGMENT_SHADER, show_fragment}};
    scene = program_build(of_scene, 2);
    screen = program_build(of_screen, 2);
    show = program_build(of_show, 2);
    cube = mesh_cube();
    glGenVertexArrays(1, &empty);
    glGenFramebuffers(1, &framebuffer);
    glGenRenderbuffers(1, &depth);
    glGenTextures(1, &colour);
    const int width = a->window.width, height = a->window.height;
    glBindTexture(GL_TEXTURE_2D, colour);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, NULL);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glBindRenderbuffer(GL_RENDERBUFFER, depth);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, width, height);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, colour, 0);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth);
}

/* Draws the triangle over the whole picture, or a part of that size in the middle. */
static void fill(GLuint program, float size)
{
    glDisable(GL_DEPTH_TEST);
    glUseProgram(program);
    glUniform1f(glGetUniformLocation(program, "size"), size);
    glBindVertexArray(empty);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glEnable(GL_DEPTH_TEST);
}

static void draw(app *a)
{
    glBindFramebuffer(GL_FRAMEBUFFER, direct ? 0 : framebuffer);
    app_clear();
    fill(screen, text ? 0.4f : 1.0f);
    glUseProgram(scene);
    const matrix4 all = matrix_multiply(a->projection, matrix_translate(0.0, 0.0, -10.0));
    glUniformMatrix4fv(glGetUniformLocation(scene, "MVP"), 1, GL_FALSE, all.m);
    mesh_bind(&cube);
    glDrawElements(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL);
    if (!direct) {
        glBindFramebuffer(GL_FRAMEBUFFER, 0);
        fill(show, 1.0f);
    }
    app_check_error(a, "a background");
}

int main(int argc, char **argv)
{
    static const app_program self = {"gles3_backdrop", API_GLES, 3, 0, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
