/*
 * A cube around the eye. Each face is a model with its own model-view-projection matrix. Three of
 * the models are stretched or skewed, so that their matrices do not show the lens. `--mode` says
 * how: axes, skew.
 */
#include "common/app.h"
#include "common/forms.h"
#include "common/mesh.h"

#include <string.h>

static mesh cube;
static GLuint program;

static void setup(app *a)
{
    (void)a;
    cube = mesh_cube();
    program = form_program("#version 410 core\n"
                           "layout(location = 0) in vec3 position;\nlayout(location = 1) in vec3 colour;\n"
                           "uniform mat4 MVP;\nuniform mat3 undo;\nout vec3 shade;\n"
                           "void main() { shade = colour; gl_Position = MVP * vec4(undo * position, 1.0); }\n");
}

static void draw(app *a)
{
    const bool skew = a->mode != NULL && strcmp(a->mode, "skew") == 0;
    const matrix4 own = matrix_multiply(a->projection, a->modelview);
    const float undo[2][9] = {{1, 0, 0, 0, 1, 0, 0, 0, 1}, {0.05f, 0, 0, skew ? -0.5f : 0, 10, 0, 0, 0, 0.25f}};
    /* The inverse of `undo`. */
    matrix4 model = matrix_identity();
    model.m[0] = 20;
    model.m[4] = skew ? 1 : 0;
    model.m[5] = 0.1f;
    model.m[10] = 4;
    const matrix4 stretched = matrix_multiply(own, model);
    app_clear();
    glUseProgram(program);
    mesh_bind(&cube);
    for (int face = 0; face < 6; face++) {
        const int is_stretched = face % 2 == 0;
        glUniformMatrix4fv(glGetUniformLocation(program, "MVP"), 1, GL_FALSE, is_stretched ? stretched.m : own.m);
        glUniformMatrix3fv(glGetUniformLocation(program, "undo"), 1, GL_FALSE, undo[is_stretched]);
        glDrawElements(GL_TRIANGLES, 6, GL_UNSIGNED_SHORT, (const char *)NULL + 12 * face);
    }
    app_check_error(a, "a stretched model");
}

int main(int argc, char **argv)
{
    static const app_program self = {"stretched_models", API_GL_CORE, 4, 5, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
