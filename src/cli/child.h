/* SPDX-License-Identifier: MIT */
/* Commands run and measured as child processes. */
#ifndef CLI_CHILD_H
#define CLI_CHILD_H

#include <stdbool.h>
#include <stddef.h>

typedef struct ibl_child {
    double wall_s;     /* from before the fork until its end was seen */
    double cpu_s;      /* user and system, of its own children too */
    size_t peak_bytes; /* the largest resident set of it or of a child */
    int status;        /* as of waitpid */
    int error;         /* errno of what kept it from starting, or 0 */
    bool timed_out;    /* was killed after limit_s */
} ibl_child;

/*
 * Runs argv (argv[0] a path, not looked up) in a process group of its own and
 * waits; whatever is left of the group at its end is killed. Standard input
 * is empty, both outputs go to the new file log. A signal that ends this
 * program takes the group along.
 *
 * Memory: Linux counts the pages that the parent had at the fork, so call
 * this before anything large was allocated.
 */
void ibl_child_run(const char *const *argv, const char *log, double limit_s,
                   ibl_child *result);

/*
 * Why a child failed, in words without a newline: "no end within 5 s", or its
 * exit status or signal and the last line that it left in log. Empty if it
 * did not fail.
 */
void ibl_child_reason(const ibl_child *c, const char *log, double limit_s,
                      char *text, size_t size);

#endif
