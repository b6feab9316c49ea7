/*
 * Uses timers that are files, under the virtual clock, and checks the time that passed. The program
 * draws nothing. With an argument it does only this part.
 */
#define _GNU_SOURCE
#include "common/clock.h"
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <stdio.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/select.h>
#include <sys/timerfd.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static int ends[2];

static void set(int timer, long first, long interval)
{
    struct itimerspec times = {{0, interval}, {0, first}};
    check(timerfd_settime(timer, 0, &times, NULL) == 0, "a timer is set");
}

static int timer_of(long first, long interval, int flags)
{
    int timer = timerfd_create(CLOCK_MONOTONIC, flags);
    set(timer, first, interval);
    return timer;
}

static bool readable(int file, int limit)
{
    struct pollfd asked = {file, POLLIN, 0};
    return poll(&asked, 1, limit) == 1 && asked.revents == POLLIN;
}

/* Takes real time, and none of the clock. */
static void real_wait(void)
{
    for (volatile long work = 0; work < 50000000; work++)
        ;
}

static void *writes(void *unused)
{
    real_wait();
    check(write(ends[1], "x", 1) == 1, "the pipe is full");
    return unused;
}

/* Waits for a byte of another thread, for as long as it takes. */
static void receive(const char *what)
{
    double before = now();
    pthread_t thread;
    pthread_create(&thread, NULL, writes, NULL);
    char byte;
    check(readable(ends[0], -1) && read(ends[0], &byte, 1) == 1, what);
    passed(before, 0, what);
    pthread_join(thread, NULL);
}

/* A timer that is closed, or that a wait does not watch, moves no time. */
static void unwatched(void)
{
    int timer = timer_of(5000000, 5000000, 0);
    receive("a wait beside a timer");
    close(timer);
    receive("a wait after a timer was closed");
    timer = timer_of(5000000, 5000000, 0);
    int other[2];
    close(timer);
    check(pipe(other) == 0 && other[0] == timer, "the system takes the number of the timer");
    check(!readable(timer, 20), "a pipe with the number of a timer is empty");
    int epoll = epoll_create1(0);
    struct epoll_event event = {.events = EPOLLIN};
    epoll_ctl(epoll, EPOLL_CTL_ADD, ends[0], &event);
    double before = now();
    pthread_t thread;
    pthread_create(&thread, NULL, writes, NULL);
    check(epoll_wait(epoll, &event, 1, -1) == 1 && read(ends[0], other, 1) == 1, "epoll after a timer was closed");
    passed(before, 0, "epoll after a timer was closed");
    pthread_join(thread, NULL);
}

static void copies(void)
{
    double before = now();
    int timer = timer_of(5000000, 0, 0), copy = dup(timer);
    check(readable(copy, -1), "a copy can be read");
    passed(before, 0.005, "a copy of a timer");
    close(timer);
    set(copy, 5000000, 0);
    int third = fcntl(copy, F_DUPFD_CLOEXEC, 100);
    check(third >= 100 && readable(third, -1), "a copy of a copy can be read");
    passed(before, 0.01, "a copy of a copy");
    int fourth = timer_of(1000000, 0, 0);
    check(dup2(ends[0], fourth) == fourth && !readable(fourth, 20), "a pipe takes the place of a timer");
    passed(before, 0.03, "the place of a timer");
}

static int armed;

static void *arms(void *unused)
{
    real_wait();
    set(armed, 20000000, 0);
    return unused;
}

/* Another thread sets the timer during the wait. */
static void set_meanwhile(void)
{
    armed = timerfd_create(CLOCK_MONOTONIC, 0);
    double before = now();
    pthread_t thread;
    pthread_create(&thread, NULL, arms, NULL);
    check(readable(armed, -1), "a timer that was set meanwhile fires");
    check(now() - before >= 0.02, "time passes until it does");
    pthread_join(thread, NULL);
    int epoll = epoll_create1(0);
    struct epoll_event event = {.events = EPOLLIN};
    set(armed, 0, 0);
    epoll_ctl(epoll, EPOLL_CTL_ADD, armed, &event);
    pthread_create(&thread, NULL, arms, NULL);
    check(epoll_wait(epoll, &event, 1, -1) == 1, "epoll tells of a timer that was set meanwhile");
    pthread_join(thread, NULL);
}

/* Only looks, and never waits. */
static void looks(void)
{
    double before = now();
    int timer = timer_of(2000000, 0, 0);
    while (!readable(timer, 0))
        ;
    check(now() - before >= 0.002, "looks at a timer take time");
    fd_set set_of_files;
    struct timeval none = {0, 0};
    set(timer, 2000000, 0);
    do {
        FD_ZERO(&set_of_files);
        FD_SET(timer, &set_of_files);
    } while (select(timer + 1, &set_of_files, NULL, NULL, &none) == 0);
    check(now() - before >= 0.004, "looks by select take time");
}

/* A copy of the process has a clock of its own, and fires none of the timers. */
static void forked(void)
{
    int timer = timer_of(20000000, 0, 0);
    double before = now();
    pid_t child = fork();
    if (child == 0) {
        usleep(50000);
        _exit(now() - before > 0.049 ? 0 : 1);
    }
    int status = 1;
    check(waitpid(child, &status, 0) == child && status == 0, "a copy of the process sleeps");
    check(!readable(timer, 0), "a copy of the process fires no timer");
    passed(before, 0, "the time of a copy");
    check(readable(timer, -1), "the timer fires later");
    passed(before, 0.02, "a timer beside a copy");
}

static const struct {
    const char *name;
    void (*run)(void);
} PARTS[] = {
    {"unwatched", unwatched}, {"copies", copies}, {"set_meanwhile", set_meanwhile},
    {"looks", looks},         {"forked", forked},
};

int main(int count, char **arguments)
{
    setvbuf(stdout, NULL, _IOLBF, 0);
    check(pipe(ends) == 0, "no pipe");
    for (size_t part = 0; part < sizeof PARTS / sizeof *PARTS; part++)
        if (count < 2 || strcmp(arguments[1], PARTS[part].name) == 0)
            PARTS[part].run();
    return clock_complaints() > 0;
}
