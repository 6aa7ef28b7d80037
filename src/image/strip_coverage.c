/* SPDX-License-Identifier: MIT */
#include "image/strip_coverage.h"

/* Point where the border crosses an end of the row: there 1 / sqrt(a^2 + q^2) =
 * sin(theta) / a. */
static ibl_border_point crossing(double a, double cosine, double tangent)
{
    const double q = a / tangent, r2 = 1 - q * q;
    const double r = sqrt(r2 > 0 ? r2 : 0), sine = cosine * tangent;
    return (ibl_border_point){q, r, cosine, -r * (sine * sine * sine) / a};
}

double ibl_coverage_share(const ibl_coverage_row *row, double a,
                          const ibl_border_point *high,
                          const ibl_border_point *low, double width)
{
    ibl_border_point enter, leave;
    double below = 0;
    if (low->cosine >= row->top)
        return 0;
    if (high->cosine <= row->bottom)
        return 1;
    if (low->cosine < row->bottom) {
        leave = crossing(a, row->bottom, row->bottom_tan);
        below = ibl_coverage_angle(leave.q, leave.r, low->q, low->r);
        low = &leave;
    }
    if (high->cosine > row->top) {
        enter = crossing(a, row->top, row->top_tan);
        high = &enter;
    }
    const double inside = ibl_coverage_angle(high->q, high->r, low->q, low->r);
    const double mean = 0.5 * (high->cosine + low->cosine) +
                        (high->slope - low->slope) * inside * (1.0 / 12);
    const double share =
        (inside * ((row->top - mean) * row->per_cosine) + below) / width;
    return share < 0 ? 0 : share > 1 ? 1 : share;
}
