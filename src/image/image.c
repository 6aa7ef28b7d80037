/* SPDX-License-Identifier: MIT */
#include "image/image.h"

#include "core/alloc.h"
#include "core/context.h"

static ibl_status check_size(ibl_ctx *ctx, int width, int height)
{
    if (width < 1 || width > IBL_MAX_EDGE || height < 1 ||
        height > IBL_MAX_EDGE)
        return ibl_fail(ctx, IBL_ERR_ARGUMENT,
                        "an image of %dx%d: each edge must be 1 to %d", width,
                        height, IBL_MAX_EDGE);
    return IBL_OK;
}

ibl_status ibl_check_image(ibl_ctx *ctx, const ibl_image *img)
{
    if (!ctx || !img || !img->data)
        return ibl_missing(ctx, "an image or its data");
    return check_size(ctx, img->width, img->height);
}

ibl_status ibl_image_alloc(ibl_ctx *ctx, int width, int height, ibl_image *img)
{
    if (!ctx || !img)
        return ibl_missing(ctx, "ibl_image_alloc: img");
    const ibl_status status = check_size(ctx, width, height);
    if (status)
        return status;
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
