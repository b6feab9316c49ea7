/*
 * A scene off screen with a background that fills its image. A triangle without depth draws the
 * background, whose colours depend on the place in the picture. The scene is the cube, small and
 * far ahead of the camera. --mode multisampled: the image has samples, which are resolved. --mode
 * corner: the cube around the camera is also drawn, in the lower left quarter of the picture. --mode
 * window: background and scene are drawn to the window itself. --mode blended: so is this, but half of
 * the background is the colour of the clear. --mode between: so is this, in a part of the window, with
 * a scissor around it, after a widget was drawn at the left border.
 */
#include "common/app.h"
#include "common/mesh.h"
#include "common/program.h"

#include <string.h>

static const char vertex[] = "#version 330 core\n"
                             "layout(location = 0) in vec3 position;\n"
                             "layout(location = 1) in vec3 colour;\n"
                             "uniform mat4 MVP;\n"
                             "out vec3 shade;\n"
                             "void main() { shade = colour; gl_Position = MVP * vec4(position, 1.0); }\n";
static const char screen_vertex[] = "#version 330 core\n"
                                    "out vec3 shade;\n"
                                    "void main() {\n"
                                    "    vec2 place = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0;\n"
                                    "    shade = vec3(place, 0.25);\n"
                                    "    gl_Position = vec4(place * 2.0 - 1.0, 0.0, 1.0);\n"
                                    "}\n";
static const char fragment[] = "#version 330 core\n"
                               "in vec3 shade;\n"
                               "out vec4 result;\n"
                               "void main() { result = vec4(shade, 1.0); }\n";
static const char show_vertex[] = "#version 330 core\n"
                                  "out vec2 place;\n"
                                  "void main() {\n"
                                  "    place = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0;\n"
                                  "    gl_Position = vec4(place * 2.0 - 1.0, 0.0, 1.0);\n"
                                  "}\n";
static const char show_fragment[] = "#version 330 core\n"
                                    "in vec2 place;\n"
                                    "uniform sampler2D picture;\n"
                                    "out vec4 result;\n"
                                    "void main() { result = vec4(texture(picture, place).rgb, 1.0); }\n";

static mesh cube;
static GLuint scene, screen, show, framebuffers[2], colour, buffers[2], empty;
static bool multisampled, corner, direct, blended, between;

static void setup(app *a)
{
    multisampled = a->mode != NULL && strcmp(a->mode, "multisampled") == 0;
    corner = a->mode != NULL && strcmp(a->mode, "corner") == 0;
    blended = a->mode != NULL && strcmp(a->mode, "blended") == 0;
    between = a->mode != NULL && strcmp(a->mode, "between") == 0;
    direct = blended || between || (a->mode != NULL && strcmp(a->mode, "window") == 0);
    const shader_source of_scene[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, fragment}};
    const shader_source of_screen[] = {{GL_VERTEX_SHADER, screen_vertex}, {GL_FRAGMENT_SHADER, fragment}};
    const shader_source of_show[] = {{GL_VERTEX_SHADER, show_vertex}, {GL_FRAGMENT_SHADER, show_fragment}};
    scene = program_build(of_scene, 2);
    screen = program_build(of_screen, 2);
    show = program_build(of_show, 2);
    cube = mesh_cube();
    glGenVertexArrays(1, &empty);
    const int width = a->window.width, height = a->window.height, samples = multisampled ? 4 : 0;
    glGenFramebuffers(2, framebuffers);
    glGenRenderbuffers(2, buffers);
    glGenTextures(1, &colour);
    glBindTexture(GL_TEXTURE_2D, colour);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, NULL);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffers[1]);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, colour, 0);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffers[0]);
    const GLenum formats[] = {GL_DEPTH_COMPONENT24, GL_RGBA8};
    const GLenum points[] = {GL_DEPTH_ATTACHMENT, GL_COLOR_ATTACHMENT0};
    for (int i = 0; i < (multisampled ? 2 : 1); i++) {
        glBindRenderbuffer(GL_RENDERBUFFER, buffers[i]);
        glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, formats[i], width, height);
        glFramebufferRenderbuffer(GL_FRAMEBUFFER, points[i], GL_RENDERBUFFER, buffers[i]);
    }
    if (!multisampled)
        glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, colour, 0);
}

static void fill(void)
{
    if (blended)
        glEnable(GL_BLEND);
    glBlendColor(0.0f, 0.0f, 0.0f, 0.5f);
    glBlendFunc(GL_CONSTANT_ALPHA, GL_ONE_MINUS_CONSTANT_ALPHA);
    glDisable(GL_DEPTH_TEST);
    glUseProgram(screen);
    glBindVertexArray(empty);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glEnable(GL_DEPTH_TEST);
    glDisable(GL_BLEND);
}

/* The cube without perspective, in a strip of the window. */
static void draw_widget(const app *a)
{
    const matrix4 flat = matrix_identity();
    glEnable(GL_SCISSOR_TEST);
    glScissor(0, 0, a->window.width / 10, a->window.height);
    glDisable(GL_DEPTH_TEST);
    glUseProgram(scene);
    glUniformMatrix4fv(glGetUniformLocation(scene, "MVP"), 1, GL_FALSE, flat.m);
    mesh_bind(&cube);
    glDrawElements(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL);
    glEnable(GL_DEPTH_TEST);
}

static void draw(app *a)
{
    glBindFramebuffer(GL_FRAMEBUFFER, direct ? 0 : framebuffers[0]);
    app_clear();
    if (between) {
        const int width = a->window.width, height = a->window.height;
        draw_widget(a);
        glScissor(width / 8, height / 8, width * 3 / 4, height * 3 / 4);
        glViewport(width / 8, height / 8, width * 3 / 4, height * 3 / 4);
    }
    fill();
    glUseProgram(scene);
    const matrix4 all = matrix_multiply(a->projection, matrix_translate(0.0, 0.0, -10.0));
    glUniformMatrix4fv(glGetUniformLocation(scene, "MVP"), 1, GL_FALSE, all.m);
    mesh_bind(&cube);
    glDrawElements(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL);
    const int width = a->window.width, height = a->window.height;
    if (corner) {
        glEnable(GL_SCISSOR_TEST);
        glScissor(0, 0, width / 2, height / 2);
        glViewport(0, 0, width / 2, height / 2);
        glClear(GL_DEPTH_BUFFER_BIT);
        const matrix4 around = matrix_multiply(a->projection, matrix_scale(CUBE_SCALE));
        glUniformMatrix4fv(glGetUniformLocation(scene, "MVP"), 1, GL_FALSE, around.m);
        glDrawElements(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL);
        glDisable(GL_SCISSOR_TEST);
        glViewport(0, 0, width, height);
    }
    if (between) {
        glDisable(GL_SCISSOR_TEST);
        glViewport(0, 0, width, height);
    }
    if (direct)
        return;
    if (multisampled) {
        glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffers[1]);
        glBlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    }
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glDisable(GL_DEPTH_TEST);
    glUseProgram(show);
    glBindVertexArray(empty);
    glBindTexture(GL_TEXTURE_2D, colour);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glEnable(GL_DEPTH_TEST);
}

int main(int argc, char **argv)
{
    static const app_program self = {"backdrop", API_GL_CORE, 3, 3, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
