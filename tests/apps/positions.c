/*
 * Squares in rings around the viewer. In each ring the positions have another form, or a vertex
 * shader moves them away from the positions in the array.
 */
#include "common/app.h"
#include "common/program.h"

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#define HEAD "#version 430 core\nuniform mat4 projection, modelview;\n"
#define TAIL(value) "void main() { gl_Position = projection * modelview * " value "; }\n"

enum { RING = 8, CORNERS = 4 };

static const char plain[] = HEAD "layout(location = 0) in vec3 position;\n" TAIL("vec4(position, 1.0)");
static const char four[] = HEAD "layout(location = 0) in vec4 position;\n" TAIL("position");
static const char shifted[] = HEAD "layout(location = 0) in vec3 position;\n" TAIL("vec4(position + vec3(4.0, 0.0, 0.0), 1.0)");
static const char instanced[] =
    HEAD "layout(location = 0) in vec3 position;\n" TAIL("vec4(position + vec3(3 * gl_InstanceID, 0.0, 0.0), 1.0)");
static const char divided[] = HEAD "layout(location = 0) in vec3 position;\nlayout(location = 1) in vec3 place;\n" TAIL(
    "vec4(position + place, 1.0)");
static const char doubled[] =
    HEAD "layout(location = 0) in vec3 position;\n"
         "void main() { vec4 p = vec4(position, 1.0); if (position.x > 0.0) p.x += 6.0; gl_Position = projection * modelview * p; }\n";
static const char fragment[] =
    "#version 430 core\nuniform vec3 colour;\nout vec4 result;\nvoid main() { result = vec4(colour, 1.0); }\n";

