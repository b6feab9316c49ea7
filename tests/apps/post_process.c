/*
 * Direction test in a core 3.3 context: the scene is drawn off screen, a second pass changes its colours into
 * another framebuffer, a third changes them back while it fills the window. A shadow map is drawn besides.
 */
#include "common/app.h"
#include "common/mesh.h"
#include "common/shader.h"

static const char vertex[] = "#version 330 core\n"
                             "layout(location = 0) in vec3 position;\n"
                             "layout(location = 1) in vec3 colour;\n"
                             "uniform mat4 MVP;\n"
                             "out vec3 shade;\n"
                             "void main() { shade = colour; gl_Position = MVP * vec4(position, 1.0); }\n";
static const char screen_vertex[] =
    "#version 330 core\n"
    "out vec2 place;\n"
    "void main() {\n"
    "    place = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0;\n"
    "    gl_Position = vec4(place * 2.0 - 1.0, 0.0, 1.0);\n"
    "}\n";
static const char screen_fragment[] = "#version 330 core\n"
                                      "in vec2 place;\n"
                                      "uniform sampler2D picture;\n"
                                      "out vec4 result;\n"
                                      "void main() { result = vec4(texture(picture, place).brg, 1.0); }\n";
/* Undoes the first pass. */
static const char undo_fragment[] = "#version 330 core\n"
                                    "in vec2 place;\n"
                                    "uniform sampler2D picture;\n"
                                    "out vec4 result;\n"
                                    "void main() { result = vec4(texture(picture, place).gbr, 1.0); }\n";

static mesh cube;
static GLuint scene, change, undo, framebuffers[3], textures[3], depths[2], empty;
static GLint location;

static void attach(int i, int width, int height, int depth)
{
    glBindTexture(GL_TEXTURE_2D, textures[i]);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, NULL);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffers[i]);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, textures[i], 0);
    if (depth >= 0) {
        glBindRenderbuffer(GL_RENDERBUFFER, depths[depth]);
        glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, width, height);
        glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depths[depth]);
    }
}

static void setup(app *a)
{
    const shader_source stages[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, shader_shade}};
    const shader_source changes[] = {{GL_VERTEX_SHADER, screen_vertex}, {GL_FRAGMENT_SHADER, screen_fragment}};
    const shader_source undoes[] = {{GL_VERTEX_SHADER, screen_vertex}, {GL_FRAGMENT_SHADER, undo_fragment}};
    scene = program_build(stages, 2);
    change = program_build(changes, 2);
    undo = program_build(undoes, 2);
    location = glGetUniformLocation(scene, "MVP");
    cube = mesh_cube();
    glGenVertexArrays(1, &empty);
    glGenFramebuffers(3, framebuffers);
    glGenTextures(3, textures);
    glGenRenderbuffers(2, depths);
    attach(0, a->window.width, a->window.height, 0);
    attach(1, a->window.width, a->window.height, -1);
    attach(2, 64, 64, 1);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
}

static void draw_cube(matrix4 mvp)
{
    app_clear();
    glUseProgram(scene);
    glUniformMatrix4fv(location, 1, GL_FALSE, mvp.m);
    mesh_bind(&cube);
    glDrawElements(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL);
}

static void fill(GLuint framebuffer, GLuint program, GLuint texture)
{
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glDisable(GL_DEPTH_TEST);
    glUseProgram(program);
    glBindVertexArray(empty);
    glBindTexture(GL_TEXTURE_2D, texture);
    glDrawArrays(GL_TRIANGLES, 0, 3);
}

static void draw(app *a)
{
    /* What a light sees: another camera, another size. */
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffers[2]);
    glViewport(0, 0, 64, 64);
    draw_cube(matrix_multiply(matrix_perspective(50.0, 1.0, 1.0, 50.0), a->modelview));
    glViewport(0, 0, a->window.width, a->window.height);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffers[0]);
    draw_cube(matrix_multiply(a->projection, a->modelview));
    fill(framebuffers[1], change, textures[0]);
    fill(0, undo, textures[1]);
}

int main(int argc, char **argv)
{
    static const app_program self = {"post_process", API_GL_CORE, 3, 3, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
