/*
 * Two squares ahead, drawn from buffers. From frame CHANGES on one of them is elsewhere. --mode
 * names the way in which its data or its buffer changes. The picture must follow in each way.
 */
#include "common/app.h"
#include "common/program.h"

#include <stddef.h>
#include <string.h>

enum { CHANGES = 4, CORNERS = 4, INDICES = 6, FLOATS = 3 * CORNERS };

static const char vertex[] =
    "#version 430 core\n"
    "layout(location = 0) in vec3 position;\n"
    "layout(std140, binding = 3) uniform Camera { mat4 projection; mat4 modelview; } camera;\n"
    "out vec3 captured;\n"
    "void main() {\n"
    "    vec4 eye = camera.modelview * vec4(position, 1.0);\n"
    "    captured = position;\n"
    "    gl_Position = camera.projection * eye;\n"
    "}\n";
static const char fragment[] =
    "#version 430 core\nuniform vec3 colour;\nout vec4 result;\nvoid main() { result = vec4(colour, 1.0); }\n";
static const char shift[] = "#version 430 core\nlayout(local_size_x = 1) in;\nlayout(std430, binding = 0) buffer B { float at[]; };\n"
                            "void main() { at[3u * gl_GlobalInvocationID.x] += 9.0; }\n";

static const unsigned short corners[2 * INDICES] = {0, 1, 2, 1, 3, 2, 4, 5, 6, 5, 7, 6};
static float places[2][FLOATS];
static GLuint program, compute, array, other_array, buffer, indices, block, source;
static const char *mode = "still";

static bool is(const char *name)
{
    return strcmp(mode, name) == 0;
}

/* A square around (x, 0, z). */
static void square(float *place, float x, float z)
{
    for (int i = 0; i < CORNERS; i++) {
        place[3 * i] = x + (i & 1 ? 1.0f : -1.0f);
        place[3 * i + 1] = i & 2 ? 1.0f : -1.0f;
        place[3 * i + 2] = z;
    }
}

static void point_at(GLuint vertices, GLuint name)
{
    glBindVertexArray(name);
    glBindBuffer(GL_ARRAY_BUFFER, vertices);
    glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, NULL);
    glEnableVertexAttribArray(0);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices);
}

static void setup(app *a)
{
    const shader_source stages[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, fragment}};
    const shader_source computes[] = {{GL_COMPUTE_SHADER, shift}};
    float both[2 * FLOATS];
    if (a->mode != NULL)
        mode = a->mode;
    program = program_build(stages, 2);
    compute = program_build(computes, 1);
    square(places[0], -1.5f, -6.0f);
    square(places[1], 7.5f, -6.0f);
    memcpy(both, places, sizeof both);
    glGenVertexArrays(1, &array);
    glGenVertexArrays(1, &other_array);
    glGenBuffers(1, &buffer);
    glGenBuffers(1, &indices);
    glGenBuffers(1, &block);
    glGenBuffers(1, &source);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, 0);
    point_at(buffer, array);
    glBufferData(GL_ARRAY_BUFFER, sizeof both, both, GL_STATIC_DRAW);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, sizeof corners, corners, GL_STATIC_DRAW);
    glBindBuffer(GL_COPY_READ_BUFFER, source);
    glBufferData(GL_COPY_READ_BUFFER, sizeof both, both, GL_STATIC_DRAW);
    glBindBuffer(GL_UNIFORM_BUFFER, block);
    glBufferData(GL_UNIFORM_BUFFER, 2 * sizeof(matrix4), NULL, GL_DYNAMIC_DRAW);
    matrix4 still = matrix_identity();
    glBufferSubData(GL_UNIFORM_BUFFER, 0, sizeof still, a->projection.m);
    glBufferSubData(GL_UNIFORM_BUFFER, sizeof still, sizeof still, still.m);
    glBindBufferBase(GL_UNIFORM_BUFFER, 3, block);
}

