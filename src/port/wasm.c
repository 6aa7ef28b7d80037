/* SPDX-License-Identifier: MIT */
/*
 * WebAssembly: one thread, in an instance that is thrown away after main. Calls
 * of the C library arrive at src/npm/system.mjs, and what it has no calls for,
 * which is declared here. Nothing can come from outside while it runs, so the
 * host asks to be left when it is called.
 */
#include "port/port.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "io/bridge/openexr.h"

#define HOST(name) __attribute__((import_module("iblbake"), import_name(name)))

HOST("process") int host_process(void);
HOST("is_gone") int host_is_gone(int process);
HOST("place") void host_place(char *text, int size);
HOST("progress") void host_progress(double done);
HOST("open") int host_open(const char *path, int flags);

/* In place of the C library's, which opens nothing without a host of its own.
 */
long __syscall_open(const char *path, long flags, ...);
long __syscall_open(const char *path, long flags, ...)
{
    return host_open(path, (int)flags);
}

int ibl_port_open(const char *path)
{
    return open(path, O_RDONLY);
}

int ibl_port_create(const char *path)
{
    return open(path, O_WRONLY | O_CREAT | O_EXCL, 0666);
}

bool ibl_port_readable(int file, int milliseconds)
{
    (void)file;
    (void)milliseconds;
    return true;
}

ptrdiff_t ibl_port_read_at(int file, void *to, size_t size, uint64_t offset)
{
    return pread(file, to, size, (off_t)offset);
}

bool ibl_port_flush(int file)
{
    return !fsync(file);
}

bool ibl_port_replace(const char *from, const char *to)
{
    return !rename(from, to);
}

bool ibl_port_make_folder(const char *path)
{
    return !mkdir(path, 0777);
}

bool ibl_port_identify(const char *path, ibl_port_file *file)
{
    struct stat st;

    *file = (ibl_port_file){0};
    if (stat(path, &st))
        return false;
    file->device = st.st_dev;
    file->number = st.st_ino;
    file->size = (uint64_t)st.st_size;
    file->written = st.st_mtim.tv_sec * 1000000000ll + st.st_mtim.tv_nsec;
    file->changed = st.st_ctim.tv_sec * 1000000000ll + st.st_ctim.tv_nsec;
    return true;
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

/* Hosts have no locks. */
int ibl_port_open_folder(const char *path)
{
    (void)path;
    return 0;
}

bool ibl_port_identify_folder(int folder, ibl_port_file *file)
{
    (void)folder;
    *file = (ibl_port_file){0};
    return false;
}

bool ibl_port_lock_folder(int folder, bool wait)
{
    (void)folder;
    (void)wait;
    return true;
}

bool ibl_port_flush_folder(int folder)
{
    (void)folder;
    return true;
}

void ibl_port_close_folder(int folder)
{
    (void)folder;
}

void *ibl_port_alloc(size_t alignment, size_t bytes)
{
    return aligned_alloc(alignment, bytes);
}

void ibl_port_free(void *p)
{
    free(p);
}

uint64_t ibl_port_memory(void)
{
    return UINT32_MAX;
}

uint64_t ibl_port_memory_quota(const char *root)
{
    (void)root;
    return 0;
}

int ibl_port_cpus(void)
{
    return 1;
}

int ibl_port_cpu_quota(const char *root)
{
    (void)root;
    return 0;
}

bool ibl_port_start(pthread_t *thread, void *(*run)(void *), void *arg)
{
    return !pthread_create(thread, NULL, run, arg); /* which fails */
}

static void (*leaving)(void);
static bool held;

void ibl_port_catch_signals(void (*leave)(void))
{
    leaving = leave;
}

void ibl_port_hold_signals(void)
{
    held = true;
}

void ibl_port_release_signals(void)
{
    held = false;
}

/* Called by the host: whether it can end the program now. */
__attribute__((export_name("leave"))) int ibl_port_leave(void);
int ibl_port_leave(void)
{
    if (leaving && !held)
        leaving();
    return !held;
}

void ibl_port_begin(int argc, char **argv)
{
    (void)argc;
    (void)argv;
}

void ibl_port_progress(double done)
{
    host_progress(done);
}

const char *ibl_port_name(void)
{
    return "iblbake";
}

bool ibl_port_program(char *path, size_t size)
{
    (void)path;
    (void)size;
    return false;
}

void ibl_port_place(char text[IBL_PORT_PATH])
{
    host_place(text, IBL_PORT_PATH);
}

pid_t getpid(void)
{
    return host_process();
}

bool ibl_port_is_gone(long process)
{
    return host_is_gone((int)process);
}

const bool ibl_port_loads = false;

bool ibl_port_load(const char *library, const char *name, void *function,
                   char why[IBL_PORT_WHY])
{
    ibl_openexr_unpack *const unpack = ibl_openexr_unpack_1;

    (void)library;
    strcpy(why, "there is none");
    if (strcmp(name, IBL_OPENEXR_UNPACK) != 0)
        return false;
    memcpy(function, &unpack, sizeof unpack);
    return true;
}

double ibl_port_number(const char *text, char **end)
{
    return strtod(text, end);
}
