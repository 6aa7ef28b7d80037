/* SPDX-License-Identifier: MIT */
#include "kern/strip_coverage.h"

#include <math.h>

/* A point of a border: the direction of psi, its cosine and slope there. */
struct point {
    double q, r;
    double cosine, slope;
};

static struct point point_at(double a, double q, double r)
{
    const double inverse = 1 / sqrt(a * a + q * q);
    const double slope = -(r * (a * a)) * (inverse * inverse * inverse);
    return (struct point){q, r, q * inverse, slope};
}

/* Where it crosses an end of the row: 1 / sqrt(a^2 + q^2) = sin(theta) / a. */
static struct point crossing(double a, double cosine, double tangent)
{
    const double q = a / tangent, r2 = 1 - q * q;
    const double r = sqrt(r2 > 0 ? r2 : 0), sine = cosine * tangent;
    return (struct point){q, r, cosine, -r * (sine * sine * sine) / a};
}

/* Angle from one direction to another. */
static double angle_between(const struct point *a, const struct point *b)
{
    const double s = b->r * a->q - b->q * a->r, s2 = s * s;
    return s * (1 + s2 * (1.0 / 6 + s2 * (3.0 / 40)));
}

static double share_of(const ibl_coverage_row *row, const ibl_coverage_cuts *c,
                       int i)
{
    const double a = c->a[i];
    struct point high = point_at(a, c->q[0][i], c->r[0][i]);
    struct point low = point_at(a, c->q[1][i], c->r[1][i]);
    double below = 0;
    if (low.cosine >= row->top)
        return 0;
    if (high.cosine <= row->bottom)
        return 1;
    if (low.cosine < row->bottom) {
        const struct point to = crossing(a, row->bottom, row->bottom_tan);
        below = angle_between(&to, &low);
        low = to;
    }
    if (high.cosine > row->top)
        high = crossing(a, row->top, row->top_tan);
    const double inside = angle_between(&high, &low);
    const double mean = 0.5 * (high.cosine + low.cosine) +
                        (high.slope - low.slope) * inside * (1.0 / 12);
    const double share =
        (inside * ((row->top - mean) * (1 / (row->top - row->bottom))) +
         below) /
        c->width[i];
    return share < 0 ? 0 : share > 1 ? 1 : share;
}

static void shares(const ibl_coverage_row *row, const ibl_coverage_cuts *cuts,
                   int count, double *share)
{
    for (int i = 0; i < count; i++)
        share[i] = share_of(row, cuts, i);
}

IBL_KERNEL(ibl_coverage, shares)
