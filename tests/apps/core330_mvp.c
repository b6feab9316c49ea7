/* Direction test in a core 3.3 context with a single model-view-projection uniform. */
#include "common/mesh.h"
#include "common/product.h"

static mesh cube;

static void setup(app *a)
{
    (void)a;
    product_program();
    cube = mesh_cube();
}

static void draw(app *a)
{
    app_clear();
    product_matrices(a);
    mesh_bind(&cube);
    glDrawElements(GL_TRIANGLES, CUBE_INDICES, GL_UNSIGNED_SHORT, NULL);
}

int main(int argc, char **argv)
{
    static const app_program self = {"core330_mvp", API_GL_CORE, 3, 3, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
