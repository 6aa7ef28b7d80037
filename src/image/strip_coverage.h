/* SPDX-License-Identifier: MIT */
/*
 * How a border of texels cuts a strip of a row of pixels.
 *
 * With psi an azimuth, q = cos(psi), r = sin(psi), every border is
 *     cosine(theta) = q / sqrt(a^2 + q^2),
 * which falls as psi grows from 0. (A rising border is treated from the
 * other end: with q and r, and the strip's ends, exchanged.) It crosses
 * cosine(theta) where q = a / tan(theta).
 */
#ifndef IBL_IMAGE_STRIP_COVERAGE_H
#define IBL_IMAGE_STRIP_COVERAGE_H

#include <math.h>

/* A row of pixels between two angles theta. Below the equator its cosines and
 * cotangents are negative, and so is q of the borders there. */
typedef struct ibl_coverage_row {
    double top, bottom;         /* cosines, top > bottom */
    double top_cot, bottom_cot; /* cotangents; infinite at the pole */
} ibl_coverage_row;

/* Angle from one direction to another, at most 0.02 radians. */
static inline double ibl_coverage_angle(double q0, double r0, double q1,
                                        double r1)
{
    const double s = r1 * q0 - q1 * r0, s2 = s * s;
    return s * (1 + s2 * (1.0 / 6 + s2 * (3.0 / 40)));
}

/* The mean cosine(theta) of a border between q0, r0 and q1, r1, `width` of psi
 * apart: from its value and its curvature in the middle, to fourth order. */
static inline double ibl_coverage_mean(double a, double q0, double r0,
                                       double q1, double r1, double width)
{
    const double q = q0 + q1, r = r0 + r1;
    const double inverse = 1 / sqrt(a * a * (q * q + r * r) + q * q);
    const double cosine = q * inverse, p = r * inverse;
    return cosine - width * width * (1.0 / 24) *
                        (cosine - cosine * cosine * cosine) * (1 + 3 * p * p);
}

/* The area of a strip above a border that enters or leaves the row in it. */
double ibl_coverage_clipped(const ibl_coverage_row *row, double a, double q0,
                            double r0, double q1, double r1, double width);

/*
 * The area in psi and cosine(theta) of the part of a strip above a border: 0 to
 * all of it, but for rounding. The border enters the strip at q0, r0 and leaves
 * it at q1, r1, `width` of psi later, at most 0.02 radians.
 */
static inline double ibl_coverage_above(const ibl_coverage_row *row, double a,
                                        double q0, double r0, double q1,
                                        double r1, double width)
{
    if (q0 > a * row->top_cot || q1 < a * row->bottom_cot)
        return ibl_coverage_clipped(row, a, q0, r0, q1, r1, width);
    return width * (row->top - ibl_coverage_mean(a, q0, r0, q1, r1, width));
}

#endif
