/* SPDX-License-Identifier: MIT */
#include "core/context.h"
#include "io/input.h"

ibl_status ibl_file_hash(const ibl_input *in, char hash[IBL_FILE_HASH])
{
    if (!in->bytes) {
        const int error = ibl_hash_file(in->name, hash);
        return error ? ibl_input_unread(in, error) : IBL_OK;
    }
    ibl_hash_bytes(in->bytes, in->size, hash);
    return IBL_OK;
}
