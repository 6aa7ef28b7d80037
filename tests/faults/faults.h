/* SPDX-License-Identifier: MIT */
/* What preload.c and walk.c share. */
#ifndef FAULTS_H
#define FAULTS_H

#include <stdatomic.h>
#include <stdint.h>

/* Kinds of calls, and their names in FAULT. */
enum {
    FAULT_MEMORY, /* malloc and its like, streams in memory */
    FAULT_THREAD,
    FAULT_OPEN,   /* of what is there */
    FAULT_CREATE, /* open with O_CREAT */
    FAULT_READ,
    FAULT_WRITE,
    FAULT_CLOSE,
    FAULT_FLUSH, /* fsync */
    FAULT_LOCK,  /* flock */
    FAULT_RENAME,
    FAULT_REMOVE, /* unlink, rmdir */
    FAULT_MKDIR,
    FAULT_STAT, /* access, too */
    FAULT_FILE, /* any of them from open on */
    FAULT_KINDS,
    FAULT_PLACES = 8
};

static const char *const fault_kinds[FAULT_KINDS] = {
    "memory", "thread", "open",   "create", "read",  "write", "close",
    "flush",  "lock",   "rename", "remove", "mkdir", "stat",  "file"};

/* Shared by all processes that a program starts. */
typedef struct fault_counts {
    atomic_uint calls[FAULT_KINDS];
    atomic_uint failed;
    uintptr_t place[FAULT_PLACES]; /* in the program, for addr2line */
} fault_counts;

#endif
