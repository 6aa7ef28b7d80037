/* SPDX-License-Identifier: MIT */
/* Linux and other systems of POSIX. */
#define _GNU_SOURCE
#include "port/port.h"

#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/utsname.h>
#include <unistd.h>

/* ---- files --------------------------------------------------------------- */

bool ibl_port_readable(int file, int milliseconds)
{
    struct pollfd p = {.fd = file, .events = POLLIN};
    return poll(&p, 1, milliseconds) > 0;
}

bool ibl_port_lock_folder(const char *path, int *lock)
{
    *lock = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    while (*lock >= 0 && flock(*lock, LOCK_EX | LOCK_NB)) {
        if (errno == EINTR)
            continue;
        if (errno != EWOULDBLOCK)
            break; /* it has no locks, as one of NFS */
        close(*lock);
        *lock = -1;
        return false;
    }
    return true;
}

bool ibl_port_flush_folder(const char *path)
{
    const int folder = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    const bool ok = folder < 0 || !fsync(folder) || errno != EIO;

    if (folder >= 0)
        close(folder);
    return ok;
}

const bool ibl_port_shares_files = true;

/* ---- memory -------------------------------------------------------------- */

uint64_t ibl_port_memory(void)
{
    const long pages = sysconf(_SC_PHYS_PAGES), size = sysconf(_SC_PAGESIZE);
    return pages > 0 && size > 0 ? (uint64_t)pages * (uint64_t)size : 0;
}

int ibl_port_cpus(void)
{
    cpu_set_t set;
    if (!sched_getaffinity(0, sizeof set, &set))
        return CPU_COUNT(&set);
    return (int)sysconf(_SC_NPROCESSORS_ONLN);
}

/* ---- signals ------------------------------------------------------------ */

static _Thread_local sigset_t held; /* what was blocked before */

void ibl_port_hold_signals(bool hold)
{
    static const int faults[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTRAP};
    sigset_t others;

    sigfillset(&others);
    for (size_t i = 0; i < sizeof faults / sizeof faults[0]; i++)
        sigdelset(&others, faults[i]);
    pthread_sigmask(SIG_SETMASK, hold ? &others : &held, hold ? &held : NULL);
}

static void (*leaving)(void);

/* The signal is blocked while its handler runs, so the raised one arrives when
 * it returns, with the default action. */
static void die(int number)
{
    leaving();
    signal(number, SIG_DFL);
    raise(number);
}

static void catch_signals(void)
{
    /* From outside, and ABRT, raised by libraries. */
    static const int caught[] = {SIGHUP,  SIGINT,  SIGQUIT, SIGABRT, SIGUSR1,
                                 SIGUSR2, SIGPIPE, SIGALRM, SIGTERM, SIGXCPU};
    struct sigaction action = {.sa_handler = die}, old;
    const size_t count = sizeof caught / sizeof *caught;

    sigemptyset(&action.sa_mask);
    for (size_t i = 0; i < count; i++)
        sigaddset(&action.sa_mask, caught[i]);
    for (size_t i = 0; i < count; i++)
        if (!sigaction(caught[i], NULL, &old) && old.sa_handler != SIG_IGN)
            sigaction(caught[i], &action, NULL);
    signal(SIGXFSZ, SIG_IGN);
}

/* ---- the program --------------------------------------------------------- */

/* What is closed of descriptors 0 to 2 becomes /dev/null in the wrong
 * direction: using it still fails, and no output file gets the number of
 * messages. */
void ibl_port_begin(int argc, char **argv, void (*leave)(void))
{
    (void)argc;
    (void)argv;
    for (int fd = 0; fd < 3; fd++)
        if (fcntl(fd, F_GETFD) < 0 && errno == EBADF &&
            open("/dev/null", fd ? O_RDONLY : O_WRONLY) < 0)
            break; /* no other file can be opened either */
    leaving = leave;
    catch_signals();
}

void (*const ibl_port_progress)(double done) = NULL;

/* The host's name, and the namespace, since containers share files, too. */
void ibl_port_place(char text[IBL_PORT_PATH])
{
    struct utsname system = {.nodename = ""};

    uname(&system);
    const size_t n = strlen(strcpy(text, system.nodename));
    const ssize_t space = readlink("/proc/self/ns/pid", text + n, 63);
    text[n + (size_t)(space > 0 ? space : 0)] = '\0';
}

bool ibl_port_is_gone(long process)
{
    return process > 0 && kill((pid_t)process, 0) && errno == ESRCH;
}

const bool ibl_port_loads = true;

bool ibl_port_load(const char *library, const char *name, void *function,
                   char why[IBL_PORT_WHY])
{
    void *opened = dlopen(library, RTLD_NOW | RTLD_LOCAL);
    void *symbol = opened ? dlsym(opened, name) : NULL;

    snprintf(why, IBL_PORT_WHY, "%s", opened ? "" : dlerror());
    /* POSIX lets it become a function pointer; C has no cast. */
    memcpy(function, &symbol, sizeof symbol);
    return symbol;
}
