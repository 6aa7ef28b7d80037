/* SPDX-License-Identifier: MIT */
/*
 * Level 0 from rows: an equirectangular map comes in batches of rows, zenith
 * first, and each is done with when it has been added. What comes out is that
 * of ibl_cube_from_latlong, the same bytes however the rows are batched and
 * for any number of threads.
 */
#ifndef IBL_IMAGE_LEVEL0_H
#define IBL_IMAGE_LEVEL0_H

#include "ibl/ibl.h"

typedef struct ibl_level0 ibl_level0;

/* For a map of width x height pixels, each 1 to IBL_MAX_EDGE, turned by a
 * finite yaw_deg, into level 0 of cube. Borrows ctx and cube, whose level 0
 * holds nothing of use before ibl_level0_finish. */
ibl_status ibl_level0_create(ibl_ctx *ctx, int width, int height,
                             double yaw_deg, ibl_cube *cube, ibl_level0 **out);

/* The next rows, RGB, width pixels each, one after the other. Begins
 * jobs of the context's pool: ibl_run_end comes before the next call for l, and
 * before rgb goes. */
ibl_status ibl_level0_add(ibl_level0 *l, int rows, const float *rgb);

/* All rows have been added: writes what is left of the cube. */
ibl_status ibl_level0_finish(ibl_level0 *l);

void ibl_level0_free(ibl_level0 *l); /* NULL is fine */

#endif
