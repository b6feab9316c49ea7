/* Declarations that the files of the two layers in faults.c share. */
#ifndef LAYER_H
#define LAYER_H

#include <stdbool.h>
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

/* A layer: the functions of the next layer. */
struct layer {
    PFN_vkGetInstanceProcAddr instance;
    PFN_vkGetDeviceProcAddr device;
};

extern struct layer above, below;

/* Notes that the program calls a function that has no stub. */
void note_program_call(const char *name);

/* Function of the next layer as this layer returns it. NULL if it is missing. */
PFN_vkVoidFunction with_stub(const struct layer *layer, const char *name, PFN_vkVoidFunction target);

/* Function that answers instead of `target`. NULL if `target` itself answers. */
void *liar(const char *kind, const char *name, void *target);

/* Sets the false answer: the name of a limit and its value, or the flags that remain. */
void set_lie(const char *name, long value);

/* The same for a driver with VK_NV_present_barrier, whose windows may join if `value` is not 0. */
void *barrier_liar(const char *name, void *target, long value);

/* Take what Cupola added for a present barrier out of its structures. The second returns whether the window joins. */
void take_barrier_of_device(VkDeviceCreateInfo *info);
bool take_barrier_of_swapchain(VkSwapchainCreateInfoKHR *info);

#endif
