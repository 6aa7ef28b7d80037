/* SPDX-License-Identifier: MIT */
/* Files and streams: opened for reading by offset, or into memory. */
#ifndef IBL_IO_INPUT_H
#define IBL_IO_INPUT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ibl/ibl.h"

/* The most bytes of a file that begins with these; 0: of no known kind. */
typedef uint64_t ibl_longest_fn(const unsigned char *bytes, size_t size);

/* The largest map, flat, in 4 channels of 4 bytes, is 64 GiB. */
#define IBL_LONGEST ((uint64_t)65 << 30)

/* Bytes that are read by offset: those of an open file, or of memory. */
typedef struct ibl_input {
    ibl_ctx *ctx;
    const char *name; /* for messages */
    size_t size;
    const unsigned char *bytes; /* NULL: they are in the file */
    void *owned;                /* memory to free with the input, or NULL */
    int fd;                     /* of the file, else -1 */
    bool swap;                  /* its words are big endian */
} ibl_input;

/* ibl_fail with the name and ": " before the text. */
ibl_status ibl_reject(const ibl_input *in, ibl_status status, const char *fmt,
                      ...) __attribute__((format(printf, 3, 4)));
#define ibl_bad_file(in, ...) ibl_reject(in, IBL_ERR_FORMAT, __VA_ARGS__)
#define ibl_unsupported(in, ...)                                               \
    ibl_reject(in, IBL_ERR_UNSUPPORTED, __VA_ARGS__)
enum {
    IBL_QUOTE_BYTES = 48
};
/* A text of a file as a message repeats it: printable, cut where it is long. */
const char *ibl_quote(const char *text, char out[IBL_QUOTE_BYTES]);
/* Says that a read failed, with an errno. */
ibl_status ibl_input_unread(const ibl_input *in, int error);

/*
 * Opens a file, or standard input for "-". A pipe by name (a FIFO, /dev/stdin,
 * a shell's <(command)) is read to its end if a writer opens it within half a
 * second. Directories, devices, terminals, other pipes and empty files are
 * refused. Large regular files stay open; everything else is read into memory.
 *   path    the name in messages; must live as long as in
 *   longest a longer stream is refused; one of no known kind from 256 MiB on
 *   in      to be closed with ibl_input_close, but not after an error
 * IBL_ERR_IO, IBL_ERR_FORMAT (empty), IBL_ERR_MEMORY, IBL_ERR_CANCELLED.
 */
ibl_status ibl_input_open(ibl_ctx *ctx, const char *path,
                          ibl_longest_fn *longest, ibl_input *in);
/* An input of bytes that stay the caller's. */
ibl_input ibl_input_of(ibl_ctx *ctx, const char *name, const void *bytes,
                       size_t size);
/* Whether [at, at + size) is inside. */
bool ibl_input_has(const ibl_input *in, uint64_t at, uint64_t size);
/* Reads the file into memory, if it is not there. */
ibl_status ibl_input_load(ibl_input *in);
/*
 * Copies up to size bytes from offset on; *got is less at the end, which may
 * come before in->size where the file was cut since. False: errno says why.
 * Safe on many threads at once.
 */
bool ibl_input_read(const ibl_input *in, uint64_t offset, size_t size,
                    void *dst, size_t *got);
void ibl_input_close(ibl_input *in); /* keeps the name */

#endif
