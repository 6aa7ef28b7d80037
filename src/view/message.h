/* SPDX-License-Identifier: MIT */
/* One line for what a user has to know, whatever names are in it. */
#ifndef VIEW_MESSAGE_H
#define VIEW_MESSAGE_H

#include <stdbool.h>

#include "ibl/ibl.h"

/* Prints "iblview: ..." on standard error: what is wrong, where, and what to
 * do. Returns false, for `return view_fail(...)`. */
bool view_fail(const char *fmt, ...) __attribute__((format(printf, 1, 2)));
/* The same for what does not stop the program; silent after view_quiet. */
void view_note(const char *fmt, ...) __attribute__((format(printf, 1, 2)));
void view_quiet(void);
/* The text alone on standard output: what was asked for. */
void view_tell(const char *fmt, ...) __attribute__((format(printf, 1, 2)));

/* For ibl_ctx_options: errors to view_fail, warnings to view_note. */
void view_log(void *cookie, ibl_log_level level, const char *text);

#endif
