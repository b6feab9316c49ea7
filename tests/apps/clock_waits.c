/*
 * Waits in all ways that libc has, under the virtual clock, and checks the time that passed. The
 * program draws nothing. It tells the clock itself when a frame ends.
 */
#define _GNU_SOURCE
#include "common/clock.h"
#include <dlfcn.h>
#include <errno.h>
#include <math.h>
#include <poll.h>
#include <pthread.h>
#include <semaphore.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/epoll.h>
#include <sys/select.h>
#include <sys/syscall.h>
#include <sys/timerfd.h>
#include <sys/wait.h>
#include <threads.h>
#include <time.h>
#include <unistd.h>

static pthread_mutex_t mutex = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t condition = PTHREAD_COND_INITIALIZER;
static bool ready;

static struct timespec date_after(double seconds)
{
    struct timespec time;
    clock_gettime(CLOCK_REALTIME, &time);
    double nanoseconds = time.tv_nsec + seconds * 1e9;
    time.tv_sec += (time_t)floor(nanoseconds / 1e9);
    time.tv_nsec = (long)fmod(nanoseconds, 1e9);
    return time;
}

static void alone(void)
{
    double before = now();
    usleep(20000);
    passed(before, 0.02, "usleep");
    sleep(3);
    passed(before, 3.02, "sleep");
    struct timespec length = {0, 30000000};
    nanosleep(&length, NULL);
    passed(before, 3.05, "nanosleep");
    struct timespec until;
    clock_gettime(CLOCK_MONOTONIC, &until);
    until.tv_sec += 2;
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, NULL);
    passed(before, 5.05, "clock_nanosleep");
    syscall(SYS_nanosleep, &length, NULL);
    passed(before, 5.08, "the system call nanosleep");
    int word = 0;
    long answer = syscall(SYS_futex, &word, 128, 0, &length, NULL, 0);
    check(answer == -1 && errno == ETIMEDOUT, "a futex is late");
    passed(before, 5.11, "the system call futex");
}

static void with_files(void)
{
    int ends[2];
    check(pipe(ends) == 0, "no pipe");
    struct pollfd file = {ends[0], POLLIN, 0};
    double before = now();
    check(poll(&file, 1, 40) == 0, "poll is late");
    passed(before, 0.04, "poll");
    struct timespec length = {0, 10000000};
    check(ppoll(&file, 1, &length, NULL) == 0, "ppoll is late");
    fd_set set;
    FD_ZERO(&set);
    FD_SET(ends[0], &set);
    struct timeval limit = {0, 50000};
    check(select(ends[0] + 1, &set, NULL, NULL, &limit) == 0, "select is late");
    passed(before, 0.1, "select");
    int epoll = epoll_create1(0);
    struct epoll_event event = {.events = EPOLLIN};
    epoll_ctl(epoll, EPOLL_CTL_ADD, ends[0], &event);
    check(epoll_wait(epoll, &event, 1, 50) == 0, "epoll_wait is late");
    passed(before, 0.15, "epoll_wait");
    check(write(ends[1], "x", 1) == 1, "the pipe is full");
    FD_SET(ends[0], &set);
    check(poll(&file, 1, 1000) == 1 && select(ends[0] + 1, &set, NULL, NULL, &limit) == 1, "data come at once");
    check(epoll_wait(epoll, &event, 1, 1000) == 1, "data come at once");
    passed(before, 0.15, "what is there");
    int timer = timerfd_create(CLOCK_MONOTONIC, 0);
    struct itimerspec times = {{0, 30000000}, {0, 50000000}};
    timerfd_settime(timer, 0, &times, NULL);
    struct pollfd waiting = {timer, POLLIN, 0};
    for (int i = 0; i < 3; i++) {
        unsigned long long count = 0;
        check(poll(&waiting, 1, -1) == 1 && read(timer, &count, 8) == 8 && count == 1, "a timer fires");
        passed(before, 0.2 + 0.03 * i, "a timer");
    }
}

#if defined SYS_poll && defined SYS_select && defined SYS_epoll_wait
/* Calls that only older processors have. */
static void older_system_calls(struct pollfd *file, fd_set *set, int epoll)
{
    struct epoll_event event;
    struct timeval limit = {0, 10000};
    double before = now();
    check(syscall(SYS_poll, file, 1, 10) == 0, "the system call poll is late");
    passed(before, 0.01, "the system call poll");
    check(syscall(SYS_select, file->fd + 1, set, NULL, NULL, &limit) == 0, "the system call select is late");
    passed(before, 0.02, "the system call select");
    check(syscall(SYS_epoll_wait, epoll, &event, 1, 10) == 0, "the system call epoll_wait is late");
    passed(before, 0.03, "the system call epoll_wait");
}
#else
static void older_system_calls(struct pollfd *file, fd_set *set, int epoll)
{
    (void)file, (void)set, (void)epoll;
}
#endif

