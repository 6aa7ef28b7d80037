/* SPDX-License-Identifier: MIT */
#ifndef CLI_SESSION_H
#define CLI_SESSION_H

#include "cli/common_options.h"
#include "cli/console.h"

/* A context for the settings, that reports to the console. */
ibl_status ibl_start(const ibl_common *common, ibl_console *console,
                     ibl_ctx **ctx);

/* Outputs that a signal aborts, until they are committed or have ended. */
ibl_status ibl_start_outputs(ibl_ctx *ctx, int sync, ibl_outputs **outputs);
/* A signal waits until all of them are in place. */
ibl_status ibl_commit_outputs(ibl_outputs *outputs);
/* Removes what was not committed, and frees them; NULL is fine. */
void ibl_end_outputs(ibl_outputs *outputs);

/* Adds a level to the sum of several: all their texels, and the largest
 * shares. */
void ibl_overflow_add(const ibl_overflow_level *level, ibl_overflow_level *sum);
/* Warns of a file whose levels together overflow, if they do. */
void ibl_warn_of_overflow(ibl_console *console, const char *file,
                          ibl_pixel pixel, ibl_overflow overflow,
                          const ibl_overflow_level *sum);

/* Warns of levels with so few texels that lookups between them are wrong. */
void ibl_warn_of_small_faces(ibl_console *console,
                             const ibl_specular_layout *layout);

#endif
