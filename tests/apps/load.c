/*
 * Large loads of one kind; --seed N is the number. At the end the window shows the cube of the
 * direction test.
 *   --mode draws     N draws in a frame, each with its own matrix (default 100,000)
 *   --mode contexts  N contexts, each of which draws a triangle of the cube (default 1,000)
 *   --mode threads   N threads with a display, a window and a context each, whose picture is
 *                    checked (default 64)
 */
#include "common/fixed.h"
#include "common/mesh.h"
#include "common/product.h"

#include <GL/glx.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

enum { TRIANGLES = CUBE_INDICES / 3 };

static mesh cube;

static int load(const app *a, int usual)
{
    return a->seed > 0 ? (int)a->seed : usual;
}

static bool is_mode(const app *a, const char *mode)
{
    return strcmp(a->mode != NULL ? a->mode : "draws", mode) == 0;
}

static void setup(app *a)
{
    if (is_mode(a, "draws")) {
        product_program();
        cube = mesh_cube();
    }
}

static void draws(app *a)
{
    mesh_bind(&cube);
    for (int i = 0; i < load(a, 100000); i++) {
        product_matrices(a);
        glDrawElements(GL_TRIANGLES, 3, GL_UNSIGNED_SHORT, (const void *)(6 * (size_t)(i % TRIANGLES)));
    }
}

static void contexts(app *a)
{
    const int count = load(a, 1000);
    GLXContext *all = calloc((size_t)count, sizeof *all);
    for (int i = 0; i < count; i++) {
        all[i] = glXCreateNewContext(a->window.display, a->window.config, GLX_RGBA_TYPE, a->window.context, True);
        app_check(a, all[i] != NULL && glXMakeCurrent(a->window.display, a->window.window, all[i]), "context %d", i);
        glEnable(GL_DEPTH_TEST);
        glMatrixMode(GL_PROJECTION);
        glLoadMatrixf(a->projection.m);
        glMatrixMode(GL_MODELVIEW);
        glLoadMatrixf(a->modelview.m);
        glBegin(GL_TRIANGLES);
        for (int corner = 0; corner < 3; corner++) {
            const int index = cube_indices[3 * (i % TRIANGLES) + corner];
            glColor3fv(cube_colours[index]);
            glVertex3fv(cube_positions[index]);
        }
        glEnd();
        app_check_error(a, "in one of many contexts");
    }
    window_make_current(&a->window);
    for (int i = 0; i < count; i++)
        glXDestroyContext(a->window.display, all[i]);
    free(all);
}

/*
 * Mesa 22.3 sometimes corrupts its memory if threads create or destroy contexts at the same time.
 */
static pthread_mutex_t contexts_lock = PTHREAD_MUTEX_INITIALIZER;

static void *thread(void *given)
{
    app *a = given;
    pthread_mutex_lock(&contexts_lock);
    a->window = window_open(&a->request);
    pthread_mutex_unlock(&contexts_lock);
    app_update_matrices(a);
    for (a->frame = 0; a->frame < 3; a->frame++) {
        fixed_cube(a);
        if (!app_is_first_read(a)) {
            image picture = image_read_framebuffer(a->window.width, a->window.height);
            app_check_cube_picture(a, &picture, "a thread's window");
            image_free(&picture);
        }
        app_check_error(a, "in a thread");
        window_swap(&a->window);
    }
    pthread_mutex_lock(&contexts_lock);
    window_release(&a->window);
    window_close(&a->window);
    XCloseDisplay(a->window.display);
    pthread_mutex_unlock(&contexts_lock);
    return NULL;
}

static void threads(app *a)
{
    const int count = load(a, 64);
    pthread_t *all = calloc((size_t)count, sizeof *all);
    app *apps = calloc((size_t)count, sizeof *apps);
    for (int i = 0; i < count; i++) {
        apps[i] = *a;
        apps[i].complaints = 0;
        apps[i].yaw = a->yaw + 5.0 * i;
        app_check(a, pthread_create(&all[i], NULL, thread, &apps[i]) == 0, "thread %d", i);
    }
    for (int i = 0; i < count; i++) {
        pthread_join(all[i], NULL);
        a->complaints += apps[i].complaints;
    }
    free(all);
    free(apps);
}

static void draw(app *a)
{
    if (is_mode(a, "draws")) {
        app_clear();
        draws(a);
        return;
    }
    if (is_mode(a, "threads") && a->frame == 0)
        threads(a);
    fixed_cube(a);
    if (is_mode(a, "contexts"))
        contexts(a);
}

int main(int argc, char **argv)
{
    static const app_program self = {"load", API_GL_COMPATIBILITY, 0, 0, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