/* The first square goes to the place of the second. */
static void change(void)
{
    const GLsizeiptr size = sizeof places[1];
    matrix4 moved = matrix_translate(9.0, 0.0, 0.0);
    float both[2 * FLOATS];
    memcpy(both, places[1], sizeof places[1]);
    memcpy(both + FLOATS, places[1], sizeof places[1]);
    glBindVertexArray(array);
    glBindBuffer(GL_ARRAY_BUFFER, buffer);
    if (is("sub_data"))
        glBufferSubData(GL_ARRAY_BUFFER, 0, size, places[1]);
    else if (is("data"))
        glBufferData(GL_ARRAY_BUFFER, sizeof both, both, GL_STATIC_DRAW);
    else if (is("named_sub_data"))
        glNamedBufferSubData(buffer, 0, size, places[1]);
    else if (is("copy"))
        glCopyBufferSubData(GL_COPY_READ_BUFFER, GL_ARRAY_BUFFER, size, 0, size);
    else if (is("named_copy"))
        glCopyNamedBufferSubData(source, buffer, size, 0, size);
    else if (is("map")) {
        memcpy(glMapBuffer(GL_ARRAY_BUFFER, GL_WRITE_ONLY), places[1], sizeof places[1]);
        glUnmapBuffer(GL_ARRAY_BUFFER);
    } else if (is("map_range")) {
        memcpy(glMapBufferRange(GL_ARRAY_BUFFER, 0, size, GL_MAP_WRITE_BIT), places[1], sizeof places[1]);
        glUnmapBuffer(GL_ARRAY_BUFFER);
    } else if (is("clear")) {
        const float far_right = 7.5f;
        glClearBufferSubData(GL_ARRAY_BUFFER, GL_R32F, 0, 4, GL_RED, GL_FLOAT, &far_right);
    } else if (is("compute")) {
        glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffer);
        glUseProgram(compute);
        glDispatchCompute(CORNERS, 1, 1);
        glMemoryBarrier(GL_ALL_BARRIER_BITS);
    } else if (is("indices")) {
        glBufferSubData(GL_ELEMENT_ARRAY_BUFFER, 0, INDICES * 2, corners + INDICES);
    } else if (is("pointer")) {
        glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, (const char *)NULL + size);
    } else if (is("binding")) {
        glBindVertexBuffer(0, buffer, size, 12);
    } else if (is("recreated")) {
        glDeleteBuffers(1, &buffer);
        glGenBuffers(1, &buffer);
        point_at(buffer, array);
        glBufferData(GL_ARRAY_BUFFER, sizeof both, both, GL_STATIC_DRAW);
    } else if (is("kept")) {
        /*
         * The array that is drawn keeps the old buffer. The buffer's name then belongs to another
         * buffer.
         */
        GLuint name = 0;
        point_at(buffer, other_array);
        glBindVertexArray(0);
        glDeleteBuffers(1, &buffer);
        glGenBuffers(1, &name);
        glBindBuffer(GL_ARRAY_BUFFER, name);
        glBufferData(GL_ARRAY_BUFFER, sizeof both, both, GL_STATIC_DRAW);
        buffer = name;
    } else if (is("block")) {
        glBufferSubData(GL_UNIFORM_BUFFER, sizeof moved, sizeof moved, moved.m);
    } else if (is("block_bound")) {
        GLuint name = 0;
        glGenBuffers(1, &name);
        glBindBuffer(GL_UNIFORM_BUFFER, name);
        glBufferData(GL_UNIFORM_BUFFER, 2 * sizeof moved, NULL, GL_STATIC_DRAW);
        glCopyNamedBufferSubData(block, name, 0, 0, sizeof moved);
        glNamedBufferSubData(name, sizeof moved, sizeof moved, moved.m);
        glBindBufferBase(GL_UNIFORM_BUFFER, 3, name);
    }
}

/* Transform feedback writes the second square over the first. Nothing is drawn to the window. */
static void record(void)
{
    static const char *const captured = "captured";
    glTransformFeedbackVaryings(program, 1, &captured, GL_INTERLEAVED_ATTRIBS);
    glLinkProgram(program);
    glUseProgram(program);
    glBindVertexArray(array);
    glBindBufferRange(GL_TRANSFORM_FEEDBACK_BUFFER, 0, source, 0, FLOATS * 4);
    glEnable(GL_RASTERIZER_DISCARD);
    glBeginTransformFeedback(GL_POINTS);
    glDrawArrays(GL_POINTS, CORNERS, CORNERS);
    glEndTransformFeedback();
    glDisable(GL_RASTERIZER_DISCARD);
    glBindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, 0);
}

static void draw(app *a)
{
    if (a->frame == CHANGES)
        change();
    app_clear();
    glUseProgram(program);
    if (is("feedback")) {
        /* Draws from the buffer that is also recorded to. */
        point_at(source, other_array);
        if (a->frame == CHANGES) {
            record();
            point_at(source, other_array);
        }
        glUseProgram(program);
        glBindVertexArray(other_array);
    } else {
        glBindVertexArray(array);
    }
    GLint colour = glGetUniformLocation(program, "colour");
    glUniform3f(colour, 1.0f, 0.5f, 0.0f);
    glDrawElements(GL_TRIANGLES, INDICES, GL_UNSIGNED_SHORT, NULL);
    glUniform3f(colour, 0.0f, 0.5f, 1.0f);
    glDrawElementsBaseVertex(GL_TRIANGLES, INDICES, GL_UNSIGNED_SHORT, (const char *)NULL + 2 * INDICES, -CORNERS);
    glDrawArrays(GL_TRIANGLE_STRIP, 0, CORNERS);
}

int main(int argc, char **argv)
{
    static const app_program self = {"buffers", API_GL_CORE, 4, 5, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
