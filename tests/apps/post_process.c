/*
 * Direction test in a core 3.3 context. The scene is drawn off screen, a second pass changes its
 * colours into another framebuffer, and a third pass changes them back while it fills the window. A
 * shadow map is also drawn.
 * --mode matrices: the passes that fill the picture also have the camera's matrices, as passes of
 * engines do. One has them in its fragment shader, the other in a block that every shader has.
 */
#include "common/app.h"
#include "common/mesh.h"
#include "common/shader.h"

#include <string.h>

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

static const char matrix_fragment[] = "#version 330 core\n"
                                      "in vec2 place;\n"
                                      "uniform sampler2D picture;\n"
                                      "uniform mat4 projection;\n"
                                      "out vec4 result;\n"
                                      "void main() {\n"
                                      "    vec4 seen = projection * vec4(place, -5.0, 1.0);\n"
                                      "    result = vec4(texture(picture, place).brg + min(seen.w, 0.0), 1.0);\n"
                                      "}\n";
static const char block_vertex[] = "#version 330 core\n"
                                   "layout(std140) uniform Matrices { mat4 view, projection; };\n"
                                   "out vec2 place;\n"
                                   "vec4 seen_from_camera(vec4 p) { return projection * view * p; }\n"
                                   "void main() {\n"
                                   "    place = vec2(gl_VertexID & 1, gl_VertexID >> 1) * 2.0;\n"
                                   "    gl_Position = vec4(place * 2.0 - 1.0, 0.0, 1.0);\n"
                                   "}\n";

static mesh cube;
static GLuint block;
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
    const shader_source changes_by_matrix[] = {{GL_VERTEX_SHADER, screen_vertex}, {GL_FRAGMENT_SHADER, matrix_fragment}};
    const shader_source undoes_with_block[] = {{GL_VERTEX_SHADER, block_vertex}, {GL_FRAGMENT_SHADER, undo_fragment}};
    const bool matrices = a->mode != NULL && strcmp(a->mode, "matrices") == 0;
    scene = program_build(stages, 2);
    change = program_build(matrices ? changes_by_matrix : changes, 2);
    undo = program_build(matrices ? undoes_with_block : undoes, 2);
    if (matrices) {
        const matrix4 both[2] = {a->modelview, a->projection};
        glGenBuffers(1, &block);
        glBindBufferBase(GL_UNIFORM_BUFFER, 0, block);
        glBufferData(GL_UNIFORM_BUFFER, sizeof both, both, GL_STATIC_DRAW);
        glUseProgram(change);
        glUniformMatrix4fv(glGetUniformLocation(change, "projection"), 1, GL_FALSE, a->projection.m);
    }
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
    /* The view of a light: another camera and another size. */
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
