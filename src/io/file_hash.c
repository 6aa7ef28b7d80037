/* SPDX-License-Identifier: MIT */
#include "io/input.h"

#include <errno.h>

#include "core/alloc.h"
#include "core/context.h"
#include "core/hash.h"

enum {
    PIECE_BYTES = 256 * 1024 /* fits in the L2 cache */
};

static ibl_status take_all(const ibl_input *in, ibl_hash *h, void *piece)
{
    size_t got;

    for (size_t at = 0; at < in->size; at += got) {
        if (ibl_cancelled(in->ctx))
            return IBL_ERR_CANCELLED;
        if (!ibl_input_read(in, at, PIECE_BYTES, piece, &got))
            return ibl_input_unread(in, errno);
        if (!got)
            break;
        ibl_hash_add(h, piece, got);
    }
    return IBL_OK;
}

ibl_status ibl_file_hash(const ibl_input *in, char hash[IBL_FILE_HASH])
{
    void *piece = ibl_alloc_array(PIECE_BYTES, 1);
    ibl_hash h;

    if (!piece)
        return ibl_no_memory(in->ctx, "a hash");
    ibl_hash_begin(&h);
    const ibl_status status = take_all(in, &h, piece);
    if (!status)
        ibl_hash_end(&h, hash);
    ibl_free(piece);
    return status;
}
