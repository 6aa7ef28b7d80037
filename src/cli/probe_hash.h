/* SPDX-License-Identifier: MIT */
/* Names of contents: 128 bits of XXH3, as 32 hexadecimal digits. They tell a
 * file that changed, not one that somebody forged. */
#ifndef CLI_PROBE_HASH_H
#define CLI_PROBE_HASH_H

#include <stdbool.h>
#include <stddef.h>

#include <ibl/io.h>

enum {
    IBL_HASH_SIZE = 33
};

void ibl_hash_bytes(const void *bytes, size_t size, char hash[IBL_HASH_SIZE]);

/* Of the file that a texture is written as. */
ibl_status ibl_hash_texture(ibl_ctx *ctx, const ibl_texture *tex,
                            ibl_container container, char hash[IBL_HASH_SIZE]);

/* Of all of a file, which must be a regular one; errno if not. */
bool ibl_hash_file(const char *path, char hash[IBL_HASH_SIZE]);

/* Whether text could be a hash. */
bool ibl_hash_is(const char *text);

#endif
