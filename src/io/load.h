/* SPDX-License-Identifier: MIT */
/* Files and streams: opened for reading by offset, or into memory. */
#ifndef IBL_IO_LOAD_H
#define IBL_IO_LOAD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ibl/ibl.h"

/* Whether bytes begin as something that is worth reading on for. */
typedef bool ibl_known_fn(const unsigned char *bytes, size_t size);

/* Bytes that are read by offset: those of an open file, or of memory. */
typedef struct ibl_input {
    const char *name; /* stands in messages */
    size_t size;
    const unsigned char *bytes; /* NULL: they are in the file */
    void *owned;                /* memory to free with the input, or NULL */
    int fd;                     /* of the file, else -1 */
} ibl_input;

/*
 * Opens a file, or standard input for "-". A path that names a pipe (a named
 * FIFO, /dev/stdin, what a shell makes of <(command)) is read to its end if
 * somebody has it open for writing, within a short grace. Directories,
 * devices, terminals, pipes that nobody writes and empty files are refused.
 * Regular files that are named stay open, unless they are small; everything
 * else is read into memory.
 *   path    kept as the name in messages: must live as long as in
 *   known   a stream that it does not know ends at 256 MiB
 *   in      to be closed with ibl_input_close; nothing to close after an error
 * IBL_ERR_IO, IBL_ERR_FORMAT (empty), IBL_ERR_MEMORY, IBL_ERR_CANCELLED.
 */
ibl_status ibl_input_open(ibl_ctx *ctx, const char *path, ibl_known_fn *known,
                          ibl_input *in);
/* An input of bytes that stay the caller's. */
ibl_input ibl_input_of(const char *name, const void *bytes, size_t size);
/* Reads the file into memory, if it is not there. */
ibl_status ibl_input_load(ibl_ctx *ctx, ibl_known_fn *known, ibl_input *in);
/*
 * Copies up to size bytes from offset on; *got is less at the end, which may
 * come before in->size where the file was cut since. False: errno says why.
 * Safe on many threads at once.
 */
bool ibl_input_read(const ibl_input *in, uint64_t offset, size_t size,
                    void *dst, size_t *got);
void ibl_input_close(ibl_input *in); /* keeps the name */

/* Opens and loads. bytes: the caller's to free with ibl_free. */
ibl_status ibl_file_load(ibl_ctx *ctx, const char *path, ibl_known_fn *known,
                         unsigned char **bytes, size_t *size);

#endif
