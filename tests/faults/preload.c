/* SPDX-License-Identifier: MIT */
/*
 * To be preloaded: counts the calls of a program to the C library, and has the
 * Nth of a kind fail. By the environment:
 *   FAULT="KIND WHAT N[+]"  the call of that kind (table below) after N others
 *                     fails with errno WHAT, a number; with +, all from there
 *                     on. WHAT may be `short` (reads and writes a part), and
 *                     `-S`, which sends signal S before the call.
 *   FAULT_COUNTS=FD   counts in that file: see faults.h
 *   FAULT_FROM=own    only calls by the program's own code, not by libraries
 *
 * Streams are those of our own open, read, write and close, as a C library's
 * own calls cannot be replaced.
 */
#define _GNU_SOURCE
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <execinfo.h>
#include <fcntl.h>
#include <link.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include "faults.h"

/* What glibc's own are called besides. */
void *__libc_malloc(size_t size);
void *__libc_calloc(size_t n, size_t size);
void *__libc_realloc(void *old, size_t size);
void *__libc_memalign(size_t alignment, size_t size);

static fault_counts nowhere, *counts = &nowhere;
static struct {
    int kind; /* -1: none */
    int error, signal;
    bool is_short, stays;
    unsigned at;
} fault = {.kind = -1};
static bool own_only;
static uintptr_t own_base, own_from, own_to; /* the program's code */

/* ---- which call ---------------------------------------------------------- */

static int find_program(struct dl_phdr_info *info, size_t size, void *unused)
{
    (void)size;
    (void)unused;
    own_base = info->dlpi_addr;
    for (int i = 0; i < info->dlpi_phnum; i++) {
        const ElfW(Phdr) *p = &info->dlpi_phdr[i];
        if (p->p_type == PT_LOAD && p->p_flags & PF_X) {
            own_from = own_base + p->p_vaddr;
            own_to = own_from + p->p_memsz;
        }
    }
    return 1; /* the first is the program */
}

__attribute__((constructor)) static void begin(void)
{
    const char *what = getenv("FAULT"), *fd = getenv("FAULT_COUNTS");
    const char *from = getenv("FAULT_FROM");
    char kind[16], error[16], end = '\0';
    void *trace[4];

    dl_iterate_phdr(find_program, NULL);
    backtrace(trace, 4); /* loads what it needs */
    own_only = from && !strcmp(from, "own");
    if (fd) {
        void *at = mmap(NULL, sizeof *counts, PROT_READ | PROT_WRITE,
                        MAP_SHARED, atoi(fd), 0);
        if (at == MAP_FAILED)
            _exit(99);
        counts = at;
    }
    if (!what ||
        sscanf(what, "%15s %15s %u%c", kind, error, &fault.at, &end) < 3)
        return;
    fault.is_short = !strcmp(error, "short");
    fault.stays = end == '+';
    fault.error = atoi(error);
    if (fault.error < 0)
        fault.signal = -fault.error;
    for (int i = 0; i < FAULT_KINDS; i++)
        if (!strcmp(kind, fault_kinds[i]))
            fault.kind = i;
    if (fault.kind < 0)
        _exit(98);
}

/* Where in the program the call is from, for whoever mends it. */
static void note_place(void)
{
    void *trace[24];
    int n = backtrace(trace, 24), own = 0;

    for (int i = 0; i < n && own < FAULT_PLACES; i++)
        if ((uintptr_t)trace[i] >= own_from && (uintptr_t)trace[i] < own_to)
            counts->place[own++] = (uintptr_t)trace[i] - own_base - 1;
}

/* Counts a call; whether it is to fail, then with errno. */
static bool counted(int kind, bool *is_short)
{
    const unsigned n = atomic_fetch_add(&counts->calls[kind], 1);

    if (fault.kind != kind ||
        !(n == fault.at || (fault.stays && n > fault.at)) ||
        (fault.is_short && !is_short))
        return false;
    if (!atomic_fetch_add(&counts->failed, 1) && fault.signal != SIGKILL)
        note_place();
    if (fault.signal) {
        kill(getpid(), fault.signal);
        return false;
    }
    if (fault.is_short) {
        *is_short = true;
        return false;
    }
    errno = fault.error;
    return true;
}

