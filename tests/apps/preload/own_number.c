/*
 * Library that asks for the number of its process. The virtual clock decides by the library's name what it answers.
 */
#include <unistd.h>

int number_of_library(void);

int number_of_library(void)
{
    return getpid();
}
