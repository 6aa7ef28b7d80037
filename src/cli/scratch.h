/* SPDX-License-Identifier: MIT */
/* A private directory that is gone afterwards, however the work in it ends. */
#ifndef CLI_SCRATCH_H
#define CLI_SCRATCH_H

#include <stdbool.h>

/*
 * Makes a directory (mode 0700, in $TMPDIR or /tmp), runs work(cookie, path)
 * in a child process and returns its status. When the child has ended, by
 * whatever, the directory is removed with all that is in it. The signals of
 * cli/signals.h are passed on to the child; if one of them ends it, this
 * process dies of that too. 1 after one line on stderr: the directory cannot be
 * made or removed, or the child was killed by another signal.
 */
int ibl_scratch_run(int (*work)(void *cookie, const char *path), void *cookie);

/* Removes path and all in it, not following links. errno is set on failure. */
bool ibl_scratch_remove(const char *path);

#endif
