/* SPDX-License-Identifier: MIT */
/*
 * Level 0 from rows: an equirectangular map arrives in batches of rows, zenith
 * first. Rows are not needed after they have been added. The result has the
 * same bytes as that of ibl_cube_from_latlong, for any batches and any number
 * of threads.
 */
#ifndef IBL_IMAGE_LEVEL0_H
#define IBL_IMAGE_LEVEL0_H

#include "ibl/ibl.h"

typedef struct ibl_level0 ibl_level0;

/* Makes level 0 of cube from a map of width x height pixels, each 1 to
 * IBL_MAX_EDGE, turned by a finite yaw_deg. Borrows ctx and cube. Level 0 is
 * undefined before ibl_level0_finish. */
ibl_status ibl_level0_create(ibl_ctx *ctx, int width, int height,
                             double yaw_deg, ibl_cube *cube, ibl_level0 **out);

/* Adds the next rows: RGB, width pixels each, tightly packed. Begins jobs of
 * the context's pool: call ibl_run_end before the next call for l and before
 * freeing rgb. */
ibl_status ibl_level0_add(ibl_level0 *l, int rows, const float *rgb);

/* Writes the rest of the cube; all rows must have been added. */
ibl_status ibl_level0_finish(ibl_level0 *l);

void ibl_level0_free(ibl_level0 *l); /* NULL is allowed */

#endif
