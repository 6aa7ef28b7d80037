/* SPDX-License-Identifier: MIT */
#ifndef VIEW_HARMONICS_H
#define VIEW_HARMONICS_H

/* Highest degree of irradiance that is shown. */
#define VIEW_SH_DEGREE 4
#define VIEW_SH_COUNT ((VIEW_SH_DEGREE + 1) * (VIEW_SH_DEGREE + 1))

/* The sum of harmonics in a unit direction, of one to four channels. Ordered
 * and with the basis of ibl_bake_sh: a count of (l + 1)^2 is to degree l. */
void view_harmonics_sum(const double *coefficients, int count, int channels,
                        const double d[3], double *sum);
/* The same at the texels of a cube's level; what is below 0 is 0. */
void view_harmonics_cube(const double *coefficients, int count, int channels,
                         int edge, float *texels);

#endif
