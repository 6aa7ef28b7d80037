/* SPDX-License-Identifier: MIT */
/*
 * The weights that interpolate a band-limited function from IBL_TAPS samples
 * around a position: for the spectrum at hand those with the least square
 * error (Wiener's interpolation). At 4 samples a wave at the degree, where the
 * spectrum has fallen to 1e-5, their error is 4e-7; that of a sinc as long
 * under the best of Kaiser's windows is 8e-6. They are polynomials of the
 * position between two samples.
 */
#ifndef IBL_BAKE_SPECTRAL_INTERP_WEIGHTS_H
#define IBL_BAKE_SPECTRAL_INTERP_WEIGHTS_H

#include "kern/interp.h"

/*
 *   spectrum  amplitudes at 0..degree waves a circle, in any unit; NULL:
 *             falling exponentially to 1e-5 at `degree`
 *   degree    >= 0
 *   circle    samples a circle, more than 2 degree
 * The weights sum to 1 at every position whatever the spectrum.
 *
 * Returns their root mean square error over all positions, in parts of that of
 * the waves without the constant; what is below 1e-7 may be off by as much.
 */
double ibl_interp_weights_design(const double *spectrum, int degree,
                                 double circle, ibl_interp_weights *taps);

#endif
