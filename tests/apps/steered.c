/*
 * Reacts to keyboard and mouse: the arrow keys turn the camera at each press, the key w as long as
 * it is held. The pointer tilts the camera while the first button is down. The program writes the
 * events of each frame to a file.
 */
#include "common/fixed.h"

#include <X11/Xutil.h>
#include <X11/keysym.h>
#include <stdio.h>

static bool is_held;
static int button;

static void setup(app *a)
{
    XSelectInput(a->window.display, a->window.window,
                 StructureNotifyMask | KeyPressMask | KeyReleaseMask | ButtonPressMask | ButtonReleaseMask |
                     PointerMotionMask | FocusChangeMask);
}

static void key(app *a, XKeyEvent *event, FILE *file)
{
    KeySym symbol = XLookupKeysym(event, 0);
    bool is_down = event->type == KeyPress;
    fprintf(file, "%d %s %s\n", a->frame, is_down ? "press" : "release", XKeysymToString(symbol));
    if (symbol == XK_w)
        is_held = is_down;
    else if (symbol == XK_Left && is_down)
        a->yaw -= 15;
    else if (symbol == XK_Right && is_down)
        a->yaw += 15;
}

static void draw(app *a)
{
    FILE *file = fopen(a->answers ? a->answers : "/dev/null", "a");
    app_check(a, file != NULL, "the events cannot be written");
    while (file && XPending(a->window.display) > 0) {
        XEvent event;
        XNextEvent(a->window.display, &event);
        if (event.type == KeyPress || event.type == KeyRelease) {
            key(a, &event.xkey, file);
        } else if (event.type == ButtonPress || event.type == ButtonRelease) {
            button = event.type == ButtonPress ? (int)event.xbutton.button : 0;
            fprintf(file, "%d button %d\n", a->frame, button);
        } else if (event.type == MotionNotify) {
            fprintf(file, "%d at %d %d\n", a->frame, event.xmotion.x, event.xmotion.y);
            if (button == 1)
                a->pitch = 60.0 * event.xmotion.y / a->window.height - 30.0;
        }
    }
    if (file)
        fclose(file);
    if (is_held)
        a->yaw += 1;
    app_update_matrices(a);
    fixed_cube(a);
}

int main(int argc, char **argv)
{
    static const app_program self = {"steered", API_GL_COMPATIBILITY, 0, 0, setup, draw, NULL};
    return app_main(argc, argv, &self);
}