static bool fails_at(int kind, const void *caller, bool *is_short)
{
    const uintptr_t from = (uintptr_t)caller;

    if (own_only && (from < own_from || from >= own_to))
        return false;
    /* Whatever touches files, to be killed there. */
    if (kind != FAULT_MEMORY && counted(FAULT_FILE, NULL))
        return true;
    return counted(kind, is_short);
}

#define FAILS(kind) fails_at(kind, __builtin_return_address(0), NULL)
/* The C library's own function of that name. */
#define NEXT(name)                                                             \
    static __typeof__(name) *next;                                             \
    if (!next)                                                                 \
    next = (__typeof__(name) *)dlsym(RTLD_NEXT, #name)

/* ---- memory -------------------------------------------------------------- */

void *malloc(size_t size)
{
    return FAILS(FAULT_MEMORY) ? NULL : __libc_malloc(size);
}

void *calloc(size_t n, size_t size)
{
    return FAILS(FAULT_MEMORY) ? NULL : __libc_calloc(n, size);
}

void *realloc(void *old, size_t size)
{
    return FAILS(FAULT_MEMORY) ? NULL : __libc_realloc(old, size);
}

void *aligned_alloc(size_t alignment, size_t size)
{
    return FAILS(FAULT_MEMORY) ? NULL : __libc_memalign(alignment, size);
}

int posix_memalign(void **to, size_t alignment, size_t size)
{
    if (FAILS(FAULT_MEMORY))
        return ENOMEM;
    *to = __libc_memalign(alignment, size);
    return *to ? 0 : ENOMEM;
}

/* These call malloc inside of the C library. */
char *strdup(const char *text)
{
    const size_t size = strlen(text) + 1;
    char *copy = FAILS(FAULT_MEMORY) ? NULL : __libc_malloc(size);

    return copy ? memcpy(copy, text, size) : NULL;
}

char *strndup(const char *text, size_t most)
{
    const size_t size = strnlen(text, most);
    char *copy = FAILS(FAULT_MEMORY) ? NULL : __libc_malloc(size + 1);

    if (copy)
        copy[size] = '\0';
    return copy ? memcpy(copy, text, size) : NULL;
}

int vasprintf(char **to, const char *format, va_list ap)
{
    NEXT(vasprintf);
    return FAILS(FAULT_MEMORY) ? -1 : next(to, format, ap);
}

int pthread_create(pthread_t *thread, const pthread_attr_t *with,
                   void *(*run)(void *), void *arg)
{
    NEXT(pthread_create);
    return FAILS(FAULT_THREAD) ? EAGAIN : next(thread, with, run, arg);
}

/* ---- files --------------------------------------------------------------- */

int open(const char *path, int flags, ...)
{
    va_list ap;

    va_start(ap, flags);
    const mode_t mode = flags & O_CREAT ? va_arg(ap, mode_t) : 0;
    va_end(ap);
    if (FAILS(flags & O_CREAT ? FAULT_CREATE : FAULT_OPEN))
        return -1;
    return openat(AT_FDCWD, path, flags, mode);
}

int close(int fd)
{
    NEXT(close);
    const bool fails = FAILS(FAULT_CLOSE);
    const int error = errno;
    const int result = next(fd); /* is closed, whatever it says */

    errno = fails ? error : errno;
    return fails ? -1 : result;
}

static ssize_t read_some(int fd, void *to, size_t size, const void *caller)
{
    NEXT(read);
    bool part = false;

    if (fails_at(FAULT_READ, caller, &part))
        return -1;
    return next(fd, to, part ? (size + 1) / 2 : size);
}

static ssize_t write_some(int fd, const void *from, size_t size,
                          const void *caller)
{
    NEXT(write);
    bool part = false;

    if (fails_at(FAULT_WRITE, caller, &part))
        return -1;
    return next(fd, from, part ? (size + 1) / 2 : size);
}

ssize_t read(int fd, void *to, size_t size)
{
    return read_some(fd, to, size, __builtin_return_address(0));
}

ssize_t write(int fd, const void *from, size_t size)
{
    return write_some(fd, from, size, __builtin_return_address(0));
}

ssize_t pread(int fd, void *to, size_t size, off_t offset)
{
    NEXT(pread);
    bool part = false;

    if (fails_at(FAULT_READ, __builtin_return_address(0), &part))
        return -1;
    return next(fd, to, part ? (size + 1) / 2 : size, offset);
}

/* Does not flush, which takes long, and nobody can tell. */
int fsync(int fd)
{
    return FAILS(FAULT_FLUSH) ? -1 : fcntl(fd, F_GETFD) < 0 ? -1 : 0;
}

int flock(int fd, int how)
{
    NEXT(flock);
    return FAILS(FAULT_LOCK) ? -1 : next(fd, how);
}

int rename(const char *from, const char *to)
{
    NEXT(rename);
    return FAILS(FAULT_RENAME) ? -1 : next(from, to);
}

int unlink(const char *path)
{
    NEXT(unlink);
    return FAILS(FAULT_REMOVE) ? -1 : next(path);
}

int rmdir(const char *path)
{
    NEXT(rmdir);
    return FAILS(FAULT_REMOVE) ? -1 : next(path);
}

int mkdir(const char *path, mode_t mode)
{
    NEXT(mkdir);
    return FAILS(FAULT_MKDIR) ? -1 : next(path, mode);
}

char *mkdtemp(char *path)
{
    NEXT(mkdtemp);
    return FAILS(FAULT_MKDIR) ? NULL : next(path);
}

int stat(const char *path, struct stat *st)
{
    return FAILS(FAULT_STAT) ? -1 : fstatat(AT_FDCWD, path, st, 0);
}

int lstat(const char *path, struct stat *st)
{
    return FAILS(FAULT_STAT) ? -1
                             : fstatat(AT_FDCWD, path, st, AT_SYMLINK_NOFOLLOW);
}

int fstat(int fd, struct stat *st)
{
    return FAILS(FAULT_STAT) ? -1 : fstatat(fd, "", st, AT_EMPTY_PATH);
}

int access(const char *path, int mode)
{
    NEXT(access);
    return FAILS(FAULT_STAT) ? -1 : next(path, mode);
}

int scandir(const char *path, struct dirent ***names,
            int (*choose)(const struct dirent *),
            int (*order)(const struct dirent **, const struct dirent **))
{
    NEXT(scandir);
    return FAILS(FAULT_OPEN) ? -1 : next(path, names, choose, order);
}

DIR *opendir(const char *path)
{
    NEXT(opendir);
    return FAILS(FAULT_OPEN) ? NULL : next(path);
}

/* ---- streams ------------------------------------------------------------- */

static ssize_t stream_read(void *cookie, char *to, size_t size)
{
    return read_some((int)(intptr_t)cookie, to, size, (void *)own_from);
}

static ssize_t stream_write(void *cookie, const char *from, size_t size)
{
    const ssize_t n =
        write_some((int)(intptr_t)cookie, from, size, (void *)own_from);
    return n < 0 ? 0 : n;
}

static int stream_seek(void *cookie, off64_t *offset, int whence)
{
    *offset = lseek((int)(intptr_t)cookie, *offset, whence);
    return *offset < 0 ? -1 : 0;
}

static int stream_close(void *cookie)
{
    return close((int)(intptr_t)cookie);
}

static FILE *stream_of(int fd, const char *mode)
{
    NEXT(fopencookie);
    return next((void *)(intptr_t)fd, mode,
                (cookie_io_functions_t){stream_read, stream_write, stream_seek,
                                        stream_close});
}

FILE *fdopen(int fd, const char *mode)
{
    return FAILS(FAULT_MEMORY) ? NULL : stream_of(fd, mode);
}

FILE *fopen(const char *path, const char *mode)
{
    const bool reads = mode[0] == 'r';
    if (FAILS(reads ? FAULT_OPEN : FAULT_CREATE))
        return NULL;
    const int fd = openat(
        AT_FDCWD, path, reads ? O_RDONLY : O_WRONLY | O_CREAT | O_TRUNC, 0666);
    return fd < 0 ? NULL : stream_of(fd, mode);
}
