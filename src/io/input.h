/* SPDX-License-Identifier: MIT */
/* Files and streams, opened for reading by offset or read into memory, and
 * hashes of contents. */
#ifndef IBL_IO_INPUT_H
#define IBL_IO_INPUT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ibl/io.h"

/* Bytes to read by offset, in an open file or in memory. */
typedef struct ibl_input {
    ibl_ctx *ctx;
    const char *name; /* for messages */
    size_t size;
    const unsigned char *bytes; /* NULL: the bytes are in the file */
    void *owned;                /* memory that ibl_input_close frees, or NULL */
    int fd;                     /* of the open file, or -1 */
    size_t head; /* bytes that there are of a texture of which all but texels
                    is wanted; 0: all */
} ibl_input;

/* ibl_fail with the name and ": " before the text. */
ibl_status ibl_reject(const ibl_input *in, ibl_status status, const char *fmt,
                      ...) __attribute__((format(printf, 3, 4)));
#define ibl_bad_file(in, ...) ibl_reject(in, IBL_ERR_FORMAT, __VA_ARGS__)
#define ibl_unsupported(in, ...)                                               \
    ibl_reject(in, IBL_ERR_UNSUPPORTED, __VA_ARGS__)
/* Refuses what takes more bytes at once than the context allows. */
ibl_status ibl_allow(const ibl_input *in, size_t bytes);
enum {
    IBL_QUOTE_BYTES = 48
};
/* A text of a file for a message: printable, cut where it is long. */
const char *ibl_quote(const char *text, char out[IBL_QUOTE_BYTES]);
/* Reports that a read failed; error is its errno. */
ibl_status ibl_input_unread(const ibl_input *in, int error);

/*
 * Opens a file, or standard input for "-". Directories, devices, terminals and
 * empty files are refused. Large regular files stay open; everything else, also
 * a pipe by name (a FIFO, /dev/stdin, a shell's <(command)), is read to its end
 * into memory: 4 GiB at most, and half of the memory that is allowed.
 *   path    the name in messages; must live as long as in
 *   in      the caller must close it with ibl_input_close, unless this fails
 * IBL_ERR_IO, IBL_ERR_FORMAT (empty), IBL_ERR_MEMORY, IBL_ERR_CANCELLED.
 */
ibl_status ibl_input_open(ibl_ctx *ctx, const char *path, ibl_input *in);
/* An input over the caller's bytes. */
ibl_input ibl_input_of(ibl_ctx *ctx, const char *name, const void *bytes,
                       size_t size);
/* Whether [at, at + size) is inside the file, or inside its head. */
bool ibl_input_has(const ibl_input *in, uint64_t at, uint64_t size);
/* Reads the file into memory, unless it is there already. */
ibl_status ibl_input_load(ibl_input *in);
/* Copies up to size bytes from offset on. *got is less than size at the end of
 * the file, which may come before in->size if the file was truncated since.
 * False: errno says why. Safe on many threads at once. */
bool ibl_input_read(const ibl_input *in, uint64_t offset, size_t size,
                    void *dst, size_t *got);
void ibl_input_close(ibl_input *in); /* keeps in->name */

/* XXH3 of 128 bits of the input's bytes, in hexadecimal digits. */
ibl_status ibl_file_hash(const ibl_input *in, char hash[IBL_FILE_HASH]);

/* Reads a decimal number after blanks and moves *t behind it; does not depend
 * on the locale. False: there is none. */
bool ibl_take_number(char **t, double *value);

/* ---- hashes of contents in pieces; ibl/io.h has those of whole ones ---- */

/* A hash of several pieces: begin, add each, end. */
typedef struct ibl_hash {
    _Alignas(64) unsigned char state[576]; /* XXH3's own */
} ibl_hash;
void ibl_hash_begin(ibl_hash *h);
void ibl_hash_add(ibl_hash *h, const void *bytes, size_t size);
void ibl_hash_end(const ibl_hash *h, char text[IBL_FILE_HASH]);

#endif
