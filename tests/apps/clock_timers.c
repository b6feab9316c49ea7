/*
 * Uses timers that are files, under the virtual clock, and checks the time that passed. The program
 * draws nothing. With an argument it does only this part.
 */
#define _GNU_SOURCE
#include "common/clock.h"
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/select.h>
#include <sys/timerfd.h>
#include <sys/uio.h>
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

static uint64_t count_of(int timer)
{
    uint64_t count = 0;
    return read(timer, &count, sizeof count) == sizeof count ? count : 0;
}

static void interrupted(int signal)
{
    (void)signal;
}

static pthread_t reader;

static atomic_bool has_read;

/* Sends signals until the read has ended: the first may come before it begins. */
static void *interrupts(void *unused)
{
    do {
        real_wait();
        pthread_kill(reader, SIGUSR1);
    } while (!has_read);
    return unused;
}

/* Reads that wait for the timer. */
static void reads(void)
{
    double before = now();
    int timer = timer_of(30000000, 0, 0);
    check(count_of(timer) == 1, "a read of a timer");
    passed(before, 0.03, "a read of a timer");
    set(timer, 10000000, 10000000);
    usleep(35000);
    check(count_of(timer) == 3, "a read tells all expirations");
    passed(before, 0.065, "a read that need not wait");
    check(count_of(timer) == 1, "the next expiration");
    passed(before, 0.07, "a read of the next expiration");
    uint64_t counts[2] = {0, 0};
    struct iovec parts[2] = {{counts, sizeof *counts}, {counts + 1, sizeof *counts}};
    check(readv(timer, parts, 2) >= 8 && counts[0] == 1, "readv reads a timer");
    passed(before, 0.08, "readv");
    check(read(timer, counts, 4) == -1 && errno == EINVAL, "a read that is too short");
    set(timer, 0, 0);

    /* A signal ends a read, unless its handler was set otherwise. */
    struct sigaction action = {.sa_handler = interrupted};
    sigaction(SIGUSR1, &action, NULL);
    reader = pthread_self();
    pthread_t thread;
    pthread_create(&thread, NULL, interrupts, NULL);
    check(read(timer, counts, 8) == -1 && errno == EINTR, "a signal ends a read");
    has_read = true;
    pthread_join(thread, NULL);
    action.sa_flags = SA_RESTART;
    sigaction(SIGUSR1, &action, NULL);
    pthread_create(&thread, NULL, interrupts, NULL);
    set(timer, 0, 0);
    armed = timer;
    pthread_t other;
    pthread_create(&other, NULL, arms, NULL);
    check(count_of(timer) == 1, "a read goes on after a signal, and ends when another thread sets the timer");
    pthread_join(thread, NULL);
    pthread_join(other, NULL);
}

/* Reads that do not wait. */
static void looks_by_reads(void)
{
    int timer = timer_of(2000000, 0, TFD_NONBLOCK);
    double before = now();
    uint64_t count;
    while (read(timer, &count, sizeof count) != sizeof count)
        if (errno != EAGAIN) {
            check(false, "a read that would wait");
            return;
        }
    check(count == 1, "a timer that is read again and again");
    /* The first 1000 looks take no time. */
    passed(before, 0.002, "looks by reads");
}

/* Another thread reads while this one waits for its time to pass. */
static void *reads_twice(void *timer)
{
    check(count_of(*(int *)timer) > 0 && count_of(*(int *)timer) > 0, "another thread reads a timer");
    return timer;
}

static void reads_of_others(void)
{
    int timer = timer_of(20000000, 20000000, 0);
    pthread_t thread;
    double before = now();
    pthread_create(&thread, NULL, reads_twice, &timer);
    for (int i = 0; i < 5; i++) {
        real_wait();
        usleep(10000);
    }
    passed(before, 0.05, "time beside reads of another thread");
    pthread_join(thread, NULL);
    int again = timer_of(20000000, 20000000, 0);
    /* The thread that waits for the other takes no time. */
    pthread_create(&thread, NULL, reads_twice, &again);
    pthread_join(thread, NULL);
    passed(before, 0.05, "a wait for a thread that reads a timer");
}

/* Waits for files beside timers of the thread that waits for it. */
static void *waits_beside(void *unused)
{
    int epoll = epoll_create1(0);
    struct epoll_event event = {.events = EPOLLIN};
    epoll_ctl(epoll, EPOLL_CTL_ADD, ends[0], &event);
    check(!readable(ends[0], 60), "the pipe is empty");
    check(epoll_wait(epoll, &event, 1, 60) == 0, "epoll of the pipe tells of nothing");
    check(epoll_wait(epoll, &event, 1, 0) == 0, "a look by epoll at the pipe tells of nothing");
    int own = timer_of(10000000, 0, 0);
    check(count_of(own) == 1, "a timer of its own");
    close(own);
    close(epoll);
    return unused;
}

/* Waits by epoll for the timer of the thread that waits for it. */
static void *waits_for_it(void *timer)
{
    int epoll = epoll_create1(0);
    struct epoll_event event = {.events = EPOLLIN};
    epoll_ctl(epoll, EPOLL_CTL_ADD, *(int *)timer, &event);
    check(epoll_wait(epoll, &event, 1, -1) == 1, "epoll tells of a timer of another thread");
    check(count_of(*(int *)timer) > 0, "another thread reads a timer after epoll");
    close(epoll);
    return timer;
}

/* A thread for which the time is later, because this one waits for it, fires no timers of this one. */
static void of_others(void)
{
    int timer = timer_of(10000000, 10000000, 0);
    double before = now();
    pthread_t thread;
    pthread_create(&thread, NULL, waits_beside, NULL);
    pthread_join(thread, NULL);
    passed(before, 0, "a wait for a thread that waits for files");
    check(!readable(timer, 0), "another thread fires no timer ahead of its time");
    usleep(25000);
    check(count_of(timer) == 2, "a timer counts the time of its thread");
    passed(before, 0.025, "a sleep beside a timer");
    pthread_create(&thread, NULL, waits_for_it, &timer);
    pthread_join(thread, NULL);
    passed(before, 0.025, "a wait for a thread that waits for a timer");
}

/* An edge-triggered wait is told of each expiration, also if nobody reads the timer. */
static void edges(void)
{
    int timer = timer_of(10000000, 10000000, 0), epoll = epoll_create1(0);
    struct epoll_event event = {.events = EPOLLIN | EPOLLET};
    epoll_ctl(epoll, EPOLL_CTL_ADD, timer, &event);
    double before = now();
    for (int i = 1; i <= 4; i++) {
        check(epoll_wait(epoll, &event, 1, 100) == 1, "an edge-triggered wait tells of an expiration");
        passed(before, 0.01 * i, "an edge-triggered wait");
    }
    check(count_of(timer) == 4, "the expirations of edge-triggered waits are counted");
}

static const struct {
    const char *name;
    void (*run)(void);
} PARTS[] = {
    {"unwatched", unwatched}, {"copies", copies}, {"set_meanwhile", set_meanwhile},
    {"looks", looks},         {"forked", forked}, {"reads", reads}, {"looks_by_reads", looks_by_reads},
    {"reads_of_others", reads_of_others}, {"of_others", of_others}, {"edges", edges},
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
