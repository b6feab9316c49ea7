/*
 * The direction test with 10,000 small calls in a frame, to measure the cost of a call. The cube is
 * drawn with twelve draws, and before each there are many changes of state that change no pixel.
 */
#include "common/mesh.h"
#include "common/product.h"

enum { TRIANGLES = CUBE_INDICES / 3, CHANGES = 10000 / TRIANGLES / 4 };

static mesh cube;

static void setup(app *a)
{
    (void)a;
    product_program();
    cube = mesh_cube();
}

static void draw(app *a)
{
    int triangle, change;
    app_clear();
    product_matrices(a);
    mesh_bind(&cube);
    for (triangle = 0; triangle < TRIANGLES; triangle++) {
        for (change = 0; change < CHANGES; change++) {
            glBindTexture(GL_TEXTURE_2D, 0);
            glDepthFunc(GL_LESS);
            glDisable(GL_BLEND);
            glLineWidth(1.0f);
        }
        glDrawElements(GL_TRIANGLES, 3, GL_UNSIGNED_SHORT, (const void *)(6 * (size_t)triangle));
    }
}

int main(int argc, char **argv)
{
    static const app_program self = {"many_calls", API_GL_CORE, 3, 3, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
