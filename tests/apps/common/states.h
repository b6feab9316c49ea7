/* Every kind of state of a core 3.3 context: unusual values for it, and whether it is what it was. */
#ifndef APPS_STATES_H
#define APPS_STATES_H

enum { STATES_ROOM = 96 };

typedef struct {
    float values[STATES_ROOM][4];
} states;

/* Sets all but the bindings of programs, vertex arrays and framebuffers, for a picture of this size. */
void states_make_unusual(int width, int height);

/* Asks for everything. */
states states_take(void);

/* Asks again, prints what differs and returns how much that is. */
int states_compare(const states *before, const char *when);

#endif
