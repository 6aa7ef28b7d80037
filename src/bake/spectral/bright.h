/* SPDX-License-Identifier: MIT */
/*
 * Bright pixels as point lights: what they add to a texel is their energy
 * times the lobe at their distance, exactly, however narrow the lobe is and
 * however far down its tail.
 */
#ifndef IBL_BAKE_SPECTRAL_BRIGHT_H
#define IBL_BAKE_SPECTRAL_BRIGHT_H

#include "ibl/ibl.h"
#include "kern/radial.h"

/* Weight of a lobe at a chord, |d - s| of unit vectors, 0..sqrt(2): finite,
 * not negative, continuous. */
typedef double ibl_chord_fn(double chord, const void *arg);

/*
 * Lobes normalised to an integral of 1 over the sphere, 0 beyond the horizon
 * (chord > sqrt(2)). Free with ibl_radial_free.
 *
 * ibl_radial_ggx: D_ggx N.L of width alpha in (0, 1], by its formula.
 * ibl_radial_table: any other, by a table of it. The error is below 1e-6 of
 * the value, and of 1e-8 of the peak where the lobe has fallen below that;
 * features that span less than a hundredth of their distance from both peak
 * and horizon get more. IBL_ERR_ARGUMENT: the integral is not positive and
 * finite. out is zeroed after an error.
 */
void ibl_radial_ggx(double alpha, ibl_radial *out);
ibl_status ibl_radial_table(ibl_ctx *ctx, ibl_chord_fn *weight, const void *arg,
                            ibl_radial *out);
void ibl_radial_free(ibl_radial *lobe); /* NULL and zeroed are fine */

typedef struct ibl_light {
    double direction[3]; /* unit, in the world's axes */
    float energy[3];     /* R, G, B: radiance times solid angle */
} ibl_light;

/* One for all the points of a light. */
ibl_light ibl_light_middle(const ibl_light *points, int count);

/* A list of lights, ready for every face of a cube. Constant after creation. */
typedef struct ibl_bright ibl_bright;

/*
 * count lights, each of some points: those of light i are
 * lights[first[i]..first[i + 1] - 1]; first NULL: one each.
 *   distance  from there on, in radians, ibl_light_middle stands for a light;
 *             INFINITY: nowhere
 */
ibl_status ibl_bright_create(ibl_ctx *ctx, const ibl_light *lights,
                             const int *first, int count, double distance,
                             ibl_bright **out);
void ibl_bright_free(ibl_bright *bright); /* NULL is fine */
/* How many points. */
int ibl_bright_count(const ibl_bright *bright);
/*
 * Adds the lights to IBL_RADIAL_BLOCK texels of a row of a face, as
 * ibl_radial_dsp has it, with that of points() for them. Lights that are below
 * the horizon of all of them are left out.
 */
void ibl_bright_add(const ibl_bright *bright, int face,
                    const ibl_radial_dsp *dsp, const ibl_radial *lobe,
                    const float *point, float *rgba);

#endif
