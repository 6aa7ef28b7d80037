/* SPDX-License-Identifier: MIT */
#ifndef COMMON_STDERR_LINE_H
#define COMMON_STDERR_LINE_H

/* Room for two paths and a message about them. */
enum {
    IBL_LINE_BYTES = 2 * 4096 + 1024
};

/* A byte in a name that would break a line or steer the terminal becomes
 * '?'. */
void ibl_one_line(char *text);

/* Prints "PROGRAM: ", kind and text as one such line on standard error, by one
 * write, which other programs' lines do not cut. */
void ibl_print_line(const char *kind, const char *text);

#endif
