/* SPDX-License-Identifier: MIT */
#include "image/strip_coverage.h"

double ibl_coverage_clipped(const ibl_coverage_row *row, double a, double q0,
                            double r0, double q1, double r1, double width)
{
    const double height = row->top - row->bottom;
    const double enter = a * row->top_cot, leave = a * row->bottom_cot;
    double below = 0;
    if (q1 >= enter)
        return 0;
    if (q0 <= leave)
        return width * height;
    if (q1 < leave) {
        const double r = sqrt(1 - leave * leave);
        below = ibl_coverage_angle(leave, r, q1, r1);
        q1 = leave;
        r1 = r;
    }
    if (q0 > enter) {
        q0 = enter;
        r0 = sqrt(1 - enter * enter);
    }
    const double inside = ibl_coverage_angle(q0, r0, q1, r1);
    const double mean = ibl_coverage_mean(a, q0, r0, q1, r1, inside);
    return inside * (row->top - mean) + below * height;
}
