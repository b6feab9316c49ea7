/* Memory of a process. */
#ifndef APPS_VULKAN_MEMORY_H
#define APPS_VULKAN_MEMORY_H

#include <sys/types.h>

/*
 * Appends a line to a file: the resident memory of a process, in pages. Ends this program if that
 * fails.
 */
void write_memory(const char *path, pid_t process);

#endif
