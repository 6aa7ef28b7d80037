/* SPDX-License-Identifier: MIT */
/* Lobes as functions of the chord, for lights (kern/radial.h). */
#ifndef IBL_BAKE_SPECTRAL_LOBE_TABLE_H
#define IBL_BAKE_SPECTRAL_LOBE_TABLE_H

#include "brdf/lobe.h"
#include "ibl/ibl.h"
#include "kern/radial.h"

/* Value of a lobe at a chord |d - s| of unit vectors, 0..sqrt(2): finite, not
 * negative, continuous. */
typedef double ibl_chord_fn(double chord, const void *arg);

/*
 * Make a lobe, per steradian, 0 beyond the horizon (chord > sqrt(2)). The
 * caller must free it with ibl_radial_free; out is zeroed after an error.
 *
 * ibl_radial_make: K. GGX uses its formula, the others a table.
 * ibl_radial_table: a table of any lobe. The error is below 1e-6 of the value,
 * or of 1e-8 of the peak if that is larger. It is larger at features narrower
 * than a hundredth of their distance from both peak and horizon.
 */
ibl_status ibl_radial_make(ibl_ctx *ctx, const ibl_lobe_shape *shape,
                           ibl_radial *out);
ibl_status ibl_radial_table(ibl_ctx *ctx, ibl_chord_fn *at, const void *arg,
                            ibl_radial *out);
void ibl_radial_free(ibl_radial *lobe); /* zeroed is fine */

#endif
