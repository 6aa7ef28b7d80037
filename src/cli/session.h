/* SPDX-License-Identifier: MIT */
/* The context of a command, and warnings that several commands have. */
#ifndef CLI_SESSION_H
#define CLI_SESSION_H

#include "cli/common_options.h"
#include "cli/console.h"
#include "common/signals.h"

/* A context for the settings, that reports to the console. */
ibl_status ibl_start(const ibl_common *common, ibl_console *console,
                     ibl_ctx **ctx);

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
