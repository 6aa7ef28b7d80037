/* SPDX-License-Identifier: MIT */
#include "io/colour_space.h"

#include <math.h>

/* The columns of P are the XYZ of the primaries, each up to a factor. W = P s
 * gives the factors: R = G = B with Y = 1 is white. The result is the inverse
 * of P diag(s). */
bool ibl_colour_space(const double xy[8], double rgb_from_xyz[9], float luma[3])
{
    double p[9], inv[9];
    for (int i = 0; i < 3; i++) {
        p[i] = xy[2 * i];
        p[3 + i] = xy[2 * i + 1];
        p[6 + i] = 1 - p[i] - p[3 + i];
    }
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++) {
            const int a = (j + 1) % 3, b = (j + 2) % 3;
            const int c = (i + 1) % 3, d = (i + 2) % 3;
            inv[3 * i + j] =
                p[3 * a + c] * p[3 * b + d] - p[3 * a + d] * p[3 * b + c];
        }
    }
    const double det = p[0] * inv[0] + p[1] * inv[3] + p[2] * inv[6];
    const double x = xy[6], y = xy[7];
    if (!(fabs(det) > 1e-6) || !(fabs(y) > 1e-6))
        return false;
    for (int i = 0; i < 3; i++) {
        const double s = (inv[3 * i] * x + inv[3 * i + 1] * y +
                          inv[3 * i + 2] * (1 - x - y)) /
                         (det * y);
        if (!(fabs(s) > 1e-6))
            return false;
        for (int j = 0; j < 3; j++)
            rgb_from_xyz[3 * i + j] = inv[3 * i + j] / (det * s);
        if (luma)
            luma[i] = (float)(p[3 + i] * s);
    }
    for (int i = 0; i < 9; i++)
        if (!(fabs(rgb_from_xyz[i]) < 1e6))
            return false;
    return true;
}

void ibl_luma_to_rgb(const float luma[3], float *p, int count)
{
    for (; count > 0; count--, p += 3) {
        const float y = p[0], ry = p[1], by = p[2];
        p[0] = p[1] = p[2] = y;
        if (ry == 0 && by == 0)
            continue; /* exact for grey */
        p[0] = (ry + 1) * y;
        p[2] = (by + 1) * y;
        p[1] = (y - p[0] * luma[0] - p[2] * luma[2]) / luma[1];
    }
}
