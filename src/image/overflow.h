/* SPDX-License-Identifier: MIT */
/* Light that a pixel format cannot hold where it is: <ibl/io.h>'s
 * ibl_overflow. */
#ifndef IBL_IMAGE_OVERFLOW_H
#define IBL_IMAGE_OVERFLOW_H

#include "ibl/io.h"

/*
 * Says in out what of a level of n x n texels, 6 faces, is beyond the largest
 * values of the channels. Where that is anything and how is SPREAD, *settled
 * gets a copy of the level (ibl_free) that has nothing beyond any more; else
 * NULL. Texels are taken in order, on the caller's thread. IBL_ERR_MEMORY.
 */
ibl_status ibl_overflow_settle(ibl_ctx *ctx, ibl_overflow how,
                               const float max[3], int n, const float *level,
                               float **settled, ibl_overflow_level *out);

#endif