/* Waits for files by `syscall`. */
static void system_calls(void)
{
    int ends[2];
    check(pipe(ends) == 0, "no pipe");
    struct pollfd file = {ends[0], POLLIN, 0};
    fd_set set;
    FD_ZERO(&set);
    FD_SET(ends[0], &set);
    int epoll = epoll_create1(0);
    struct epoll_event event = {.events = EPOLLIN};
    epoll_ctl(epoll, EPOLL_CTL_ADD, ends[0], &event);
    older_system_calls(&file, &set, epoll);
    double before = now();
    struct timespec limit = {0, 10000000};
    check(syscall(SYS_ppoll, &file, 1, &limit, NULL, 8) == 0, "the system call ppoll is late");
    passed(before, 0.01, "the system call ppoll");
    FD_SET(ends[0], &set);
    struct {
        const void *mask;
        size_t size;
    } none = {NULL, 8};
    check(syscall(SYS_pselect6, ends[0] + 1, &set, NULL, NULL, &limit, &none) == 0,
          "the system call pselect6 is late");
    passed(before, 0.02, "the system call pselect6");
    check(syscall(SYS_epoll_pwait, epoll, &event, 1, 10, NULL, 8) == 0, "the system call epoll_pwait is late");
    passed(before, 0.03, "the system call epoll_pwait");
    long timer = syscall(SYS_timerfd_create, CLOCK_MONOTONIC, 0);
    struct itimerspec times = {{0, 0}, {0, 30000000}}, left;
    check(syscall(SYS_timerfd_settime, timer, 0, &times, NULL) == 0, "the system call timerfd_settime");
    check(syscall(SYS_nanosleep, &limit, NULL) == 0, "the system call nanosleep");
    check(syscall(SYS_timerfd_gettime, timer, &left) == 0 && left.it_value.tv_nsec == 20000000,
          "the system call timerfd_gettime");
    unsigned long long count = 0;
    check(syscall(SYS_read, timer, &count, sizeof count) == sizeof count && count == 1, "the system call read");
    passed(before, 0.06, "the system call read");
    /* Older systems lack it. */
    long answer = syscall(SYS_epoll_pwait2, epoll, &event, 1, &limit, NULL, 8);
    if (answer != -1 || errno != ENOSYS) {
        check(answer == 0, "the system call epoll_pwait2 is late");
        passed(before, 0.07, "the system call epoll_pwait2");
    }
}

static void locks(void)
{
    double before = now();
    struct timespec date = date_after(1);
    pthread_mutex_lock(&mutex);
    check(pthread_cond_timedwait(&condition, &mutex, &date) == ETIMEDOUT, "a condition is late");
    pthread_mutex_unlock(&mutex);
    passed(before, 1, "pthread_cond_timedwait");
    sem_t semaphore;
    sem_init(&semaphore, 0, 0);
    date = date_after(1);
    check(sem_timedwait(&semaphore, &date) == -1 && errno == ETIMEDOUT, "a semaphore is late");
    passed(before, 2, "sem_timedwait");
    mtx_t lock;
    mtx_init(&lock, mtx_timed);
    mtx_lock(&lock);
    timespec_get(&date, TIME_UTC);
    date.tv_sec += 1;
    check(mtx_timedlock(&lock, &date) == thrd_timedout, "a lock is late");
    passed(before, 3, "mtx_timedlock");
}

static int sleeps_c11(void *unused)
{
    struct timespec length = {0, 20000000};
    check(thrd_sleep(&length, NULL) == 0, "thrd_sleep");
    return unused != NULL;
}

static cnd_t told;
static mtx_t lock;
static int turn;

static int tells(void *unused)
{
    sleeps_c11(unused);
    mtx_lock(&lock);
    turn++;
    cnd_signal(&told);
    mtx_unlock(&lock);
    return 7;
}

static pthread_barrier_t barrier;

static void *comes_late(void *unused)
{
    usleep(20000);
    pthread_barrier_wait(&barrier);
    return unused;
}

static int to_child[2];

static void *ends_child(void *unused)
{
    usleep(20000);
    check(write(to_child[1], "x", 1) == 1, "the pipe is full");
    return unused;
}

/* Waits for a process, to which a thread that sleeps sends a word. */
static void for_process(pid_t (*wait_for)(pid_t))
{
    check(pipe(to_child) == 0, "no pipe");
    pid_t child = fork();
    if (child == 0) {
        char byte;
        _exit(read(to_child[0], &byte, 1) == 1 ? 0 : 1);
    }
    pthread_t thread;
    pthread_create(&thread, NULL, ends_child, NULL);
    check(wait_for(child) == child, "a wait for a process");
    pthread_join(thread, NULL);
}

static pid_t by_waitpid(pid_t child)
{
    return waitpid(child, NULL, 0);
}

