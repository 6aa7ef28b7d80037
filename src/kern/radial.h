/* SPDX-License-Identifier: MIT */
/*
 * Point lights seen through a lobe: a function K of the distance between two
 * unit vectors, q = |d - s|^2, which is 0 from the horizon, q = 2, on.
 *
 * Unit vectors come as a float and what that lacks, so that differences of
 * near ones are as exact as any.
 */
#ifndef IBL_KERN_RADIAL_H
#define IBL_KERN_RADIAL_H

#include "ibl/ibl.h"
#include "kern/isa.h"

enum {
    IBL_RADIAL_BLOCK = 16 /* texels */
};

/*
 * A lobe, one of two ways. Without a table (coef NULL):
 *     K = peak max(1 - q/2, 0) / (1 + slope q)^2,
 * GGX, whose half vector has sin^2 = q/4 and cos^2 = 1 - q/4.
 *
 * Else by cubic pieces. With v = q to q = 1 and v = 2 - q beyond, on side 0
 * and 1, t = v + start[side] is a float with 2^bits pieces an octave: its
 * exponent and the first bits of its fraction, less base[side], are the
 * number of the piece, the rest of the fraction as x in 0..1 its argument:
 *     K = c[0] + c[1] x + c[2] x^2 + c[3] x^3, c = coef + 4 piece.
 */
typedef struct ibl_radial {
    float peak, slope;
    float *coef;
    int bits;
    float start[2]; /* powers of two */
    int base[2];
} ibl_radial;

/* A light: where it is, the place's remainder, and R, G, B times whatever;
 * the last is unused. */
typedef struct ibl_radial_light {
    float at[3], rest[3], rgb[4];
} ibl_radial_light;

typedef struct ibl_radial_dsp {
    /*
     * Points of texels first.. of a row of a face of `size`:
     * (1, u_i, v) / |(1, u_i, v)|, u_i = (2 i + 1) / size - 1. Component k of
     * texel first + i is point[k stride + i], its remainder
     * point[(k + 3) stride + i].
     *   stride  how many, a multiple of IBL_RADIAL_BLOCK; some may lie beyond
     *           the face
     */
    void (*points)(double v, int size, int first, int stride, float *point);
    /*
     * rgba[4 i + c] += sum over lights of rgb[c] K(|point_i - at|^2), for the
     * `stride` texels of points(); the fourth channel is left alone.
     */
    void (*add)(const ibl_radial *lobe, const ibl_radial_light *lights,
                int count, const float *point, int stride, float *rgba);
} ibl_radial_dsp;

IBL_DECLARE_KERNEL(ibl_radial);

#endif
