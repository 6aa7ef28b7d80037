/* SPDX-License-Identifier: MIT */
/* The Gauss-Legendre rule with four points on 0..1; polynomials through points.
 */
#ifndef IBL_BAKE_SPECTRAL_GAUSS_H
#define IBL_BAKE_SPECTRAL_GAUSS_H

enum {
    IBL_GAUSS_POINTS = 4
};

static const double ibl_gauss_node[IBL_GAUSS_POINTS] = {
    0.069431844202973712, 0.33000947820757187, 0.66999052179242813,
    0.93056815579702629};
static const double ibl_gauss_mass[IBL_GAUSS_POINTS] = {
    0.17392742256872693, 0.32607257743127307, 0.32607257743127307,
    0.17392742256872693};

/* Replaces f by the coefficients of the polynomial through n points (x[i],
 * f[i]): Newton's form, then its products. */
static inline void ibl_polynomial_through(int n, const double *x, double *f)
{
    for (int j = 1; j < n; j++)
        for (int i = n - 1; i >= j; i--)
            f[i] = (f[i] - f[i - 1]) / (x[i] - x[i - j]);
    for (int j = n - 2; j >= 0; j--)
        for (int k = j; k < n - 1; k++)
            f[k] -= x[j] * f[k + 1];
}

#endif
