/* SPDX-License-Identifier: MIT */
/* A program's clock, and its standard streams. */
#ifndef COMMON_PROCESS_H
#define COMMON_PROCESS_H

#include <stdio.h>

#include "json/text.h"

/* Seconds of the monotonic clock. */
double ibl_now(void);

/* Replaces control characters, which would break the line or act on the
 * terminal, by '?'. */
void ibl_one_line(char *text);

/* Prints "PROGRAM: ", kind and text as one such line on standard error, in one
 * write, so that lines of other programs do not mix with it. */
void ibl_print_line(const char *kind, const char *text);

/* Flushes a stream. NULL if all that was printed is written, else why not:
 * errno, which the caller sets to 0 before. */
const char *ibl_unwritten(FILE *stream);

#endif
