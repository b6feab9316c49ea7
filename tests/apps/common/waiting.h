/* Functions for programs that draw until a test has noticed a change. */
#ifndef APPS_WAITING_H
#define APPS_WAITING_H

#include <stdbool.h>

/*
 * To be called after each frame. Returns whether the frame counts as one of the program's frames.
 * Frames before that do not count: the program draws them, with pauses, until the file `end` exists
 * in the folder that the variable APP_WAIT names. It writes the file `begun` there after some of
 * these frames.
 */
bool frame_counts(void);

#endif
