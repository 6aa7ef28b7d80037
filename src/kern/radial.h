/* SPDX-License-Identifier: MIT */
/*
 * Point lights seen through a lobe (brdf/lobe.h), a function K of the squared
 * distance q = |d - s|^2 of two unit vectors.
 *
 * A component of a unit vector is a float and a float remainder, so that
 * differences of near vectors keep full precision.
 */
#ifndef IBL_KERN_RADIAL_H
#define IBL_KERN_RADIAL_H

#include "brdf/lobe.h"
#include "kern/isa.h"

enum {
    IBL_RADIAL_BLOCK = 8 /* texels */
};

/* K = scale D(q) N.L, N.L = 1 - q/2. D is
 *   GGX      1 / (1 + slope q)^2: the half vector has sin^2 = q/4
 *   Charlie  (q/2)^power
 *   Phong    (1 - q/2)^power */
typedef struct ibl_radial {
    ibl_lobe lobe;
    float scale, slope, power;
} ibl_radial;

/* sin^2 h + alpha^2 cos^2 h = alpha^2 + (1 - alpha^2) q/4. */
static inline ibl_radial ibl_radial_of(const ibl_lobe_shape *s)
{
    const double a2 = s->alpha * s->alpha;
    const bool ggx = s->lobe == IBL_LOBE_GGX;
    return (ibl_radial){.lobe = s->lobe,
                        .scale =
                            (float)(ggx ? ibl_lobe_value(s, 0, 1) : s->scale),
                        .slope = (float)(0.25 * (1 - a2) / a2),
                        .power = (float)s->power};
}

/* A light: its direction, the direction's remainder, and its R, G, B. For
 * add_far and add_cut it is a rectangle, at + x side[0] + y side[1], |x| and
 * |y| <= 1, and rgb[3] a third of the sum of the squares of the sides. */
typedef struct ibl_radial_light {
    float at[3], rest[3], rgb[4], side[2][3];
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
     * rgba[4 i + c] += sum over lights of rgb[c] K(|point_i - at|^2), for
     * IBL_RADIAL_BLOCK points; the fourth channel is unchanged.
     */
    void (*add)(const ibl_radial *lobe, const ibl_radial_light *lights,
                int count, const float *point, int stride, float *rgba);
    /* The same with the second derivatives of GGX over the rectangles: for
     * those that are small beside their distance or alpha, and above the
     * horizon of all points. */
    void (*add_far)(const ibl_radial *lobe, const ibl_radial_light *lights,
                    int count, const float *point, int stride, float *rgba);
    /* The same for rectangles that the horizon may cut. */
    void (*add_cut)(const ibl_radial *lobe, const ibl_radial_light *lights,
                    int count, const float *point, int stride, float *rgba);
} ibl_radial_dsp;

IBL_DECLARE_KERNEL(ibl_radial);

#endif
