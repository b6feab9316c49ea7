/*
 * Every way to read the window's framebuffer must give the picture that the program drew, and must
 * name that framebuffer.
 */
#include "common/fixed.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void check_bindings(app *a)
{
    GLint value = -1;
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &value);
    app_check(a, value == 0, "GL_DRAW_FRAMEBUFFER_BINDING is %d", value);
    glGetIntegerv(GL_READ_FRAMEBUFFER_BINDING, &value);
    app_check(a, value == 0, "GL_READ_FRAMEBUFFER_BINDING is %d", value);
    glGetIntegerv(GL_READ_BUFFER, &value);
    app_check(a, value == GL_BACK, "GL_READ_BUFFER is 0x%x", (unsigned)value);
    glGetIntegerv(GL_DRAW_BUFFER, &value);
    app_check(a, value == GL_BACK, "GL_DRAW_BUFFER is 0x%x", (unsigned)value);
    GLboolean doubled = GL_FALSE;
    glGetBooleanv(GL_DOUBLEBUFFER, &doubled);
    app_check(a, doubled, "GL_DOUBLEBUFFER is false");
    GLint viewport[4], scissor[4];
    glGetIntegerv(GL_VIEWPORT, viewport);
    glGetIntegerv(GL_SCISSOR_BOX, scissor);
    app_check(a, viewport[0] == 0 && viewport[1] == 0 && viewport[2] == a->window.width &&
                     viewport[3] == a->window.height, "GL_VIEWPORT is %d %d %d %d", viewport[0], viewport[1],
              viewport[2], viewport[3]);
    app_check(a, scissor[0] == 0 && scissor[1] == 0 && scissor[2] == a->window.width &&
                     scissor[3] == a->window.height, "GL_SCISSOR_BOX is %d %d %d %d", scissor[0], scissor[1],
              scissor[2], scissor[3]);
    app_check(a, glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE,
              "framebuffer 0 is not complete");
    glGetFramebufferAttachmentParameteriv(GL_FRAMEBUFFER, GL_BACK_LEFT, GL_FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE, &value);
    app_check(a, value == GL_FRAMEBUFFER_DEFAULT, "framebuffer 0's object type is 0x%x", (unsigned)value);
    float top[16];
    glGetFloatv(GL_PROJECTION_MATRIX, top);
    app_check(a, memcmp(top, a->projection.m, sizeof top) == 0, "GL_PROJECTION_MATRIX is not what was loaded");
}

/* Reads the texture and compares it with the window's picture at (x, y from the bottom). */
static void check_texture(app *a, const image *picture, int x, int y, int width, int height, const char *what)
{
    unsigned char *texels = malloc(4 * (size_t)width * (size_t)height);
    if (texels == NULL)
        return;
    glGetTexImage(GL_TEXTURE_2D, 0, GL_RGBA, GL_UNSIGNED_BYTE, texels);
    int wrong = 0;
    for (int row = 0; row < height; row++) {
        for (int column = 0; column < width; column++) {
            const unsigned char *t = texels + 4 * ((size_t)row * (size_t)width + (size_t)column);
            wrong += memcmp(t, image_at(picture, x + column, picture->height - 1 - (y + row)), 3) != 0;
        }
    }
    app_check(a, wrong == 0, "%s: %d of %d texels differ from glReadPixels", what, wrong, width * height);
    free(texels);
}

static void draw(app *a)
{
    fixed_cube(a);
    check_bindings(a);
    if (app_is_first_read(a))
        return;
    image picture = image_read_framebuffer(a->window.width, a->window.height);
    app_check_cube_picture(a, &picture, "glReadPixels");

    /* Reads a part in another format with the current pack state. */
    unsigned char part[7 * 40 * 3];
    memset(part, 77, sizeof part);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glPixelStorei(GL_PACK_ROW_LENGTH, 40);
    glPixelStorei(GL_PACK_SKIP_PIXELS, 3);
    glReadPixels(100, 60, 31, 7, GL_RGB, GL_UNSIGNED_BYTE, part);
    glPixelStorei(GL_PACK_ROW_LENGTH, 0);
    glPixelStorei(GL_PACK_SKIP_PIXELS, 0);
    glPixelStorei(GL_PACK_ALIGNMENT, 4);
    app_check(a, part[0] == 77 && memcmp(part + 9, image_at(&picture, 100, picture.height - 1 - 60), 93) == 0,
              "a partial glReadPixels differs from the whole");

    /* Reads into a pixel buffer. */
    GLuint buffer;
    glGenBuffers(1, &buffer);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, buffer);
    glBufferData(GL_PIXEL_PACK_BUFFER, 64, NULL, GL_STREAM_READ);
    glReadPixels(50, 40, 16, 1, GL_RGBA, GL_UNSIGNED_BYTE, NULL);
    const unsigned char *mapped = glMapBuffer(GL_PIXEL_PACK_BUFFER, GL_READ_ONLY);
    app_check(a, mapped != NULL && memcmp(mapped, image_at(&picture, 50, picture.height - 1 - 40), 3) == 0,
              "glReadPixels into a buffer differs");
    glUnmapBuffer(GL_PIXEL_PACK_BUFFER);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, 0);
    glDeleteBuffers(1, &buffer);

    /* Depth in the middle: the distance along -z to the cube's wall. */
    float depth = -1.0f;
    glReadPixels(a->window.width / 2, a->window.height / 2, 1, 1, GL_DEPTH_COMPONENT, GL_FLOAT, &depth);
    app_check(a, depth > 0.5f && depth < 1.0f, "the depth in the middle is %g", (double)depth);

    GLuint texture;
    glGenTextures(1, &texture);
    glBindTexture(GL_TEXTURE_2D, texture);
    glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    glCopyTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, 10, 20, 128, 64, 0);
    check_texture(a, &picture, 10, 20, 128, 64, "glCopyTexImage2D");
    glCopyTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, 30, 5, 128, 64);
    check_texture(a, &picture, 30, 5, 128, 64, "glCopyTexSubImage2D");

    /* Copies from framebuffer 0 into a framebuffer of the program. */
    GLuint framebuffer, target;
    glGenTextures(1, &target);
    glBindTexture(GL_TEXTURE_2D, target);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGB8, 96, 96, 0, GL_RGB, GL_UNSIGNED_BYTE, NULL);
    glGenFramebuffers(1, &framebuffer);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
    glFramebufferTexture2D(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, target, 0);
    glBlitFramebuffer(40, 50, 136, 146, 0, 0, 96, 96, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    GLint bound = -1;
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &bound);
    app_check(a, (GLuint)bound == framebuffer, "the program's framebuffer is bound as %d", bound);
    check_texture(a, &picture, 40, 50, 96, 96, "glBlitFramebuffer");
    /* Deleting the bound framebuffer binds 0 again. */
    glDeleteFramebuffers(1, &framebuffer);
    glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &bound);
    app_check(a, bound == 0, "after the deletion of the bound framebuffer %d is bound", bound);
    glBindTexture(GL_TEXTURE_2D, 0);
    glDeleteTextures(1, &texture);
    glDeleteTextures(1, &target);
    image_free(&picture);
}

int main(int argc, char **argv)
{
    static const app_program self = {"read_back", API_GL_COMPATIBILITY, 0, 0, NULL, draw, NULL};
    return app_main(argc, argv, &self);
}