/* Corners of a square at z = 0, in each form. */
static const float floats[CORNERS][3] = {{-1, -1, 0}, {1, -1, 0}, {-1, 1, 0}, {1, 1, 0}};
static const double doubles[CORNERS][3] = {{-1, -1, 0}, {1, -1, 0}, {-1, 1, 0}, {1, 1, 0}};
static const float with_w[CORNERS][4] = {{-3, -3, 0, 3}, {3, -3, 0, 3}, {-3, 3, 0, 3}, {3, 3, 0, 3}};
static const float with_one[CORNERS][4] = {{-1, -1, 0, 1}, {1, -1, 0, 1}, {-1, 1, 0, 1}, {1, 1, 0, 1}};
static const float two[CORNERS][2] = {{-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
static const uint16_t halves[CORNERS][4] = {{0xbc00, 0xbc00}, {0x3c00, 0xbc00}, {0xbc00, 0x3c00}, {0x3c00, 0x3c00}};
static const int16_t shorts[CORNERS][4] = {{-32767, -32768}, {32767, -32768}, {-32767, 32767}, {32767, 32767}};
static const uint8_t bytes[CORNERS][4] = {{0, 0}, {255, 0}, {0, 255}, {255, 255}};
static const float apart[CORNERS][5] = {{9, -1, -1, 0, 9}, {9, 1, -1, 0, 9}, {9, -1, 1, 0, 9}, {9, 1, 1, 0, 9}};

static const uint8_t strip8[] = {0, 1, 2, 3};
static const uint32_t strip32[] = {4, 5, 6, 7};
static const uint16_t restarted[] = {0, 1, 2, 65535, 1, 3, 2};

static GLuint programs[6], arrays[10], indices[3], places;

/* A vertex array with attribute 0 from `data`. */
static GLuint array_of(const void *data, GLsizeiptr size, GLint components, GLenum kind, GLboolean normalised, GLsizei stride)
{
    GLuint array, buffer;
    glGenVertexArrays(1, &array);
    glGenBuffers(1, &buffer);
    glBindVertexArray(array);
    glBindBuffer(GL_ARRAY_BUFFER, buffer);
    glBufferData(GL_ARRAY_BUFFER, size, data, GL_STATIC_DRAW);
    glVertexAttribPointer(0, components, kind, normalised, stride, NULL);
    glEnableVertexAttribArray(0);
    return array;
}

static void setup(app *a)
{
    (void)a;
    const char *const sources[] = {plain, four, shifted, instanced, divided, doubled};
    for (int i = 0; i < 6; i++) {
        const shader_source stages[] = {{GL_VERTEX_SHADER, sources[i]}, {GL_FRAGMENT_SHADER, fragment}};
        programs[i] = program_build(stages, 2);
    }
    arrays[0] = array_of(floats, sizeof floats, 3, GL_FLOAT, GL_FALSE, 0);
    arrays[1] = array_of(doubles, sizeof doubles, 3, GL_DOUBLE, GL_FALSE, 0);
    arrays[2] = array_of(with_w, sizeof with_w, 4, GL_FLOAT, GL_FALSE, 0);
    arrays[3] = array_of(with_one, sizeof with_one, 4, GL_FLOAT, GL_FALSE, 0);
    arrays[4] = array_of(two, sizeof two, 2, GL_FLOAT, GL_FALSE, 0);
    arrays[5] = array_of(halves, sizeof halves, 3, GL_HALF_FLOAT, GL_FALSE, 8);
    arrays[6] = array_of(shorts, sizeof shorts, 3, GL_SHORT, GL_TRUE, 8);
    arrays[7] = array_of(bytes, sizeof bytes, 3, GL_UNSIGNED_BYTE, GL_TRUE, 4);
    /*
     * The format is set with a binding. Other numbers are between the positions, and the positions
     * begin at the second number of each vertex.
     */
    GLuint buffer;
    glCreateVertexArrays(1, &arrays[8]);
    glCreateBuffers(1, &buffer);
    glNamedBufferStorage(buffer, sizeof apart, apart, 0);
    glVertexArrayVertexBuffer(arrays[8], 5, buffer, 0, sizeof apart[0]);
    glVertexArrayAttribFormat(arrays[8], 0, 3, GL_FLOAT, GL_FALSE, 4);
    glVertexArrayAttribBinding(arrays[8], 0, 5);
    glEnableVertexArrayAttrib(arrays[8], 0);
    arrays[9] = array_of(floats, sizeof floats, 3, GL_FLOAT, GL_FALSE, 0);
    float ring[RING][3] = {{0}};
    for (int i = 0; i < RING; i++)
        ring[i][0] = 3.0f * (float)i;
    glGenBuffers(1, &places);
    glBindBuffer(GL_ARRAY_BUFFER, places);
    glBufferData(GL_ARRAY_BUFFER, sizeof ring, ring, GL_STATIC_DRAW);
    glVertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, 0, NULL);
    glVertexAttribDivisor(1, 1);
    glEnableVertexAttribArray(1);
    const struct {
        const void *data;
        GLsizeiptr size;
    } lists[] = {{strip8, sizeof strip8}, {strip32, sizeof strip32}, {restarted, sizeof restarted}};
    glBindVertexArray(0);
    glGenBuffers(3, indices);
    for (int i = 0; i < 3; i++) {
        glBindBuffer(GL_COPY_WRITE_BUFFER, indices[i]);
        glBufferData(GL_COPY_WRITE_BUFFER, lists[i].size, lists[i].data, GL_STATIC_DRAW);
    }
}

static void issue(int ring)
{
    const GLint firsts[] = {0, 1};
    const GLsizei counts[] = {3, 3};
    switch (ring) {
    case 8:
        glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices[0]);
        glDrawElements(GL_TRIANGLE_STRIP, CORNERS, GL_UNSIGNED_BYTE, NULL);
        break;
    case 9:
        glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices[1]);
        glDrawElementsBaseVertex(GL_TRIANGLE_STRIP, CORNERS, GL_UNSIGNED_INT, NULL, -4);
        break;
    case 10:
        glEnable(GL_PRIMITIVE_RESTART);
        glPrimitiveRestartIndex(65535);
        glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices[2]);
        glDrawElements(GL_TRIANGLE_STRIP, 7, GL_UNSIGNED_SHORT, NULL);
        glDisable(GL_PRIMITIVE_RESTART);
        break;
    case 11:
        glMultiDrawArrays(GL_TRIANGLES, firsts, counts, 2);
        break;
    case 12:
    case 14:
        glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, CORNERS, 3);
        break;
    default:
        glDrawArrays(GL_TRIANGLE_STRIP, 0, CORNERS);
    }
}

static void draw(app *a)
{
    /* Array and program of each ring. */
    static const int of[][2] = {{0, 0}, {1, 0}, {2, 1}, {3, 1}, {4, 0}, {5, 0}, {6, 0}, {7, 0}, {8, 0},
                                {0, 0}, {0, 0}, {0, 0}, {0, 0}, {0, 2}, {0, 3}, {9, 4}, {0, 5}};
    const int rings = (int)(sizeof of / sizeof of[0]);
    app_clear();
    for (int ring = 0; ring < rings; ring++) {
        GLuint program = programs[of[ring][1]];
        glUseProgram(program);
        glUniformMatrix4fv(glGetUniformLocation(program, "projection"), 1, GL_FALSE, a->projection.m);
        glBindVertexArray(arrays[of[ring][0]]);
        for (int i = 0; i < RING; i++) {
            matrix4 turn = matrix_camera(360.0 * i / RING + 7.0 * ring, 70.0 * ring / rings - 15.0);
            matrix4 modelview = matrix_multiply(turn, matrix_translate(0.0, 0.0, -20.0 - 3.0 * ring));
            glUniformMatrix4fv(glGetUniformLocation(program, "modelview"), 1, GL_FALSE, modelview.m);
            glUniform3f(glGetUniformLocation(program, "colour"), 0.1f + 0.05f * (float)ring, 0.1f * (float)i, 0.9f);
            issue(ring);
        }
    }
}

int main(int argc, char **argv)
{
    static const app_program self = {"positions", API_GL_CORE, 4, 5, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
