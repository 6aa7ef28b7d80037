/* SPDX-License-Identifier: MIT */
/* Shared by the files set_*.c, which read and make a baked_set. */
#ifndef VIEW_SET_PARTS_H
#define VIEW_SET_PARTS_H

#include "view/baked_set.h"

/* Makes the table of sheen for a chain of levels with rising roughness. False:
 * no memory. */
bool view_set_fill_sheen(ibl_ctx *ctx, const double *roughness, int levels,
                         baked_set *set);

/* ---- missing textures (set_make.c) --------------------------------------- */

/* Makes the missing table and irradiance of a set that has its specular chain
 * and roughness. */
bool view_set_fill(ibl_ctx *ctx, baked_set *set);
/* Stores the cosine-weighted harmonics of radiance: 3 for each (l, m) up to
 * degree, which is VIEW_SH_DEGREE or less. */
void view_set_harmonics(baked_set *set, int degree, const double *radiance);

#endif
