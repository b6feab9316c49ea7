/*
 * Checks of programs that run under the virtual clock.
 */
#ifndef COMMON_CLOCK_H
#define COMMON_CLOCK_H

#include <stdbool.h>

/* The monotonic clock, in seconds. */
double now(void);

/* Complains unless `good`. */
void check(bool good, const char *what);

/* Checks that exactly this time has passed since `before`. */
void passed(double before, double seconds, const char *what);

/* Number of complaints so far. */
int clock_complaints(void);

#endif
