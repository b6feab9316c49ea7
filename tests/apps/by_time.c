/*
 * Moves by time and by random numbers, as programs do. Writes the values that it reads in each
 * frame to a file.
 */
#define _GNU_SOURCE
#include "common/fixed.h"
#include "common/program.h"

#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

static double start, next;
static GLuint program, late;

static double now(void)
{
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return time.tv_sec + time.tv_nsec * 1e-9;
}

static void setup(app *a)
{
    srand((unsigned)(time(NULL) ^ getpid()));
    start = next = now();
    if (a->mode && strcmp(a->mode, "uniform") == 0) {
        static const shader_source stage = {
            GL_FRAGMENT_SHADER, "uniform float number;\nvoid main() { gl_FragColor = vec4(number); }\n"};
        program = program_build(&stage, 1);
    }
}

/* Ways to wait for the next frame. */
static void limit(const char *mode)
{
    if (mode && strcmp(mode, "sleep") == 0) {
        usleep(10000);
    } else if (mode && strcmp(mode, "slides") == 0) {
        usleep(1500000);
    } else if (mode && strcmp(mode, "limit") == 0) {
        next += 1.0 / 30;
        while (now() < next)
            usleep(1000);
    } else if (mode && strcmp(mode, "spin") == 0) {
        next += 1.0 / 30;
        while (now() < next)
            ;
    }
}

static void write_down(app *a, double read)
{
    FILE *file = a->answers ? fopen(a->answers, "a") : NULL;
    if (!file)
        return;
    struct timeval date;
    gettimeofday(&date, NULL);
    unsigned numbers[3] = {0, 0, 0};
    int device = open("/dev/urandom", O_RDONLY);
    if (device < 0 || getrandom(&numbers[0], 4, 0) != 4 || getentropy(&numbers[1], 4) != 0 || read == 0)
        app_check(a, false, "random numbers cannot be read");
    if (device >= 0 && pread(device, &numbers[2], 4, 0) != 4)
        app_check(a, false, "the device of random numbers cannot be read");
    close(device);
    fprintf(file, "%d %.9f %ld.%06ld %ld %ld %d %u %u %u\n", a->frame, read - start, (long)date.tv_sec,
            (long)date.tv_usec, (long)time(NULL), (long)clock(), rand(), numbers[0], numbers[1], numbers[2]);
    fclose(file);
}

/* The processor's counter: a number that no library can intercept. */
static unsigned counter(void)
{
#if defined(__x86_64__)
    return (unsigned)__builtin_ia32_rdtsc();
#elif defined(__aarch64__)
    unsigned long count;
    __asm__ volatile("mrs %0, cntvct_el0" : "=r"(count));
    return (unsigned)count;
#else
    return (unsigned)time(NULL);
#endif
}

static void draw(app *a)
{
    double read = now();
    write_down(a, read);
    a->yaw = fmod((read - start) * 50, 360);
    /* Without random numbers, frames of the same time are equal. */
    bool is_steady = a->mode && strcmp(a->mode, "steady") == 0;
    a->pitch = is_steady ? 5 : rand() % 20 - 10;
    if (a->mode && strcmp(a->mode, "counter") == 0 && a->frame >= 2)
        a->pitch += counter() % 1000 * 1e-3;
    if (program && a->frame >= 2) {
        glUseProgram(program);
        glUniform1f(glGetUniformLocation(program, "number"), counter() % 1000 * 1e-3f);
        glUseProgram(0);
    }
    if (a->mode && strcmp(a->mode, "texture") == 0 && a->frame >= 2) {
        const GLuint pixels[2][2] = {{1, counter()}, {3, 4}};
        glTexImage2D(GL_TEXTURE_2D, 0, GL_RGBA, 2, 2, 0, GL_RGBA, GL_UNSIGNED_BYTE, pixels);
    }
    if (a->mode && strcmp(a->mode, "shader") == 0 && a->frame >= 2) {
        char text[64];
        snprintf(text, sizeof text, "void main() { gl_FragColor = vec4(0.%u); }\n", counter());
        const char *source = text;
        GLuint shader = glCreateShader(GL_FRAGMENT_SHADER);
        glShaderSource(shader, 1, &source, NULL);
        glDeleteShader(shader);
    }
    if (a->mode && strcmp(a->mode, "array") == 0 && a->frame >= 2) {
        const GLfloat corners[3][2] = {{0, 0}, {1, 0}, {0, 1 + counter() % 1000 * 1e-3f}};
        glEnableClientState(GL_VERTEX_ARRAY);
        glVertexPointer(2, GL_FLOAT, 0, corners);
        glDrawArrays(GL_TRIANGLES, 0, 3);
        glDisableClientState(GL_VERTEX_ARRAY);
    }
    if (a->mode && strcmp(a->mode, "vector") == 0 && a->frame >= 2) {
        const GLfloat colour[3] = {counter() % 1000 * 1e-3f, 0, 0};
        glColor3fv(colour);
    }
    if (a->mode && strcmp(a->mode, "light") == 0 && a->frame >= 2) {
        const GLfloat place[4] = {0, counter() % 1000 * 1e-3f, 0, 1};
        glLightfv(GL_LIGHT0, GL_POSITION, place);
    }
    if (a->mode && strcmp(a->mode, "layers") == 0 && a->frame >= 2) {
        const GLuint pixels[2][2][2] = {{{1, 2}, {3, 4}}, {{5, 6}, {7, counter()}}};
        glTexImage3D(GL_TEXTURE_3D, 0, GL_RGBA, 2, 2, 2, 0, GL_RGBA, GL_UNSIGNED_BYTE, pixels);
    }
    /* The driver chooses the names, and Cupola's objects exist by then. */
    if (a->mode && strcmp(a->mode, "late") == 0 && a->frame >= 2) {
        if (late == 0) {
            static const shader_source stage = {
                GL_FRAGMENT_SHADER, "void main() { gl_FragColor = vec4(gl_FragCoord.x * 0.01); }\n"};
            late = program_build(&stage, 1);
        }
        glUseProgram(late);
    }
    app_update_matrices(a);
    fixed_cube(a);
    glUseProgram(0);
    limit(a->mode);
}

int main(int argc, char **argv)
{
    static const app_program self = {"by_time", API_GL_COMPATIBILITY, 0, 0, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
