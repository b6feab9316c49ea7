/* A core 3.3 program with a single model-view-projection uniform. */
#ifndef APPS_PRODUCT_H
#define APPS_PRODUCT_H

#include "app.h"

/* Builds the program. Positions are attribute 0, colours attribute 1. */
void product_program(void);

/* Sets the matrices of the app. */
void product_matrices(const app *a);

#endif
