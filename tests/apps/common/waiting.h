/* Programs that draw until a test has seen what it waits for. */
#ifndef APPS_WAITING_H
#define APPS_WAITING_H

#include <stdbool.h>

/* To be called after a frame: whether it is one of the program's frames, and not one of those before. Those are drawn, with
 * pauses, until there is a file `end` in the folder that the variable APP_WAIT names; the program writes a file `begun` there
 * when it has drawn some. */
bool frame_counts(void);

#endif
