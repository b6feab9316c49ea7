/*
 * An LD_PRELOAD library behind that of the virtual clock, which finds the function here in the place of libc's. The
 * clock calls it between the calls of the system that make one wait, and with its list of timers locked.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <sys/timerfd.h>

/* What the program does at each call of the function. */
void (*beside_call)(void);
/* A lock as other libraries have, which they take when the process is copied. */
pthread_mutex_t beside_lock = PTHREAD_MUTEX_INITIALIZER;
/* True when a copy has begun. */
atomic_bool beside_forks;

int timerfd_gettime(int timer, struct itimerspec *time)
{
    int (*next)(int, struct itimerspec *);
    *(void **)&next = dlsym(RTLD_NEXT, "timerfd_gettime");
    if (beside_call)
        beside_call();
    return next(timer, time);
}

static void before(void)
{
    beside_forks = true;
    pthread_mutex_lock(&beside_lock);
}

static void after(void)
{
    pthread_mutex_unlock(&beside_lock);
}

/* This library begins before that of the clock, which lies in front of it. So its lock is taken last. */
__attribute__((constructor)) static void begin(void)
{
    pthread_atfork(before, after, after);
}
