/* SPDX-License-Identifier: MIT */
/* Whole files and streams into memory. */
#ifndef IBL_IO_LOAD_H
#define IBL_IO_LOAD_H

#include <stdbool.h>
#include <stddef.h>

#include "ibl/ibl.h"

/* Whether bytes begin as something that is worth reading on for. */
typedef bool ibl_known_fn(const unsigned char *bytes, size_t size);

/*
 * Reads a file, or standard input for "-". A path that names a pipe (a named
 * FIFO, /dev/stdin, what a shell makes of <(command)) is read to its end if
 * somebody has it open for writing, within a short grace. Directories,
 * devices, terminals, pipes that nobody writes and empty files are refused.
 *   known   a stream that it does not know ends at 256 MiB
 *   bytes   the caller's to free with ibl_free
 * IBL_ERR_IO, IBL_ERR_FORMAT (empty), IBL_ERR_MEMORY, IBL_ERR_CANCELLED.
 */
ibl_status ibl_file_load(ibl_ctx *ctx, const char *path, ibl_known_fn *known,
                         unsigned char **bytes, size_t *size);

#endif
