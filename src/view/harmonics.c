/* SPDX-License-Identifier: MIT */
/* Normalised Legendre functions by their recurrences, without the
 * Condon-Shortley phase. */
#include "view/vector.h"

#include <math.h>

#include "ibl/ibl.h"

/* sqrt((4 l^2 - 1) / (l^2 - m^2)) */
static double step(int l, int m)
{
    return sqrt((4.0 * l * l - 1) / (l * l - m * m));
}

static void basis(const double d[3], double y[VIEW_SH_COUNT])
{
    double c = 1, s = 0, first = sqrt(1 / (4 * M_PI));

    for (int m = 0; m <= VIEW_SH_DEGREE; m++) {
        double before = 0, p = first;
        for (int l = m; l <= VIEW_SH_DEGREE; l++) {
            y[l * (l + 1) - m] = M_SQRT2 * p * s;
            y[l * (l + 1) + m] = (m ? M_SQRT2 : 1) * p * c;
            const double next = step(l + 1, m) * (d[2] * p - before);
            before = p / step(l + 1, m);
            p = next;
        }
        const double turned = c * d[0] - s * d[1];
        s = s * d[0] + c * d[1];
        c = turned;
        first *= sqrt((2 * m + 3) / (2 * m + 2.0));
    }
}

void view_harmonics_sum(const double *coefficients, int count, int channels,
                        const double d[3], double *sum)
{
    double y[VIEW_SH_COUNT];

    basis(d, y);
    for (int c = 0; c < channels; c++) {
        sum[c] = 0;
        for (int i = 0; i < count; i++)
            sum[c] += coefficients[channels * i + c] * y[i];
    }
}

void view_harmonics_cube(const double *coefficients, int count, int channels,
                         int edge, float *texels)
{
    for (int i = 0; i < IBL_FACES * edge * edge; i++) {
        const int face = i / (edge * edge), at = i % (edge * edge);
        double d[3], sum[4];
        ibl_cube_direction(edge, face, at % edge, at / edge, d);
        view_harmonics_sum(coefficients, count, channels, d, sum);
        for (int c = 0; c < channels; c++)
            *texels++ = (float)fmax(sum[c], 0);
    }
}
