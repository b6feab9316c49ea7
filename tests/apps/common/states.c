#include "states.h"

#include "gl.h"

#include <stdio.h>
#include <string.h>

typedef struct {
    GLenum name;
    const char *text;
    int count;
} query;

#define ONE(name) {name, #name, 1}
#define FOUR(name) {name, #name, 4}
static const query queries[] = {
    FOUR(GL_VIEWPORT), FOUR(GL_SCISSOR_BOX), FOUR(GL_COLOR_CLEAR_VALUE), FOUR(GL_COLOR_WRITEMASK),
    FOUR(GL_BLEND_COLOR), {GL_DEPTH_RANGE, "GL_DEPTH_RANGE", 2}, {GL_POLYGON_MODE, "GL_POLYGON_MODE", 1},
    ONE(GL_DEPTH_CLEAR_VALUE), ONE(GL_STENCIL_CLEAR_VALUE), ONE(GL_DEPTH_WRITEMASK), ONE(GL_DEPTH_FUNC),
    ONE(GL_STENCIL_WRITEMASK), ONE(GL_STENCIL_FUNC), ONE(GL_STENCIL_REF), ONE(GL_STENCIL_VALUE_MASK),
    ONE(GL_STENCIL_FAIL), ONE(GL_STENCIL_PASS_DEPTH_FAIL), ONE(GL_STENCIL_PASS_DEPTH_PASS),
    ONE(GL_BLEND_SRC_RGB), ONE(GL_BLEND_DST_RGB), ONE(GL_BLEND_SRC_ALPHA), ONE(GL_BLEND_DST_ALPHA),
    ONE(GL_BLEND_EQUATION_RGB), ONE(GL_BLEND_EQUATION_ALPHA), ONE(GL_LOGIC_OP_MODE), ONE(GL_CULL_FACE_MODE),
    ONE(GL_FRONT_FACE), ONE(GL_POLYGON_OFFSET_FACTOR), ONE(GL_POLYGON_OFFSET_UNITS), ONE(GL_LINE_WIDTH),
    ONE(GL_POINT_SIZE), ONE(GL_CURRENT_PROGRAM), ONE(GL_ACTIVE_TEXTURE), ONE(GL_TEXTURE_BINDING_2D),
    ONE(GL_TEXTURE_BINDING_3D), ONE(GL_TEXTURE_BINDING_2D_ARRAY), ONE(GL_SAMPLER_BINDING),
    ONE(GL_VERTEX_ARRAY_BINDING), ONE(GL_ARRAY_BUFFER_BINDING), ONE(GL_ELEMENT_ARRAY_BUFFER_BINDING),
    ONE(GL_UNIFORM_BUFFER_BINDING), ONE(GL_PIXEL_PACK_BUFFER_BINDING), ONE(GL_PIXEL_UNPACK_BUFFER_BINDING),
    ONE(GL_COPY_READ_BUFFER_BINDING), ONE(GL_DRAW_FRAMEBUFFER_BINDING), ONE(GL_READ_FRAMEBUFFER_BINDING),
    ONE(GL_RENDERBUFFER_BINDING), ONE(GL_DRAW_BUFFER), ONE(GL_READ_BUFFER), ONE(GL_PACK_ALIGNMENT),
    ONE(GL_PACK_ROW_LENGTH), ONE(GL_PACK_SKIP_ROWS), ONE(GL_UNPACK_ALIGNMENT), ONE(GL_UNPACK_ROW_LENGTH),
    ONE(GL_UNPACK_SKIP_PIXELS), ONE(GL_PROVOKING_VERTEX), ONE(GL_PRIMITIVE_RESTART_INDEX), ONE(GL_SAMPLES),
    ONE(GL_SAMPLE_BUFFERS), ONE(GL_SAMPLE_COVERAGE_VALUE), ONE(GL_CLIP_DISTANCE0), ONE(GL_BLEND), ONE(GL_CULL_FACE),
    ONE(GL_DEPTH_TEST), ONE(GL_STENCIL_TEST), ONE(GL_SCISSOR_TEST), ONE(GL_DITHER), ONE(GL_MULTISAMPLE),
    ONE(GL_POLYGON_OFFSET_FILL), ONE(GL_PRIMITIVE_RESTART), ONE(GL_PROGRAM_POINT_SIZE), ONE(GL_RASTERIZER_DISCARD),
    ONE(GL_FRAMEBUFFER_SRGB), ONE(GL_COLOR_LOGIC_OP), ONE(GL_DEPTH_CLAMP), ONE(GL_SAMPLE_ALPHA_TO_COVERAGE),
    ONE(GL_SAMPLE_MASK), ONE(GL_TEXTURE_CUBE_MAP_SEAMLESS),
};
enum { QUERIES = sizeof queries / sizeof queries[0] };

