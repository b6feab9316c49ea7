/*
 * A geometry shader draws to four viewports. They are set once and are not whole numbers of pixels,
 * and one of them has a scissor. It draws in the window, and in a framebuffer after glViewport has
 * set all of them.
 */
#include "common/app.h"
#include "common/probe.h"
#include "common/program.h"

static GLuint program, framebuffer;

static void set_viewports(const app *a)
{
    float w = (float)a->window.width / 2, h = (float)a->window.height / 2;
    float own[16] = {0.25f, 0, w, h, w, 0, w, h, 0, h, w, h, w, h, w, h};
    glViewportArrayv(0, 4, own);
    glScissorIndexed(3, a->window.width / 2, a->window.height / 2, a->window.width / 4, a->window.height);
    glEnablei(GL_SCISSOR_TEST, 3);
}

static void setup(app *a)
{
    static const char *vertex = "#version 410\nvoid main() { gl_Position = vec4(0.0, 0.0, 0.0, 1.0); }\n";
    static const char *geometry =
        "#version 410\nlayout(points, invocations = 4) in;\nlayout(triangle_strip, max_vertices = 3) out;\n"
        "out vec3 shade;\nvoid corner(float x, float y) {\n"
        "    gl_ViewportIndex = gl_InvocationID;\n"
        "    shade = vec3(gl_InvocationID & 1, gl_InvocationID >> 1, 1);\n"
        "    gl_Position = vec4(x, y, 0.0, 1.0);\n    EmitVertex();\n}\n"
        "void main() { corner(-1.0, -1.0); corner(3.0, -1.0); corner(-1.0, 3.0); EndPrimitive(); }\n";
    static const char *fragment =
        "#version 410\nin vec3 shade;\nout vec4 colour;\nvoid main() { colour = vec4(shade, 1.0); }\n";
    const shader_source stages[] = {
        {GL_VERTEX_SHADER, vertex}, {GL_GEOMETRY_SHADER, geometry}, {GL_FRAGMENT_SHADER, fragment}};
    program = program_build(stages, 3);
    GLuint array, texture;
    glGenVertexArrays(1, &array);
    glBindVertexArray(array);
    glGenTextures(1, &texture);
    glBindTexture(GL_TEXTURE_2D, texture);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, a->window.width, a->window.height, 0, GL_RGBA, GL_UNSIGNED_BYTE, NULL);
    glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture, 0);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    set_viewports(a);
}

static void ask(app *a, const char *when)
{
    float viewport[4];
    GLint rounded[4], scissor[4];
    glGetFloati_v(GL_VIEWPORT, 0, viewport);
    app_check(a, viewport[0] == 0.25f, "the first viewport is at %g %s", (double)viewport[0], when);
    glGetFloatv(GL_VIEWPORT, viewport);
    app_check(a, viewport[0] == 0.25f, "glGetFloatv says %g %s", (double)viewport[0], when);
    glGetFloati_v(GL_VIEWPORT, 2, viewport);
    app_check(a, viewport[1] == (float)a->window.height / 2, "the third viewport is at %g %s", (double)viewport[1], when);
    glGetIntegeri_v(GL_VIEWPORT, 0, rounded);
    app_check(a, rounded[0] == 0, "glGetIntegeri_v says %d %s", rounded[0], when);
    glGetIntegeri_v(GL_SCISSOR_BOX, 3, scissor);
    app_check(a, scissor[2] == a->window.width / 4, "the fourth scissor is %d wide %s", scissor[2], when);
    app_check(a, glIsEnabledi(GL_SCISSOR_TEST, 3) && !glIsEnabledi(GL_SCISSOR_TEST, 1) && !glIsEnabled(GL_SCISSOR_TEST),
              "the scissor tests differ %s", when);
}

static void draw(app *a)
{
    int w = a->window.width, h = a->window.height;
    ask(a, "before");
    glClearColor(0.0f, 0.0f, 0.0f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glUseProgram(program);
    glDrawArrays(GL_POINTS, 0, 1);
    ask(a, "after");
    probe(a, w / 4, h / 4, 0, 0, 1, "in the first viewport");
    probe(a, 3 * w / 4, h / 4, 1, 0, 1, "in the second one");
    probe(a, w / 4, 3 * h / 4, 0, 1, 1, "in the third one");
    probe(a, 5 * w / 8, 3 * h / 4, 1, 1, 1, "in the fourth one");
    probe(a, 7 * w / 8, 3 * h / 4, 0, 0, 0, "beside the scissor of the fourth one");

    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
    glViewport(0, 0, w, h);
    glDisable(GL_SCISSOR_TEST);
    glDrawArrays(GL_POINTS, 0, 1);
    probe(a, w / 4, h / 4, 1, 1, 1, "in the framebuffer");
    glViewportIndexedf(3, 0, 0, 1, 1);
    glViewport(0, 0, w, h);
    glDrawArrays(GL_POINTS, 0, 1);
    probe(a, w / 4, h / 4, 1, 1, 1, "in the framebuffer, after the same viewport again");
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    set_viewports(a);
    app_check_error(a, "at the end");
}

int main(int argc, char **argv)
{
    static const app_program self = {"viewports", API_GL_CORE, 4, 1, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
