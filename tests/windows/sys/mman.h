/* SPDX-License-Identifier: MIT */
/* What tests use of POSIX and Windows lacks; read before each of them. Signals
 * are not told of: a test that ends early has no last line. */
#ifndef TESTS_WINDOWS_SYS_MMAN_H
#define TESTS_WINDOWS_SYS_MMAN_H

#ifndef _GNU_SOURCE
#define _GNU_SOURCE /* vasprintf */
#endif
#include <direct.h>
#include <io.h>
#include <signal.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

void *__stdcall VirtualAlloc(void *at, size_t size, unsigned long type,
                             unsigned long protection);
int __stdcall VirtualFree(void *at, size_t size, unsigned long type);
int __stdcall VirtualProtect(void *at, size_t size, unsigned long protection,
                             unsigned long *old);

enum {
    PROT_NONE = 1, /* PAGE_NOACCESS, PAGE_READONLY, PAGE_READWRITE */
    PROT_READ = 2,
    PROT_WRITE = 4,
    MAP_PRIVATE = 0,
    MAP_ANONYMOUS = 0,
    _SC_PAGESIZE = 0,
    SIGBUS = 64,
    SIGTRAP,
    SA_RESETHAND = 0,
    SA_ONSTACK = 0
};
#define MAP_FAILED NULL

static inline void *mmap(void *at, size_t size, int protection, int flags,
                         int file, long long offset)
{
    (void)flags, (void)file, (void)offset;
    return VirtualAlloc(at, size, 0x3000, protection & PROT_WRITE ? 4 : 2);
}

static inline int munmap(void *at, size_t size)
{
    (void)size;
    return !VirtualFree(at, 0, 0x8000);
}

static inline int mprotect(void *at, size_t size, int protection)
{
    unsigned long old;
    return !VirtualProtect(
        at, size, protection & PROT_WRITE ? 4UL : (unsigned long)protection,
        &old);
}

static inline long sysconf(int name)
{
    return name == _SC_PAGESIZE ? 4096 : -1;
}

typedef struct {
    void *ss_sp;
    size_t ss_size;
} stack_t;
struct sigaction {
    void (*sa_handler)(int);
    int sa_flags;
};

static inline int sigaltstack(const stack_t *own, stack_t *old)
{
    (void)own, (void)old;
    return 0;
}

static inline int sigaction(int number, const struct sigaction *action,
                            struct sigaction *old)
{
    (void)number, (void)action, (void)old;
    return -1;
}

/* Not for tests that have a test_setup() of their own. */
#define weak
static inline void __sanitizer_set_death_callback(void (*call)(void))
{
    (void)call;
}

static inline long readlink(const char *path, char *to, size_t size)
{
    (void)path, (void)to, (void)size;
    return -1;
}

/* For those that write EXR files, which are not run here. */
static inline FILE *open_memstream(char **bytes, size_t *size)
{
    (void)bytes, (void)size;
    return NULL;
}

static inline char *mkdtemp(char *name)
{
    return mktemp(name) && !mkdir(name) ? name : NULL;
}

#endif
