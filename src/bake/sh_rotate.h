/* SPDX-License-Identifier: MIT */
#ifndef IBL_BAKE_SH_ROTATE_H
#define IBL_BAKE_SH_ROTATE_H

#include <stddef.h>

/*
 * Turns the polar axis of real spherical harmonics of degree l from y to z.
 *   ring   l + 1 times 6 doubles: for m = 0..l the coefficients (R, G, B) of
 *          the function with cos(m p) and the one with sin(m p), where p is
 *          the azimuth of a frame x' = z, y' = x, z' = y
 *   out    2l + 1 times 3 doubles: R, G, B of the order -l..l in the frame
 *          x, y, z (the basis of ibl_bake_sh)
 *   work   ibl_sh_rotate_work(l) doubles of scratch
 * l <= 1000: beyond it 2^-l leaves the range of doubles.
 */
void ibl_sh_rotate(int l, const double *ring, double *out, double *work);
size_t ibl_sh_rotate_work(int l);

#endif
