/* SPDX-License-Identifier: MIT */
#ifndef CLI_SIDECAR_H
#define CLI_SIDECAR_H

#include "cli/bake_record.h"

/* NAME.json: see FILES in the manual page. Says nothing of threads or times
 * unless --timings was given, so that equal bakes give equal bytes. The text
 * is the caller's to free; NULL: no memory. */
char *ibl_sidecar_text(const ibl_bake *b);

#endif
