/* SPDX-License-Identifier: MIT */
/*
 * Legendre coefficients of a function known at some points.
 *
 * With y = 1 - x the recurrence (l + 1) P_l+1 = (2 l + 1) x P_l - l P_l-1 is
 *     e_l+1 = e_l - (2 l + 1) y P_l,   P_l+1 = P_l + e_l+1 / (l + 1),
 * e_l = l (P_l - P_l-1): no digits are lost next to x = 1, where P_l varies
 * over distances in x of 1 / l^2. (The idea is Reinsch's, for sums of cosines;
 * Stoer and Bulirsch 2002, section 2.3.2.)
 */
#ifndef IBL_KERN_LEGENDRE_SUMS_H
#define IBL_KERN_LEGENDRE_SUMS_H

#include <stddef.h>

#include "ibl/ibl.h"
#include "kern/isa.h"

enum {
    IBL_LEGENDRE_SUMS_POINTS = 32, /* divides the number of points */
    IBL_LEGENDRE_SUMS_SCRATCH = 4  /* doubles for each degree */
};

typedef struct ibl_legendre_sums_dsp {
    /*
     * k[l] = sum over i of w[i] P_l(1 - y[i]), l = 0..degree.
     *   count    points, a multiple of IBL_LEGENDRE_SUMS_POINTS
     *   inverse  1 / (l + 1), l = 0..degree - 1
     *   scratch  IBL_LEGENDRE_SUMS_SCRATCH (degree + 1) doubles
     */
    void (*sums)(const double *y, const double *w, int count,
                 const double *inverse, int degree, double *scratch, double *k);
} ibl_legendre_sums_dsp;

IBL_DECLARE_KERNEL(ibl_legendre_sums);

#endif