static pid_t by_waitid(pid_t child)
{
    siginfo_t answer;
    return waitid(P_PID, (id_t)child, &answer, WEXITED) == 0 ? answer.si_pid : -1;
}

static void *stays(void *unused)
{
    for (;;)
        pause();
    return unused;
}

/* Real time, in seconds. */
static double real(void)
{
    double seconds = 0;
    FILE *file = fopen("/proc/uptime", "r");
    check(file && fscanf(file, "%lf", &seconds) == 1, "the system's uptime can be read");
    if (file)
        fclose(file);
    return seconds;
}

/* Waits for threads without a limit. Those sleep in real time meanwhile. */
static void without_limit(void)
{
    double before = now(), begin = real();
    thrd_t thread;
    int answer = 0;
    cnd_init(&told);
    mtx_init(&lock, mtx_plain);
    thrd_create(&thread, tells, NULL);
    mtx_lock(&lock);
    while (turn == 0)
        check(cnd_wait(&told, &lock) == thrd_success, "cnd_wait");
    mtx_unlock(&lock);
    check(thrd_join(thread, &answer) == thrd_success && answer == 7, "thrd_join");
    thrd_create(&thread, tells, NULL);
    check(thrd_join(thread, &answer) == thrd_success && answer == 7, "thrd_join of a thread that sleeps");
    pthread_barrier_init(&barrier, NULL, 2);
    pthread_t late;
    pthread_create(&late, NULL, comes_late, NULL);
    pthread_barrier_wait(&barrier);
    pthread_join(late, NULL);
    for_process(by_waitpid);
    for_process(by_waitid);
    passed(before, 0, "waits without a limit");
    check(real() - begin < 4, "nobody waits until the drawing thread counts as stalled");

    pthread_create(&late, NULL, stays, NULL);
    before = now();
    struct timespec date = date_after(1);
    check(pthread_timedjoin_np(late, NULL, &date) == ETIMEDOUT, "pthread_timedjoin_np is late");
    passed(before, 1, "pthread_timedjoin_np");
    clock_gettime(CLOCK_MONOTONIC, &date);
    date.tv_sec += 2;
    begin = real();
    check(pthread_clockjoin_np(late, NULL, CLOCK_MONOTONIC, &date) == ETIMEDOUT, "pthread_clockjoin_np is late");
    passed(before, 3, "pthread_clockjoin_np");
    check(real() - begin < 1, "pthread_clockjoin_np takes the program's time");
    pthread_cancel(late);
    pthread_join(late, NULL);
}

static void *sleeps(void *unused)
{
    for (int i = 0; i < 5; i++)
        usleep(2000);
    pthread_mutex_lock(&mutex);
    ready = true;
    pthread_cond_signal(&condition);
    pthread_mutex_unlock(&mutex);
    return unused;
}

/* Sleeps for three frames. */
static void *until_frames(void *woke)
{
    struct timespec date = date_after(0.05);
    pthread_mutex_lock(&mutex);
    while (pthread_cond_timedwait(&condition, &mutex, &date) != ETIMEDOUT)
        ;
    pthread_mutex_unlock(&mutex);
    *(double *)woke = now();
    return woke;
}

static void with_threads(void (*frame)(unsigned long))
{
    double before = now();
    pthread_t thread;
    pthread_create(&thread, NULL, sleeps, NULL);
    pthread_mutex_lock(&mutex);
    while (!ready)
        pthread_cond_wait(&condition, &mutex);
    pthread_mutex_unlock(&mutex);
    pthread_join(thread, NULL);
    passed(before, 0, "a wait for a thread that sleeps");

    frame(1);
    before = now();
    double woke = 0;
    pthread_create(&thread, NULL, until_frames, &woke);
    for (int i = 0; i < 6; i++) {
        /* The other thread needs real time. No call of libc waits for real time here. */
        for (volatile long work = 0; work < 20000000; work++)
            ;
        frame(1);
    }
    pthread_join(thread, NULL);
    /* The time at the start was not that of a frame, so a frame is the tolerance. */
    check(fabs(now() - before - 0.1) < 1.0 / 60, "six frames take six times 1/60 s");
    check(woke >= before + 0.05, "a thread wakes in the program's time");
}

int main(void)
{
    void (*frame)(unsigned long) = (void (*)(unsigned long))dlsym(RTLD_DEFAULT, "cupola_clock_frame");
    if (!frame) {
        printf("clock_waits: there is no virtual clock\n");
        return 1;
    }
    setvbuf(stdout, NULL, _IOLBF, 0);
    check(now() == 1000 && time(NULL) == 946728000, "the time starts at noon of 2000-01-01");
    alone();
    with_files();
    system_calls();
    locks();
    without_limit();
    with_threads(frame);
    return clock_complaints() > 0;
}
