/* A white scene: its picture under a rig shows the blending alone. */
#include "common/app.h"

static void draw(app *a)
{
    (void)a;
    glClearColor(1, 1, 1, 1);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
}

int main(int argc, char **argv)
{
    static const app_program program = {"white", API_GL_COMPATIBILITY, 0, 0, NULL, draw, NULL};
    return app_main(argc, argv, &program);
}
