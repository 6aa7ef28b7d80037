/* SPDX-License-Identifier: MIT */
/*
 * The weights that interpolate a band-limited function from IBL_TAPS samples
 * around a position: for the spectrum at hand those with the least square
 * error (Wiener's interpolation), which a windowed sinc of so few taps is far
 * from. They are polynomials of the position between two samples.
 */
#ifndef IBL_BAKE_SPECTRAL_TAPS_H
#define IBL_BAKE_SPECTRAL_TAPS_H

#include "kern/interp.h"

/*
 *   spectrum  amplitudes at 0..degree waves a circle, in any unit; NULL:
 *             falling exponentially to 1e-5 at `degree`
 *   degree    >= 0
 *   circle    samples a circle, more than 2 degree
 * The weights sum to 1 at every position whatever the spectrum.
 */
void ibl_taps_design(const double *spectrum, int degree, double circle,
                     ibl_taps *taps);

#endif
