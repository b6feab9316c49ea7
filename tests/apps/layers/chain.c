/* The entry points of the layers, and their places in the loader's chains. */
#include "layer.h"

#include <string.h>

struct layer above, below;

static VkResult make_instance(struct layer *layer, const VkInstanceCreateInfo *info, const VkAllocationCallbacks *allocator,
                              VkInstance *made)
{
    const VkLayerInstanceCreateInfo *at = info->pNext;
    while (at != NULL && !(at->sType == VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO && at->function == VK_LAYER_LINK_INFO))
        at = at->pNext;
    if (at == NULL)
        return VK_ERROR_INITIALIZATION_FAILED;
    VkLayerInstanceCreateInfo *link = (VkLayerInstanceCreateInfo *)at;
    layer->instance = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    PFN_vkCreateInstance next = (PFN_vkCreateInstance)layer->instance(VK_NULL_HANDLE, "vkCreateInstance");
    return next(info, allocator, made);
}

static VkResult make_device(struct layer *layer, VkPhysicalDevice physical, const VkDeviceCreateInfo *info,
                            const VkAllocationCallbacks *allocator, VkDevice *made)
{
    const VkLayerDeviceCreateInfo *at = info->pNext;
    while (at != NULL && !(at->sType == VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO && at->function == VK_LAYER_LINK_INFO))
        at = at->pNext;
    if (at == NULL)
        return VK_ERROR_INITIALIZATION_FAILED;
    VkLayerDeviceCreateInfo *link = (VkLayerDeviceCreateInfo *)at;
    PFN_vkGetInstanceProcAddr instance = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
    layer->device = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
    link->u.pLayerInfo = link->u.pLayerInfo->pNext;
    PFN_vkCreateDevice next = (PFN_vkCreateDevice)instance(VK_NULL_HANDLE, "vkCreateDevice");
    VkDeviceCreateInfo changed = *info;
    if (layer == &below)
        take_barrier_of_device(&changed);
    return next(physical, &changed, allocator, made);
}

/* Functions of one layer. `NAME`_negotiate is named in the layer's description. */
#define LAYER(NAME, NOTE) \
    static PFN_vkVoidFunction NAME##_instance_address(VkInstance instance, const char *name); \
    static PFN_vkVoidFunction NAME##_device_address(VkDevice device, const char *name); \
    static VkResult NAME##_make_instance(const VkInstanceCreateInfo *info, const VkAllocationCallbacks *allocator, \
                                         VkInstance *made) \
    { \
        NOTE("vkCreateInstance"); \
        return make_instance(&NAME, info, allocator, made); \
    } \
    static VkResult NAME##_make_device(VkPhysicalDevice physical, const VkDeviceCreateInfo *info, \
                                       const VkAllocationCallbacks *allocator, VkDevice *made) \
    { \
        NOTE("vkCreateDevice"); \
        return make_device(&NAME, physical, info, allocator, made); \
    } \
    static PFN_vkVoidFunction NAME##_own(const char *name) \
    { \
        if (strcmp(name, "vkGetInstanceProcAddr") == 0) \
            return (PFN_vkVoidFunction)NAME##_instance_address; \
        if (strcmp(name, "vkGetDeviceProcAddr") == 0) \
            return (PFN_vkVoidFunction)NAME##_device_address; \
        if (strcmp(name, "vkCreateInstance") == 0) \
            return (PFN_vkVoidFunction)NAME##_make_instance; \
        return strcmp(name, "vkCreateDevice") == 0 ? (PFN_vkVoidFunction)NAME##_make_device : NULL; \
    } \
    static PFN_vkVoidFunction NAME##_instance_address(VkInstance instance, const char *name) \
    { \
        const PFN_vkVoidFunction own = NAME##_own(name); \
        if (own != NULL || instance == VK_NULL_HANDLE) \
            return own; \
        const PFN_vkVoidFunction next = NAME.instance(instance, name); \
        const bool told = strncmp(name, "vkGetPhysicalDevice", 19) == 0 \
            || strcmp(name, "vkEnumerateDeviceExtensionProperties") == 0; \
        return told ? with_stub(&NAME, name, next) : next; \
    } \
    static PFN_vkVoidFunction NAME##_device_address(VkDevice device, const char *name) \
    { \
        const PFN_vkVoidFunction own = NAME##_own(name); \
        return own != NULL ? own : with_stub(&NAME, name, NAME.device(device, name)); \
    } \
    VKAPI_ATTR VkResult VKAPI_CALL NAME##_negotiate(VkNegotiateLayerInterface *interface); \
    VKAPI_ATTR VkResult VKAPI_CALL NAME##_negotiate(VkNegotiateLayerInterface *interface) \
    { \
        interface->loaderLayerInterfaceVersion = 2; \
        interface->pfnGetInstanceProcAddr = NAME##_instance_address; \
        interface->pfnGetDeviceProcAddr = NAME##_device_address; \
        interface->pfnGetPhysicalDeviceProcAddr = NULL; \
        return VK_SUCCESS; \
    }

#define NOTHING(name)

LAYER(above, note_program_call)
LAYER(below, NOTHING)
