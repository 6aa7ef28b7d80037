/* SPDX-License-Identifier: MIT */
#ifndef VIEW_HARMONICS_H
#define VIEW_HARMONICS_H

/* Highest degree of irradiance that is drawn. */
#define VIEW_SH_DEGREE 4
#define VIEW_SH_COUNT ((VIEW_SH_DEGREE + 1) * (VIEW_SH_DEGREE + 1))

/* Sums harmonics in a unit direction, for one to four channels. Order and basis
 * are those of ibl_bake_sh: count (l + 1)^2 means degree l. */
void view_harmonics_sum(const double *coefficients, int count, int channels,
                        const double d[3], double *sum);
/* The same for all texels of a cube's level; values below 0 become 0. */
void view_harmonics_cube(const double *coefficients, int count, int channels,
                         int edge, float *texels);

#endif
