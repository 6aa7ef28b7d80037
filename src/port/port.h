/* SPDX-License-Identifier: MIT */
/*
 * What a system must give beyond C11, pthreads and the calls of POSIX that
 * windows.h names. shared.c is of all systems; plain.c of those without parts
 * that are loaded; and one file beside these is compiled, for the system that
 * is built for. Nothing else asks which one that is. Functions return false,
 * NULL or -1 and set errno if they fail.
 */
#ifndef IBL_PORT_PORT_H
#define IBL_PORT_PORT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    IBL_PORT_PATH = 4096,    /* a path and its zero */
    IBL_PORT_HUGE = 1 << 21, /* bytes of a huge page, on x86-64 and arm64 */
    IBL_PORT_WHY = 1024
};

/* ---- files --------------------------------------------------------------- */

/* Makes all separators of a path '/', in place. */
void ibl_port_use_slashes(char *path);
/* Opens a file to be read, and does not wait for the writer of a FIFO. */
int ibl_port_open(const char *path);
/* Makes a new file to be written; no link is followed. It can be removed while
 * it is open. */
int ibl_port_create(const char *path);
/* Waits for up to some milliseconds until read() does not. */
bool ibl_port_readable(int file, int milliseconds);
/* Locks a folder until *lock is closed. -1: it cannot be locked. False: it is
 * locked already, by this process or another. */
bool ibl_port_lock_folder(const char *path, int *lock);
/* True also of folders that cannot be flushed. */
bool ibl_port_flush_folder(const char *path);
/* Whether a thread can use a file that another one has opened. */
extern const bool ibl_port_shares_files;

/* ---- memory, CPUs -------------------------------------------------------- */

/* Memory for ibl_port_free. Huge pages where they are asked for by alignment.
 * The alignment is a power of 2, and bytes are a multiple of it. */
void *ibl_port_alloc(size_t alignment, size_t bytes);
void ibl_port_free(void *p);
/* Bytes of physical memory; 0: unknown. */
uint64_t ibl_port_memory(void);
/* CPUs that this process may run on, but for quotas. */
int ibl_port_cpus(void);
/* The tightest limit of this process's groups, of "cpu.max", rounded up, or of
 * "memory.max"; 0: none. root: "", or in tests a folder before system paths. */
uint64_t ibl_port_quota(const char *root, const char *name);

/* ---- the program --------------------------------------------------------- */

/* First of all in main: standard streams are open, paths have no separator but
 * '/', and signals that end the program, but those that are ignored, call
 * `leave` first, which makes only system calls. Writes fail at limits of sizes.
 */
void ibl_port_begin(int argc, char **argv, void (*leave)(void));
/* Between true and false no signal stops the calling thread, or threads that it
 * starts, but their own faults. They do not nest. */
void ibl_port_hold_signals(bool hold);
/* Tells those who run the program as a part of theirs what is done, or NULL. */
extern void (*const ibl_port_progress)(double done);
/* Names where a process's number is valid, among machines that share files. */
void ibl_port_place(char text[IBL_PORT_PATH]);
bool ibl_port_is_gone(long process);

/* Whether what is written in C++ can be loaded: the bridges. */
extern const bool ibl_port_loads;
/* Loads a library and sets *function to one of it. Else false and why; an empty
 * one: the library has no such function. */
bool ibl_port_load(const char *library, const char *name, void *function,
                   char why[IBL_PORT_WHY]);

#endif
