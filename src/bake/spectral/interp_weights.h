/* SPDX-License-Identifier: MIT */
/*
 * Weights that interpolate a band-limited function from IBL_TAPS samples around
 * a position, with the least square error for its spectrum (Wiener
 * interpolation). At 4 samples per wave at the degree, where the spectrum has
 * fallen to 1e-5, the error is 4e-7; that of a sinc of the same length with the
 * best Kaiser window is 8e-6. The weights are polynomials of the position
 * between two samples.
 */
#ifndef IBL_BAKE_SPECTRAL_INTERP_WEIGHTS_H
#define IBL_BAKE_SPECTRAL_INTERP_WEIGHTS_H

#include "kern/interp.h"

/*
 *   spectrum  amplitudes at 0..degree waves a circle, in any unit; NULL:
 *             falling exponentially to 1e-5 at `degree`
 *   degree    >= 0
 *   circle    samples a circle, more than 2 degree
 * The weights sum to 1 at every position, for any spectrum.
 *
 * Returns their rms error over all positions, relative to the rms of the waves
 * without the constant. An error below 1e-7 is uncertain by as much.
 */
double ibl_interp_weights_design(const double *spectrum, int degree,
                                 double circle, ibl_interp_weights *taps);

#endif
