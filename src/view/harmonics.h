/* SPDX-License-Identifier: MIT */
#ifndef VIEW_HARMONICS_H
#define VIEW_HARMONICS_H

/* Highest degree of irradiance that is shown. */
#define VIEW_SH_DEGREE 4
#define VIEW_SH_COUNT ((VIEW_SH_DEGREE + 1) * (VIEW_SH_DEGREE + 1))

/* Y_lm of a unit direction, ordered and with the basis of ibl_bake_sh: the
 * first (l + 1)^2 are those to degree l. */
void view_harmonics(const double d[3], double y[VIEW_SH_COUNT]);

#endif
