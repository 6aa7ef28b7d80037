/* SPDX-License-Identifier: MIT */
/* Linux and other systems of POSIX. */
#define _GNU_SOURCE
#include "port/port.h"

#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <locale.h>
#include <poll.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/utsname.h>
#include <unistd.h>

/* ---- files --------------------------------------------------------------- */

int ibl_port_open(const char *path)
{
    return open(path, O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
}

int ibl_port_create(const char *path)
{
    return open(path, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC,
                0666);
}

bool ibl_port_readable(int file, int milliseconds)
{
    struct pollfd p = {.fd = file, .events = POLLIN};
    return poll(&p, 1, milliseconds) > 0;
}

ptrdiff_t ibl_port_read_at(int file, void *to, size_t size, uint64_t offset)
{
    return pread(file, to, size, (off_t)offset);
}

bool ibl_port_flush(int file)
{
    while (fsync(file)) {
        if (errno == EINVAL) /* of file systems that cannot flush */
            break;
        if (errno != EINTR)
            return false;
    }
    return true;
}

bool ibl_port_replace(const char *from, const char *to)
{
    return !rename(from, to);
}

bool ibl_port_make_folder(const char *path)
{
    return !mkdir(path, 0777);
}

size_t ibl_port_root(const char *path)
{
    return *path == '/';
}

static int64_t nanoseconds(struct timespec t)
{
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

static bool identify(int failed, const struct stat *st, ibl_port_file *file)
{
    *file = (ibl_port_file){0};
    if (!failed)
        *file = (ibl_port_file){.device = (uint64_t)st->st_dev,
                                .number = (uint64_t)st->st_ino,
                                .size = (uint64_t)st->st_size,
                                .written = nanoseconds(st->st_mtim),
                                .changed = nanoseconds(st->st_ctim)};
    return !failed;
}

bool ibl_port_identify(const char *path, ibl_port_file *file)
{
    struct stat st;
    return identify(stat(path, &st), &st, file);
}

bool ibl_port_identify_folder(int folder, ibl_port_file *file)
{
    struct stat st;
    return identify(fstat(folder, &st), &st, file);
}

bool ibl_port_is_link(const char *path)
{
    struct stat st;
    return !lstat(path, &st) && S_ISLNK(st.st_mode);
}

bool ibl_port_resolve(const char *path, char real[IBL_PORT_PATH])
{
    return realpath(path, real);
}

int ibl_port_open_folder(const char *path)
{
    return open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
}

bool ibl_port_lock_folder(int folder, bool wait)
{
    while (flock(folder, wait ? LOCK_EX : LOCK_EX | LOCK_NB))
        if (errno != EINTR)
            return errno != EWOULDBLOCK;
    return true;
}

bool ibl_port_flush_folder(int folder)
{
    return !fsync(folder) || errno != EIO; /* not all can be flushed */
}

void ibl_port_close_folder(int folder)
{
    close(folder);
}

/* ---- memory -------------------------------------------------------------- */

void *ibl_port_alloc(size_t alignment, size_t bytes)
{
    void *p = aligned_alloc(alignment, bytes);
#ifdef MADV_HUGEPAGE
    if (p && alignment >= IBL_PORT_HUGE)
        madvise(p, bytes, MADV_HUGEPAGE); /* failure does no harm */
#endif
    return p;
}

void ibl_port_free(void *p)
{
    free(p);
}

uint64_t ibl_port_memory(void)
{
    const long pages = sysconf(_SC_PHYS_PAGES), size = sysconf(_SC_PAGESIZE);
    return pages > 0 && size > 0 ? (uint64_t)pages * (uint64_t)size : 0;
}

/* What a group's file allows: bytes, or quota and period, as CPUs rounded up.
 * 0: "max", or there is no such file, as of a container's parents. */
static uint64_t limit_of(const char *path)
{
    unsigned long long limit, period = 1;
    FILE *file = fopen(path, "re");
    const int read = file ? fscanf(file, "%llu %llu", &limit, &period) : 0;

    if (file)
        fclose(file);
    return read < 1 || !period ? 0 : limit / period + (limit % period != 0);
}

/* The tightest limit from this process's group up to the root. The group is
 * that of version 2, in a line "0::GROUP". */
static uint64_t find_limit(const char *root, const char *name)
{
    char group[4096] = "", path[2 * sizeof group];
    uint64_t best = 0;

    snprintf(path, sizeof path, "%s/proc/self/cgroup", root);
    FILE *file = fopen(path, "re");
    while (file && strncmp(group, "0::", 3) != 0)
        if (!fgets(group, sizeof group, file)) {
            fclose(file);
            return 0;
        }
    if (!file)
        return 0;
    fclose(file);
    group[strcspn(group, "\n")] = '\0';
    for (;;) {
        snprintf(path, sizeof path, "%s/sys/fs/cgroup%s/%s", root, group + 3,
                 name);
        const uint64_t limit = limit_of(path);
        if (limit && (!best || limit < best))
            best = limit;
        char *slash = strrchr(group, '/');
        if (!slash)
            return best;
        *slash = '\0';
    }
}

int ibl_port_cpu_quota(const char *root)
{
    const uint64_t cpus = find_limit(root, "cpu.max");
    return cpus < INT_MAX ? (int)cpus : INT_MAX;
}

uint64_t ibl_port_memory_quota(const char *root)
{
    return find_limit(root, "memory.max");
}

/* ---- threads, signals ---------------------------------------------------- */

int ibl_port_cpus(void)
{
    cpu_set_t set;
    if (!sched_getaffinity(0, sizeof set, &set))
        return CPU_COUNT(&set);
    return (int)sysconf(_SC_NPROCESSORS_ONLN);
}

bool ibl_port_start(pthread_t *thread, void *(*run)(void *), void *arg)
{
    static const int faults[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTRAP};
    sigset_t blocked, before;

    sigfillset(&blocked);
    for (size_t i = 0; i < sizeof faults / sizeof faults[0]; i++)
        sigdelset(&blocked, faults[i]);
    pthread_sigmask(SIG_BLOCK, &blocked, &before);
    const int error = pthread_create(thread, NULL, run, arg);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return !error;
}

static _Thread_local sigset_t held; /* what was blocked before */

void ibl_port_hold_signals(void)
{
    sigset_t all;

    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &held);
}

void ibl_port_release_signals(void)
{
    pthread_sigmask(SIG_SETMASK, &held, NULL);
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

void ibl_port_catch_signals(void (*leave)(void))
{
    /* From outside, and ABRT, raised by libraries. */
    static const int caught[] = {SIGHUP,  SIGINT,  SIGQUIT, SIGABRT, SIGUSR1,
                                 SIGUSR2, SIGPIPE, SIGALRM, SIGTERM, SIGXCPU};
    struct sigaction action = {.sa_handler = die}, old;
    const size_t count = sizeof caught / sizeof *caught;

    leaving = leave;
    sigemptyset(&action.sa_mask);
    for (size_t i = 0; i < count; i++)
        sigaddset(&action.sa_mask, caught[i]);
    for (size_t i = 0; i < count; i++)
        if (!sigaction(caught[i], NULL, &old) && old.sa_handler != SIG_IGN)
            sigaction(caught[i], &action, NULL);
    signal(SIGXFSZ, SIG_IGN);
}

/* ---- the program --------------------------------------------------------- */

/* Opens /dev/null for each of descriptors 0 to 2 that is closed, in the wrong
 * direction, so that using it still fails. Otherwise an output file could get
 * that number, and messages would be written into it. */
void ibl_port_begin(int argc, char **argv)
{
    (void)argc;
    (void)argv;
    for (int fd = 0; fd < 3; fd++)
        if (fcntl(fd, F_GETFD) < 0 && errno == EBADF)
            if (open("/dev/null", fd ? O_RDONLY : O_WRONLY) < 0)
                return; /* no other file can be opened either */
}

void ibl_port_progress(double done)
{
    (void)done;
}

const char *ibl_port_name(void)
{
    return program_invocation_short_name;
}

bool ibl_port_program(char *path, size_t size)
{
    const ssize_t length = readlink("/proc/self/exe", path, size);

    if (length <= 0 || (size_t)length >= size)
        return false;
    path[length] = '\0';
    return true;
}

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

double ibl_port_number(const char *text, char **end)
{
    const locale_t plain = newlocale(LC_NUMERIC_MASK, "C", (locale_t)0);
    const locale_t was = uselocale(plain);
    const double value = strtod(text, end);

    uselocale(was);
    if (plain)
        freelocale(plain);
    return value;
}