typedef char enough_room[(int)QUERIES <= (int)STATES_ROOM ? 1 : -1];

void states_make_unusual(int width, int height)
{
    GLuint texture, sampler, buffers[4], renderbuffer;
    glGenTextures(1, &texture);
    glGenSamplers(1, &sampler);
    glGenBuffers(4, buffers);
    glGenRenderbuffers(1, &renderbuffer);
    glActiveTexture(GL_TEXTURE5);
    glBindTexture(GL_TEXTURE_2D, texture);
    glBindSampler(5, sampler);
    glBindBuffer(GL_UNIFORM_BUFFER, buffers[0]);
    glBindBuffer(GL_COPY_READ_BUFFER, buffers[1]);
    glBindBuffer(GL_PIXEL_UNPACK_BUFFER, buffers[2]);
    glBindBuffer(GL_PIXEL_PACK_BUFFER, buffers[3]);
    glBindRenderbuffer(GL_RENDERBUFFER, renderbuffer);
    glViewport(3, 5, width - 20, height - 10);
    glScissor(7, 9, 100, 90);
    glEnable(GL_SCISSOR_TEST);
    glClearColor(0.5f, 0.25f, 0.75f, 0.125f);
    glClearDepth(0.875);
    glClearStencil(3);
    glColorMask(GL_TRUE, GL_FALSE, GL_TRUE, GL_FALSE);
    glDepthRange(0.125, 0.75);
    glDepthFunc(GL_GEQUAL);
    glStencilFunc(GL_NOTEQUAL, 5, 0x0f);
    glStencilOp(GL_INCR, GL_DECR, GL_INVERT);
    glStencilMask(0x3c);
    glEnable(GL_STENCIL_TEST);
    glEnable(GL_BLEND);
    glBlendFuncSeparate(GL_DST_COLOR, GL_ONE_MINUS_CONSTANT_ALPHA, GL_ZERO, GL_SRC_ALPHA);
    glBlendEquationSeparate(GL_FUNC_SUBTRACT, GL_MAX);
    glBlendColor(0.1f, 0.2f, 0.3f, 0.4f);
    glEnable(GL_CULL_FACE);
    glCullFace(GL_FRONT);
    glFrontFace(GL_CW);
    glEnable(GL_POLYGON_OFFSET_FILL);
    glPolygonOffset(1.5f, 2.0f);
    glPixelStorei(GL_PACK_ALIGNMENT, 2);
    glPixelStorei(GL_PACK_ROW_LENGTH, 17);
    glPixelStorei(GL_PACK_SKIP_ROWS, 1);
    glPixelStorei(GL_UNPACK_ALIGNMENT, 8);
    glPixelStorei(GL_UNPACK_ROW_LENGTH, 19);
    glPixelStorei(GL_UNPACK_SKIP_PIXELS, 2);
    glProvokingVertex(GL_FIRST_VERTEX_CONVENTION);
    glEnable(GL_PRIMITIVE_RESTART);
    glPrimitiveRestartIndex(999);
    glEnable(GL_PROGRAM_POINT_SIZE);
    glEnable(GL_DEPTH_CLAMP);
    glEnable(GL_SAMPLE_ALPHA_TO_COVERAGE);
    glDisable(GL_DITHER);
}

states states_take(void)
{
    states taken;
    memset(&taken, 0, sizeof taken);
    for (int i = 0; i < QUERIES; i++) {
        GLfloat answer[16] = {0};
        glGetFloatv(queries[i].name, answer);
        memcpy(taken.values[i], answer, (size_t)queries[i].count * sizeof(GLfloat));
    }
    return taken;
}

int states_compare(const states *before, const char *when)
{
    int different = 0;
    states now = states_take();
    for (int i = 0; i < QUERIES; i++) {
        const GLfloat *b = before->values[i], *n = now.values[i];
        if (memcmp(b, n, sizeof now.values[i]) == 0)
            continue;
        different++;
        fprintf(stderr, "%s changed %s from %g %g %g %g to %g %g %g %g\n", when, queries[i].text, (double)b[0],
                (double)b[1], (double)b[2], (double)b[3], (double)n[0], (double)n[1], (double)n[2], (double)n[3]);
    }
    return different;
}
