/* SPDX-License-Identifier: MIT */
#ifndef COMMON_LINE_H
#define COMMON_LINE_H

/* Room for two paths and what is to be said about them. */
enum {
    IBL_LINE_BYTES = 2 * 4096 + 1024
};

/* Prints "PROGRAM: ", kind and text as one line on standard error, by one
 * write, which other programs' lines do not cut: a byte in a name that would
 * break the line or steer the terminal becomes '?'. */
void ibl_print_line(const char *kind, const char *text);

#endif
