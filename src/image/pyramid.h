/* SPDX-License-Identifier: MIT */
/* A cube and its mips, laid out for bilinear lookups. */
#ifndef IBL_IMAGE_PYRAMID_H
#define IBL_IMAGE_PYRAMID_H

#include "ibl/ibl.h"

/*
 * A face of level l is (edge + 2)^2 texels of 4 floats R G B A, rows from the
 * top, no padding: the face's own texels and one more all around, taken from
 * the neighbouring faces (in a corner, where three texels meet, their mean).
 * A bilinear lookup anywhere on a face thus stays on it, and on the border of
 * two faces both give the same: OpenGL's seamless filtering. Horizontal pairs
 * of texels are 32 bytes together. Faces follow each other.
 *
 * A texel is the mean of the level above under the tent of bilinear lookups,
 * weighted by solid angle: along each edge 1/8 3/8 3/8 1/8 of four texels,
 * across faces too. A plain 2x2 mean would put a small light in the middle of
 * its texel, up to half a texel from where it is; the tent shares it out so
 * that lookups find it in place. A is the solid angle that a texel gathered.
 *
 * The smallest value of each channel is taken off every texel and kept in
 * floor: weights that sum to 1 let constants pass, so who looks up adds it at
 * the end, and a constant map stays what it is to the last bit.
 */
typedef struct ibl_pyramid {
    int size, levels;
    float floor[3];
    float *texels[IBL_MAX_LEVELS]; /* face +X of each level; [0] owns all */
} ibl_pyramid;

/* From level 0 of a cube, which is not needed after. Every level has half the
 * edge of the one above, exactly. Reports as stage "mips". */
ibl_status ibl_pyramid_create(ibl_ctx *ctx, const ibl_cube *cube, int levels,
                              ibl_pyramid *pyramid);
void ibl_pyramid_free(ibl_pyramid *pyramid); /* NULL and zeroed are fine */

#endif
