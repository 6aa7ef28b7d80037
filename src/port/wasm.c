/* SPDX-License-Identifier: MIT */
/*
 * WebAssembly, in an instance that is thrown away after main. Calls of the C
 * library arrive at src/npm/system.mjs, and what it has no calls for, which is
 * declared here. Each thread has a host of its own, and the first one's has the
 * files. The host takes signals.
 */
#include "port/port.h"

#include <unistd.h>

#define HOST(name) __attribute__((import_module("iblbake"), import_name(name)))

HOST("process") int host_process(void);
HOST("is_gone") int host_is_gone(int process);
HOST("cpus") int host_cpus(void);
HOST("place") void host_place(char *text, int size);
HOST("progress") void host_progress(double done);
HOST("open") int host_open(const char *path, int flags);

/* The C library's opens nothing without a host of its own. */
long __syscall_open(const char *path, long flags, ...);
long __syscall_open(const char *path, long flags, ...)
{
    return host_open(path, (int)flags);
}

bool ibl_port_lock_folder(const char *path, int *lock)
{
    (void)path;
    *lock = -1;
    return true;
}

const bool ibl_port_shares_files = false;

uint64_t ibl_port_memory(void)
{
    return UINT32_MAX;
}

int ibl_port_cpus(void)
{
    return host_cpus();
}

static void (*leaving)(void);
static bool held;

void ibl_port_begin(int argc, char **argv, void (*leave)(void))
{
    (void)argc;
    (void)argv;
    leaving = leave;
}

void ibl_port_hold_signals(bool hold)
{
    held = hold;
}

/* Called by the host: whether it can end the program now. */
__attribute__((export_name("leave"))) bool ibl_port_leave(void);
bool ibl_port_leave(void)
{
    if (leaving && !held)
        leaving();
    return !held;
}

void (*const ibl_port_progress)(double done) = host_progress;

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
