/* SPDX-License-Identifier: MIT */
/*
 * The lights of a level: bright pixels of the map, seen through its lobe. Each
 * pixel is replaced by Gauss-Legendre points, more for texels whose lobe may
 * be narrow on it, and at each texel the lobe's formula is summed over all
 * points.
 */
#ifndef IBL_BAKE_SPECTRAL_POINT_LIGHTS_H
#define IBL_BAKE_SPECTRAL_POINT_LIGHTS_H

#include "brdf/lobe.h"
#include "ibl/ibl.h"
#include "kern/radial.h"

/* A pixel of constant radiance. theta from +Y and phi in the world's axes, in
 * radians: x = sin(theta) cos(phi), z = sin(theta) sin(phi). */
typedef struct ibl_patch {
    double theta[2];
    double phi, width; /* middle and width */
    float rgb[3];      /* radiance */
} ibl_patch;

/* Constant after creation. */
typedef struct ibl_point_lights ibl_point_lights;

/* error: accepted relative error of the light of a pixel. */
ibl_status ibl_point_lights_create(ibl_ctx *ctx, const ibl_patch *patches,
                                   int count, const ibl_lobe_shape *shape,
                                   double error, ibl_point_lights **out);
void ibl_point_lights_free(ibl_point_lights *p); /* NULL is fine */
/* Adds the lights to rgba of IBL_RADIAL_BLOCK directions in the world's axes,
 * as ibl_radial_dsp's points() has them. */
void ibl_point_lights_add(const ibl_point_lights *p, const ibl_radial_dsp *dsp,
                          const float *point, int stride, float *rgba);

#endif
