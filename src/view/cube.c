/* SPDX-License-Identifier: MIT */
#include "view/vector.h"

#include <math.h>

static int texel(double at, int edge)
{
    return (int)fmin(fmax(floor((at + 1) / 2 * edge), 0), edge - 1);
}

void view_cube_texel(const double d[3], int edge, int *face, int *x, int *y)
{
    const double ax = fabs(d[0]), ay = fabs(d[1]), az = fabs(d[2]);
    double u, v, by;

    if (ax >= ay && ax >= az) {
        *face = d[0] < 0;
        u = d[0] < 0 ? d[2] : -d[2], v = -d[1], by = ax;
    } else if (ay >= az) {
        *face = 2 + (d[1] < 0);
        u = d[0], v = d[1] < 0 ? -d[2] : d[2], by = ay;
    } else {
        *face = 4 + (d[2] < 0);
        u = d[2] < 0 ? -d[0] : d[0], v = -d[1], by = az;
    }
    *x = texel(u / by, edge);
    *y = texel(v / by, edge);
}
