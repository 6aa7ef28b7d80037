/* SPDX-License-Identifier: MIT */
/*
 * Point lights seen through a lobe: a function K of the squared distance
 * q = |d - s|^2 of two unit vectors, which is 0 from the horizon, q = 2, on.
 *
 * A component of a unit vector is a float and a float remainder, so that
 * differences of near vectors keep full precision.
 */
#ifndef IBL_KERN_RADIAL_H
#define IBL_KERN_RADIAL_H

#include "ibl/ibl.h"
#include "kern/isa.h"

enum {
    IBL_RADIAL_BLOCK = 16 /* texels */
};

/*
 * A lobe, as a formula or a table. Without a table (coef NULL):
 *     K = peak max(1 - q/2, 0) / (1 + slope q)^2,
 * GGX, whose half vector has sin^2 = q/4 and cos^2 = 1 - q/4.
 *
 * Else by cubic pieces. On side 0, q <= 1, v = q; on side 1, v = 2 - q.
 * t = v + start[side] is a float with 2^bits pieces per octave: its exponent
 * and the first bits of its fraction, minus base[side], are the number of the
 * piece. The rest of the fraction is the argument x in 0..1:
 *     K = c[0] + c[1] x + c[2] x^2 + c[3] x^3, c = coef + 4 piece.
 */
typedef struct ibl_radial {
    float peak, slope;
    float *coef;
    int bits;
    float start[2]; /* powers of two */
    int base[2];
} ibl_radial;

/* A light: its direction, the direction's remainder, and its R, G, B; the last
 * of rgb is unused. */
typedef struct ibl_radial_light {
    float at[3], rest[3], rgb[4];
} ibl_radial_light;

typedef struct ibl_radial_dsp {
    /*
     * Directions of the texels from `first` on in a row of a face of `size`:
     * (1, u_i, v) / |(1, u_i, v)|, u_i = (2 i + 1) / size - 1. Component k of
     * texel first + i is point[k stride + i], its remainder
     * point[(k + 3) stride + i].
     *   stride  number of texels, a multiple of IBL_RADIAL_BLOCK; some may lie
     *           beyond the face
     */
    void (*points)(double v, int size, int first, int stride, float *point);
    /*
     * rgba[4 i + c] += sum over lights of rgb[c] K(|point_i - at|^2), for the
     * `stride` texels of points(); the fourth channel is unchanged.
     */
    void (*add)(const ibl_radial *lobe, const ibl_radial_light *lights,
                int count, const float *point, int stride, float *rgba);
} ibl_radial_dsp;

IBL_DECLARE_KERNEL(ibl_radial);

#endif
