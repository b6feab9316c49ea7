#include "matrix_kinds.h"

#include "options.h"

bool has_address(void)
{
    return options.matrix >= MATRIX_ADDRESS && options.matrix <= MATRIX_ADDRESS_SUM;
}

bool has_push(void)
{
    return options.matrix == MATRIX_PUSH || options.matrix == MATRIX_ADDRESS || options.matrix == MATRIX_ADDRESS_SUM;
}

bool of_instances(void)
{
    return options.matrix == MATRIX_INSTANCE || options.matrix == MATRIX_INSTANCE_COPIED;
}

bool has_attribute(void)
{
    return of_instances() || options.matrix == MATRIX_VERTICES;
}

bool copies(void)
{
    return options.matrix == MATRIX_COPIED || options.matrix == MATRIX_LARGE || options.matrix == MATRIX_FILLED ||
           options.matrix == MATRIX_INSTANCE_COPIED;
}

VkDeviceSize block_size(void)
{
    return options.matrix == MATRIX_LARGE ? 1 << 17 : 3 * SLICE;
}

const VkPipelineVertexInputStateCreateInfo *matrix_input(void)
{
    static VkVertexInputBindingDescription instances;
    static VkVertexInputAttributeDescription columns[4];
    static const VkPipelineVertexInputStateCreateInfo input = {
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO,
        .vertexBindingDescriptionCount = 1,
        .pVertexBindingDescriptions = &instances,
        .vertexAttributeDescriptionCount = 4,
        .pVertexAttributeDescriptions = columns};
    const bool each = of_instances();
    instances = (VkVertexInputBindingDescription){1, each ? SLICE : 0,
                                                  each ? VK_VERTEX_INPUT_RATE_INSTANCE : VK_VERTEX_INPUT_RATE_VERTEX};
    for (uint32_t i = 0; i < 4; i++)
        columns[i] = (VkVertexInputAttributeDescription){3 + i, 1, VK_FORMAT_R32G32B32A32_SFLOAT, 16 * i};
    return has_attribute() ? &input : NULL;
}

VkDeviceAddress address_of_matrix(const vulkan_window *w, const block *from, uint32_t offset)
{
    const VkBufferDeviceAddressInfo info = {.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO, .buffer = from->buffer};
    return vkGetBufferDeviceAddress(w->device, &info) + offset + AFTER_ADDRESS - BEFORE_MATRIX;
}
