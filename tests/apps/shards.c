/*
 * White triangles on black. Each is much larger than a lens keeps straight, so their edges show how
 * they are drawn.
 */
#include "common/product.h"

enum { SHARDS = 5, CORNERS = 3 * SHARDS };

/* The same directions are in tests/suite/vertices.rs. */
static const float positions[CORNERS][3] = {
    {-0.9f, -0.8f, -1.0f}, {0.3f, -0.9f, -1.0f}, {-0.2f, 0.1f, -1.0f},  /* ahead */
    {0.4f, 0.2f, -1.0f},   {1.0f, 0.1f, -0.3f},  {0.8f, 0.9f, -0.6f},   /* to the right */
    {-1.0f, 0.2f, -0.5f},  {-0.5f, 1.0f, -0.2f}, {-1.0f, 0.9f, 0.3f},   /* to the left, behind */
    {0.1f, 0.3f, -1.0f},   {0.2f, 1.0f, -0.4f},  {-0.3f, 0.7f, -1.0f},  /* above */
    {0.5f, -0.9f, -0.6f},  {0.1f, -1.0f, -0.1f}, {0.9f, -0.8f, -0.2f},  /* below */
};
static float colours[CORNERS][3];

static GLuint array;

static void setup(app *a)
{
    (void)a;
    for (int i = 0; i < CORNERS; i++)
        for (int k = 0; k < 3; k++)
            colours[i][k] = 1.0f;
    product_program();
    GLuint buffers[2];
    glGenVertexArrays(1, &array);
    glBindVertexArray(array);
    glGenBuffers(2, buffers);
    glBindBuffer(GL_ARRAY_BUFFER, buffers[0]);
    glBufferData(GL_ARRAY_BUFFER, sizeof positions, positions, GL_STATIC_DRAW);
    glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, 0, NULL);
    glBindBuffer(GL_ARRAY_BUFFER, buffers[1]);
    glBufferData(GL_ARRAY_BUFFER, sizeof colours, colours, GL_STATIC_DRAW);
    glVertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, 0, NULL);
    glEnableVertexAttribArray(0);
    glEnableVertexAttribArray(1);
}

static void draw(app *a)
{
    glClearColor(0.0f, 0.0f, 0.0f, 1.0f);
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glEnable(GL_DEPTH_TEST);
    product_matrices(a);
    glBindVertexArray(array);
    glDrawArrays(GL_TRIANGLES, 0, CORNERS);
}

int main(int argc, char **argv)
{
    static const app_program self = {"shards", API_GL_CORE, 3, 3, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
