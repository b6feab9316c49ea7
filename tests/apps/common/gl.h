/* The GL header of the dialect that is being compiled: APP_GLES is 2, 3 or (desktop GL) undefined. */
#ifndef APPS_GL_H
#define APPS_GL_H

#if !defined(APP_GLES)
#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
#include <GL/glext.h>
#elif APP_GLES == 2
#include <GLES2/gl2.h>
#else
#include <GLES3/gl3.h>
#endif

#endif
