/* SPDX-License-Identifier: MIT */
/* Light above the range of a pixel format: <ibl/io.h>'s ibl_overflow. */
#ifndef IBL_IMAGE_OVERFLOW_H
#define IBL_IMAGE_OVERFLOW_H

#include "ibl/io.h"

/*
 * Reports in out how much of a level is above max,
 * the channels' largest values. If any is and how is SPREAD, *settled becomes a
 * copy of the level with nothing above max (free with ibl_free), else NULL.
 * Runs on the caller's thread, so the order of texels is fixed.
 * Returns IBL_OK or IBL_ERR_MEMORY.
 */
ibl_status ibl_overflow_settle(ibl_ctx *ctx, ibl_overflow how,
                               const float max[3], const ibl_level_shape *shape,
                               const float *level, float **settled,
                               ibl_overflow_level *out);

#endif
