/* SPDX-License-Identifier: MIT */
/* Pixels that no radiance has: Inf, NaN and negative values. */
#ifndef IBL_IO_REPAIR_H
#define IBL_IO_REPAIR_H

#include <stddef.h>

#include "ibl/ibl.h"

typedef struct ibl_repair {
    size_t nonfinite; /* pixels that held Inf or NaN */
    size_t negative;  /* pixels that held a finite value below 0 */
    float peak;       /* largest component after */
} ibl_repair;

/*
 * Mends img as ibl_image_read says, the same for any number of threads. -0
 * becomes 0 and is not counted. IBL_ERR_CANCELLED or IBL_ERR_MEMORY leave img
 * half mended.
 */
ibl_status ibl_image_repair(ibl_ctx *ctx, ibl_image *img, ibl_repair *done);

#endif
