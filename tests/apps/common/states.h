/* Every kind of state of a core 3.3 context: sets it to unusual values and checks that it stays. */
#ifndef APPS_STATES_H
#define APPS_STATES_H

enum { STATES_ROOM = 96 };

typedef struct {
    float values[STATES_ROOM][4];
} states;

/* Sets all but the bindings of programs, vertex arrays and framebuffers, for a picture of this size. */
void states_make_unusual(int width, int height);

/* Reads all state. */
states states_take(void);

/* Reads all state again, prints the differences and returns their number. */
int states_compare(const states *before, const char *when);

#endif
