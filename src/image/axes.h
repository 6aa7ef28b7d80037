/* SPDX-License-Identifier: MIT */
/* Signed permutations of the axes, and of the texels of a cube. */
#ifndef IBL_IMAGE_AXES_H
#define IBL_IMAGE_AXES_H

#include <stddef.h>

#include "ibl/ibl.h"

/* Checks the range. Else IBL_ERR_ARGUMENT. */
ibl_status ibl_check_axes(ibl_ctx *ctx, ibl_axes axes);

/*
 * Permutes the texels of a level: those of `to` have the directions of `from`
 * in other axes, as by ibl_axes_turn. Runs on ctx's pool.
 *   s         of the level; if flat, axes only mirror
 *   words     of 4 bytes in a texel
 *   from, to  the texels of a level each, apart
 */
ibl_status ibl_level_turn_axes(ibl_ctx *ctx, ibl_level_shape s, int words,
                               ibl_axes axes, int back, const void *from,
                               void *to);

#endif
