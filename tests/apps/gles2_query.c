/*
 * A query of any samples in GLES 2 without a clear. A program is created, used and deleted while
 * the query is open.
 */
#include "common/app.h"
#include "common/program.h"

#include <EGL/egl.h>
#include <GLES2/gl2ext.h>

static PFNGLGENQUERIESEXTPROC gen;
static PFNGLBEGINQUERYEXTPROC begin;
static PFNGLENDQUERYEXTPROC end;
static PFNGLGETQUERYOBJECTUIVEXTPROC result;
static PFNGLDELETEQUERIESEXTPROC delete;

static const char vertex[] = "attribute vec2 position;\nvoid main() { gl_Position = vec4(position, 0.0, 1.0); }\n";
static const char fragment[] = "precision mediump float;\nvoid main() { gl_FragColor = vec4(0.0, 1.0, 0.0, 1.0); }\n";

static void setup(app *a)
{
    (void)a;
    gen = (PFNGLGENQUERIESEXTPROC)eglGetProcAddress("glGenQueriesEXT");
    begin = (PFNGLBEGINQUERYEXTPROC)eglGetProcAddress("glBeginQueryEXT");
    end = (PFNGLENDQUERYEXTPROC)eglGetProcAddress("glEndQueryEXT");
    result = (PFNGLGETQUERYOBJECTUIVEXTPROC)eglGetProcAddress("glGetQueryObjectuivEXT");
    delete = (PFNGLDELETEQUERIESEXTPROC)eglGetProcAddress("glDeleteQueriesEXT");
}

static void draw(app *a)
{
    static const GLfloat corners[] = {-1.0f, -1.0f, 1.0f, -1.0f, -1.0f, 1.0f, 1.0f, 1.0f};
    GLuint query = 0, seen = 77;
    gen(1, &query);
    begin(GL_ANY_SAMPLES_PASSED_EXT, query);
    const shader_source stages[] = {{GL_VERTEX_SHADER, vertex}, {GL_FRAGMENT_SHADER, fragment}};
    GLuint program = program_build(stages, 2);
    glUseProgram(program);
    GLint place = glGetAttribLocation(program, "position");
    glVertexAttribPointer((GLuint)place, 2, GL_FLOAT, GL_FALSE, 0, corners);
    glEnableVertexAttribArray((GLuint)place);
    glDrawArrays(GL_TRIANGLE_STRIP, 0, 4);
    glDeleteProgram(program);
    end(GL_ANY_SAMPLES_PASSED_EXT);
    result(query, GL_QUERY_RESULT_EXT, &seen);
    app_check(a, seen == 1, "a query of any samples in frame %d says %u", a->frame, seen);
    delete(1, &query);
    app_check_error(a, "the query");
}

int main(int argc, char **argv)
{
    static const app_program self = {"gles2_query", API_GLES, 2, 0, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
