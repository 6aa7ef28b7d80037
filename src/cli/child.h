/* SPDX-License-Identifier: MIT */
/* Runs and measures commands as child processes; makes a private directory for
 * their files. */
#ifndef CLI_CHILD_H
#define CLI_CHILD_H

#include <stdbool.h>
#include <stddef.h>

typedef struct ibl_child {
    double wall_s;     /* from before the fork until the end was seen */
    double cpu_s;      /* user and system, including the child's children */
    size_t peak_bytes; /* largest resident set of it or of a child */
    bool timed_out;    /* was killed after limit_s */
    /* Why it failed, without a newline: "cannot be run: ...", "no end within
     * 5 s", or its exit status or signal and the last line of its log. Empty
     * if it did not fail. */
    char reason[600];
} ibl_child;

/*
 * Runs argv (argv[0] a path, not looked up) as the leader of a process group,
 * waits at most limit_s seconds, and kills the rest of the group. Standard
 * input is empty, both outputs go to the new file log. A signal that ends this
 * program also kills the group. False: it failed, see result->reason.
 *
 * On Linux peak_bytes includes the pages that this process has at the fork, so
 * call this before you allocate anything large.
 */
bool ibl_child_run(char *const *argv, const char *log, double limit_s,
                   ibl_child *result);

/* Runs work(cookie) in a forked child, under the same rules for signals.
 * Returns the status from waitpid; -1, with errno: no child could be made. */
int ibl_child_call(bool (*work)(void *cookie), void *cookie);

/*
 * Makes a directory (mode 0700, in $TMPDIR or /tmp) and returns
 * work(cookie, path). Another process removes the directory and its contents
 * when work has returned or this process has ended for any reason. Returns 1
 * after one line on stderr if the directory cannot be made or removed.
 */
int ibl_scratch_run(int (*work)(const void *cookie, const char *path),
                    const void *cookie);

/* Removes path and its contents; does not follow links. False sets errno. */
bool ibl_scratch_remove(const char *path);

#endif
