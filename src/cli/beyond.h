/* SPDX-License-Identifier: MIT */
/* What textures' pixels could not hold, in words and as JSON. */
#ifndef CLI_BEYOND_H
#define CLI_BEYOND_H

#include <ibl/io.h>
#include <jansson.h>

#include "cli/console.h"

/* Of levels together: all their texels, and the largest shares. Adds to *sum.
 */
void ibl_beyond_add(const ibl_overflow_level *level, ibl_overflow_level *sum);

/* One line about a file whose levels had that together; nothing if they had
 * nothing. */
void ibl_beyond_warn(ibl_console *console, const char *file, ibl_pixel pixel,
                     ibl_overflow overflow, const ibl_overflow_level *sum);

/* {"texels": .., "moved": .., "lost": ..}; NULL: no memory. */
json_t *ibl_beyond_json(const ibl_overflow_level *level);

#endif
