#include "probe.h"

void probe(app *a, int x, int y, int red, int green, int blue, const char *what)
{
    unsigned char pixel[4] = {77, 77, 77, 77};
    glReadPixels(x, y, 1, 1, GL_RGBA, GL_UNSIGNED_BYTE, pixel);
    app_check(a, pixel[0] == 255 * red && pixel[1] == 255 * green && pixel[2] == 255 * blue && pixel[3] == 255,
              "%s: (%d, %d) is %d %d %d %d instead of %d %d %d 1", what, x, y, pixel[0], pixel[1], pixel[2], pixel[3],
              red, green, blue);
}
