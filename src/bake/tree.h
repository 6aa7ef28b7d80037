/* SPDX-License-Identifier: MIT */
/* The source as a tree of blocks, for the sums of the specular chain to a
 * known accuracy without visiting every pixel. */
#ifndef IBL_BAKE_TREE_H
#define IBL_BAKE_TREE_H

#include "brdf/lobe.h"
#include "ibl/ibl.h"

typedef struct ibl_tree ibl_tree;

/* Borrows env until ibl_tree_free. IBL_ERR_CANCELLED, IBL_ERR_MEMORY. */
ibl_status ibl_tree_create(ibl_ctx *ctx, const ibl_image *env, double yaw_deg,
                           ibl_tree **out);
void ibl_tree_free(ibl_tree *tree); /* NULL is fine */

/* Mean radiance over the sphere. */
void ibl_tree_mean(const ibl_tree *tree, double rgb[3]);

/*
 * sum L_i K_i dO_i, K = D N.L of a lobe with an integral of 1: the sum of
 * ibl_bake_specular in double precision, each pixel's light in its centre
 * where the lobe is wide for it, spread over the pixel where it is not.
 *   dir       unit direction
 *   accuracy  the error left, relative to the sum of the three channels, is
 *             about this; 1e-6..0.1
 */
void ibl_tree_specular(const ibl_tree *tree, const ibl_lobe_shape *lobe,
                       const double dir[3], double accuracy, double rgb[3]);

#endif
