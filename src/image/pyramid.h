/* SPDX-License-Identifier: MIT */
/* A cube and its mips, laid out for bilinear lookups. */
#ifndef IBL_IMAGE_PYRAMID_H
#define IBL_IMAGE_PYRAMID_H

#include "ibl/ibl.h"

/*
 * A face of level l is (edge + 2)^2 texels of 4 floats R G B A, rows from the
 * top, no padding: the face's own texels and a border of one texel, copied from
 * the neighbouring faces (in a corner, where three texels meet, their mean).
 * So a bilinear lookup needs one face only, and on the border of two faces both
 * give the same: OpenGL's seamless filtering. Horizontal pairs of texels are 32
 * bytes together. Faces follow each other.
 *
 * A texel is the mean of the level above under the tent of bilinear lookups,
 * weighted by solid angle: along each edge 1/8 3/8 3/8 1/8 of four texels,
 * across faces too. A plain 2x2 mean would move a small light to the middle of
 * its texel, by up to half a texel; with the tent, lookups find it in place. A
 * is the solid angle that a texel gathered.
 *
 * The smallest value of each channel is subtracted from every texel and kept in
 * floor. Weights sum to 1, so a caller adds floor after the lookups, and a
 * constant map is exact to the last bit.
 */
typedef struct ibl_pyramid {
    int size, levels;
    float floor[3];
    float *texels[IBL_MAX_LEVELS]; /* face +X of each level; [0] owns all */
} ibl_pyramid;

/* Builds the pyramid from level 0 of a cube, which is not needed afterwards.
 * Each level has exactly half the edge of the one above. Reports as stage
 * "mips". */
ibl_status ibl_pyramid_create(ibl_ctx *ctx, const ibl_cube *cube, int levels,
                              ibl_pyramid *pyramid);
void ibl_pyramid_free(ibl_pyramid *pyramid); /* NULL and zeroed are allowed */

#endif
