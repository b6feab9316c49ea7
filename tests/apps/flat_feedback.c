/*
 * The first flat draw and the first read happen while transform feedback records. Cupola's own
 * draws must be neither recorded nor refused.
 */
#include "common/app.h"
#include "common/probe.h"

static GLuint program, buffer;

static void setup(app *a)
{
    static const char *vertex =
        "#version 330\nin vec2 position;\nout vec2 seen;\nuniform vec4 colour;\nout vec4 shade;\n"
        "void main() { seen = 2.0 * position; shade = colour; gl_Position = vec4(position, 0.0, 1.0); }\n";
    static const char *fragment =
        "#version 330\nin vec4 shade;\nout vec4 colour;\nvoid main() { colour = shade; }\n";
    static const char *recorded[] = {"seen"};
    static const float corners[] = {-1, -1, 1, -1, -1, 1};
    GLuint shaders[] = {glCreateShader(GL_VERTEX_SHADER), glCreateShader(GL_FRAGMENT_SHADER)};
    glShaderSource(shaders[0], 1, &vertex, NULL);
    glShaderSource(shaders[1], 1, &fragment, NULL);
    program = glCreateProgram();
    for (int i = 0; i < 2; i++) {
        glCompileShader(shaders[i]);
        glAttachShader(program, shaders[i]);
    }
    glTransformFeedbackVaryings(program, 1, recorded, GL_INTERLEAVED_ATTRIBS);
    glLinkProgram(program);
    GLint good = 0;
    glGetProgramiv(program, GL_LINK_STATUS, &good);
    app_check(a, good, "the program does not link");
    glUseProgram(program);
    glUniform4f(glGetUniformLocation(program, "colour"), 0.0f, 1.0f, 0.0f, 1.0f);
    GLuint array, positions;
    glGenVertexArrays(1, &array);
    glBindVertexArray(array);
    glGenBuffers(1, &positions);
    glBindBuffer(GL_ARRAY_BUFFER, positions);
    glBufferData(GL_ARRAY_BUFFER, sizeof corners, corners, GL_STATIC_DRAW);
    GLint place = glGetAttribLocation(program, "position");
    glVertexAttribPointer((GLuint)place, 2, GL_FLOAT, GL_FALSE, 0, NULL);
    glEnableVertexAttribArray((GLuint)place);
    glGenBuffers(1, &buffer);
}

static void draw(app *a)
{
    glBindBufferBase(GL_TRANSFORM_FEEDBACK_BUFFER, 0, buffer);
    glBufferData(GL_TRANSFORM_FEEDBACK_BUFFER, 64 * sizeof(float), NULL, GL_STREAM_READ);
    glClearColor(1.0f, 0.0f, 0.0f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    GLuint query;
    glGenQueries(1, &query);
    glBeginQuery(GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN, query);
    glBeginTransformFeedback(GL_TRIANGLES);
    glDrawArrays(GL_TRIANGLES, 0, 3);
    probe(a, 10, 10, 0, 1, 0, "while it records");
    glDrawArrays(GL_TRIANGLES, 0, 3);
    glEndTransformFeedback();
    glEndQuery(GL_TRANSFORM_FEEDBACK_PRIMITIVES_WRITTEN);
    app_check_error(a, "after transform feedback");
    GLuint count = 0;
    glGetQueryObjectuiv(query, GL_QUERY_RESULT, &count);
    glDeleteQueries(1, &query);
    app_check(a, count == 2, "%u primitives are recorded", count);
    float values[12];
    glGetBufferSubData(GL_TRANSFORM_FEEDBACK_BUFFER, 0, sizeof values, values);
    static const float expected[] = {-2, -2, 2, -2, -2, 2};
    for (int i = 0; i < 12; i++)
        app_check(a, values[i] == expected[i % 6], "value %d is %g", i, (double)values[i]);
    probe(a, 10, 10, 0, 1, 0, "after it");
}

int main(int argc, char **argv)
{
    static const app_program self = {"flat_feedback", API_GL_CORE, 3, 3, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
