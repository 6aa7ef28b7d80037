/* SPDX-License-Identifier: MIT */
#ifndef CLI_HASH_H
#define CLI_HASH_H

#include <stdbool.h>
#include <stddef.h>

#include <ibl/io.h>

/* Hashes of contents: 128 bits of XXH3, as 32 hexadecimal digits and a NUL.
 * They detect changes, not forgery. */
enum {
    IBL_HASH_SIZE = 33
};

void ibl_hash_bytes(const void *bytes, size_t size, char hash[IBL_HASH_SIZE]);

/* Hashes the bytes of ibl_texture_visit, which are those of tex's file. */
ibl_status ibl_hash_texture(ibl_ctx *ctx, const ibl_texture *tex,
                            ibl_container container, char hash[IBL_HASH_SIZE]);

/* Hashes a regular file. False, with errno: it cannot be read; EISDIR: it is a
 * directory; EINVAL: it is neither. */
bool ibl_hash_file(const char *path, char hash[IBL_HASH_SIZE]);

#endif
