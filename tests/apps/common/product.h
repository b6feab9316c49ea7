/* A core 3.3 program with a single model-view-projection uniform. */
#ifndef APPS_PRODUCT_H
#define APPS_PRODUCT_H

#include "app.h"

/* Builds it; positions are attribute 0, colours attribute 1. */
void product_program(void);

/* Gives it the app's matrices. */
void product_matrices(const app *a);

#endif
