/* SPDX-License-Identifier: MIT */
/* The x, y, z polynomials of Sloan 2013, "Efficient Spherical Harmonic
 * Evaluation", with every sign positive. */
#include "view/vector.h"

#include <math.h>

#include "ibl/ibl.h"

static void basis(const double d[3], double y[VIEW_SH_COUNT])
{
    const double x = d[0], s = d[1], z = d[2], zz = z * z;
    const double c2 = x * x - s * s, s2 = 2 * x * s;
    const double c3 = x * c2 - s * s2, s3 = x * s2 + s * c2;
    const double c4 = x * c3 - s * s3, s4 = x * s3 + s * c3;

    y[0] = sqrt(1 / (4 * M_PI));
    y[1] = sqrt(3 / (4 * M_PI)) * s;
    y[2] = sqrt(3 / (4 * M_PI)) * z;
    y[3] = sqrt(3 / (4 * M_PI)) * x;
    y[4] = sqrt(15 / (16 * M_PI)) * s2;
    y[5] = sqrt(15 / (4 * M_PI)) * s * z;
    y[6] = sqrt(5 / (16 * M_PI)) * (3 * zz - 1);
    y[7] = sqrt(15 / (4 * M_PI)) * x * z;
    y[8] = sqrt(15 / (16 * M_PI)) * c2;
    y[9] = sqrt(35 / (32 * M_PI)) * s3;
    y[10] = sqrt(105 / (16 * M_PI)) * s2 * z;
    y[11] = sqrt(21 / (32 * M_PI)) * s * (5 * zz - 1);
    y[12] = sqrt(7 / (16 * M_PI)) * z * (5 * zz - 3);
    y[13] = sqrt(21 / (32 * M_PI)) * x * (5 * zz - 1);
    y[14] = sqrt(105 / (16 * M_PI)) * c2 * z;
    y[15] = sqrt(35 / (32 * M_PI)) * c3;
    y[16] = sqrt(315 / (256 * M_PI)) * s4;
    y[17] = sqrt(315 / (32 * M_PI)) * s3 * z;
    y[18] = sqrt(45 / (64 * M_PI)) * s2 * (7 * zz - 1);
    y[19] = sqrt(45 / (32 * M_PI)) * s * z * (7 * zz - 3);
    y[20] = sqrt(9 / (256 * M_PI)) * (35 * zz * zz - 30 * zz + 3);
    y[21] = sqrt(45 / (32 * M_PI)) * x * z * (7 * zz - 3);
    y[22] = sqrt(45 / (64 * M_PI)) * c2 * (7 * zz - 1);
    y[23] = sqrt(315 / (32 * M_PI)) * c3 * z;
    y[24] = sqrt(315 / (256 * M_PI)) * c4;
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
