/* SPDX-License-Identifier: MIT */
/* Messages of one line, with any names in them. */
#ifndef VIEW_MESSAGE_H
#define VIEW_MESSAGE_H

#include <stdbool.h>

#include "ibl/ibl.h"

/* Prints "iblview: ..." on standard error: the problem, its place and a remedy.
 * Returns false, for `return view_fail(...)`. */
bool view_fail(const char *fmt, ...) __attribute__((format(printf, 1, 2)));
/* The same for what does not stop the program; silent after view_quiet. */
void view_note(const char *fmt, ...) __attribute__((format(printf, 1, 2)));
void view_quiet(void);
/* The text of the last view_fail; "" before. */
const char *view_last_failure(void);

/* Log callback of contexts: errors to view_fail, warnings to view_note. */
void view_log(void *cookie, ibl_log_level level, const char *text);

/* Appends to a text of that many bytes, as far as it has room. */
void view_add(char *text, size_t size, const char *fmt, ...)
    __attribute__((format(printf, 3, 4)));

#endif
