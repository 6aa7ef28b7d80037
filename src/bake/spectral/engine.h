/* SPDX-License-Identifier: MIT */
/*
 * The spectral method: lobes that depend on the angle to R alone are zonal
 * kernels, and a convolution with one multiplies the spherical harmonics of
 * the environment by a number for each degree (Ramamoorthi and Hanrahan 2001,
 * for the cosine). One analysis of the rows serves every level.
 *
 * What is computed is the integral of <ibl/ibl.h> over all pixels, constant
 * patches, to the tolerance. Pixels that outshine the rows around them are no
 * part of the analysis but added to each texel by the lobe's own formula: a
 * series that is cut rings, and next to a sun even a little of it would show.
 */
#ifndef IBL_BAKE_SPECTRAL_ENGINE_H
#define IBL_BAKE_SPECTRAL_ENGINE_H

#include <stdbool.h>

#include "bake/spectral/near.h"
#include "ibl/ibl.h"

#define IBL_SPECTRAL_GROUP 16 /* rows that are analysed together */

typedef struct ibl_spectral ibl_spectral;

/*
 * For a map of width x height pixels, turned by yaw_deg. Borrows ctx.
 *   degree   of the analysis, the highest of any level
 *   halved   whether 2 x 2 pixels, their mean, are one: width and height are
 *            even
 */
ibl_status ibl_spectral_create(ibl_ctx *ctx, int width, int height,
                               double yaw_deg, int degree, bool halved,
                               ibl_spectral **out);
void ibl_spectral_free(ibl_spectral *s); /* NULL is fine */

/* The next rows from the zenith, RGB: a multiple of 2 IBL_SPECTRAL_GROUP,
 * but for the last ones. Begins jobs of the context's pool: ibl_run_end comes
 * before the next call for s, and rgb stays until that has returned. */
ibl_status ibl_spectral_add(ibl_spectral *s, int rows, const float *rgb);
/* All rows have been added. Reports as stage "analysis". */
ibl_status ibl_spectral_finish(ibl_spectral *s);

typedef struct ibl_spectral_target {
    const ibl_lobe_shape *shape; /* the lobe, or its far part */
    ibl_near *near;              /* the near part, all rows added; NULL: none */
    double tolerance;            /* of the relative error */
    ibl_cube *cube;              /* allocated */
    int level;                   /* of cube, that is written */
} ibl_spectral_target;

/*
 * Makes a level at the smallest degree that keeps the tolerance. Reports its
 * synthesis under stage, then "resampling".
 *   degree   written: that degree
 *   error    written: the estimate, a bound of the 95th percentile of
 *            ibl_relative_error over the level's texels
 */
ibl_status ibl_spectral_bake(ibl_spectral *s, const char *stage,
                             const ibl_spectral_target *target, int *degree,
                             double *error);

/* The coefficients of ibl_bake_sh, up to the degree of the analysis. */
ibl_status ibl_spectral_sh(const ibl_spectral *s, int degree, double *coeffs);

#endif
