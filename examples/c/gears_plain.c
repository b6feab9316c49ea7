/*
 * Three gears that turn, with GLFW and a core profile, drawn in the usual way: one perspective,
 * one shader, one loop. `gears_dome.c` is the same program with Cupola; compare the two to see what
 * a program has to add.
 *
 * Build: cc -std=c99 -o gears_plain gears_plain.c gears_scene.c $(pkg-config --cflags --libs glfw3) -lGL -lm
 * Run:   gears_plain [FRAMES]     (0 or nothing: until the window is closed)
 */
#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
#include <GL/glext.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include "gears_scene.h"

#include <stdio.h>
#include <stdlib.h>

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

    scene gears;
    if (!scene_create(&gears)) {
        glfwTerminate();
        return 1;
    }
    for (long frame = 0; !glfwWindowShouldClose(window) && (frames == 0 || frame < frames); frame++) {
        int width, height;
        float view[16], projection[16];
        glfwGetFramebufferSize(window, &width, &height);
        scene_camera(view);
        scene_perspective(projection, 60.0f, (float)width / (float)height);

        glViewport(0, 0, width, height);
        scene_draw(&gears, glfwGetTime(), view, projection);

        glfwSwapBuffers(window);
        glfwPollEvents();
    }
    scene_destroy(&gears);
    glfwDestroyWindow(window);
    glfwTerminate();
    return 0;
}
