/*
 * Direction test: the scene is drawn to a part of an image of the window's size, as programs with a
 * dynamic resolution do. A triangle (or with --mode blit, a blit) shows this part in the window.
 * --mode most: the part has 0.8 of the size, else 0.4. --mode changing: it is larger in every second
 * frame. --mode quarters: the cube is drawn to four parts, and the whole image is shown.
 */
#include "common/app.h"
#include "common/mesh.h"
#include "common/program.h"
#include "common/shader.h"

#include <string.h>

static const char vertex[] = "#version 330 core\n"
                             "layout(location = 0) in vec3 position;\n"
                             "layout(location = 1) in vec3 colour;\n"
                             "uniform mat4 MVP;\n"
                             "out vec3 shade;\n"
                             "void main() { shade = colour; gl_Position = MVP * vec4(position, 1.0); }\n";
static const char show_vertex[] = "#version 330 core\n"
                                  "uniform vec2 part;\n"
                                  "out vec2 place;\n"
                                  "void main() {\n"
                                  "    vec2 corner = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0;\n"
                                  "    place = corner * part;\n"
                                  "    gl_Position = vec4(corner * 2.0 - 1.0, 0.0, 1.0);\n"
                                  "}\n";
static const char show_fragment[] = "#version 330 core\n"
                                    "in vec2 place;\n"
                                    "uniform sampler2D picture;\n"
                                    "uniform vec2 part;\n"
                                    "out vec4 result;\n"
                                    "void main() { result = vec4(texture(picture, min(place, part - 0.5 / vec2(textureSize(picture, 0)))).rgb, 1.0); }\n";

static mesh cube;
static GLuint scene, show, framebuffer, colour, depth, empty;
static int frame;

static bool is(const app *a, const char *mode)
{
    return a->mode != NULL && strcmp(a->mode, mode) == 0;
}

static void setup(app *a)
{
    const shader_source of_scene[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, shader_shade}};
    const shader_source of_show[] = {{GL_VERTEX_SHADER, show_vertex}, {GL_FRAGMENT_SHADER, show_fragment}};
    scene = program_build(of_scene, 2);
    show = program_build(of_show, 2);
    cube = mesh_cube();
    const int width = a->window.width, height = a->window.height;
    glGenVertexArrays(1, &empty);
    glGenFramebuffers(1, &framebuffer);
    glGenRenderbuffers(1, &depth);
    glGenTextures(1, &colour);
    glBindTexture(GL_TEXTURE_2D, colour);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, NULL);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glBindRenderbuffer(GL_RENDERBUFFER, depth);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, width, height);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, colour, 0);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth);
}

static void draw_cube(const app *a, int x, int y, int width, int height)
{
    glViewport(x, y, width, height);
    glUseProgram(scene);
    const matrix4 all = matrix_multiply(a->projection, a->modelview);
    glUniformMatrix4fv(glGetUniformLocation(scene, "MVP"), 1, GL_FALSE, all.m);
    mesh_bind(&cube);
    glDrawElements(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL);
}

static void draw(app *a)
{
    const int width = a->window.width, height = a->window.height;
    const bool quarters = is(a, "quarters");
    const double size = is(a, "most") ? 0.8 : is(a, "changing") && frame % 2 == 1 ? 0.5 : 0.4;
    const int across = (int)(width * size), up = (int)(height * size);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    app_clear();
    for (int i = 0; i < (quarters ? 4 : 0); i++)
        draw_cube(a, i % 2 * width / 2, i / 2 * height / 2, width / 2, height / 2);
    if (!quarters)
        draw_cube(a, 0, 0, across, up);
    glViewport(0, 0, width, height);
    if (is(a, "blit")) {
        glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
        glBlitFramebuffer(0, 0, across, up, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_LINEAR);
    } else {
        glBindFramebuffer(GL_FRAMEBUFFER, 0);
        glDisable(GL_DEPTH_TEST);
        glUseProgram(show);
        const float part[2] = {quarters ? 1.0f : (float)across / (float)width, quarters ? 1.0f : (float)up / (float)height};
        glUniform2fv(glGetUniformLocation(show, "part"), 1, part);
        glBindVertexArray(empty);
        glDrawArrays(GL_TRIANGLES, 0, 3);
        glEnable(GL_DEPTH_TEST);
    }
    frame++;
    app_check_error(a, "a part of an image");
}

int main(int argc, char **argv)
{
    static const app_program self = {"dynamic_size", API_GL_CORE, 3, 3, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
