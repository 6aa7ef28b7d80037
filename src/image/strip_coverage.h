/* SPDX-License-Identifier: MIT */
/*
 * How a border of texels cuts a strip of a row of pixels.
 *
 * With psi an azimuth, q = cos(psi), r = sin(psi), every border is
 *     cosine(theta) = q / sqrt(a^2 + q^2),
 * which falls as psi grows to 90 degrees. (A rising border is treated from the
 * other end: with q and r, and the strip's ends, exchanged.) It crosses
 * cosine(theta) where q = a / tan(theta).
 */
#ifndef IBL_IMAGE_STRIP_COVERAGE_H
#define IBL_IMAGE_STRIP_COVERAGE_H

#include <math.h>

/* A row of pixels between two angles theta of at most 90 degrees. */
typedef struct ibl_coverage_row {
    double top, bottom;         /* cosines, top > bottom */
    double per_cosine;          /* 1 / (top - bottom) */
    double top_tan, bottom_tan; /* 0 to infinite */
} ibl_coverage_row;

/* A point of a border: q and r of psi, cosine(theta) and its slope. */
typedef struct ibl_border_point {
    double q, r;
    double cosine, slope;
} ibl_border_point;

static inline ibl_border_point ibl_border_point_at(double a, double q, double r)
{
    const double inverse = 1 / sqrt(a * a + q * q);
    const double slope = -(r * (a * a)) * (inverse * inverse * inverse);
    return (ibl_border_point){q, r, q * inverse, slope};
}

/* Angle from one direction to another, at most 0.02 radians. */
static inline double ibl_coverage_angle(double q0, double r0, double q1,
                                        double r1)
{
    const double s = r1 * q0 - q1 * r0, s2 = s * s;
    return s * (1 + s2 * (1.0 / 6 + s2 * (3.0 / 40)));
}

/*
 * The part of a strip of a row above a border, 0..1. The border enters the
 * strip at `high` and leaves it at `low`, `width` of psi later, at most 0.02
 * radians. Within the row it is a straight line plus a correction for its
 * curvature: the area is right to fourth order (Hermite's end correction of the
 * trapezium rule).
 */
double ibl_coverage_share(const ibl_coverage_row *row, double a,
                          const ibl_border_point *high,
                          const ibl_border_point *low, double width);

#endif
