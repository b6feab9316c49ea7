/* An OpenGL 3.3 core context without a window. */
#ifndef APPS_SURFACELESS_H
#define APPS_SURFACELESS_H

/* Makes one current; ends the program where there is none. */
void surfaceless_open(void);

#endif
