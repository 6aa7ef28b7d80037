/* SPDX-License-Identifier: MIT */
/*
 * The lights of a level: bright pixels, that are patches of the sphere, seen
 * through its lobe, however narrow that is and however far down its tail.
 *
 * Points stand for each light. Lights next to one another, as those of a sun,
 * form a cluster: the polynomial through the lobe at a few nodes is as good as
 * the lobe, so points at the nodes stand for all of them. From half a radian
 * on fewer nodes are enough. Where the horizon of a texel crosses a cluster its
 * lights are summed one by one, and cut at the horizon.
 */
#ifndef IBL_BAKE_SPECTRAL_POINT_LIGHTS_H
#define IBL_BAKE_SPECTRAL_POINT_LIGHTS_H

#include "bake/spectral/patch.h"
#include "ibl/ibl.h"
#include "kern/radial.h"

/* Constant after creation. */
typedef struct ibl_point_lights ibl_point_lights;

/*
 *   error  of the light of a cluster, relative, that is accepted
 *   least  what a light may miss on the horizon, absolute
 */
ibl_status ibl_point_lights_create(ibl_ctx *ctx, const ibl_patch *patches,
                                   int count, const ibl_lobe_shape *shape,
                                   double error, double least,
                                   ibl_point_lights **out);
void ibl_point_lights_free(ibl_point_lights *bright); /* NULL is fine */
/* How many points, at most, a texel sees. */
int ibl_point_lights_count(const ibl_point_lights *bright);
/* Adds the lights to IBL_RADIAL_BLOCK texels of a row of a face, as
 * ibl_radial_dsp has it, with that of points() for them. */
void ibl_point_lights_add(const ibl_point_lights *bright, int face,
                          const ibl_radial_dsp *dsp, const float *point,
                          float *rgba);

#endif
