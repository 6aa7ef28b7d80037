/* SPDX-License-Identifier: MIT */
/*
 * The lights of a level: bright pixels, as patches of the sphere, seen through
 * its lobe, which may be narrow, and far down its tail.
 *
 * Points replace each light. Neighbouring lights, such as those of a sun, form
 * a cluster: the polynomial through the lobe at a few nodes is as good as the
 * lobe, so points at these nodes replace all lights of it. Beyond half a radian
 * fewer nodes are enough. If the horizon of a texel crosses a cluster, its
 * lights are summed one by one and cut at the horizon.
 */
#ifndef IBL_BAKE_SPECTRAL_POINT_LIGHTS_H
#define IBL_BAKE_SPECTRAL_POINT_LIGHTS_H

#include "bake/spectral/patch.h"
#include "ibl/ibl.h"
#include "kern/radial.h"

/* Constant after creation. */
typedef struct ibl_point_lights ibl_point_lights;

/*
 *   error  accepted relative error of the light of a cluster
 *   least  accepted absolute error of a light on the horizon
 */
ibl_status ibl_point_lights_create(ibl_ctx *ctx, const ibl_patch *patches,
                                   int count, const ibl_lobe_shape *shape,
                                   double error, double least,
                                   ibl_point_lights **out);
void ibl_point_lights_free(ibl_point_lights *bright); /* NULL is fine */
/* Most points that a texel sees. */
int ibl_point_lights_count(const ibl_point_lights *bright);
/* Adds the lights to rgba of IBL_RADIAL_BLOCK texels of a row of a face. point
 * comes from ibl_radial_dsp's points() for these texels. */
void ibl_point_lights_add(const ibl_point_lights *bright, int face,
                          const ibl_radial_dsp *dsp, const float *point,
                          float *rgba);
/* The same for any IBL_RADIAL_BLOCK directions: point, in the order of points()
 * with that stride, is in the world's axes. */
void ibl_point_lights_add_at(const ibl_point_lights *bright,
                             const ibl_radial_dsp *dsp, const float *point,
                             float *rgba);

#endif
