/* SPDX-License-Identifier: MIT */
/* The levels of supercompressed KTX2 files: frames of Zstandard (RFC 8878). */
#ifndef IBL_IO_ZSTD_FRAMES_H
#define IBL_IO_ZSTD_FRAMES_H

#include "io/container.h"

/*
 * Compresses each level to a frame that states its size, on the pool.
 *   tex     valid, zstd is 1..IBL_MAX_ZSTD
 *   packed  memory of all frames, which the caller frees, after errors too
 *   frames  one for each level
 */
ibl_status ibl_zstd_pack(ibl_ctx *ctx, const ibl_texture *tex,
                         unsigned char **packed,
                         ibl_piece frames[IBL_MAX_TEXTURE_LEVELS]);

/*
 * Checks that the `packed` bytes at an offset, which are in the file, are one
 * or more whole frames that do not claim to hold other than `bytes`, and could
 * hold so much. Allocates nothing. level: for messages.
 */
ibl_status ibl_zstd_check(const ibl_input *in, int level, uint64_t at,
                          uint64_t packed, uint64_t bytes);

/* Decompresses the same frames to `bytes` of new memory, which the caller frees
 * with ibl_free; NULL after an error. */
ibl_status ibl_zstd_unpack(const ibl_input *in, int level, uint64_t at,
                           uint64_t packed, uint64_t bytes,
                           unsigned char **unpacked);

#endif
