/* SPDX-License-Identifier: MIT */
/*
 * WebAssembly: one thread, in an instance that is thrown away after main. Calls
 * of the C library arrive at src/npm/system.mjs, and what it has no calls for,
 * which is declared here. Nothing can come from outside while it runs, so the
 * host asks to be left when it is called.
 */
#include "port/port.h"

#include <stdlib.h>
#include <unistd.h>

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

bool ibl_port_readable(int file, int milliseconds)
{
    (void)file;
    (void)milliseconds;
    return true;
}

/* Hosts have no locks. */
int ibl_port_open_folder(const char *path)
{
    (void)path;
    return 0;
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

/* It never gets to run: who waits for its work does it. */
bool ibl_port_start(pthread_t *thread, void *(*run)(void *), void *arg)
{
    (void)run;
    (void)arg;
    *thread = 0;
    return true;
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

double ibl_port_number(const char *text, char **end)
{
    return strtod(text, end);
}
