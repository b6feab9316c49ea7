/* An OpenGL 3.3 core context without a window. */
#ifndef APPS_SURFACELESS_H
#define APPS_SURFACELESS_H

/* Creates a context and makes it current. Ends the program if that fails. */
void surfaceless_open(void);

#endif
