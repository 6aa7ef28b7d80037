/* SPDX-License-Identifier: MIT */
#include "io/input.h"

#include <errno.h>
#include <stdio.h>

/* The functions themselves, so that the library needs no other one. */
#define XXH_INLINE_ALL
#include <xxhash.h>

#include "core/alloc.h"
#include "core/context.h"

enum {
    PIECE_BYTES = 256 * 1024 /* fits in the L2 cache */
};

static ibl_status take_all(const ibl_input *in, XXH3_state_t *state,
                           void *piece)
{
    size_t got;

    for (size_t at = 0; at < in->size; at += got) {
        if (ibl_cancelled(in->ctx))
            return IBL_ERR_CANCELLED;
        if (!ibl_input_read(in, at, PIECE_BYTES, piece, &got))
            return ibl_input_unread(in, errno);
        if (!got)
            break;
        XXH3_128bits_update(state, piece, got);
    }
    return IBL_OK;
}

ibl_status ibl_file_hash(const ibl_input *in, char hash[IBL_FILE_HASH])
{
    void *piece = ibl_alloc_array(PIECE_BYTES, 1);
    XXH3_state_t *state = ibl_alloc_array(1, sizeof *state);
    ibl_status status = IBL_OK;

    if (!piece || !state) {
        status = ibl_no_memory(in->ctx, "a hash");
    } else {
        XXH3_128bits_reset(state);
        status = take_all(in, state, piece);
    }
    if (!status) {
        const XXH128_hash_t h = XXH3_128bits_digest(state);
        snprintf(hash, IBL_FILE_HASH, "%016llx%016llx",
                 (unsigned long long)h.high64, (unsigned long long)h.low64);
    }
    ibl_free(state);
    ibl_free(piece);
    return status;
}
