/* Where the cube's shader gets its matrix, by the options. */
#ifndef APPS_VULKAN_MATRIX_KINDS_H
#define APPS_VULKAN_MATRIX_KINDS_H

#include "window.h"

enum { SLICE = 256 }; /* distance of two matrices in a block: the largest alignment that a device may require */
enum { AFTER_ADDRESS = 64, BEFORE_MATRIX = 16 }; /* behind an address: its block's matrix, and what is before it */

/* Whether the shader has an address of the matrix. */
bool has_address(void);
/* Whether push constants hold the matrix, or its address. */
bool has_push(void);
/* Whether the matrix is an attribute of instances. */
bool of_instances(void);
/* Whether the matrix is an attribute. */
bool has_attribute(void);
/* Whether commands write the matrix to memory of the device. */
bool copies(void);
/* Size of a block: that of its matrices, or more than Cupola stores of a copy. */
VkDeviceSize block_size(void);
/* Vertex input with the matrix; null if it is no attribute. */
const VkPipelineVertexInputStateCreateInfo *matrix_input(void);
/* Address of what a shader reads of a block from `offset` on. */
VkDeviceAddress address_of_matrix(const vulkan_window *w, const block *from, uint32_t offset);

#endif
