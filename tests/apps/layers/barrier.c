/* A driver with VK_NV_present_barrier: what arrives of Cupola is written to stderr, and taken out again. */
#include "layer.h"

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

static void *ask_extensions, *ask_surface;
static VkBool32 lets_join;

/* Returns the place of the pointer to a structure in a chain, or NULL. */
static VkBaseInStructure **find(const void **chain, VkStructureType type)
{
    VkBaseInStructure **at = (VkBaseInStructure **)(uintptr_t)chain;
    while (*at != NULL && (*at)->sType != type)
        at = (VkBaseInStructure **)(uintptr_t)&(*at)->pNext;
    return *at == NULL ? NULL : at;
}

static VkResult tell_extensions(VkPhysicalDevice device, const char *layer, uint32_t *number, VkExtensionProperties *told)
{
    const uint32_t room = *number;
    const VkResult result = ((PFN_vkEnumerateDeviceExtensionProperties)ask_extensions)(device, layer, number, told);
    if (told != NULL && *number < room)
        memcpy(told[*number].extensionName, VK_NV_PRESENT_BARRIER_EXTENSION_NAME, sizeof VK_NV_PRESENT_BARRIER_EXTENSION_NAME);
    ++*number;
    return result;
}

static VkResult tell_surface(VkPhysicalDevice device, const VkPhysicalDeviceSurfaceInfo2KHR *surface,
                             VkSurfaceCapabilities2KHR *told)
{
    VkBaseInStructure **barrier = find((const void **)&told->pNext, VK_STRUCTURE_TYPE_SURFACE_CAPABILITIES_PRESENT_BARRIER_NV);
    if (barrier != NULL) {
        ((VkSurfaceCapabilitiesPresentBarrierNV *)*barrier)->presentBarrierSupported = lets_join;
        *barrier = (VkBaseInStructure *)(uintptr_t)(*barrier)->pNext;
    }
    return ((PFN_vkGetPhysicalDeviceSurfaceCapabilities2KHR)ask_surface)(device, surface, told);
}

void *barrier_liar(const char *name, void *target, long value)
{
    lets_join = value != 0;
    if (strcmp(name, "vkEnumerateDeviceExtensionProperties") == 0) {
        ask_extensions = target;
        return (void *)(intptr_t)tell_extensions;
    }
    if (strcmp(name, "vkGetPhysicalDeviceSurfaceCapabilities2KHR") == 0) {
        ask_surface = target;
        return (void *)(intptr_t)tell_surface;
    }
    return NULL;
}

void take_barrier_of_device(VkDeviceCreateInfo *info)
{
    static const char *names[64];
    VkBaseInStructure **features = find(&info->pNext, VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PRESENT_BARRIER_FEATURES_NV);
    uint32_t number = 0;
    if (info->enabledExtensionCount > sizeof names / sizeof names[0])
        return;
    for (uint32_t i = 0; i < info->enabledExtensionCount; i++)
        if (strcmp(info->ppEnabledExtensionNames[i], VK_NV_PRESENT_BARRIER_EXTENSION_NAME) != 0)
            names[number++] = info->ppEnabledExtensionNames[i];
    if (number < info->enabledExtensionCount && features != NULL
        && ((VkPhysicalDevicePresentBarrierFeaturesNV *)*features)->presentBarrier) {
        fprintf(stderr, "barrier: device\n");
        *features = (VkBaseInStructure *)(uintptr_t)(*features)->pNext;
    }
    info->ppEnabledExtensionNames = names;
    info->enabledExtensionCount = number;
}

bool take_barrier_of_swapchain(VkSwapchainCreateInfoKHR *info)
{
    VkBaseInStructure **barrier = find(&info->pNext, VK_STRUCTURE_TYPE_SWAPCHAIN_PRESENT_BARRIER_CREATE_INFO_NV);
    const bool joins = barrier != NULL && ((VkSwapchainPresentBarrierCreateInfoNV *)*barrier)->presentBarrierEnable;
    fprintf(stderr, "barrier: swapchain %d\n", joins);
    if (barrier != NULL)
        *barrier = (VkBaseInStructure *)(uintptr_t)(*barrier)->pNext;
    return joins;
}
