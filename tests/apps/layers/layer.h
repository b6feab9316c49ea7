/* The two layers of faults.c: what their files share. */
#ifndef LAYER_H
#define LAYER_H

#include <stdbool.h>
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

/* A layer, and the next one's functions. */
struct layer {
    PFN_vkGetInstanceProcAddr instance;
    PFN_vkGetDeviceProcAddr device;
};

extern struct layer above, below;

/* The program calls a function that has no stub. */
void note_program_call(const char *name);

/* A function of the next layer as this layer hands it out; NULL where it is missing. */
PFN_vkVoidFunction with_stub(const struct layer *layer, const char *name, PFN_vkVoidFunction target);

/* What answers in the place of `target`; NULL: it answers itself. */
void *liar(const char *kind, const char *name, void *target);

/* What the liars say: the name of a limit and its value, or the flags that are left. */
void set_lie(const char *name, long value);

#endif
