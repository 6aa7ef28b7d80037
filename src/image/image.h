/* SPDX-License-Identifier: MIT */
#ifndef IBL_IMAGE_IMAGE_H
#define IBL_IMAGE_IMAGE_H

#include "ibl/ibl.h"

/* Checks that there is a context and a valid image, with data and a size in
 * range. Else IBL_ERR_ARGUMENT. */
ibl_status ibl_check_image(ibl_ctx *ctx, const ibl_image *img);

/* Fills map, whose width is a multiple of 4, from a square octahedral image.
 * Each pixel is the mean over its solid angle of the texels, as patches of
 * constant radiance. */
ibl_status ibl_latlong_from_octahedral(ibl_ctx *ctx, const ibl_image *from,
                                       ibl_image *map);

/* i around a circle of n. */
static inline int ibl_wrap(int i, int n)
{
    i %= n;
    return i < 0 ? i + n : i;
}

#endif
