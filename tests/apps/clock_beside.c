/*
 * Uses timers that are files, under the virtual clock and beside a library (preload/beside.c) by which something
 * happens at the worst moment. With an argument the program does only this part. One that hangs is ended.
 */
#define _GNU_SOURCE
#include "common/clock.h"
#include <dlfcn.h>
#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <sched.h>
#include <semaphore.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/select.h>
#include <sys/timerfd.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static int timer, epoll;
static int calls;
static volatile sig_atomic_t signals;

/* A name of the library, or of this program if it is missing. */
static void *beside(const char *name)
{
    static void *nothing[8];
    void *found = dlsym(RTLD_DEFAULT, name);
    check(found, "the library beside the clock is missing");
    return found ? found : nothing;
}

static void at_each_call(void (*what)(void))
{
    calls = 0;
    *(void (**)(void))beside("beside_call") = what;
}

static void count(int signal)
{
    (void)signal;
    signals++;
}

/* Sends one signal while no call of the system waits. */
static void interrupt(void)
{
    if (++calls == 5)
        raise(SIGUSR1);
}

static int by_poll(void)
{
    struct pollfd asked = {timer, POLLIN, 0};
    return poll(&asked, 1, -1);
}

static int by_ppoll(void)
{
    struct pollfd asked = {timer, POLLIN, 0};
    sigset_t none;
    sigemptyset(&none);
    return ppoll(&asked, 1, NULL, &none);
}

static int by_select(void)
{
    fd_set files;
    FD_ZERO(&files);
    FD_SET(timer, &files);
    return select(timer + 1, &files, NULL, NULL, NULL);
}

static int by_epoll(void)
{
    struct epoll_event event;
    return epoll_wait(epoll, &event, 1, -1);
}

static int by_read(void)
{
    uint64_t expired;
    return (int)read(timer, &expired, sizeof expired);
}

static const struct {
    const char *name;
    int (*wait)(void);
} WAITS[] = {
    {"poll", by_poll}, {"ppoll", by_ppoll}, {"select", by_select}, {"epoll_wait", by_epoll}, {"read", by_read},
};

/* A signal ends a wait also between the calls of the system that the wait makes. */
static void interrupted(void)
{
    struct sigaction action = {.sa_handler = count};
    sigaction(SIGUSR1, &action, NULL);
    timer = timerfd_create(CLOCK_MONOTONIC, 0);
    epoll = epoll_create1(0);
    struct epoll_event event = {.events = EPOLLIN};
    epoll_ctl(epoll, EPOLL_CTL_ADD, timer, &event);
    for (size_t i = 0; i < sizeof WAITS / sizeof *WAITS; i++) {
        printf("%s\n", WAITS[i].name);
        signals = 0;
        at_each_call(interrupt);
        check(WAITS[i].wait() == -1 && errno == EINTR, "a signal ends a wait");
        at_each_call(NULL);
        check(signals == 1, "its handler has run");
    }
    sigset_t mask;
    pthread_sigmask(SIG_BLOCK, NULL, &mask);
    check(!sigismember(&mask, SIGUSR1) && !sigismember(&mask, SIGTERM), "the mask of signals is as before");
}

static int status_of(pid_t child)
{
    int status = 1;
    while (waitpid(child, &status, 0) == -1 && errno == EINTR)
        ;
    return status;
}

static sem_t ready;

/* Uses a timer with the lock of the other library, which the copy of the process waits for. */
static void *holds_the_lock(void *unused)
{
    pthread_mutex_t *lock = beside("beside_lock");
    atomic_bool *forks = beside("beside_forks");
    pthread_mutex_lock(lock);
    sem_post(&ready);
    while (!*forks)
        sched_yield();
    close(timerfd_create(CLOCK_MONOTONIC, 0));
    pthread_mutex_unlock(lock);
    return unused;
}

/* Locks of other libraries are taken in any order when the process is copied. */
static void locked(void)
{
    pthread_t thread;
    sem_init(&ready, 0, 0);
    *(atomic_bool *)beside("beside_forks") = false;
    pthread_create(&thread, NULL, holds_the_lock, NULL);
    sem_wait(&ready);
    pid_t child = fork();
    if (child == 0)
        _exit(0);
    check(status_of(child) == 0, "a copy of the process ends");
    pthread_join(thread, NULL);
}

static sem_t released;
static pthread_t busy;

/* Stays in a call of the clock that has its list of timers locked. */
static void stay(void)
{
    if (pthread_equal(pthread_self(), busy) && calls++ == 0) {
        sem_post(&ready);
        sem_wait(&released);
    }
}

static void *uses_a_timer(void *unused)
{
    busy = pthread_self();
    at_each_call(stay);
    struct itimerspec time;
    timerfd_gettime(timer, &time);
    return unused;
}

/* The lists of the clock are locked while the process is copied. */
static void copied(void)
{
    pthread_t thread;
    sem_init(&ready, 0, 0);
    sem_init(&released, 0, 0);
    timer = timerfd_create(CLOCK_MONOTONIC, 0);
    pthread_create(&thread, NULL, uses_a_timer, NULL);
    sem_wait(&ready);
    pid_t child = fork();
    if (child == 0) {
        alarm(10);
        double before = now();
        int own = timerfd_create(CLOCK_MONOTONIC, 0);
        struct itimerspec soon = {{0, 0}, {0, 10000000}};
        uint64_t expired = 0;
        timerfd_settime(own, 0, &soon, NULL);
        bool good = read(own, &expired, sizeof expired) == sizeof expired && expired == 1;
        pid_t second = fork();
        if (second == 0)
            _exit(timerfd_settime(own, 0, &soon, NULL) == 0 ? 0 : 1);
        _exit(good && now() - before > 0.009 && status_of(second) == 0 ? 0 : 1);
    }
    check(status_of(child) == 0, "a copy of the process uses timers");
    sem_post(&released);
    pthread_join(thread, NULL);
    at_each_call(NULL);
}

static const struct {
    const char *name;
    void (*run)(void);
} PARTS[] = {
    {"interrupted", interrupted}, {"locked", locked}, {"copied", copied},
};

int main(int count, char **arguments)
{
    setvbuf(stdout, NULL, _IOLBF, 0);
    alarm(20);
    for (size_t part = 0; part < sizeof PARTS / sizeof *PARTS; part++)
        if (count < 2 || strcmp(arguments[1], PARTS[part].name) == 0)
            PARTS[part].run();
    return clock_complaints() > 0;
}
