/*
 * The gears of `gears_plain.c` on a dome: the same window, shader and scene. What Cupola adds is marked.
 *
 * Build: cc -std=c99 -o gears_dome gears_dome.c gears_scene.c -I../../include -L../../target/release -lcupola \
 *        $(pkg-config --cflags --libs glfw3) -lGL -lm
 * Run:   gears_dome [FRAMES [RIG]]     (0 or nothing: until the window is closed; RIG: a preset or a file)
 */
#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
#include <GL/glext.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "gears_scene.h"

#include <cupola.h> /* Cupola */

#include <stdio.h>
#include <stdlib.h>

/* Cupola: prints the error, if there is one. */
static int good(cupola_status status)
{
    char detail[512];
    if (status == CUPOLA_OK)
        return 1;
    cupola_last_error(detail, sizeof detail, NULL);
    fprintf(stderr, "Cupola: %s\n", detail);
    return 0;
}

/* Cupola: data for the drawing of a view. */
typedef struct {
    const scene *gears;
    double seconds;
} moment;

/* Cupola: the part of the plain program's loop that draws, called once for each view. */
static void draw(const cupola_gl_view *view, void *user)
{
    const moment *now = user;
    float camera[16];
    scene_camera(camera);
    scene_draw(now->gears, now->seconds, camera, view->projection_matrix);
}

int main(int argc, char **argv)
{
    long frames = argc > 1 ? strtol(argv[1], NULL, 10) : 0;
    if (!glfwInit()) {
        fprintf(stderr, "GLFW cannot be initialised\n");
        return 1;
    }
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    GLFWwindow *window = glfwCreateWindow(640, 640, "gears", NULL, NULL);
    if (window == NULL) {
        fprintf(stderr, "a window with OpenGL 3.3 cannot be opened\n");
        glfwTerminate();
        return 1;
    }
    glfwMakeContextCurrent(window);

    /* Cupola */
    cupola_rig *rig = NULL;
    cupola_gl *dome = NULL;
    cupola_gl_options options = {sizeof options, glfwGetProcAddress, 640, 640};
    int ready = good(cupola_rig_load(argc > 2 ? argv[2] : "fisheye", &rig)) && good(cupola_gl_create(rig, &options, &dome));
    cupola_rig_free(rig);

    scene gears;
    if (!ready || !scene_create(&gears)) {
        glfwTerminate();
        return 1;
    }
    int status = 0;
    for (long frame = 0; !glfwWindowShouldClose(window) && (frames == 0 || frame < frames); frame++) {
        int width, height;
        glfwGetFramebufferSize(window, &width, &height);

        /* Cupola: replaces the camera, the viewport and the call of scene_draw. */
        moment now = {&gears, glfwGetTime()};
        if (width > 0 && height > 0 && !(good(cupola_gl_resize(dome, (uint32_t)width, (uint32_t)height)) &&
                                         good(cupola_gl_draw_frame(dome, 1.0, 100.0, draw, &now, 0, 0, 0)))) {
            status = 1;
            break;
        }
        glfwSwapBuffers(window);
        glfwPollEvents();
    }
    cupola_gl_destroy(dome); /* Cupola */
    scene_destroy(&gears);
    glfwDestroyWindow(window);
    glfwTerminate();
    return status;
}
