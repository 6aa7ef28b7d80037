/* SPDX-License-Identifier: MIT */
#include <string.h>

#include "core/alloc.h"
#include "io/container.h"
#include "io/load.h"

static uint64_t longest(const unsigned char *bytes, size_t size)
{
    return ibl_is_ktx2(bytes, size) || ibl_is_ktx(bytes, size) ||
                   ibl_is_dds(bytes, size)
               ? IBL_LONGEST
               : 0;
}

ibl_status ibl_texture_read(ibl_ctx *ctx, const char *path, ibl_texture *tex,
                            ibl_container *container)
{
    unsigned char *bytes;
    size_t size;

    if (!ctx || !path || !tex)
        return ibl_missing(ctx, "ibl_texture_read: path or tex");
    *tex = (ibl_texture){0};
    ibl_status status = ibl_file_load(ctx, path, longest, &bytes, &size);
    if (status)
        return status;
    status =
        ibl_texture_decode(ctx, strcmp(path, "-") ? path : "standard input",
                           bytes, size, tex, container);
    ibl_free(bytes);
    return status;
}
