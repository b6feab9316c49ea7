/*
 * Object names that the program chooses itself, buffers by their names as in
 * EXT_direct_state_access, and reads of a window that was only cleared: in the first frame, and
 * beyond the window.
 */
#include "common/fixed.h"
#include "common/probe.h"

#include <string.h>

static void check_names(app *a)
{
    /* All of these names are free, because no call has created one. */
    for (GLuint name = 1; name <= 40; name++) {
        glBindBuffer(GL_ARRAY_BUFFER, name);
        GLint size = -1;
        glGetBufferParameteriv(GL_ARRAY_BUFFER, GL_BUFFER_SIZE, &size);
        app_check(a, size == 0, "the new buffer %u has %d bytes", name, size);
        glBindBuffer(GL_ARRAY_BUFFER, 0);
        glDeleteBuffers(1, &name);
        glBindRenderbuffer(GL_RENDERBUFFER, name);
        glGetRenderbufferParameteriv(GL_RENDERBUFFER, GL_RENDERBUFFER_WIDTH, &size);
        app_check(a, size == 0, "the new renderbuffer %u is %d wide", name, size);
        glBindRenderbuffer(GL_RENDERBUFFER, 0);
        glDeleteRenderbuffers(1, &name);
        glBindFramebuffer(GL_FRAMEBUFFER, name);
        GLint kind = -1;
        glGetFramebufferAttachmentParameteriv(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0,
                                              GL_FRAMEBUFFER_ATTACHMENT_OBJECT_TYPE, &kind);
        app_check(a, kind == GL_NONE, "the new framebuffer %u has 0x%x", name, (unsigned)kind);
        glBindFramebuffer(GL_FRAMEBUFFER, 0);
        glDeleteFramebuffers(1, &name);
    }
}

static void check_named_buffers(app *a)
{
    static const char text[] = "named";
    char back[sizeof text] = "";
    GLuint names[3];
    glGenBuffers(3, names);
    glNamedBufferDataEXT(names[0], sizeof text, text, GL_STATIC_DRAW);
    app_check_error(a, "glNamedBufferDataEXT of a name that was only asked for");
    glGetNamedBufferSubDataEXT(names[0], 0, sizeof back, back);
    app_check(a, memcmp(back, text, sizeof text) == 0, "glNamedBufferDataEXT stores nothing");
    glNamedBufferStorageEXT(names[1], sizeof text, text, 0);
    app_check_error(a, "glNamedBufferStorageEXT of a name that was only asked for");
    glNamedBufferDataEXT(names[2], 16, NULL, GL_STATIC_DRAW);
    void *mapped = glMapNamedBufferEXT(names[2], GL_WRITE_ONLY);
    app_check(a, mapped != NULL && glUnmapNamedBufferEXT(names[2]), "glMapNamedBufferEXT returns no address");
    GLuint texture;
    glGenTextures(1, &texture);
    glTextureBufferEXT(texture, GL_TEXTURE_BUFFER, GL_R32F, names[2]);
    app_check_error(a, "glTextureBufferEXT");
    glDeleteTextures(1, &texture);
    glDeleteBuffers(3, names);
    GLint buffer = -1;
    glFramebufferDrawBufferEXT(0, GL_NONE);
    glGetIntegerv(GL_DRAW_BUFFER, &buffer);
    app_check(a, buffer == GL_NONE, "glFramebufferDrawBufferEXT sets 0x%x", (unsigned)buffer);
    glFramebufferDrawBufferEXT(0, GL_BACK);
    glFramebufferReadBufferEXT(0, GL_NONE);
    glGetIntegerv(GL_READ_BUFFER, &buffer);
    app_check(a, buffer == GL_NONE, "glFramebufferReadBufferEXT sets 0x%x", (unsigned)buffer);
    glFramebufferReadBufferEXT(0, GL_BACK);
}

static void check_reads(app *a)
{
    enum { SIDE = 8 };
    glClearColor(0.0f, 1.0f, 0.0f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    probe(a, 30, 30, 0, 1, 0, "only cleared");
    fixed_begin_pixels(a);
    glColor3f(1.0f, 0.0f, 0.0f);
    glRecti(20, 20, 40, 40);
    fixed_end_pixels();
    probe(a, 30, 30, 1, 0, 0, "a rectangle");
    probe(a, 50, 50, 0, 1, 0, "beside the rectangle");
    /* Half of the lines and half of each line are outside of the window. */
    unsigned char pixels[SIDE][SIDE][4];
    memset(pixels, 77, sizeof pixels);
    glReadPixels(-SIDE / 2, -SIDE / 2, SIDE, SIDE, GL_RGBA, GL_UNSIGNED_BYTE, pixels);
    app_check(a, pixels[0][SIDE - 1][0] == 77 && pixels[SIDE - 1][0][0] == 77, "memory for pixels outside changes");
    app_check(a, pixels[SIDE - 1][SIDE - 1][1] == 255 && pixels[SIDE / 2][SIDE / 2][1] == 255, "pixels inside are missing");
    memset(pixels, 77, sizeof pixels);
    glReadPixels(a->window.width - SIDE / 2, a->window.height - SIDE / 2, SIDE, SIDE, GL_RGBA, GL_UNSIGNED_BYTE, pixels);
    app_check(a, pixels[0][SIDE - 1][0] == 77 && pixels[SIDE - 1][0][0] == 77, "memory for pixels outside changes");
    app_check(a, pixels[0][0][1] == 255 && pixels[SIDE / 2 - 1][SIDE / 2 - 1][1] == 255, "pixels inside are missing");
    /* The same into a texture. */
    GLuint texture;
    static unsigned char texels[SIDE][SIDE][4];
    memset(texels, 77, sizeof texels);
    glGenTextures(1, &texture);
    glBindTexture(GL_TEXTURE_2D, texture);
    glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, SIDE, SIDE, 0, GL_RGBA, GL_UNSIGNED_BYTE, texels);
    glCopyTexSubImage2D(GL_TEXTURE_2D, 0, 0, 0, -SIDE / 2, -SIDE / 2, SIDE, SIDE);
    glGetTexImage(GL_TEXTURE_2D, 0, GL_RGBA, GL_UNSIGNED_BYTE, texels);
    app_check(a, texels[0][SIDE - 1][0] == 77 && texels[SIDE - 1][0][0] == 77, "texels outside change");
    app_check(a, texels[SIDE - 1][SIDE - 1][1] == 255 && texels[SIDE / 2][SIDE / 2][1] == 255, "texels inside are missing");
    glDeleteTextures(1, &texture);
}

static void draw(app *a)
{
    if (a->frame == 0) {
        check_reads(a);
        check_names(a);
        check_named_buffers(a);
    } else {
        check_names(a);
        check_reads(a);
    }
}

int main(int argc, char **argv)
{
    static const app_program self = {"own_choice", API_GL_COMPATIBILITY, 0, 0, NULL, draw, NULL};
    return app_main(argc, argv, &self);
}
