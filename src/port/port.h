/* SPDX-License-Identifier: MIT */
/*
 * What a system must give beyond C11, pthreads and the calls that all have:
 * open files are read, written and closed, names are looked at with stat, and
 * folders listed as in POSIX. One file beside this one is compiled, for the
 * system that is built for; nothing else asks which one that is. Functions
 * return false, NULL or -1 and set errno if they fail.
 */
#ifndef IBL_PORT_PORT_H
#define IBL_PORT_PORT_H

#include <pthread.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    IBL_PORT_PATH = 4096,    /* a path and its zero */
    IBL_PORT_HUGE = 1 << 21, /* bytes of a huge page, on x86-64 and arm64 */
    IBL_PORT_WHY = 1024
};

/* ---- files --------------------------------------------------------------- */

/* Opens a file to be read, and does not wait for the writer of a FIFO. */
int ibl_port_open(const char *path);
/* Makes a new file to be written; no link is followed. */
int ibl_port_create(const char *path);
/* Waits for up to some milliseconds until read() does not. */
bool ibl_port_readable(int file, int milliseconds);
/* As read(), from a place of a regular file, on any thread. */
ptrdiff_t ibl_port_read_at(int file, void *to, size_t size, uint64_t offset);
bool ibl_port_flush(int file); /* to the disk */
/* Gives a file the name of another, which it replaces at once. */
bool ibl_port_replace(const char *from, const char *to);
bool ibl_port_make_folder(const char *path);
/* Bytes of what a path begins with that is there always: "/", "C:/",
 * "//machine/share/". 0: the path is relative. */
size_t ibl_port_root(const char *path);

/* Which file it is, in words that no two files share; what changes with it. */
typedef struct ibl_port_file {
    uint64_t device, number;
    uint64_t size;
    int64_t written, changed; /* nanoseconds since 1970: contents; anything */
} ibl_port_file;

/* Of what a name leads to, and of an open folder. */
bool ibl_port_identify(const char *path, ibl_port_file *file);
bool ibl_port_identify_folder(int folder, ibl_port_file *file);
bool ibl_port_is_link(const char *path);
/* The path without links. */
bool ibl_port_resolve(const char *path, char real[IBL_PORT_PATH]);

/* Opens a folder to lock or to flush it. Who opened it first locks it first;
 * closing it ends the lock. */
int ibl_port_open_folder(const char *path);
/* False, unless it waits: it is locked already, by this process or another.
 * Folders that cannot be locked, as of NFS, count as locked. */
bool ibl_port_lock_folder(int folder, bool wait);
bool ibl_port_flush_folder(int folder);
void ibl_port_close_folder(int folder);

/* ---- memory, threads ----------------------------------------------------- */

/* Memory for ibl_port_free. Huge pages where they are asked for by alignment.
 * The alignment is a power of 2, and bytes are a multiple of it. */
void *ibl_port_alloc(size_t alignment, size_t bytes);
void ibl_port_free(void *p);
/* Bytes of physical memory; 0: unknown. */
uint64_t ibl_port_memory(void);
/* CPUs that this process may run on, but for quotas. */
int ibl_port_cpus(void);
/* What the groups of this process allow of both, CPUs rounded up; 0: no limit.
 * root is before the paths of system files: "", or a folder in tests. */
int ibl_port_cpu_quota(const char *root);
uint64_t ibl_port_memory_quota(const char *root);

/* Starts a thread that takes no signals but those of its own faults. */
bool ibl_port_start(pthread_t *thread, void *(*run)(void *), void *arg);

/* ---- signals, the program ------------------------------------------------ */

/* Between these no signal stops the calling thread. They do not nest. */
void ibl_port_hold_signals(void);
void ibl_port_release_signals(void);
/* Signals that end a program call `leave` first, which makes only system calls.
 * Those that are ignored stay so. Writes fail at limits of sizes. */
void ibl_port_catch_signals(void (*leave)(void));

/* First of all in main: the standard streams are open, and as they are in
 * POSIX; paths have no separator but '/'. */
void ibl_port_begin(int argc, char **argv);
/* Tells who runs the program as a part of theirs what share is done. */
void ibl_port_progress(double done);
const char *ibl_port_name(void); /* of the program */
/* The file of the program. */
bool ibl_port_program(char *path, size_t size);
/* Names what a process's number is valid in, among machines that share files.
 */
void ibl_port_place(char text[IBL_PORT_PATH]);
bool ibl_port_is_gone(long process);

/* Whether what is written in C++ can be loaded: the bridges. */
extern const bool ibl_port_loads;
/* Loads a library and sets *function to one of it. Else false and why; an empty
 * one: the library has no such function. */
bool ibl_port_load(const char *library, const char *name, void *function,
                   char why[IBL_PORT_WHY]);

/* strtod() of the C locale. */
double ibl_port_number(const char *text, char **end);

#endif
