/*
 * Uses the number of its process, under the virtual clock: clock_process [LIBRARY [LIBRARY]]. The number that
 * it reads is the same in each run, and the system understands it. The first library (preload/own_number.c) is to
 * get the real number, the second one that of the program.
 */
#define _GNU_SOURCE
#include "common/clock.h"
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

enum { SAME = (1 << 22) + 1 };

static volatile sig_atomic_t signals;

static void count(int signal)
{
    (void)signal;
    signals++;
}

/* The number as the system has it. */
static int real_number(void)
{
    char text[32] = "";
    check(readlink("/proc/self", text, sizeof text - 1) > 0, "/proc/self is a link");
    return atoi(text);
}

static void by_libc(void)
{
    int own = getpid();
    check(own == SAME, "getpid is the same in each run");
    signals = 0;
    signal(SIGUSR1, count);
    signal(SIGUSR2, count);
    union sigval value = {1};
    check(kill(own, SIGUSR1) == 0 && signals == 1, "kill");
    check(sigqueue(own, SIGUSR1, value) == 0 && signals == 2, "sigqueue");
    check(tgkill(own, gettid(), SIGUSR1) == 0 && signals == 3, "tgkill");
    cpu_set_t set;
    check(sched_getaffinity(own, sizeof set, &set) == 0, "sched_getaffinity");
    check(sched_setaffinity(own, sizeof set, &set) == 0, "sched_setaffinity");
    struct sched_param parameters;
    check(sched_getscheduler(own) >= 0 && sched_getparam(own, &parameters) == 0, "sched_getscheduler");
    errno = 0;
    int priority = getpriority(PRIO_PROCESS, own);
    check(errno == 0 && setpriority(PRIO_PROCESS, own, priority) == 0, "getpriority and setpriority");
    check(getpgid(own) == getpgrp() && getsid(own) == getsid(0), "getpgid and getsid");
    struct rlimit limit;
    check(prlimit(own, RLIMIT_CORE, NULL, &limit) == 0, "prlimit");
    int from = 7, to = 0;
    struct iovec read_to = {&to, sizeof to}, read_from = {&from, sizeof from};
    check((process_vm_readv(own, &read_to, 1, &read_from, 1, 0) == sizeof to && to == 7) || errno == EPERM ||
              errno == ENOSYS,
          "process_vm_readv");
    int ends[2];
    check(socketpair(AF_UNIX, SOCK_STREAM, 0, ends) == 0 && fcntl(ends[0], F_SETOWN, own) == 0, "F_SETOWN");
    struct f_owner_ex owner = {F_OWNER_PID, own}, is = {0, 0};
    check(fcntl(ends[1], F_SETOWN_EX, &owner) == 0 && fcntl(ends[1], F_GETOWN_EX, &is) == 0, "F_SETOWN_EX");
    check(is.type == F_OWNER_PID && is.pid == real_number(), "F_SETOWN_EX sets the owner");
    struct {
        uint32_t size, policy;
        uint64_t flags, others[5];
    } attributes = {0};
    check(syscall(SYS_sched_getattr, own, &attributes, sizeof attributes, 0) == 0, "sched_getattr");
    check(syscall(SYS_sched_setattr, own, &attributes, 0) == 0, "sched_setattr");
    /* libc has these functions since its version 2.41; the library of the clock always has. */
    int (*get)(pid_t, void *, unsigned, unsigned), (*set_to)(pid_t, void *, unsigned);
    *(void **)&get = dlsym(RTLD_DEFAULT, "sched_getattr");
    *(void **)&set_to = dlsym(RTLD_DEFAULT, "sched_setattr");
    check(get && get(own, &attributes, sizeof attributes, 0) == 0, "sched_getattr of libc");
    check(set_to && set_to(own, &attributes, 0) == 0, "sched_setattr of libc");
}

