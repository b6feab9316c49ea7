/* False answers about the device for Cupola. */
#include "layer.h"

#include <stddef.h>
#include <stdint.h>
#include <string.h>

static struct {
    const char *name;
    long value;
} lie;

/* Function of the driver that a false answer replaces. */
static void *asked;

void set_lie(const char *name, long value)
{
    lie.name = name;
    lie.value = value;
}

#define LIMIT(field) {#field, offsetof(VkPhysicalDeviceLimits, field), sizeof(((VkPhysicalDeviceLimits *)0)->field)}

static const struct {
    const char *name;
    size_t offset, size;
} limits[] = {LIMIT(maxImageDimension2D),
              LIMIT(maxImageArrayLayers),
              LIMIT(maxFramebufferWidth),
              LIMIT(maxFramebufferHeight),
              LIMIT(maxBoundDescriptorSets),
              LIMIT(maxPushConstantsSize),
              LIMIT(maxUniformBufferRange),
              LIMIT(maxMemoryAllocationCount),
              LIMIT(maxPerStageDescriptorSamplers),
              LIMIT(maxDescriptorSetUniformBuffersDynamic),
              LIMIT(maxViewports),
              LIMIT(minUniformBufferOffsetAlignment),
              LIMIT(minStorageBufferOffsetAlignment),
              LIMIT(nonCoherentAtomSize),
              LIMIT(timestampPeriod)};

static void tell_properties(VkPhysicalDevice device, VkPhysicalDeviceProperties *told)
{
    ((PFN_vkGetPhysicalDeviceProperties)asked)(device, told);
    for (size_t i = 0; i < sizeof limits / sizeof limits[0]; i++)
        if (strcmp(limits[i].name, lie.name) == 0)
            memcpy((char *)&told->limits + limits[i].offset, &lie.value, limits[i].size);
    if (strcmp(lie.name, "apiVersion") == 0)
        told->apiVersion = (uint32_t)lie.value;
    if (strcmp(lie.name, "deviceName") == 0)
        memset(told->deviceName, (int)lie.value, sizeof told->deviceName);
}

static void tell_memory(VkPhysicalDevice device, VkPhysicalDeviceMemoryProperties *told)
{
    ((PFN_vkGetPhysicalDeviceMemoryProperties)asked)(device, told);
    for (uint32_t i = 0; i < told->memoryTypeCount; i++)
        told->memoryTypes[i].propertyFlags &= (VkMemoryPropertyFlags)lie.value;
    if (lie.value == 0)
        told->memoryTypeCount = 0;
}

static void tell_queues(VkPhysicalDevice device, uint32_t *number, VkQueueFamilyProperties *told)
{
    ((PFN_vkGetPhysicalDeviceQueueFamilyProperties)asked)(device, number, told);
    for (uint32_t i = 0; told != NULL && i < *number; i++) {
        told[i].queueFlags &= (VkQueueFlags)lie.value;
        told[i].timestampValidBits = 0;
    }
}

static void tell_format(VkPhysicalDevice device, VkFormat format, VkFormatProperties *told)
{
    ((PFN_vkGetPhysicalDeviceFormatProperties)asked)(device, format, told);
    told->optimalTilingFeatures &= (VkFormatFeatureFlags)lie.value;
}

static VkResult tell_surface(VkPhysicalDevice device, VkSurfaceKHR surface, VkSurfaceCapabilitiesKHR *told)
{
    const VkResult result = ((PFN_vkGetPhysicalDeviceSurfaceCapabilitiesKHR)asked)(device, surface, told);
    told->supportedUsageFlags &= (VkImageUsageFlags)lie.value;
    return result;
}

static void tell_features(VkPhysicalDevice device, VkPhysicalDeviceFeatures *told)
{
    ((PFN_vkGetPhysicalDeviceFeatures)asked)(device, told);
    memset(told, 0, sizeof *told);
}

void *liar(const char *kind, const char *name, void *target)
{
    const struct {
        const char *kind, *name;
        void *answer;
    } liars[] = {{"limit", "vkGetPhysicalDeviceProperties", (void *)(intptr_t)tell_properties},
                 {"memory", "vkGetPhysicalDeviceMemoryProperties", (void *)(intptr_t)tell_memory},
                 {"queues", "vkGetPhysicalDeviceQueueFamilyProperties", (void *)(intptr_t)tell_queues},
                 {"formats", "vkGetPhysicalDeviceFormatProperties", (void *)(intptr_t)tell_format},
                 {"surface", "vkGetPhysicalDeviceSurfaceCapabilitiesKHR", (void *)(intptr_t)tell_surface},
                 {"features", "vkGetPhysicalDeviceFeatures", (void *)(intptr_t)tell_features}};
    if (strcmp(kind, "barrier") == 0)
        return barrier_liar(name, target, lie.value);
    for (size_t i = 0; i < sizeof liars / sizeof liars[0]; i++) {
        if (strcmp(liars[i].kind, kind) == 0 && strcmp(liars[i].name, name) == 0) {
            asked = target;
            return liars[i].answer;
        }
    }
    return NULL;
}
