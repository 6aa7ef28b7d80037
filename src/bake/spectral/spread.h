/* SPDX-License-Identifier: MIT */
/* How rows of any length are spread onto a ring of samples: azimuth.h. */
#ifndef IBL_BAKE_SPECTRAL_SPREAD_H
#define IBL_BAKE_SPECTRAL_SPREAD_H

#include <stdbool.h>

#include "kern/row_block.h"

#define IBL_SPREAD_NODES 12

/*
 * The filter, in samples: g(x) = e^(beta (sqrt(1 - (2 x / taps)^2) - 1)) for
 * |x| <= taps / 2, "exponential of semicircle" (Barnett, Magland, af
 * Klinteberg 2019, A parallel nonuniform fast Fourier transform library
 * based on an "exponential of semicircle" kernel, section 2).
 */
typedef struct ibl_spread_window {
    double beta;
    /* A quadrature of its transform: weight cos(f angle). */
    double weight[IBL_SPREAD_NODES], angle[IBL_SPREAD_NODES];
} ibl_spread_window;

/* The filter for orders below `orders` on a ring of n >= 4 (orders - 1)
 * samples: |g^(k + m / n)| / g^(m / n) summed over k != 0 is at most 5e-8
 * for all m < orders, where g^ is the Fourier transform of g. */
ibl_spread_window ibl_spread_window_of(int n, int orders);

/* g(x), 0 outside. */
double ibl_spread_value(const ibl_spread_window *window, double x);
/* g^(f): the integral of g(x) cos(2 pi f x) dx, |f| <= 1/4; error 1e-10. */
double ibl_spread_transform(const ibl_spread_window *window, double f);

/*
 * The taps for rows of width pixels onto n samples. Pixel 0 adds to ring
 * sample *origin (may be negative) first, which is sample 0 of the spread.
 * False if memory cannot be had; *spread is then empty.
 */
bool ibl_spread_init(ibl_row_block_spread *spread, int width, int n,
                     const ibl_spread_window *window, int *origin);
void ibl_spread_free(ibl_row_block_spread *spread); /* zeroed is fine */

#endif
