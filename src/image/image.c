/* SPDX-License-Identifier: MIT */
#include "core/alloc.h"
#include "core/context.h"

ibl_status ibl_image_alloc(ibl_ctx *ctx, int width, int height, ibl_image *img)
{
    if (width < 1 || width > IBL_MAX_EDGE || height < 1 ||
        height > IBL_MAX_EDGE)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "an image of %dx%d: each edge must be 1 to %d", width,
                        height, IBL_MAX_EDGE);
    float *data =
        ibl_alloc_array((size_t)width * (size_t)height, 3 * sizeof *data);
    if (!data)
        return ibl_no_memory(ctx, "an image");
    *img = (ibl_image){width, height, data};
    return IBL_OK;
}

void ibl_image_free(ibl_image *img)
{
    if (!img)
        return;
    ibl_free(img->data);
    *img = (ibl_image){0};
}
