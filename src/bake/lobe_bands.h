/* SPDX-License-Identifier: MIT */
/*
 * The spherical harmonics of the lobe of bake/true_lobe.h, degree by degree:
 * its power, and its sum of harmonics in some directions. With the lookups of
 * bake/lobe_kernels.h these give the error of a lookup exactly:
 *     <T, T> = sum over l of C_l power(l),
 *     <K(d), T> = sum over l of C_l k(l) toward(d, l).
 */
#ifndef IBL_BAKE_LOBE_BANDS_H
#define IBL_BAKE_LOBE_BANDS_H

#include "ibl/ibl.h"

enum {
    IBL_BANDS_DIRECTIONS = 8
};

typedef struct ibl_lobe_bands {
    int degree;
    int directions;
    double angle[IBL_BANDS_DIRECTIONS]; /* from N towards R */
    double energy[2];                   /* F0 = 1, .04: scale F0 + bias */
    double *power[2];                   /* degree + 1 each */
    double *toward[2][IBL_BANDS_DIRECTIONS];
} ibl_lobe_bands;

/* Fills the results for the directions and degree of *bands, whose memory is
 * the caller's; but for energy, the lobes have the energy 1. n_dot_v and alpha
 * in (0, 1]. IBL_ERR_MEMORY without a message. */
ibl_status ibl_lobe_bands_make(double n_dot_v, double alpha,
                               ibl_lobe_bands *bands);

#endif
