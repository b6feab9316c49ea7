/* How much memory a program has. */
#ifndef APPS_VULKAN_MEMORY_H
#define APPS_VULKAN_MEMORY_H

/* Appends a line to a file: the resident memory of this process, in pages. Ends the program where that cannot be. */
void write_memory(const char *path);

#endif
