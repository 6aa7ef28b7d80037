/* SPDX-License-Identifier: MIT */
/*
 * Sums of light that a surface reflects to a viewer, for the exact values of
 * <ibl/reference.h>; in double precision.
 *
 * In the surface's frame the normal is +Z and the viewer at (sv, 0, nv). The
 * half vector of a light at L is H = (x + sv, y, z + nv) / |.|, so its squared
 * sine and cosine are s2 / h2 and c2 / h2, with s2 = (x + sv)^2 + y^2,
 * c2 = (z + nv)^2 and h2 = s2 + c2. None of them cancels near the peak.
 */
#ifndef IBL_KERN_REFLECTION_H
#define IBL_KERN_REFLECTION_H

#include "ibl/ibl.h"
#include "kern/isa.h"

enum {
    IBL_REFLECTION_BLOCK = 64 /* points */
};

/* Points of a quadrature, seen by one viewer. */
typedef struct ibl_reflection_points {
    double z[IBL_REFLECTION_BLOCK];    /* N.L */
    double s2[IBL_REFLECTION_BLOCK];   /* see above */
    double c2[IBL_REFLECTION_BLOCK];   /* see above */
    double mass[IBL_REFLECTION_BLOCK]; /* solid angle times z h2^2, or 0 */
    double fc[IBL_REFLECTION_BLOCK];   /* Schlick's (1 - V.H)^5 */
} ibl_reflection_points;

/* A row of pixels: L = at + ahead cos(phi) + aside sin(phi), phi the azimuth.
 * Pixels with s2 + wide c2 below `least`, or z below `low`, are left out. */
typedef struct ibl_reflection_row {
    double at[3], ahead[3], aside[3];
    double sv, nv;
    double solid_angle; /* of a pixel */
    double wide, least, low;
} ibl_reflection_row;

typedef enum ibl_reflection_kind {
    IBL_REFLECTION_SMITH,   /* g = v z + nv sqrt(a2 + (1 - a2) z^2) */
    IBL_REFLECTION_SCHLICK, /* g = v + (1 - v) z */
    IBL_REFLECTION_LOBE     /* g = 1; without the sums with fc */
} ibl_reflection_kind;

/* What divides a point's mass: (s2 + a2 c2)^2 g. */
typedef struct ibl_reflection_shape {
    ibl_reflection_kind kind;
    double a2, nv, v;
} ibl_reflection_shape;

typedef struct ibl_reflection_dsp {
    /* Fills all points of a block from as many cosines and sines of azimuths.
     * Those left out, and those from n on, have a mass of 0. Returns the number
     * of the others. */
    int (*place)(const ibl_reflection_row *row, const double *cosine,
                 const double *sine, int n, ibl_reflection_points *points);
    /*
     * For each point, w = mass / ((s2 + a2 c2)^2 g): adds to sum[0..3] w times
     * R, G, B and 1, and to sum[4..7] fc times the same. Points of mass 0 add
     * nothing.
     *   rgb    R of all points, then G `stride` after it, then B
     *   count  points, a multiple of 8 (mass 0: z, s2, c2 must be finite and
     *          not make the divisor 0)
     */
    void (*add)(const ibl_reflection_shape *shape,
                const ibl_reflection_points *points, const double *rgb,
                size_t stride, int count, double sum[8]);
} ibl_reflection_dsp;

IBL_DECLARE_KERNEL(ibl_reflection);

#endif