/* Does what a shell does to get its terminal. */
static void by_terminal(void)
{
    int own = getpid(), terminal = posix_openpt(O_RDWR | O_NOCTTY), end = -1;
    check(terminal >= 0 && grantpt(terminal) == 0 && unlockpt(terminal) == 0, "no terminal");
    /* The first process of a group can begin no session. */
    if (getsid(0) != own && getpgrp() != own)
        check(setsid() == own, "setsid");
    if (getsid(0) != own)
        return;
    check(getpgrp() == own && getpgid(own) == own, "the first process of a session has its number");
    check(syscall(SYS_getsid, 0) == own, "the system call getsid");
    end = open(ptsname(terminal), O_RDWR);
    signal(SIGTTOU, SIG_IGN);
    check(tcsetpgrp(end, own) == 0 && tcgetpgrp(end) == own && tcgetsid(end) == own, "tcsetpgrp");
    pid_t group = own;
    check(ioctl(end, TIOCSPGRP, &group) == 0 && ioctl(end, TIOCGPGRP, &group) == 0 && group == own, "TIOCSPGRP");
    signal(SIGHUP, SIG_IGN);
    close(end);
    close(terminal);
}

static void by_syscall(void)
{
    long own = syscall(SYS_getpid);
    check(own == SAME, "the system call getpid is the same in each run");
    signals = 0;
    check(syscall(SYS_kill, own, SIGUSR1) == 0 && signals == 1, "the system call kill");
    check(syscall(SYS_tgkill, own, syscall(SYS_gettid), SIGUSR1) == 0 && signals == 2, "the system call tgkill");
    cpu_set_t set;
    check(syscall(SYS_sched_getaffinity, own, sizeof set, &set) > 0, "the system call sched_getaffinity");
    check(syscall(SYS_getpgid, own) == getpgrp(), "the system call getpgid");
    check(syscall(SYS_getpriority, PRIO_PROCESS, own) > 0, "the system call getpriority");
}

/* A copy of the process has a number of its own, and knows that of its parent. */
static void by_fork(void)
{
    int parent = getpid();
    signals = 0;
    pid_t child = fork();
    if (child == 0) {
        bool good = getpid() != parent && getpid() == real_number() && getppid() == parent;
        _exit(good && kill(parent, SIGUSR1) == 0 && signals == 0 ? 0 : 1);
    }
    int status = 1;
    while (waitpid(child, &status, 0) == -1 && errno == EINTR)
        ;
    check(status == 0 && signals == 1, "a copy of the process sends a signal to its parent");
}

/* Sends the number over a connection, as a program does that asks the bus of the session for something. */
static bool is_accepted(int number)
{
    int ends[2], on = 1;
    check(socketpair(AF_UNIX, SOCK_STREAM, 0, ends) == 0, "no connection");
    setsockopt(ends[1], SOL_SOCKET, SO_PASSCRED, &on, sizeof on);
    struct ucred own = {number, getuid(), getgid()};
    union {
        char bytes[CMSG_SPACE(sizeof own)];
        struct cmsghdr header;
    } control = {{0}};
    char byte = 0;
    struct iovec part = {&byte, 1};
    struct msghdr message = {
        .msg_iov = &part, .msg_iovlen = 1, .msg_control = &control, .msg_controllen = sizeof control};
    control.header.cmsg_level = SOL_SOCKET;
    control.header.cmsg_type = SCM_CREDENTIALS;
    control.header.cmsg_len = CMSG_LEN(sizeof own);
    *(struct ucred *)(void *)CMSG_DATA(&control.header) = own;
    return sendmsg(ends[0], &message, 0) == 1;
}

static int number_of(const char *library)
{
    void *handle = dlopen(library, RTLD_NOW);
    int (*number)(void) = handle ? (int (*)(void))dlsym(handle, "number_of_library") : NULL;
    check(number, "a library can be loaded");
    return number ? number() : 0;
}

int main(int arguments, char **argument)
{
    setvbuf(stdout, NULL, _IOLBF, 0);
    by_libc();
    by_syscall();
    by_fork();
    by_terminal();
    if (arguments > 1) {
        int number = number_of(argument[1]);
        check(number == real_number(), "a library that tells others its number gets the real one");
        check(is_accepted(number) && !is_accepted(SAME), "the system accepts only the real one as a credential");
    }
    if (arguments > 2)
        check(number_of(argument[2]) == SAME, "another library gets that of the program");
    return clock_complaints() > 0;
}
